"""Drawbar tests: the closed form against its integral, the case of a test, a run beside the closed form."""

from importlib.resources import files
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from exudyn_crawler import Case, CaseFile, StepProfile, read_case, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.results.measured import drawbar
from exudyn_crawler.results.measured.traction import EvenTrack, even_track
from exudyn_crawler.sweep.answers import Drawbar

SPRINGS = BekkerSoil.lete_sand("chrono").with_(
    exponent=1.0, k_c=0.0, k_phi=2e7, reload_stiffness=0.0, cohesion=0.0, friction_angle=31.1
)
"""Soil that springs back, so that no rut stays and no work of compaction."""
SPACING, RADIUS, SPEED = 0.33, 0.16, 0.5
"""m, of many small rollers, which press evenly; m/s of the chain."""


def closed_case(law=SPRINGS):
    """Half a machine on a closed track below many rollers without resistance, its weight in the middle."""
    case = Case.closed()
    gear = case.gear
    lower = gear.roller_radius - RADIUS

    def moved(place):
        return place[0], place[1] + lower

    gear = gear.with_(
        rollers=tuple(SPACING * number for number in range(-9, 10)),
        roller_radius=RADIUS,
        tumbler=gear.tumbler.with_(place=moved(gear.tumbler.place)),
        idler=gear.idler.with_(place=moved(gear.idler.place)),
        carriers=tuple(map(moved, gear.carriers)),
        rolling_resistance=0.0,
        com=(0.0, 0.0, gear.com[2]),
    )
    drive = Drive(speed=StepProfile(times=(0.0, 2.0), values=(0.0, SPEED)))
    solver = case.solver.with_(step=5e-3, output_interval=0.05)
    return case.with_(gear=gear, drive=drive, solver=solver).on_cells(law, cell=0.2)


def test_thrust_is_the_integral_of_shear_over_the_length():
    law = BekkerSoil.lete_sand()
    track = EvenTrack(law, length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1, rollers=6)
    strength = 100e3 * (np.tan(np.radians(law.friction_angle)) + law.cohesion / 101e3)
    for slip in (0.01, 0.05, 0.2, 1.0):
        shear = quad(lambda x, i=slip: -np.expm1(-i * x / law.shear_deformation), 0.0, 3.0)[0] / 3.0
        assert track.thrust(np.array([slip]))[0] == pytest.approx(1.5 * strength * shear, rel=1e-6)


@pytest.mark.parametrize("starts", [1, 6])
def test_shear_that_starts_anew_is_integrated_over_the_distance_of_the_rollers(starts):
    law = BekkerSoil.lete_sand()
    track = EvenTrack(law, length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1, rollers=6)
    span = 3.0 / starts
    places = np.arange(0.5e-4, 3.0, 1e-4) % span
    for slip in (0.02, 0.1):
        mobilized = np.mean(-np.expm1(-slip * places / law.shear_deformation))
        thrust = track.thrust(np.array([slip]), starts)[0]
        assert thrust == pytest.approx(mobilized * track.strength, rel=1e-5)


def test_rebound_is_the_share_of_the_sinkage_that_unloading_gives_back():
    def rebound(law, weight):
        track = EvenTrack(law, length=3.0, width=0.5, area=1.5, weight=weight, tracks=1, rollers=6)
        return track.rebound, track.pressure, track.sinkage

    stiff, pressure, sinkage = rebound(BekkerSoil.lete_sand("chrono"), 300e3)
    assert stiff == pytest.approx(pressure / 4e8 / sinkage, abs=2.0 / 400)
    assert rebound(BekkerSoil.lete_sand(), 300e3)[0] == 1.0
    deep, pressure, sinkage = rebound(BekkerSoil.lete_sand(), 900e3)
    assert deep == pytest.approx(pressure / (503e6 * sinkage) / sinkage, abs=2.0 / 400)


