"""Contact of a tread's strip with a rail, as a function of numbers."""

import numpy as np
import pytest

from exudyn_crawler.ground.laws import Impact
from exudyn_crawler.model.forces.treads import Bending, Rail, tread_force

LAW = Impact(1e9, 1.2, 3e5, 1e-3)
RAIL = Rail(-0.3, 0.3, 0.22)
RADIUS = 0.4
LEVEL = Bending(0.0, 0.0, 0.0)

PLACES = {"on the rail": (0.1, 0.6195), "over the gap": (0.32, 0.619), "past an end": (-0.31, 0.6193)}


def force(center, rates=(0.0, 0.0), bending=LEVEL, drag=0.0):
    return tread_force(LAW, RAIL, (RADIUS, drag), center, rates, bending, True)


def test_presses_straight_up_by_its_law_on_a_level_rail():
    met = force((0.1, 0.6195))
    np.testing.assert_allclose(met.force, (0.0, 1e9 * 5e-4**1.2), rtol=1e-9)
    assert met.foot == (0.1, 0.22)


def test_past_the_end_of_a_rail_the_force_points_from_its_edge_to_the_axis():
    met = force((0.32, 0.619))
    away = np.array([0.02, 0.399])
    assert met.foot == (0.3, 0.22)
    assert met.depth == pytest.approx(RADIUS - np.hypot(*away))
    assert met.force[0] * away[1] == pytest.approx(met.force[1] * away[0])


def test_none_without_depth_and_damping_does_not_pull():
    assert force((0.0, 0.6201)).force == (0.0, 0.0)
    assert force((0.0, 0.6195), rates=(0.0, 5.0)).force == (0.0, 0.0)


def test_resistance_lies_along_the_rail_against_the_travel():
    met = force((0.0, 0.6195), drag=0.03)
    assert met.force[0] == pytest.approx(-0.03 * met.force[1])


def test_force_does_not_jump_as_a_roller_leaves_a_rail():
    """Along a path over both ends, bent as it is: steps of 10 micrometres change the force by little."""
    x = np.arange(-0.33, 0.33, 1e-5)
    forces = np.array([force((one, 0.6193), (0.1, 0.0), LEVEL, 0.03).force for one in x])
    assert np.abs(forces).max() > 1e5
    assert np.abs(np.diff(forces, axis=0)).max() < 1e-3 * np.abs(forces).max()


@pytest.mark.parametrize("drag", [0.0, 0.05])
@pytest.mark.parametrize("place", PLACES)
def test_derivatives_are_those_of_the_force(place, drag):
    start = np.array([*PLACES[place], 1e-4, 2e-3, 0.1, -0.02, 0.01])

    def by_numbers(v):
        x, z, rise, slope, x_rate, z_rate, rise_rate = v
        # on the rail the rise is that below the axis
        rise += slope * (np.clip(x, RAIL.rear, RAIL.front) - np.clip(start[0], RAIL.rear, RAIL.front))
        return np.array(force((x, z), (x_rate, z_rate), Bending(rise, slope, rise_rate), drag).force)

    steps = np.diag([1e-8, 1e-8, 1e-8, 1e-7, 1e-6, 1e-6, 1e-6])
    found = np.array([(by_numbers(start + s) - by_numbers(start - s)) / (2.0 * s.max()) for s in steps])
    met = force(start[:2], start[4:6], Bending(start[2], start[3], start[6]), drag)
    own = np.array([*met.by_place, *met.by_rate])
    scale = np.abs(found).max(axis=1, keepdims=True) + 1.0
    np.testing.assert_allclose(own / scale, found / scale, atol=2e-5)


def test_elastic_force_does_no_work_on_a_way_round():
    """Off the rail, past its end and back: the force has a potential, with the rail bent as well."""
    angles = np.linspace(0.0, 2.0 * np.pi, 4001)
    x, z = 0.3 + 0.04 * np.cos(angles), 0.619 + 5e-4 * np.sin(angles)
    bent = [Bending(1e-4 + 1e-3 * min(one, 0.3), 1e-3, 0.0) for one in x]
    forces = np.array([force((a, b), bending=c).force for a, b, c in zip(x, z, bent, strict=True)])
    steps = np.diff(np.column_stack((x, z)), axis=0)
    work = np.sum(0.5 * (forces[1:] + forces[:-1]) * steps, axis=1)
    assert abs(work.sum()) < 1e-3 * np.abs(work).sum()
