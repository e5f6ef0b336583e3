"""A machine on two closed tracks: straight it is one track twice, on the spot it turns."""

import numpy as np
import pytest

from exudyn_crawler import Case, FlexibleShoes, History, MachineCycle, StepProfile, recover_stresses, simulate
from exudyn_crawler.assessment.pressure import Footprints
from exudyn_crawler.assessment.travel import turn_of_footprints, turn_of_lines
from exudyn_crawler.case import CarBody, Drive, LoadCycle, Machine, MachinePhase, Part
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.balance import energy_balance, frame_imbalance, shoe_imbalance, tumbler_imbalance
from exudyn_crawler.results.history.catalogue import link_name
from exudyn_crawler.views.figures import history_series, run_figures
from exudyn_crawler.views.scenes.gear import gear_solids

pytestmark = [pytest.mark.simulation, pytest.mark.slow]

STILL = Drive(speed=StepProfile.constant(0.0))
PINS = 0.7
"""m, of the pins' middles beside that of the shoe."""
FRICTION = 0.3


def twice(case):
    """Two of a closed track, whose side frames have the machine between them."""
    small = {"mass": 1e3, "inertia": (1e3, 1e3, 1e3, 0.0, 0.0, 0.0), "com": case.gear.com}
    body = CarBody(gauge=9.0, **small, **{f"upper_{name}": value for name, value in small.items()})
    gear = Machine.of(case.gear.with_(mass=case.gear.mass - 1e3), body)
    return case.with_({"track.shoe_count": 76}, loads=LoadCycle.constant([0.0] * 76), gear=gear)


def test_straight_each_of_two_tracks_is_a_single_one():
    """On rock, which moves under neither of them for the other."""
    drive = Drive(speed=StepProfile(times=(0.0, 0.2), values=(0.0, 0.2)))
    # cells lie evenly about the middle of each track
    places = {"track.first_com[1]": 9.3, "track.spherical_y": 9.3 - PINS, "track.parallel_y": 9.3 + PINS}
    # a take-up that is solved for ends within 0.01 mm, and slacker chains creep for longer than their search
    same = {"gear.idler.slack": 0.005}
    case = Case.closed().with_({"terrain.rows": 6, **places, **same}, drive=drive)
    cases = [each.on_cells(RockFloor.hard_floor()) for each in (case, twice(case))]
    one, two = (simulate(each, 0.2, progress=False) for each in cases)
    single, tension = one.link_tension.values, two.link_tension.values.reshape(-1, 2, 38)
    scale = single.max()
    assert np.abs(tension[:, 0] - tension[:, 1]).max() < 1e-7 * scale
    # the small bodies between them change the pitching inertia
    assert np.abs(tension[:, 0] - single).max() < 1e-5 * scale
    torque = two.drive_moment.sel(track="left").values
    assert torque == pytest.approx(one.drive_moment.values, abs=1e-5 * torque.max())
    assert np.abs(two.side_frame_angles.values[:, [0, 2]]).max() < 1e-9


def test_flexible_shoes_of_two_tracks_are_those_of_one():
    """With their stress, of both tracks together and of one of them by itself."""
    flexible = FlexibleShoes.ph4100c("coarse").with_(shoes=(8,), highest_frequency=1500.0)
    drive = Drive(speed=StepProfile(times=(0.0, 0.1), values=(0.0, 0.3)))
    case, aside = Case.closed().with_(drive=drive, flexible=flexible), 9.3 - Case.closed().track.first_com[1]
    pins = {f"track.{name}": getattr(case.track, name) + aside for name in ("spherical_y", "parallel_y")}
    case = case.with_({"terrain.rows": 6, "track.first_com[1]": 9.3} | pins).on_cells(RockFloor.hard_floor())
    both = twice(case).with_({"flexible.shoes": (8, 46)})
    one, two = (simulate(each, 0.06, progress=False) for each in (case, both))
    single, modes = one.modal_coordinate.values[:, 0], np.moveaxis(two.modal_coordinate.values, 1, 0)
    most = np.abs(single).max()
    # pins beside the middle of their shoes let a track roll by itself, and load both tracks otherwise
    for found in modes:
        assert found == pytest.approx(single, abs=1e-2 * most)
    left, alone = two.of_track("left"), recover_stresses(one).dataset.highest_von_mises
    assert left.flexible_shoe.values.tolist() == [8]
    whole = recover_stresses(two).dataset.highest_von_mises
    highest = recover_stresses(left).dataset.highest_von_mises
    np.testing.assert_allclose(highest.sel(shoe=8), whole.sel(shoe=46), rtol=1e-5)
    for shoe in (8, 46):
        np.testing.assert_allclose(whole.sel(shoe=shoe), alone.sel(shoe=8), rtol=5e-2)
    np.testing.assert_array_equal(left.strip_wheel, one.strip_wheel)