@pytest.mark.parametrize("unloading", ["wong", "chrono"])
def test_a_rut_without_pressure_between_rollers_forgets_shear(unloading):
    """A cell under six rollers: its pressure falls between them by a fifth of the sinkage and grows again.

    Shear that the ground keeps is Janosi's of the whole way; where it starts anew, a roller gives what the
    first one gave.
    """
    law = BekkerSoil.lete_sand(unloading)
    spacing, slip, deepest = 0.4, 0.02, 8e-3
    way = np.arange(0.0, 6.0 * spacing, 5e-4)
    depth = deepest * (0.9 - 0.1 * np.cos(2.0 * np.pi * way / spacing))
    pressure, shear = law.drive(depth, slip * way)
    strength = pressure * (np.tan(np.radians(law.friction_angle)) + law.cohesion / (pressure + 1e3))
    middles = np.flatnonzero(np.isclose(way % spacing, 0.5 * spacing, atol=1e-6))
    mobilized = shear[middles] / strength[middles]
    kept = -np.expm1(-slip * way[middles] / law.shear_deformation)
    if unloading == "wong":
        # less by what the first roller misses while its pressure still rises
        assert np.all((mobilized < kept) & (mobilized > kept - 0.03))
        return
    assert pressure.min() == 0.0
    assert mobilized[1:] == pytest.approx(np.full(5, mobilized[1]), rel=1e-3)
    assert mobilized[-1] < 0.25 * kept[-1]


def test_resistance_is_the_work_of_compaction_less_what_springs_back():
    law = BekkerSoil.lete_sand("chrono")
    track = EvenTrack(law, length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1, rollers=6)
    modulus = law.k_c / 0.5 + law.k_phi
    sinkage = (100e3 / modulus) ** (1.0 / law.exponent)
    bekker = 0.5 * modulus * sinkage ** (law.exponent + 1.0) / (law.exponent + 1.0)
    back = 0.5 * 0.5 * 100e3**2 / law.reload_stiffness
    assert track.sinkage == pytest.approx(sinkage, rel=1e-6)
    assert track.resistance == pytest.approx(bekker - back, rel=2e-3)
    springs = EvenTrack(SPRINGS, length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1, rollers=6)
    assert springs.resistance == pytest.approx(0.0, abs=1e-6)


def test_no_thrust_without_slip():
    sand = BekkerSoil.lete_sand()
    track = EvenTrack(sand, length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1, rollers=6)
    assert track.thrust(np.zeros(1)) == pytest.approx([0.0], abs=1e-6 * track.strength)
    assert track.pull(np.zeros(1)) == pytest.approx([-track.resistance], rel=1e-3)


def pulled(case, slips=(0.02, 0.2), **changes):
    """Case of a drawbar test, and how long it lasts."""
    file = CaseFile(case=case, duration=1.0)
    changed = drawbar.pulled_case(file, drawbar.DrawbarTest(slips, **changes))
    return changed.case, changed.duration


def test_slips_rise_and_are_held_until_the_machine_goes_steadily():
    case, duration = pulled(closed_case(), height=0.5)
    passage = even_track(case).length / SPEED
    slip = case.drive.slip
    assert slip.values == (0.0, 0.02, 0.02, 0.2, 0.2)
    assert slip.times[0] == pytest.approx(2.0 + 2.85 * passage)
    assert np.diff(slip.times) == pytest.approx([0.15 * passage, 2.85 * passage] * 2)
    assert duration == slip.times[-1]
    assert case.drive.drawbar_height == 0.5
    case.check_support(duration)


def test_ground_of_cells_gets_as_long_as_the_way():
    enough, _ = pulled(closed_case().with_({"terrain.length": 200.0}))
    assert enough.terrain.length == 200.0
    case, duration = pulled(closed_case())
    assert closed_case().terrain.length < case.terrain.length < 200.0
    case.check_support(duration)


@pytest.mark.parametrize("name", ["m113", "marder"])
def test_machines_with_their_sprocket_in_front_travel_the_other_way(name):
    library = files("exudyn_crawler.machines.datasheet") / "library"
    case = read_case(library / f"{name}.toml").case
    assert case.drive.speed.values[-1] < 0.0
    test, duration = pulled(case, drawbar.SLIPS)
    test.check_support(duration)
    (rear, front), (before, _) = test.terrain.bounds[0], case.terrain.bounds[0]
    assert rear == pytest.approx(test.outline(duration)[:, 0].min() - even_track(case).length)
    assert rear < before
    assert front == pytest.approx(case.terrain.bounds[0][1])


