"""A closed track on posts: travel, pull of a hanging run, and the work of its drive."""

import math

import imageio_ffmpeg
import numpy as np
import pytest

from exudyn_crawler import Case, CaseFile, History, StepProfile, run_case, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.case.parameters.closed_track import Tensioner
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.machines import Outputs, read_case
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.equations import STIFFNESS
from exudyn_crawler.results.balance import (
    energy_balance,
    frame_imbalance,
    shoe_actions,
    shoe_imbalance,
    tumbler_imbalance,
)
from exudyn_crawler.results.history.catalogue import link_name
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.views.scenes.films import TrackPicture
from studies.closed import torque_by_tension
from tests.model.both import compiled_matrix, residual_of
from tests.states import row_of

pytestmark = [pytest.mark.simulation, pytest.mark.slow]

ON_POSTS = {"gear.support": "posts"}
TAUT = {"gear.idler.slack": 0.0}
"""A chain whose runs hardly swing, where means over some pitches are compared with a formula."""


def risen(speed, seconds):
    """Drive from rest to a speed (m/s) within some seconds, and on."""
    return Drive(speed=StepProfile(times=(0.0, seconds), values=(0.0, speed)))


def driven(case, speed, seconds, duration):
    """Run of a case with such a drive."""
    return simulate(case.with_(drive=risen(speed, seconds)), duration, progress=False)


def rest_of(case):
    """History of a case's rest alone, without multipliers."""
    system = compiled_system(case)
    return system_history(system, row_of(system.layout, {"coordinates": static_equilibrium(case)})[None])


@pytest.fixture(scope="module")
def rig():
    """Four pitches of the chain at 0.3 m/s, its frame on posts."""
    return driven(Case.closed().with_(ON_POSTS | TAUT).on_cells(RockFloor.hard_floor()), 0.3, 0.5, 10.5)


@pytest.fixture(scope="module")
def on_ground():
    """From rest to 0.3 m/s and on, over half a pitch."""
    return driven(Case.closed().with_(TAUT), 0.3, 0.3, 0.8)


@pytest.mark.parametrize("changes", [
    {"gear.pitch_growth": 0.001},
    {"gear.pitch_growth": 0.02},
    {"gear.carriers": ()},
    {"gear.idler.slack": 0.005},
    {"shoe.mass": 4489.63},
])  # fmt: skip
def test_worn_slack_and_light_chains_find_their_rest(changes):
    """On the papers' ground, which carries frame, tumbler and shoes; what creeps on is slow."""
    case = Case.closed().with_(changes)
    carried = rest_of(case).normal_force.sel(axis="z").sum().item()
    tumbler, gear = case.gear.tumbler.mass, case.gear.mass
    weight = (gear + tumbler + case.track.shoe_count * case.shoe.mass) * case.gravity
    assert carried == pytest.approx(weight, rel=1e-3)


def pins(history):
    """Front pins of all shoes, and their velocities: arrays (times, shoes, 3), m and m/s."""
    data, track = history.dataset, history.case.track
    arm = rotation_matrices(data.angles.values) @ [track.pin_ahead, 0.0, track.pin_height]
    return data.position.values + arm, data.velocity.values + np.cross(data.angular_velocity.values, arm)


def crossings(history):
    """Rows of the times at which shoes pass a place above, after the start has died away."""
    data = history.dataset
    place = data.position.values - data.tumbler_position.values[:, None]
    ahead, above = place[..., 0] > 4.0, place[..., 2] > 0.0
    rows = np.sort(np.nonzero(ahead[1:] & ~ahead[:-1] & above[1:])[0])
    return rows[data.time.values[rows] > 1.2]


def test_chain_stays_closed(rig):
    front, _ = pins(rig)
    track = rig.case.track
    back = rotation_matrices(rig.angles.values) @ [track.pin_ahead - track.pitch, 0.0, track.pin_height]
    apart = front - np.roll(rig.position.values + back, -1, axis=1)
    assert np.abs(apart[..., [0, 2]]).max() < 2e-6  # with what compliance in roll and yaw makes of it
    assert np.abs(apart[..., 1]).max() < 1e-4


