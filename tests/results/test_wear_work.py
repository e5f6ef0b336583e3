"""Work of wear from histories: sweeps of hinges, and pairs of a short run of a machine."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from exudyn_crawler import StepProfile, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.library import machines
from exudyn_crawler.results.wear.closed_form import (
    GrowthLimit,
    WheelTensions,
    bends,
    bends_of,
    growth_limits,
    pin_drag,
    pin_work,
    take_up_of,
)
from exudyn_crawler.results.wear.duty_work import DutyWork, growth_table
from exudyn_crawler.results.wear.parts import limit_fraction, limit_source
from exudyn_crawler.results.wear.plan import WearDuty, WearPart, WearPlan, WearRun
from exudyn_crawler.results.wear.sweeps import sweep_signs, sweep_work
from exudyn_crawler.results.wear.work import PAIRS, run_work
from tests.results.test_machine_answers import SHEET

RADIUS = 0.0238


def test_work_of_one_hinge_is_force_times_radius_times_angle():
    angle = np.linspace(0.0, 0.6, 50)[:, None]
    work = sweep_work(angle, np.full((50, 1), 4e4), RADIUS, math.radians(20.0))
    assert work.sum() == pytest.approx(4e4 * RADIUS * 0.6, rel=1e-12)


@pytest.mark.parametrize("ripple", [0.0, 0.02, 0.05])
def test_sweeps_of_a_sine_are_four_amplitudes_a_period_whatever_the_ripple(ripple):
    periods, amplitude = 5, 0.3
    time = np.linspace(0.0, periods, 20_001)
    # the ripple's extremes coincide with the sine's, and its ends with zero
    angle = amplitude * np.sin(2.0 * np.pi * time) + ripple * np.sin(2.0 * np.pi * 41 * time)
    work = sweep_work(angle[:, None], np.ones((len(time), 1)), 1.0, 0.2)
    # the sweep after the last turning point counts as well, since it is above the threshold
    assert work.sum() == pytest.approx(periods * 4.0 * (amplitude + ripple), rel=0.02)
    raw = sweep_work(angle[:, None], np.ones((len(time), 1)), 1.0, 0.0).sum()
    assert raw == pytest.approx(np.abs(np.diff(angle)).sum())
    assert ripple == 0.0 or raw > 2.0 * work.sum()


def test_turns_below_the_threshold_count_for_nothing():
    angle = 0.05 * np.sin(np.linspace(0.0, 60.0, 2000))[:, None]
    assert not sweep_signs(angle, 0.2).any()
    # each item has sweeps of its own
    both = np.column_stack((angle[:, 0], np.linspace(0.0, 1.0, 2000)))
    signs = sweep_signs(both, 0.2)
    assert not signs[:, 0].any()
    assert (signs[:, 1] == 1).all()


def test_closed_form_adds_bends_on_and_off_both_wheels():
    angles = bends(10.5, 0.216, 0.3, 0.062)
    assert np.degrees(angles) == pytest.approx([34.29, 33.22], abs=0.02)
    even = pin_work(RADIUS, angles, WheelTensions(3e4, 3e4, 3e4, 3e4))
    assert even == pytest.approx(2.0 * 3e4 * RADIUS * (angles.tumbler + angles.idler))
    # a pull acts forward on one side of the tumbler, and in reverse on both sides of the idler, too
    forward = pin_work(RADIUS, angles, WheelTensions(8e4, 3e4, 3e4, 3e4))
    reverse = pin_work(RADIUS, angles, WheelTensions(3e4, 8e4, 8e4, 8e4))
    assert 1.0 < forward / even < reverse / even


@pytest.fixture(scope="module")
def travels():
    """Begin of travel of an excavator, at half of its speed after 0.05 s."""
    speed = Drive(speed=StepProfile(times=(0.0, 0.05), values=(0.0, 0.6)))
    case = derived(SHEET).case.with_({"solver.output_interval": 0.002}, drive=speed)
    return simulate(case, 0.1, progress=False)


def test_pins_resist_by_their_work_in_a_lap():
    """Greased pins by the closed form; rubber by half a cycle of Reid's law at each bend on and off."""
    case = derived(SHEET).case
    pitch = case.track.pitch
    tumbler, idler = bends_of(case)
    greased = 0.12 * 2.0 * (tumbler + idler) * 0.105 * pitch * 4e4 / pitch
    assert pin_drag(case, 4e4) == pytest.approx(greased)
    law = case.with_({"track.pin.kind": "rubber"}).track.pin.law(pitch)
    twisted = sum(
        2.0 * quad(lambda angle: 0.5 * np.pi * law.loss * law.stiffness * angle, 0.0, bend)[0]
        for bend in (tumbler, idler)
    )
    rubber = case.with_({"track.pin.kind": "rubber"})
    assert pin_drag(rubber, 4e4) == pytest.approx(twisted / pitch)
    assert pin_drag(case.with_({"track.pin.kind": "ideal"}), 4e4) == 0.0