@pytest.fixture(scope="module")
def spot():
    """Turn on the spot, on rollers that are a pitch apart: shoes come under all of them alike."""
    case = Case.shovel()
    closed, pitch, count, radius = case.gear, case.track.pitch, 11, 0.32
    up = closed.roller_radius - radius
    places = {
        "gear.rollers": tuple(pitch * (k - 0.5 * (count - 1)) for k in range(count)),
        "gear.roller_radius": radius,
        "gear.tumbler.place[1]": closed.tumbler.place[1] + up,
        "gear.idler.place[1]": closed.idler.place[1] + up,
        "gear.carriers": tuple((x, z + up) for x, z in closed.carriers),
        "gear.car_body.upper_com": (0.0, 0.0, 4.5),
        "contact.static_friction": FRICTION,
        "contact.dynamic_friction": FRICTION,
        "solver.output_interval": 0.01,
    }
    turn = StepProfile(times=(0.0, 0.8), values=(0.0, 0.05))
    drive = Drive(speed=StepProfile.constant(0.0), turn_rate=turn)
    return simulate(case.with_(places, drive=drive), 2.4, progress=False)


def in_machine(history, vectors):
    """Components of global vectors (times, n, 3) ahead and to the left of the machine, (times, n) each."""
    ahead, left = (rotation_matrices(history.side_frame_angles.values)[..., k] for k in (0, 1))
    return np.einsum("tnc,tc->tn", vectors, ahead), np.einsum("tnc,tc->tn", vectors, left)


def test_moment_of_turning_on_the_spot(spot):
    """Across the tracks mu G L / 4, less what slip along them takes of the friction's direction."""
    late = spot.time.values > 1.2
    data, case = spot.dataset, spot.case
    arm = np.where(data.area.values[..., None] > 0.0, data.point.values, np.nan)
    arm = np.nan_to_num(arm - data.side_frame_position.values[:, None])
    along, _ = in_machine(spot, arm)
    pull, across = in_machine(spot, data.friction_force.values)
    pressed = np.linalg.norm(data.normal_force.values, axis=-1)
    length = len(case.gear.rollers) * case.track.pitch
    even = FRICTION * pressed[late].sum(axis=1).mean() * length / 4.0
    # pressure is even enough that it has this moment where tracks slip across alone
    assert FRICTION * (pressed * abs(along))[late].sum(axis=1).mean() == pytest.approx(even, rel=0.05)
    moment = -(across * along)[late].sum(axis=1).mean()
    assert moment == pytest.approx(even, rel=0.1)
    # slip along the tracks over that across at their ends
    rate = data.side_frame_angular_velocity.values[late, 2].mean()
    slip = (0.05 - rate) * 0.5 * case.gear.car_body.gauge / (0.5 * rate * length)
    share = np.sqrt(1.0 + slip**2) - slip**2 * np.arcsinh(1.0 / slip)
    assert moment == pytest.approx(share * even, rel=0.03)
    # both tracks pull against each other
    right = data.contact_shoe.values <= 38
    pulls = [pull[late][:, side].sum(axis=1).mean() for side in (right, ~right)]
    assert pulls[0] == pytest.approx(-pulls[1], rel=0.1)


