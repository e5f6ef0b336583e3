"""Tipping over four edges against hand calculations."""

import numpy as np
import pytest

from exudyn_crawler.assessment import forces, stability
from exudyn_crawler.assessment.forces import MachineWeights, Work
from exudyn_crawler.assessment.stability import EDGES, Edges

LEVEL = forces.gravity_on_slope(10.0, 0.0, 0.0)
CRANE = MachineWeights(100e3, (0.0, 0.0, 1.0), 40e3, (-1.0, 0.0, 3.0))
FEET = Edges(front=3.0, rear=3.0, left=2.0, right=2.0)


def test_moments_and_angle_of_a_block():
    """Weight alone: d = (d cos a - h sin a) on a slope towards the edge, and tan t = d / h on the level."""
    block = MachineWeights(100e3, (0.5, 0.2, 2.0), 0.0, (0.0, 0.0, 0.0))
    on_level = stability.tipping(forces.forces_at(block, Work(), np.zeros(1), LEVEL), FEET)
    assert on_level.distance[0] == pytest.approx([2.5, 3.5, 1.8, 2.2])
    assert on_level.angle[0] == pytest.approx(np.arctan(np.array([2.5, 3.5, 1.8, 2.2]) / 2.0))
    assert np.isinf(on_level.margin).all()
    slope = 0.2
    downhill = forces.gravity_on_slope(10.0, slope, 0.5 * np.pi)
    leaning = stability.tipping(forces.forces_at(block, Work(), np.zeros(1), downhill), FEET)
    left = EDGES.index("left")
    foot = 1.8 * np.cos(slope) - 2.0 * np.sin(slope)
    assert leaning.distance[0, left] * np.cos(slope) == pytest.approx(foot)
    assert leaning.angle[0, left] == pytest.approx(on_level.angle[0, left] - slope)
    whole = 1e6 * foot
    assert leaning.stabilising[0, left] - leaning.overturning[0, left] == pytest.approx(whole)


def test_margin_with_a_payload_ahead():
    """By hand about the front edge, 3 m ahead: lower 1 MN x 3 + upper 0.4 MN x 4 over 0.1 MN x 7."""
    work = Work(payload=10e3, reach=10.0, height=5.0)
    found = stability.tipping(forces.forces_at(CRANE, work, np.zeros(1), LEVEL), FEET)
    front = EDGES.index("front")
    assert found.margin[0, front] == pytest.approx((3.0 + 1.6) / 0.7)
    rear = EDGES.index("rear")
    assert np.isinf(found.margin[0, rear])


def test_other_forces_do_not_turn_with_gravity():
    """Wind of 0.1 MN at 10 m on 1 MN: W (d cos t - h sin t) = M at the angle, and beyond it tips."""
    block = MachineWeights(100e3, (0.0, 0.0, 2.0), 0.0, (0.0, 0.0, 0.0))
    work = Work(wind=1e5, wind_height=10.0)
    found = stability.tipping(forces.forces_at(block, work, np.zeros(1), LEVEL), FEET)
    tilt = found.angle[0, EDGES.index("front")]
    assert 1e6 * (3.0 * np.cos(tilt) - 2.0 * np.sin(tilt)) == pytest.approx(1e6)
    storm = work._replace(wind=4e5)
    over = stability.tipping(forces.forces_at(block, storm, np.zeros(1), LEVEL), FEET)
    assert over.angle[0, EDGES.index("front")] == 0.0
    assert over.margin[0, EDGES.index("front")] == pytest.approx(3.0 / 4.0)


def test_tipping_load_is_that_at_which_the_margin_is_one():
    slew = np.radians([0.0, 35.0, 90.0, 180.0])
    reach = 9.0
    loads = stability.tipping_load(forces.forces_at(CRANE, Work(), slew, LEVEL), FEET, reach, 0.0, slew)
    # ahead: (3 + 1.6) MN m / (9 - 3) m; to the left: (2 + 1.2) MN m / (9 - 2) m
    assert loads[0] == pytest.approx(4.6e6 / 6.0)
    assert loads[2] == pytest.approx(3.2e6 / 7.0)
    for load, angle in zip(loads, slew, strict=True):
        work = Work(payload=load / 10.0, reach=reach)
        found = stability.tipping(forces.forces_at(CRANE, work, np.array([angle]), LEVEL), FEET)
        assert found.margin.min() == pytest.approx(1.0)


def test_lift_chart_of_an_excavator():
    """PC300LC-8 over side: rated 12 650, 8300, 5950, 4450 kg at 4.6, 6.1, 7.6, 9.1 m are 75 % of T (R - x_t).

    The front of m = 2.10 t moves out with the reach, M_0 = 65.7 t m about the edge at half the gauge.
    """
    side = 0.5 * 2.59
    rated = {4.6: 12650.0, 6.1: 8300.0, 7.6: 5950.0, 9.1: 4450.0}
    front, held = 2100.0, 65.7e3
    feet = Edges(2.0, 2.0, side, side)
    for reach, chart in rated.items():
        body = MachineWeights(
            34e3 - front, (0.0, side - held / (34e3 - front), 1.0), front, (reach, 0.0, 1.5)
        )
        # held is about the edge with the front's weight taken to the swing axis
        body = body._replace(lower_com=(0.0, side - (held - front * side) / (34e3 - front), 1.0))
        angle = np.array([0.5 * np.pi])
        found = stability.tipping_load(forces.forces_at(body, Work(), angle, LEVEL), feet, reach, 0.0, angle)
        assert 0.75 * found[0] / 10.0 == pytest.approx(chart, rel=0.01)
