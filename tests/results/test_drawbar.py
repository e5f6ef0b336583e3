"""Drawbar tests: the closed form against its integral, the case of a test, a run beside the closed form."""

import numpy as np
import pytest
from scipy.integrate import quad

from exudyn_crawler import Case, CaseFile, StepProfile, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.results.measured import drawbar
from exudyn_crawler.results.measured.traction import EvenTrack, even_track
from exudyn_crawler.sweep.answers import Drawbar

SPRINGS = BekkerSoil.lete_sand().with_(
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
    track = EvenTrack(law, length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1)
    strength = 100e3 * (np.tan(np.radians(law.friction_angle)) + law.cohesion / 101e3)
    for slip in (0.01, 0.05, 0.2, 1.0):
        shear = quad(lambda x, i=slip: -np.expm1(-i * x / law.shear_deformation), 0.0, 3.0)[0] / 3.0
        assert track.thrust(np.array([slip]))[0] == pytest.approx(1.5 * strength * shear, rel=1e-6)


def test_resistance_is_the_work_of_compaction_less_what_springs_back():
    law = BekkerSoil.lete_sand()
    track = EvenTrack(law, length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1)
    modulus = law.k_c / 0.5 + law.k_phi
    sinkage = (100e3 / modulus) ** (1.0 / law.exponent)
    bekker = 0.5 * modulus * sinkage ** (law.exponent + 1.0) / (law.exponent + 1.0)
    back = 0.5 * 0.5 * 100e3**2 / law.reload_stiffness
    assert track.sinkage == pytest.approx(sinkage, rel=1e-6)
    assert track.resistance == pytest.approx(bekker - back, rel=2e-3)
    springs = EvenTrack(SPRINGS, length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1)
    assert springs.resistance == pytest.approx(0.0, abs=1e-6)


def test_no_thrust_without_slip():
    track = EvenTrack(BekkerSoil.lete_sand(), length=3.0, width=0.5, area=1.5, weight=150e3, tracks=1)
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


def test_cases_without_a_drawbar_are_refused():
    with pytest.raises(ValueError, match=r"gear\.kind must be 'closed' or 'machine' .*'rolled'"):
        even_track(Case.rolled().on_cells(SPRINGS))
    posts = closed_case()
    posts = posts.with_(gear=posts.gear.with_(support="posts"))
    for other in (posts, Case.translation(), Case.rolled()):
        drive = other.drive.with_(slip=StepProfile.constant(0.1))
        with pytest.raises(ValueError, match=r"drive\.slip must be none but for closed tracks on the ground"):
            other.with_(drive=drive)
    with pytest.raises(ValueError, match=r"slip must lie within 0 and 1, got .*1\.1"):
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
    with pytest.raises(ValueError, match=r"slip must be among those that are held, up to 0\.2, got 0\.3"):
        answer.check(file)
    with pytest.raises(ValueError, match=r"gradeability: drawbar needs a drive\.slip"):
        Drawbar(result="gradeability").check(CaseFile(case=closed_case(), duration=1.0))


@pytest.mark.simulation
@pytest.mark.slow
def test_a_drawbar_holds_the_slip():
    case = Case.closed()
    drive = Drive(
        speed=StepProfile(times=(0.0, 0.1), values=(0.0, 0.1)),
        slip=StepProfile(times=(0.1, 0.15), values=(0.0, 0.4)),
        # at the frame's origin, whose speed a history has, but for the centimetres that it sinks at rest
        drawbar_height=float(case.frame_start[2]),
    )
    held = case.with_(drive=drive, solver=case.solver.with_(step=5e-3, output_interval=0.02))
    history = simulate(held.on_cells(SPRINGS, cell=0.2), 0.2, progress=False)
    speed = history.side_frame_velocity.sel(axis="x").values
    time = history.time.values
    assert speed[time >= 0.15] == pytest.approx(0.06, rel=0.01)
    at_ends = speed[(time > 0.09) & (time < 0.11)]
    assert at_ends == pytest.approx(0.1, rel=0.01)


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
@pytest.mark.parametrize(("stays", "part"), [(True, 0.72), (False, 1.0)])
def test_a_rut_takes_pull_at_little_slip(stays, part):
    law = BekkerSoil.lete_sand()
    law = law if stays else law.with_(reload_stiffness=0.0)
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
