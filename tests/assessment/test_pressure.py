"""Pressure of two tracks against hand calculations, and of beams against a plate on linear ground."""

import numpy as np
import pytest

from exudyn_crawler.assessment import forces, pressure
from exudyn_crawler.assessment.forces import MachineWeights, Resultant, Work
from exudyn_crawler.assessment.pressure import Footprints
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor

SHOVEL = Footprints(gauge=9.3, length=7.8, width=3.5)
WEIGHT, MOMENT = 14e6, 14e6


def slewing(degrees, arm=MOMENT / WEIGHT):
    angle = np.radians(degrees)
    nothing = np.zeros_like(angle)
    weight = np.full_like(angle, WEIGHT)
    return Resultant(weight, arm * np.cos(angle), arm * np.sin(angle), nothing, nothing)


def test_greatest_pressure_is_between_the_cardinal_angles():
    """By hand: V / (b L) (1/2 + e sin / B) (1 + 6 e cos / L)."""
    left, right = pressure.pressure_of_tracks(slewing(np.array([0.0, 30.0, 90.0])), SHOVEL)
    greatest = np.maximum(left.greatest, right.greatest)
    assert greatest / 1e3 == pytest.approx([453.65, 473.16, 311.55], abs=0.01)


def test_both_tracks_carry_the_weight_and_its_moment():
    stands = slewing(np.linspace(0.0, 360.0, 25))
    left, right = pressure.track_loads(stands.weight, stands.aside, SHOVEL.gauge)
    assert left + right == pytest.approx(stands.weight)
    assert (left - right) * 0.5 * SHOVEL.gauge == pytest.approx(stands.weight * stands.aside, abs=1e-3)


@pytest.mark.parametrize("part", [0.0, 0.1, 1 / 6, 0.3, 0.45])
def test_a_beams_pressure_has_its_load_and_its_place(part):
    """Trapezoid and triangle: force, and first moment from the loaded end, by their areas."""
    load, length, width = 5e6, 8.0, 1.2
    found = pressure.track_pressure(load, part * length, length, width)
    force = 0.5 * (found.greatest + found.least) * found.length * width
    assert force == pytest.approx(load)
    fall = (found.greatest - found.least) * found.length * width
    moment = 0.5 * found.least * width * found.length**2 + fall * found.length / 6.0
    assert moment / load == pytest.approx((0.5 - part) * length)
    assert found.mean == pytest.approx(load / (width * found.length))
    assert found.even == pytest.approx(load / (width * length * (1.0 - 2.0 * part)))


def test_triangles_length_and_pressure_by_hand():
    """Load at 3 m of L = 8 m: 3 (4 - 3) = 3 m carry, 2 P / (b L') at the end."""
    found = pressure.track_pressure(6e6, 3.0, 8.0, 2.0)
    assert (found.length, found.greatest, found.least) == (3.0, pytest.approx(2e6), 0.0)
    tipped = pressure.track_pressure(6e6, 4.0, 8.0, 2.0)
    assert np.isinf(tipped.greatest)
    assert tipped.length == 0.0


def test_a_plate_is_that_of_both_rectangles_while_all_of_it_carries():
    """P / A + M c / I, by hand."""
    b, length, gauge = SHOVEL.width, SHOVEL.length, SHOVEL.gauge
    along = 2.0 * b * length**3 / 12.0
    across = 2.0 * (b * length * gauge**2 / 4.0 + length * b**3 / 12.0)
    x, y = 0.5, -0.8
    found = pressure.plate_pressure(WEIGHT, x, y, SHOVEL)
    change = WEIGHT * (abs(x) * 0.5 * length / along + abs(y) * 0.5 * (gauge + b) / across)
    middle = WEIGHT / SHOVEL.area
    # sums over rectangles leave out a part of (1 / 240)^2 and (1 / 12)^2 of the second moments
    assert found.greatest == pytest.approx(middle + change, rel=1e-3)
    assert found.least == pytest.approx(middle - change, rel=3e-3)


@pytest.mark.parametrize("stiffness", [1e7, 1e9])
def test_a_plate_that_lifts_carries_the_weight_on_what_is_left(stiffness):
    """Straight ahead it is the beams' triangle, whatever the ground's stiffness is."""
    found = pressure.plate_pressure(WEIGHT, 3.0, 0.0, SHOVEL, pressure.linear_ground(stiffness))
    beam = pressure.track_pressure(0.5 * WEIGHT, 3.0, SHOVEL.length, SHOVEL.width)
    assert found.greatest == pytest.approx(beam.greatest, rel=2e-3)
    part = SHOVEL.area / len(found.x)
    assert found.pressure.sum() * part == pytest.approx(WEIGHT)
    assert (found.pressure * found.x).sum() * part == pytest.approx(3.0 * WEIGHT)
    assert found.least == 0.0


