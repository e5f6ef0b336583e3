"""Contact of a tread's strip with a rail, as a function of numbers."""

import numpy as np
import pytest

from exudyn_crawler.ground.laws import Impact
from exudyn_crawler.model.forces.treads import Bending, Disc, Rail, tread_force

LAW = Impact(1e9, 1.2, 3e5, 1e-3)
RAIL = Rail(-0.3, 0.3, 0.22)
RADIUS = 0.4
RESISTANCE = 0.05
FADING = 5e-3
"""m/s."""
LEVEL = Bending(0.0, 0.0, 0.0)

PLACES = {"on the rail": (0.1, 0.6195), "over the gap": (0.32, 0.619), "past an end": (-0.31, 0.6193)}


def force(center, rates=(0.0, 0.0, 0.0), bending=LEVEL, resistance=0.0):
    return tread_force(LAW, RAIL, Disc(RADIUS, resistance, FADING), center, rates, bending, True)


def test_presses_straight_up_by_its_law_on_a_level_rail():
    tread = force((0.1, 0.6195))
    np.testing.assert_allclose(tread.force, (0.0, 1e9 * 5e-4**1.2), rtol=1e-9)
    assert tread.foot == (0.1, 0.22)


def test_past_the_end_of_a_rail_the_force_points_from_its_edge_to_the_axis():
    tread = force((0.32, 0.619))
    away = np.array([0.02, 0.399])
    assert tread.foot == (0.3, 0.22)
    assert tread.depth == pytest.approx(RADIUS - np.hypot(*away))
    assert tread.force[0] * away[1] == pytest.approx(tread.force[1] * away[0])


def test_none_without_depth_and_damping_does_not_pull():
    assert force((0.0, 0.6201)).force == (0.0, 0.0)
    assert force((0.0, 0.6195), rates=(0.0, 5.0, 0.0)).force == (0.0, 0.0)


@pytest.mark.parametrize("speed", [-0.1, -FADING, 0.0, FADING, 0.1])
def test_resistance_lies_along_the_rail_against_the_wheels_own_motion(speed):
    resisted = force((0.0, 0.6195), (speed, 0.0, 0.0), resistance=RESISTANCE)
    part = speed / np.hypot(speed, FADING)
    assert resisted.force[0] == pytest.approx(-RESISTANCE * part * resisted.force[1])


def test_wheel_whose_carrier_turns_as_the_wheel_does_has_no_resistance():
    """A carrier that turns about the wheel's axis as fast as the wheel rolls: the bearing does not turn."""
    distance = 0.6195 - RAIL.height
    rolling = force((0.0, 0.6195), (0.1, 0.0, 0.1 / distance), resistance=RESISTANCE)
    assert rolling.force[0] == pytest.approx(0.0, abs=1e-9 * rolling.force[1])


def test_resistance_never_gives_power():
    """Against the same strip without it, by the velocity of its carrier over the rail where both touch."""
    rng = np.random.default_rng(3)
    powers = []
    for center in PLACES.values():
        for rates in rng.normal(scale=(0.05, 0.05, 0.2), size=(60, 3)):
            slope, rate, along_rate = rng.normal(scale=(2e-3, 0.02, 0.02))
            bending = Bending(1e-4, slope, rate, 0.0, 0.0, along_rate)
            resisted = force(center, rates, bending, RESISTANCE)
            free = force(center, rates, bending)
            arm = np.subtract(resisted.foot, center)
            over = rates[:2] + rates[2] * np.array([arm[1], -arm[0]]) - (along_rate, rate)
            powers.append(np.subtract(resisted.force, free.force) @ over)
    assert len(powers) == 180
    assert max(powers) <= 0.0
    assert min(powers) < -100.0


def test_force_does_not_jump_as_a_roller_leaves_a_rail():
    """Along a path over both ends, bent as it is: steps of 10 micrometres change the force by little."""
    x = np.arange(-0.33, 0.33, 1e-5)
    forces = np.array([force((place, 0.6193), (0.1, 0.0, 0.0), LEVEL, 0.03).force for place in x])
    assert np.abs(forces).max() > 1e5
    assert np.abs(np.diff(forces, axis=0)).max() < 1e-3 * np.abs(forces).max()


@pytest.mark.parametrize("speed", [0.1, 2e-3])
@pytest.mark.parametrize("resistance", [0.0, RESISTANCE])
@pytest.mark.parametrize("place", PLACES)
def test_derivatives_are_those_of_the_force(place, resistance, speed):
    start = np.array([*PLACES[place], 1e-4, 2e-3, speed, -0.02, 0.01])
    spin = 0.02

    def by_numbers(v):
        x, z, rise, slope, x_rate, z_rate, rise_rate = v
        # on the rail the rise is that below the axis
        rise += slope * (np.clip(x, RAIL.rear, RAIL.front) - np.clip(start[0], RAIL.rear, RAIL.front))
        bending = Bending(rise, slope, rise_rate, 0.0, 0.0, 3e-3)
        return np.array(force((x, z), (x_rate, z_rate, spin), bending, resistance).force)

    steps = np.diag([1e-8, 1e-8, 1e-8, 1e-7, 1e-6, 1e-6, 1e-6])
    differences = np.array([(by_numbers(start + s) - by_numbers(start - s)) / (2.0 * s.max()) for s in steps])
    bending = Bending(start[2], start[3], start[6], 0.0, 0.0, 3e-3)
    tread = force(start[:2], (*start[4:6], spin), bending, resistance)
    derivatives = np.array([*tread.by_place, *tread.by_rate])
    scale = np.abs(differences).max(axis=1, keepdims=True) + 1.0
    np.testing.assert_allclose(derivatives / scale, differences / scale, atol=2e-5)


def test_elastic_force_does_no_work_on_a_way_round():
    """Off the rail, past its end and back: the force has a potential, with the rail bent as well."""
    angles = np.linspace(0.0, 2.0 * np.pi, 4001)
    x, z = 0.3 + 0.04 * np.cos(angles), 0.619 + 5e-4 * np.sin(angles)
    bent = [Bending(1e-4 + 1e-3 * min(place, 0.3), 1e-3, 0.0) for place in x]
    forces = np.array([force((a, b), bending=c).force for a, b, c in zip(x, z, bent, strict=True)])
    steps = np.diff(np.column_stack((x, z)), axis=0)
    work = np.sum(0.5 * (forces[1:] + forces[:-1]) * steps, axis=1)
    assert abs(work.sum()) < 1e-3 * np.abs(work).sum()