def test_a_spring_holds_the_idler_as_shims_at_its_place_do():
    taut = Case.closed().with_(ON_POSTS)
    place = taut.gear.assembled(taut).take_up - 2e-3
    shims = rest_of(taut.with_({"gear.idler.take_up": place}))
    push, stiffness = -shims.wheel_force.sel(wheel="idler", axis="x").item(), 2e8
    spring = Tensioner(mass=8e3, stiffness=stiffness, preload=push + stiffness * place)
    sprung = rest_of(taut.with_({"gear.idler.tensioner": spring}))
    assert sprung.take_up.item() == pytest.approx(place, abs=1e-6)
    np.testing.assert_allclose(sprung.joint_force, shims.joint_force, rtol=0.0, atol=1e-3 * push)


def test_the_tensioners_row_is_its_spring_and_damper():
    """Its matrix is the derivative of its residual by places and rates of frame and idler."""
    spring = Tensioner(mass=8e3, stiffness=2e8, preload=3e7, damping=1e6)
    case = Case.closed().with_(ON_POSTS | {"gear.idler.tensioner": spring})
    system, velocity = compiled_system(case), 700.0
    q, weights = static_equilibrium(case), (1.0, velocity, 0.0, False, 1.0)
    still = np.zeros_like(q)
    row = len(q) + system.layout.first_multiplier("bearing of the idler")
    first = len(q) - 6
    found = compiled_matrix(system, q, still, weights)[row, first : first + 3]
    differences = np.zeros(3)
    for k in range(3):
        step = np.zeros_like(q)
        step[first + k] = 1e-7
        above, below = (residual_of(system, q + e, velocity * e, still)[row] for e in (step, -step))
        differences[k] = (above - below) / 2e-7
    np.testing.assert_allclose(found, differences, rtol=1e-6, atol=1e-6 * STIFFNESS)
    assert found[0] == pytest.approx(STIFFNESS * (1.0 + velocity * spring.damping / spring.stiffness))


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_upper_run_of_an_m113_hangs_as_a_catenary():
    """A second machine with a spring: its push on the idler is the pull of both runs, by curvature too."""
    case = read_case("studies/m113.toml").case
    rest, spring = rest_of(case), case.gear.idler.tensioner
    on_idler = rest.wheel_force.sel(wheel="idler").isel(time=0).values
    assert -on_idler[0] == pytest.approx(spring.preload - spring.stiffness * rest.take_up.item(), rel=1e-4)
    place = (rest.position - rest.side_frame_position).isel(time=0).values
    free = place[(place[:, 2] > 0.37) & (place[:, 0] > 0.6) & (place[:, 0] < 3.4)]
    curvature = 2.0 * np.polyfit(free[:, 0], free[:, 2], 2)[0]
    pull = case.shoe.mass * case.gravity / case.track.pitch / curvature
    assert pull == pytest.approx(0.5 * np.hypot(on_idler[0], on_idler[2]), rel=0.02)
    assert 50e3 < pull < 70e3
    assert rest.take_up.item() == pytest.approx(0.1547, abs=2e-4)


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_a_driven_m113_has_the_torque_of_its_tension_and_hangs_as_a_catenary_on_average():
    """Two lugs a shoe, beside its pins, and an idler on a spring; 0.2 m/s, at which the run swings little."""
    case = read_case("studies/m113.toml").case
    history, ends = driven(case, 0.2, 0.5, 3.0), np.array([0.7, 2.0, 3.3])
    table = torque_by_tension(history, (0.2,)).iloc[0]
    assert table["by work in kN m"] == pytest.approx(table["torque in kN m"], rel=3e-3)
    assert table["by means of tension in kN m"] == pytest.approx(table["torque in kN m"], rel=1e-2)
    place = (history.position - history.side_frame_position).values[history.time.values > 1.0]
    upper = [one[(one[:, 2] > 0.3) & (one[:, 0] > 0.2) & (one[:, 0] < 3.9)] for one in place]
    height = np.mean([np.interp(ends, *one[np.argsort(one[:, 0])].T[[0, 2]]) for one in upper], axis=0)
    hanging = history.link_tension.values[history.time.values > 1.0]
    hanging = np.mean(hanging, where=(place[..., 2] > 0.37) & (place[..., 0] > 0.6) & (place[..., 0] < 3.4))
    weight, length = case.shoe.mass * case.gravity / case.track.pitch, ends[2] - ends[0]
    assert height[[0, 2]].mean() - height[1] == pytest.approx(weight * length**2 / (8.0 * hanging), rel=0.02)
    # driven, the idler stands where it is at rest
    late = history.take_up.values[history.time.values > 1.0]
    assert late.mean() == pytest.approx(history.take_up.values[0], abs=1e-3)