def test_a_drive_that_ends_at_rest_is_refused():
    case = closed_case()
    for speed in (StepProfile.constant(0.0), StepProfile(times=(0.0, 1.0, 2.0), values=(0.0, SPEED, 0.0))):
        with pytest.raises(ValueError, match=r"drive\.speed must not end at zero in a drawbar test"):
            pulled(case.with_({"drive.speed": speed}))


class Ridden:
    """History of a test in closed form: travel by slip, and a frame that nods about the drawbar's place."""

    def __init__(self, case, duration, pull, torque):
        self.case = case
        sense = np.sign(case.drive.speed.values[-1])
        time = np.linspace(0.0, duration, 20001)
        self.time = xr.DataArray(time, dims="time")
        speed, slip = case.drive.speed.value(time), case.drive.slip.value(time)
        chain = case.drive.speed.integral(time)
        steps = 0.5 * ((speed * (1.0 - slip))[1:] + (speed * (1.0 - slip))[:-1]) * np.diff(time)
        place = np.concatenate(([0.0], np.cumsum(steps)))
        nod = 0.01 * np.sin(0.3 * time)
        axes = Rotation.from_rotvec(np.outer(nod, [0.0, 1.0, 0.0])).as_matrix()
        up = case.gear.frame_start(case)[2] - case.drive.drawbar_height
        position = np.column_stack((place + axes[:, 0, 2] * up, 0.0 * time, 0.0 * time))
        self.side_frame_position = xr.DataArray(position, dims=("time", "axis"), coords={"axis": [*"xyz"]})
        angles = np.column_stack((0.0 * nod, nod, 0.0 * nod))
        self.side_frame_angles = xr.DataArray(angles, dims=("time", "axis"))
        self._named = {
            "tumbler_angle": chain / case.gear.travel_per_angle(case.track),
            "drive_moment": np.full_like(time, sense * torque),
            "drawbar_pull": np.full_like(time, sense * pull),
        }

    def quantity(self, name):
        """Quantity of a name over time."""
        return xr.DataArray(self._named[name], dims="time")

    def contacts_by_shoe(self):
        """Area and sinkage of one shoe."""
        one = xr.DataArray(np.full((len(self.time), 1), 0.01), dims=("time", "shoe"))
        return SimpleNamespace(area=one, penetration=one)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_table_has_the_slip_of_the_drawbars_place_in_either_sense(sense):
    case = closed_case()
    speed = StepProfile(times=(0.0, 2.0), values=(0.0, sense * SPEED))
    case, duration = pulled(case.with_({"drive.speed": speed, "gear.torque_limit": 300e3}), (0.01, 0.1))
    ridden = Ridden(case, duration, pull=200e3, torque=400e3)
    table = drawbar.drawbar_table(ridden).rename(columns={head: name for name, head in drawbar.HEADS.items()})
    assert table["wanted"].tolist() == [0.0, 0.01, 0.1]
    assert table["slip"].to_numpy() == pytest.approx([0.0, 0.01, 0.1], abs=1e-6)
    assert table["pull"].to_numpy() == pytest.approx(np.full(3, 200e3))
    force = 400e3 / case.gear.travel_per_angle(case.track)
    assert table["efficiency"].to_numpy() == pytest.approx(200e3 * (1.0 - table["slip"]) / force, rel=1e-6)
    assert table["resistance"].to_numpy() == pytest.approx(np.full(3, force - 200e3), rel=1e-6)