def test_a_turn_on_the_spot_is_as_much_less_than_commanded_as_tracks_must_slip(spot):
    """A turn takes the pull of both tracks, which pull only as they slip: B / (B + k L) of the command.

    Units bear friction at a point for each pair and a torque about it: less than over the shoes' whole width,
    more than on a line.
    """
    case, late = spot.case, spot.time.values > 1.2
    gauge, length = case.gear.car_body.gauge, len(case.gear.rollers) * case.track.pitch
    rate = spot.side_frame_angular_velocity.values[late, 2].mean()
    footprint = Footprints(gauge, length, case.shoe.width)
    wide, line = (
        0.05 * gauge / (gauge + turn.slip * length)
        for turn in (
            turn_of_footprints(1.0, footprint, FRICTION),
            turn_of_lines(1.0, length, gauge, FRICTION),
        )
    )
    assert wide < rate < line
    assert rate == pytest.approx(0.5 * (wide + line), rel=0.05)


def test_all_forces_on_the_machine_are_the_rate_of_its_momentum(spot):
    data, case = spot.dataset, spot.case
    outside = (data.normal_force + data.friction_force).sum("contact").values
    turn = rotation_matrices(data.side_frame_angles.values)
    spin, change = data.side_frame_angular_velocity.values, data.side_frame_angular_acceleration.values
    parts = [(part.mass, part.com) for part in case.gear.frame_parts]
    tumblers = case.gear.tumbler_reference(case)[:, :3] - case.gear.frame_start(case)
    parts += [(case.gear.tumbler.mass, place) for place in tumblers]
    rate = case.shoe.mass * data.acceleration.sum("shoe").values
    mass = case.shoe.mass * case.track.shoe_count
    for own, place in parts:
        arm = turn @ place
        swung = np.cross(change, arm) + np.cross(spin, np.cross(spin, arm))
        rate = rate + own * (data.side_frame_acceleration.values + swung)
        mass += own
    assert abs(rate - outside - mass * case.gravity_vector()).max() < 2e-6 * mass * case.gravity
    # the machine with its tumblers, and these about their axles
    for values in frame_imbalance(spot).values():
        assert np.abs(values.values).max() < 1e-3 * mass * case.gravity
    assert np.abs(tumbler_imbalance(spot)[:, 2:-2]).max() < 1e-3 * np.abs(data.drive_moment.values).max()
    # each shoe by itself, with the links of its own loop
    left = shoe_imbalance(spot)
    assert float(abs(left.force).max()) < 2e-6 * mass * case.gravity
    assert float(abs(left.moment).max()) < 2e-6 * mass * case.gravity


def test_work_of_both_torques_is_losses_and_what_is_stored(spot):
    balance = energy_balance(spot)
    assert np.abs(balance.imbalance.values).max() < 1e-2 * balance.drive.values.max()
    assert float(balance.friction[-1]) > 0.5 * float(balance.drive[-1])


def test_one_track_of_a_machine_is_a_history_of_its_own(spot):
    left = spot.of_track("left")
    assert left.link_tension.values == pytest.approx(spot.link_tension.values[:, 38:])
    assert link_name(spot.joint, 76) == "link 76-39"
    assert link_name(left.joint, 38) == "link 38-1"
    assert spot.shoe_track.sel(shoe=39) == spot.joint_track.sel(joint=76) == "left"
    apart = left.side_frame_position.values - spot.side_frame_position.values
    assert np.linalg.norm(apart, axis=-1) == pytest.approx(0.5 * spot.case.gear.car_body.gauge)
    place = (left.tumbler_position - left.side_frame_position).values
    start = left.case.gear.tumbler_reference(left.case)[0, :3] - left.case.gear.frame_start(left.case)
    assert np.linalg.norm(place, axis=1) == pytest.approx(np.linalg.norm(start), rel=1e-3)
    torque = history_series(spot)["torque of the drive"].values
    assert torque["item"].values.tolist() == ["right tumbler", "left tumbler"]
    assert "tension along the left chain" in run_figures(spot)
    names = {one.name for one in gear_solids(History(spot.case, spot.dataset.isel(time=[0, -1])))}
    assert {"car body", "right tumbler", "left tumbler", "left lugs"} <= names