def test_travel_a_radian_is_that_of_the_pitches(rig):
    rows, angle = crossings(rig), rig.tumbler_angle.values
    travel = (len(rows) - 1) * rig.case.track.pitch / (angle[rows[-1]] - angle[rows[0]])
    teeth = rig.case.gear.tumbler.teeth
    assert travel == pytest.approx(teeth * rig.case.track.pitch / (2.0 * math.pi), rel=2e-3)


def test_a_worn_chain_travels_further_a_radian():
    """By its growth: over five pitches of the tumbler its hanging shoes go five grown ones.

    They swing, so that over a single pitch they go up to 0.3 % more or less.
    """
    growth = 0.01
    case = Case.closed().with_(ON_POSTS | TAUT | {"gear.pitch_growth": growth})
    data, teeth = driven(case, 0.3, 0.5, 14.0).dataset, case.gear.tumbler.teeth
    place = data.position.values - data.tumbler_position.values[:, None]
    hanging = (place[..., 2] < 0.0) & (abs(place[..., 0] - 4.2) < 3.0)
    speed = np.mean(abs(data.velocity.values[..., 0]), axis=1, where=hanging)
    last = data.tumbler_angle.values > data.tumbler_angle.values[-1] - 5.0 * 2.0 * math.pi / teeth
    travel = speed[last].mean() / data.tumbler_speed.values[last].mean()
    assert travel == pytest.approx((1.0 + growth) * teeth * case.track.pitch / (2.0 * math.pi), rel=2e-3)


def test_torque_is_what_tension_and_weight_say_over_whole_pitches(rig):
    """By moments, by work and by means at n p / (2 pi) with w dz between COMs, wherever the cut is."""
    table = torque_by_tension(rig, (0.4, 0.5, 0.6))
    torque = table["torque in kN m"]
    assert table["by moments in kN m"].to_numpy() == pytest.approx(torque, rel=5e-3)
    assert table["by work in kN m"].to_numpy() == pytest.approx(torque, rel=2e-3)
    # this close though either run pulls ten times as much as the drive
    assert table["by means of tension in kN m"].to_numpy() == pytest.approx(torque, rel=1e-2)


def test_torque_on_the_ground_is_what_tension_and_weight_say():
    """By means, cut 0.3 m ahead of the axis: further on the ground begins to carry shoes."""
    table = torque_by_tension(driven(Case.closed().with_(TAUT), 0.3, 0.5, 10.5)).iloc[0]
    torque = table["torque in kN m"]
    assert table["by moments in kN m"] == pytest.approx(torque, rel=5e-3)
    assert table["by means of tension in kN m"] == pytest.approx(torque, rel=1e-2)