def test_slips_that_are_missed_and_a_drive_that_would_stall_are_said():
    case, duration = pulled(closed_case().with_({"gear.torque_limit": 300e3}), (0.01, 0.1))
    ridden = Ridden(case, duration, pull=200e3, torque=299e3)
    table = drawbar.drawbar_table(ridden)
    assert list(drawbar.remarks(ridden, table)) == []
    table[drawbar.HEADS["slip"]] = [1e-4, 0.0101, 0.065]
    assert list(drawbar.remarks(ridden, table)) == ["slip: 10 % wanted, 6.5 % measured"]
    ridden = Ridden(case, duration, pull=200e3, torque=310e3)
    (stalls,) = drawbar.remarks(ridden, drawbar.drawbar_table(ridden))
    assert stalls.startswith("the drive stalls before a slip of 0 %, which takes 310 kN m of its 300 kN m")


def test_cases_without_a_drawbar_are_refused():
    with pytest.raises(ValueError, match=r"gear\.kind must be 'closed' or 'machine' .*'rolled'"):
        even_track(Case.rolled().on_cells(SPRINGS))
    posts = closed_case()
    posts = posts.with_(gear=posts.gear.with_(support="posts"))
    for other in (posts, Case.translation(), Case.rolled()):
        drive = other.drive.with_(slip=StepProfile.constant(0.1))
        with pytest.raises(ValueError, match=r"drive\.slip must be none: only closed tracks on the ground"):
            other.with_(drive=drive)
    with pytest.raises(ValueError, match=r"slip must be between 0 and 1, got .*1\.1"):
        Drive(speed=StepProfile.constant(0.0), slip=StepProfile.constant(1.1))


@pytest.mark.parametrize("slips", [(), (0.0, 0.1), (0.1, 0.1), (0.2, 0.1), (0.5, 1.0)])
def test_slips_that_do_not_rise_are_refused(slips):
    with pytest.raises(ValueError, match="slips must increase between 0 and 1"):
        pulled(closed_case(), slips)


def test_slips_are_read_from_words():
    assert drawbar.read_slips("0.02, 0.1") == (0.02, 0.1)
    with pytest.raises(ValueError, match="slips must be numbers with commas between them, got '2 %'"):
        drawbar.read_slips("2 %")


def answered(**words):
    return Drawbar(**words), CaseFile(case=pulled(closed_case())[0], duration=1.0)


def test_an_answer_of_a_sweep_has_to_lie_among_the_slips():
    answer, file = answered(slip=0.2)
    answer.check(file)
    assert (answer.label, answer.unit) == ("pull_at_slip_0.2", "N")
    answer, file = answered(slip=0.3)
    with pytest.raises(ValueError, match=r"slip must be at most the greatest held slip, 0\.2, got 0\.3"):
        answer.check(file)
    with pytest.raises(ValueError, match=r"gradeability: drawbar needs a drive\.slip"):
        Drawbar(result="gradeability").check(CaseFile(case=closed_case(), duration=1.0))


@pytest.mark.simulation
@pytest.mark.slow
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_drawbar_holds_the_slip_and_the_drive_its_speed_beyond_its_torque(sense):
    case = Case.closed()
    drive = Drive(
        speed=StepProfile(times=(0.0, 0.1), values=(0.0, 0.1 * sense)),
        slip=StepProfile(times=(0.1, 0.15), values=(0.0, 0.4)),
        # at the frame's origin, whose speed a history has, but for the centimetres that it sinks at rest
        drawbar_height=float(case.gear.frame_start(case)[2]),
    )
    case = case.with_({"gear.torque_limit": 1e3})
    held = case.with_(drive=drive, solver=case.solver.with_(step=5e-3, output_interval=0.02))
    history = simulate(held.on_cells(SPRINGS, cell=0.2), 0.2, progress=False)
    speed = sense * history.side_frame_velocity.sel(axis="x").values
    time = history.time.values
    assert speed[time >= 0.15] == pytest.approx(0.06, rel=0.01)
    at_ends = speed[(time > 0.09) & (time < 0.11)]
    assert at_ends == pytest.approx(0.1, rel=0.01)
    chain = sense * history.tumbler_speed.values * case.gear.travel_per_angle(case.track)
    assert chain[time >= 0.1] == pytest.approx(0.1, rel=1e-6)
    assert np.abs(history.drive_moment.values).max() > 10.0 * case.gear.torque_limit