def test_laws_of_cells_are_laws_of_plates():
    """Rock floor is linear, so that its plate is Winkler's; soil that hardens less evens the pressure."""
    width = min(SHOVEL.length, SHOVEL.width)
    rock = RockFloor.hard_floor()
    assert rock.exponent == 1.0
    law = pressure.law_of_sinkage(lambda p: rock.sinkage(p, width), 1e7)
    linear = pressure.plate_pressure(WEIGHT, 0.8, 0.5, SHOVEL)
    assert pressure.plate_pressure(WEIGHT, 0.8, 0.5, SHOVEL, law).greatest == pytest.approx(
        linear.greatest, rel=1e-4
    )
    sand = BekkerSoil.lete_sand()
    law = pressure.law_of_sinkage(lambda p: sand.sinkage(p, width), 1e7)
    softer = pressure.plate_pressure(WEIGHT, 0.8, 0.5, SHOVEL, law)
    assert softer.greatest < linear.greatest
    assert sand.exponent < 1.0


def test_a_machine_that_tips_is_refused():
    with pytest.raises(ValueError, match="tips"):
        pressure.plate_pressure(WEIGHT, 4.0, 0.0, SHOVEL)


def test_resultant_by_hand():
    """Upper structure, payload and bank ahead, aside and astern; level and on a slope."""
    weights = MachineWeights(100.0, (0.2, 0.0, 1.0), 60.0, (-1.0, 0.0, 3.0), 0.5)
    work = Work(payload=10.0, reach=8.0, height=4.0, digging=(-200.0, 100.0))
    level = forces.gravity_on_slope(10.0, 0.0, 0.0)
    found = forces.resultant(forces.forces_at(weights, work, np.radians([0.0, 90.0]), level))
    weight = 1700.0 - 100.0
    assert found.weight == pytest.approx([weight, weight])
    ahead = 1000.0 * 0.2 + 600.0 * (0.5 - 1.0) + (100.0 - 100.0) * 8.5 - 200.0 * 4.0
    assert found.ahead[0] == pytest.approx(ahead / weight)
    aside = 600.0 * -1.0 + (100.0 - 100.0) * 8.0 - 200.0 * 4.0
    assert found.aside[1] == pytest.approx(aside / weight)
    assert found.push_left[1] == pytest.approx(-200.0)
    # downhill to the left: the weight's foot moves by its height times the slope
    idle = MachineWeights(100.0, (0.0, 0.0, 2.0), 0.0, (0.0, 0.0, 0.0))
    slope = forces.gravity_on_slope(10.0, np.arctan(0.1), np.radians(90.0))
    leaning = forces.resultant(forces.forces_at(idle, Work(), np.zeros(1), slope))
    assert leaning.aside == pytest.approx([0.2])
    assert leaning.weight == pytest.approx([1000.0 * np.cos(np.arctan(0.1))])


def test_slewing_pulls_outward():
    """By m r w^2 of upper structure and payload, at the height of both."""
    weights = MachineWeights(100.0, (0.0, 0.0, 1.0), 50.0, (2.0, 0.0, 3.0))
    work = Work(payload=10.0, reach=10.0, height=6.0, slew_rate=0.5)
    found = forces.forces_at(weights, work, np.zeros(1), forces.gravity_on_slope(10.0, 0.0, 0.0))
    assert found.force[0, -1] == pytest.approx([0.25 * 200.0, 0.0, 0.0])
    assert found.place[0, -1, 2] == pytest.approx(0.5 * 3.0 + 0.5 * 6.0)


def test_clay_and_rollers_by_hand():
    assert pressure.bearing_capacity(50e3, Footprints(3.0, 5.0, 1.0)) == pytest.approx(257e3 * 1.04)
    # 100 kN, 5 rollers, A_l 1, b 0.5 m, p 0.2 m, D 0.8 m: 1.26 x 100 / (10 x 0.5 x 0.4) = 63 kPa
    assert pressure.mean_maximum_pressure(1e5, 5, 1.0, 0.5, 0.2, 0.8) == pytest.approx(63e3)