def test_load_times_way_of_all_wheels_is_that_of_all_shoes(travels):
    """By two variables of the history; only a shoe between two wheels adds forces as vectors."""
    work = run_work(travels, RADIUS, 20.0)
    rails = work.by_place.sel(pair="rail").sum("place").values
    wheels = work.wheels.values.reshape(2, -1).sum(axis=1)
    assert wheels == pytest.approx(rails, rel=0.03)
    assert work.travel == pytest.approx(0.6 * 0.05 + 0.5 * 0.6 * 0.05, rel=0.02)
    # places sum up to all
    assert work.by_place.sel(pair="bush").values.min() >= 0.0
    assert work.each("rail") * work.shoes == pytest.approx(rails)
    # no hinge bends by 20 deg in a fifth of a pitch
    assert work.pins_by_threshold[0.0] > 0.0


def test_a_machine_that_stands_has_no_work(travels):
    stands = simulate(travels.case.with_(drive=Drive(speed=StepProfile.constant(0.0))), 0.02, progress=False)
    moving = run_work(travels, RADIUS, 20.0)
    work = run_work(stands, RADIUS, 20.0)
    assert work.travel == pytest.approx(0.0, abs=1e-6)
    for pair in PAIRS:
        assert work.each(pair).max() <= 1e-3 * moving.each("rail").max(), pair
    assert work.wheels.max() <= 1e-3 * moving.wheels.max()
    assert np.isnan(work.by_tensions) or work.by_tensions < 1e-3 * moving.by_tensions


def test_limits_of_growth_are_in_order_and_a_used_up_adjuster_is_one_of_them(travels):
    case = travels.case
    turning = GrowthLimit("turned", 0.0175, "source")
    limits = growth_limits(case, 0.0, turning)
    assert turning in limits
    assert [limit.growth for limit in limits] == sorted(limit.growth for limit in limits)
    end = case.gear.idler.range[1]
    used_up = growth_limits(case, end, turning)[0]
    assert (used_up.limit, used_up.growth) == ("adjuster used up", 0.0)
    growth = next(limit.growth for limit in limits if limit.limit == "adjuster used up")
    assert take_up_of(growth, case.track.shoe_count // 2, case.track.pitch) == pytest.approx(end)


@pytest.mark.parametrize(
    ("parts", "growth", "how"),
    [
        ((), limit_fraction("pitch"), limit_source("pitch")),
        ((WearPart(part="pitch", new=0.2),), limit_fraction("pitch"), limit_source("pitch")),
        ((WearPart(part="pitch", new=0.2, limit=0.206),), 0.03, "wear file"),
    ],
    ids=["no pitch", "limit of makers", "limit of the file"],
)
def test_the_limit_of_turning_names_its_source(travels, parts, growth, how):
    duty = WearDuty(runs=(WearRun(name="straight", folder="straight", share=1.0),))
    work = DutyWork(duty, {"straight": run_work(travels, RADIUS, 20.0)})
    table = growth_table(work, WearPlan(parts=parts, duties=(duty,)), None).set_index("limit")
    turned = table.loc["pins and bushes to be turned"]
    assert turned["growth in %"] == pytest.approx(100.0 * growth)
    assert turned["how"] == how
    assert "D31EX" in limit_source("pitch")


def test_an_interval_without_states_is_refused(travels):
    with pytest.raises(ValueError, match="must reach its end with at least 3 stored times"):
        run_work(travels, RADIUS, 20.0, 0.0, 5.0)


@pytest.mark.slow
@pytest.mark.parametrize("machine", ["pc300lc", "d155ax"])
def test_bushes_wear_more_in_reverse(machine):
    """Makers advise against driving in reverse, where bushes turn on the sprocket under load."""
    works = []
    for travel in ("straight", "backward"):
        case = read_case(machines()[machine], [f'datasheet.travel="{travel}"']).case
        radius, pitch = case.track.pin.radius_at(case.track.pitch), case.track.pitch
        speed = abs(case.drive.speed.values[-1])
        work = run_work(simulate(case, 1.2 + 5.0 * pitch / speed, progress=False), radius, 20.0, 1.2)
        works.append(float((work.each("bush") / work.laps).mean()))
    # found 1.24 (excavator) and 3.8 (dozer); with bushes about the rear pins 0.63 and 1.8
    assert works[1] > 1.1 * works[0]