@pytest.fixture(scope="module")
def springing():
    """Drawbar test on soil that springs back, below many rollers."""
    case, duration = pulled(closed_case(), drawbar.SLIPS)
    return simulate(case, duration, progress=False)


def even(history):
    """Slip, and pull over that of the closed form, of the slips above zero."""
    table = drawbar.drawbar_table(history).iloc[1:]
    ratio = table[drawbar.HEADS["pull"]] / table[drawbar.HEADS["closed"]]
    return table[drawbar.HEADS["slip"]].to_numpy(), ratio.to_numpy()


@pytest.mark.simulation
@pytest.mark.slow
def test_pull_over_slip_is_the_closed_form_where_its_assumptions_hold(springing):
    slip, ratio = even(springing)
    assert slip == pytest.approx(drawbar.SLIPS, rel=0.01)
    assert ratio == pytest.approx(1.0, abs=0.03)


@pytest.mark.simulation
@pytest.mark.slow
def test_work_of_the_drive_is_that_of_the_pull_of_slip_and_of_resistance(springing):
    table = drawbar.drawbar_table(springing).iloc[1:]
    values = {name: table[head].to_numpy() for name, head in drawbar.HEADS.items()}
    gear = springing.case.gear
    force = values["torque"] / gear.travel_per_angle(springing.case.track)
    assert values["pull"] + values["resistance"] == pytest.approx(force, rel=0.01)
    drawn = values["pull"] * (1.0 - values["slip"]) / force
    assert values["efficiency"] == pytest.approx(drawn, rel=0.01)
    result = drawbar.drawbar_result(springing)
    assert np.tan(result.gradeability) == pytest.approx(values["pull"].max() / result.track.weight)
    at_slip = values["pull"][drawbar.SLIPS.index(0.2)]
    assert result.pull_at_slip == pytest.approx(at_slip, rel=1e-3)
    assert abs(result.motion_resistance) < 0.01 * result.greatest_pull


@pytest.mark.simulation
@pytest.mark.slow
@pytest.mark.parametrize(("unloading", "part"), [("chrono", 0.72), ("wong", 1.0)])
def test_a_rut_takes_pull_at_little_slip(unloading, part):
    law = BekkerSoil.lete_sand(unloading)
    case, duration = pulled(closed_case(law), (0.02,))
    _, ratio = even(simulate(case, duration, progress=False))
    assert ratio[0] == pytest.approx(part, abs=0.03)


@pytest.mark.simulation
@pytest.mark.slow
def test_a_machine_pulls_as_two_tracks_do():
    """Both tracks of the 4100C with its seven rollers on soil that springs back: the closed form within 3 %.

    Its weight in the middle and no rolling resistance, as the closed form has it.
    """
    case = Case.shovel()
    gear = case.gear
    body = gear.car_body.with_(com=(0.0, 0.0, 0.0), upper_com=(0.0, 0.0, 4.0))
    gear = gear.with_(rolling_resistance=0.0, car_body=body, com=(0.0, 0.0, gear.com[2]))
    drive = Drive(speed=StepProfile(times=(0.0, 2.0), values=(0.0, SPEED)))
    solver = case.solver.with_(step=5e-3, output_interval=0.05)
    case = case.with_(gear=gear, drive=drive, solver=solver).on_cells(SPRINGS, cell=0.2)
    pulls, duration = pulled(case, (0.05, 0.2))
    history = simulate(pulls, duration, progress=False)
    slip, ratio = even(history)
    assert slip == pytest.approx([0.05, 0.2], rel=0.01)
    assert ratio == pytest.approx(1.0, abs=0.03)
    result = drawbar.drawbar_result(history)
    assert result.track.tracks == 2
    masses = [part.mass for part in case.gear.frame_parts]
    masses += [case.gear.tumbler.mass] * 2 + [case.shoe.mass] * 76
    assert result.track.weight == pytest.approx(9.81 * sum(masses), rel=1e-3)