def test_hanging_run_is_a_catenary(rig):
    """Curvature of the lower run at rest, which no roller carries, times its pull is its weight a metre."""
    case, place = rig.case, (pins(rig)[0] - rig.tumbler_position.values[:, None])[0]
    below = np.flatnonzero((place[:, 2] < 0.0) & (place[:, 0] > 1.2) & (place[:, 0] < 7.2))
    pull = rig.joint_force.values[0, below, 0]
    assert np.ptp(pull) < 1e-6 * pull.mean()
    curvature = 2.0 * np.polyfit(place[below, 0], place[below, 2], 2)[0]
    weight = case.shoe.mass * case.gravity / case.track.pitch
    assert curvature * pull.mean() == pytest.approx(weight, rel=0.02)
    assert rig.wheel_force.sel(wheel="roller 4").isel(time=0).values == pytest.approx(0.0)


@pytest.mark.parametrize("speed", [0.1, -0.1], ids=["forward", "backward"])
def test_all_that_acts_on_a_shoe_is_its_mass_times_its_acceleration(speed):
    """On the ground; the records have the teeth, the wheels and the link of the last shoe."""
    history = driven(Case.closed(), speed, 0.1, 0.1)
    acts, left = (abs(of(history)).max(("time", "shoe", "axis")) for of in (shoe_actions, shoe_imbalance))
    for name, parts in acts.items():
        assert (parts.sel(source=["contact", "joint", "wheel", "tooth"]) > 1e4).all()
        assert left[name] < 1e-5 * parts.max()
    assert link_name(history.joint, 38) == "link 38-1"
    assert link_name(history.joint, 37) == "link 37-38"


def test_compliance_of_pins_across_hardly_changes_forces_in_the_chains_plane():
    """Ten times as much, and a tenth: links, teeth and torque; across the chain it does share the loads."""
    cases = [Case.closed().with_(TAUT | {"gear.compliance": one}) for one in (1e-10, 1e-11, 1e-9)]
    first, *others = (driven(case, 0.1, 0.1, 0.1) for case in cases)
    greatest = float(first.link_tension.max())
    for other in others:
        for name in ("joint_force", "tooth_force", "wheel_load"):
            apart = (other.dataset[name] - first.dataset[name]).sel(axis=["x", "z"])
            assert float(abs(apart).max()) < 2e-3 * greatest
        # the moment of these forces about the tumbler's axis
        torque = first.drive_moment.values
        lever = first.case.gear.travel_per_angle(first.case.track)
        assert other.drive_moment.values == pytest.approx(torque, abs=2e-3 * greatest * lever)
        moment = float(abs(first.joint_torque).max())
        assert float(abs(other.joint_torque - first.joint_torque).max()) > 0.1 * moment


def test_sand_carries_a_closed_track_and_each_shoe_is_in_balance():
    """Cells with memory below all shoes, from the first instant on.

    Work is summed over stored times: with twice the step the imbalance is 2.6 times as large.
    """
    steps = {"solver.step": 1e-3, "solver.output_interval": 1e-3}
    case = Case.closed().on_cells(BekkerSoil.lete_sand()).with_(steps)
    history = simulate(case, 0.1, progress=False)
    mass = case.gear.mass + case.gear.tumbler.mass + case.track.shoe_count * case.shoe.mass
    carried = (history.normal_force + history.friction_force).sel(axis="z").sum("contact").values
    assert carried == pytest.approx(mass * case.gravity, rel=1e-3)
    acts, left = shoe_actions(history), shoe_imbalance(history)
    for name, parts in acts.items():
        assert float(abs(left[name]).max()) < 1e-5 * float(abs(parts).max())
        assert float(abs(parts).sel(source="contact").max()) > 1e4
    work = energy_balance(history)
    assert float(abs(work.imbalance).max()) < 1e-3 * float(work.pressure[-1])