@pytest.mark.parametrize("changes", [{"gear.car_body.slew": 0.5 * np.pi}, {"terrain.side_slope": 0.1}])
def test_weight_beside_the_middle_is_shared_by_the_tracks(changes):
    """As on two supports; shoes that lean carry a little beside their middles."""
    case = Case.shovel().with_(changes, drive=STILL)
    history = simulate(case, 0.02, progress=False)
    parts = [*case.gear.frame_parts, Part(76 * case.shoe.mass, np.array([0.0, 0.0, 0.4]), np.eye(3))]
    down, ground = case.terrain.down, case.gear.frame_start(case)[2]
    aside = sum(part.mass * (part.com[1] - (part.com[2] + ground) * down[1] / down[2]) for part in parts)
    expected = 0.5 + aside / sum(part.mass for part in parts) / case.gear.car_body.gauge
    pressed = [history.of_track(side).normal_force.isel(time=-1).sum() for side in ("right", "left")]
    assert float(pressed[1] / (pressed[0] + pressed[1])) == pytest.approx(expected, abs=0.004)
    assert abs(expected - 0.5) > 0.02


def test_digging_loads_are_shared_by_the_tracks_and_held_by_the_ground():
    force, about = np.array([-2e5, 0.0, -9e5]), 3e6  # N and N m: the dipper is to the right
    phase = MachinePhase(name="dig", end=0.0, force=tuple(force), moment=(about, 0.0, 0.0))
    still = Case.shovel().with_(drive=STILL)
    dug = still.with_(machine=MachineCycle(phases=(phase,)))
    idle, digging = (simulate(case, 0.02, progress=False) for case in (still, dug))
    carried, moments = [], []
    for history in (idle, digging):
        held = (history.normal_force + history.friction_force).isel(time=-1)
        left = held.where(history.contact_shoe > 38, 0.0)
        carried.append(held.sum("contact").values)
        moments.append(float((2.0 * left - held).sel(axis="z").sum()) * 0.5 * still.gear.car_body.gauge)
    weight = carried[0][2]
    # the ground gives as it takes the pull up
    assert carried[1] - carried[0] == pytest.approx(-force, abs=5e-3 * weight)
    assert moments[1] - moments[0] == pytest.approx(-about, rel=0.05)


def test_a_differential_turn_is_in_balance_and_less_than_commanded():
    rises = [StepProfile(times=(0.0, 0.3), values=(0.0, one)) for one in (0.1, 0.02)]
    case = Case.shovel().with_(drive=Drive(speed=rises[0], turn_rate=rises[1]))
    # a chain that sags would pull on the ground only later
    changes = {"solver.output_interval": 0.01, "gear.idler.slack": 0.005}
    history = simulate(case.with_(changes), 0.8, progress=False)
    weight = float(history.normal_force.sel(axis="z").isel(time=0).sum())
    assert float(abs(shoe_imbalance(history).force).max()) < 2e-6 * weight
    for values in frame_imbalance(history).values():
        assert np.abs(values.values).max() < 1e-4 * weight
    assert 0.1 * 0.02 < history.side_frame_angular_velocity.values[-20:, 2].mean() < 0.02
    right, left = (history.of_track(side).drive_moment.values[-20:].mean() for side in ("right", "left"))
    assert right > 0.0 > left


def test_a_machine_stands_on_a_grade_by_friction_and_leans_to_its_rear():
    """The resultant of its weight meets the ground where the pressure's centre is."""
    case = Case.shovel().with_({"terrain.grade": 0.1}, drive=STILL)
    data = simulate(case, 0.02, progress=False).dataset.isel(time=-1)
    place, turn = data.side_frame_position.values, rotation_matrices(data.side_frame_angles.values)
    parts = [(part.mass, place + turn @ part.com) for part in case.gear.frame_parts]
    tumblers = data.tumbler_position.transpose("track", "axis").values
    parts += [(case.gear.tumbler.mass, one) for one in tumblers]
    parts += [(case.shoe.mass, one) for one in data.position.values]
    mass, down = sum(part[0] for part in parts), case.gravity_vector()
    middle = sum(part[0] * part[1] for part in parts) / mass
    pressed = np.linalg.norm(data.normal_force.values, axis=-1)
    pressure = pressed @ data.point.values / pressed.sum()
    met = middle - (middle[2] - pressure[2]) / down[2] * down
    assert pressure[0] == pytest.approx(met[0], abs=0.02)
    assert met[0] < middle[0] - 0.3
    held = (data.normal_force + data.friction_force).sum("contact").values
    # the ground gives as it takes the friction up
    assert held == pytest.approx(-mass * down, abs=5e-3 * mass * case.gravity)
