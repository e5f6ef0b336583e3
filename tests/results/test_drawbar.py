"""Drawbar tests: the closed form against its integral, the case of a test, a run beside the closed form."""

import numpy as np
import pytest
from scipy.integrate import quad

from exudyn_crawler import Case, CaseFile, StepProfile, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.results.measured import drawbar
from exudyn_crawler.results.measured.traction import EvenTrack, even_track

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


def test_the_pull_rises_after_a_start_and_acts_at_its_height():
    case = closed_case()
    track = even_track(case)
    test = drawbar.DrawbarTest(pull=1e6, rise=30.0, height=0.5)
    pulled = drawbar.pulled_case(CaseFile(case=case, duration=1.0), test)
    begin = pulled.duration - 30.0
    assert begin == pytest.approx(2.0 + drawbar.START_LENGTHS * track.length / SPEED)
    force, moment = pulled.case.machine_wrench([begin, pulled.duration])
    assert force[:, 0].tolist() == pytest.approx([0.0, -1e6], abs=1e-6)
    origin = case.running_gear().frame_start(case.shoe, case.track)[2]
    # the drawbar is below the rollers' axes or above them: a pull above them presses on the rear
    assert moment[:, 1].tolist() == pytest.approx([0.0, -1e6 * (0.5 - origin)], abs=1e-6)
    assert drawbar.pull_over_time(pulled.case, np.array([pulled.duration])) == pytest.approx([1e6])


def test_cases_without_a_drawbar_are_refused():
    with pytest.raises(ValueError, match=r"gear\.kind must be 'closed' or 'machine' .*'rolled'"):
        even_track(Case.rolled().on_cells(SPRINGS))
    file = CaseFile(case=closed_case(), duration=1.0)
    with pytest.raises(ValueError, match="pull must be greater than zero, got -1 N"):
        drawbar.pulled_case(file, drawbar.DrawbarTest(pull=-1.0))
    with pytest.raises(ValueError, match="rise must be greater than zero, got 0 s"):
        drawbar.pulled_case(file, drawbar.DrawbarTest(rise=0.0))


@pytest.mark.simulation
@pytest.mark.slow
def test_pull_over_slip_is_the_closed_form_where_its_assumptions_hold():
    test = drawbar.DrawbarTest(rise=40.0)
    pulled = drawbar.pulled_case(CaseFile(case=closed_case(), duration=1.0), test)
    history = simulate(pulled.case, pulled.duration, progress=False)
    table = drawbar.drawbar_table(history)
    pull, closed = table[drawbar.HEADS["pull"]], table[drawbar.HEADS["closed"]]
    late = table[drawbar.HEADS["slip"]] > 0.02
    assert late.sum() > 10
    assert (pull[late] / closed[late]).to_numpy() == pytest.approx(1.0, abs=0.03)