def test_work_of_the_torque_is_losses_and_what_is_stored(on_ground):
    balance = energy_balance(on_ground)
    work = balance.drive.values
    assert np.abs(balance.imbalance.values).max() < 1e-3 * work.max()
    # each part is some times more than what may be left open
    for name in ("kinetic", "frame_kinetic", "wheel_losses", "tooth_losses", "friction"):
        assert float(balance[name][-1]) > 5e-3 * work.max(), name
    for name in ("treads", "teeth", "springs", "gravitational", "frame_gravitational"):
        assert float(abs(balance[name]).max()) > 1e-2 * work.max(), name


@pytest.mark.filterwarnings("ignore:gear.slide_friction")
def test_a_slide_carries_the_upper_run_and_rubs_on_it():
    """Lines bear the weight between them; tension and work of the torque have its friction."""
    closed, speed, friction = Case.closed().gear, 0.1, 0.3
    slide = (-2.7, 2.7, closed.carriers[0][1] + closed.carrier_radius)
    changes, supplied = ON_POSTS | {"gear.carriers": (), "gear.slides": (slide,)}, []
    for rubbing in (0.0, friction):
        case = Case.closed().with_(changes | {"gear.slide_friction": rubbing})
        # slow from the start on: else the hanging run swings, and stores a tenth of the work for a while
        history = driven(case, speed, 1.0, 7.6)
        # a pitch at the full speed
        late = history.time.values >= history.time.values[-1] - case.track.pitch / speed
        supplied.append((history.drive_moment * history.tumbler_speed).values[late].mean())
        on_slide = history.wheel_force.values[late].mean(axis=0)[8:]
        place = (history.position.values - history.side_frame_position.values[:, None])[late]
        upper = place[..., 2] > slide[2]
        tension, near = history.link_tension.values[late], 0.5 * case.track.pitch
        front, rear = (tension[upper & (abs(place[..., 0] - x) < near)].mean() for x in (1.35, -1.35))
        # cut over the outer ones of these lines, which bend no chain: half of what they bear is between
        between = 0.5 * (on_slide[3:-3].sum(axis=0) + on_slide[4:-4].sum(axis=0))
        assert front - rear == pytest.approx(between[0], rel=0.01, abs=500.0)
        weight = case.shoe.mass * case.gravity / case.track.pitch * 0.45
        assert -between[2] == pytest.approx(6.0 * weight, rel=0.01)
        # the chain's tension presses it on the ends of the slide
        assert (-on_slide[[0, -1], 2] > 4.0 * weight).all()
    pressed = np.linalg.norm(history.wheel_force.values[late][:, 8:], axis=-1) / math.hypot(1.0, friction)
    work = friction * pressed.sum(axis=1).mean() * speed
    assert supplied[1] - supplied[0] == pytest.approx(work, rel=0.01)
    balance = energy_balance(history)
    assert np.abs(balance.imbalance.values).max() < 2e-3 * balance.drive.values.max()


@pytest.mark.parametrize("tensioner", [False, True], ids=["shims", "spring"])
def test_all_that_acts_on_frame_and_tumbler_is_the_rate_of_their_momentum(tensioner, on_ground):
    """And the work of the torque, where a spring and a damper push the idler."""
    case, history = Case.closed(), on_ground
    if tensioner:
        push = 1.3e6 + 1e8 * case.gear.assembled(case).take_up
        spring = Tensioner(mass=8e3, stiffness=1e8, preload=push, damping=1e6)
        history = driven(case.with_({"gear.idler.tensioner": spring}), 0.3, 0.3, 0.6)
    late = history.time.values > 0.01
    left, weight = frame_imbalance(history), case.gear.mass * case.gravity
    # the acceleration of an idler that slides is known by differences of its place
    within = 5e-3 if tensioner else 1e-4
    for name, values in left.items():
        assert np.abs(values.values[late]).max() < within * weight, name
    torque = history.drive_moment.values
    assert np.abs(tumbler_imbalance(history)[0, late]).max() < 1e-4 * torque.max()
    if tensioner:
        balance = energy_balance(history)
        assert np.abs(balance.imbalance.values).max() < 2e-3 * balance.drive.values.max()
        assert abs(balance.tensioners.values).max() > 1e-2 * balance.drive.values.max()


def test_a_film_and_a_page_of_a_closed_track_show_its_gear(tmp_path):
    outputs = Outputs(animation=True, figures=False, tables=False, forces=False)
    case_file = CaseFile(case=Case.closed().with_(drive=risen(0.5, 0.1)), duration=0.4, outputs=outputs)
    run_case(case_file, tmp_path / "out", progress=False)
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "out" / "track.mp4"))
    assert frames >= 8
    assert seconds == pytest.approx(0.4, abs=0.1)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for body in ("tumbler", "lugs", "idler", "rollers", "carriers", "forces of wheels", "forces of teeth"):
        assert f'"name":"{body}"' in page, body
    assert '"label":"angle of the tumbler"' in page
    # the tumbler turns and the chain goes on between two pictures
    picture = TrackPicture(History.load(tmp_path / "out" / "history.nc"), 20.0)
    first, last = (picture.image(time).astype(int) for time in (0.0, 0.4))
    changed = abs(last - first).max(axis=2) > 40
    assert 0.01 < changed.mean() < 0.3


def test_drive_with_a_limited_torque_keeps_to_it():
    limit = 4e5
    case = Case.closed().with_({"gear.torque_limit": limit})
    history = driven(case, 0.3, 0.2, 0.4)
    closed, torque = case.gear, history.drive_moment.values
    wanted = risen(0.3, 0.2).speed.value(history.time.values)
    lag = wanted / closed.travel_per_angle(case.track) - history.tumbler_speed.values
    assert 0.95 * limit < torque.max() < limit
    # the drive that keeps its speed takes three times as much here, and this one lags far behind
    assert lag.max() > 5.0 * closed.torque_speed
    assert torque == pytest.approx(limit * lag / np.hypot(lag, closed.torque_speed), abs=1e-4 * limit)


@pytest.mark.parametrize(
    ("changes", "speed", "message"),
    [
        ({"tension_limit": 2.8e6}, 0.3, r"link \d+-\d+ broke: its tension of 2\.[89]\d*e\+06 N.*too taut"),
        # wheels that are packed with dirt hold a slack chain back, which piles up on them
        (
            {"idler.slack": 0.15, "rolling_resistance": 0.7},
            4.0,
            r"the chain folded: shoes \d+ and \d+ are at .* beyond gear.fold_limit = 1 rad; likely",
        ),
        # teeth that reach 10 mm beyond the pins
        (
            {"tumbler.reach": 0.01, "idler.slack": 0.1},
            5.0,
            r"shoe \d+ jumped a tooth of the tumbler.*pulled harder than such teeth hold",
        ),
        # on a side slope it lies 73 mm aside on soft flanges, and loses their hold as it goes faster
        (
            {"idler.slack": 0.05, "offset_limit": 0.0735}
            | {"guide_play": 0.05, "guide_stiffness": 1e6, "guide_height": 0.005},
            3.0,
            r"shoe \d+ came off sideways: it is -0\.07\d+ m from the track's middle.*flanges do not hold",
        ),
    ],
    ids=["breaks", "folds", "jumps", "comes off"],
)
@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_chain_that_fails_ends_the_run_with_shoe_time_and_cause(changes, speed, message):
    case = Case.closed().with_(ON_POSTS | {f"gear.{name}": value for name, value in changes.items()})
    if "offset_limit" in changes:
        case = case.with_({"terrain.side_slope": 0.2})
    with pytest.raises(SimulationStopped, match=message) as stopped:
        driven(case, speed, 0.2, 0.6)
    # what was computed is kept
    assert 0.0 < stopped.value.time < 0.6
    assert stopped.value.history.duration == pytest.approx(stopped.value.time, abs=2e-3)
    assert np.isfinite(stopped.value.history.link_tension.values).all()
