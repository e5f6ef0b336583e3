"""Rollers, pins and treads against hand calculations."""

import numpy as np
import pytest
from scipy.optimize import linprog

from exudyn_crawler.assessment import rollers, utilisation
from exudyn_crawler.assessment.utilisation import PartStrength, PinnedHinge, RollerTread

PLACES = 0.95 * (np.arange(7) - 3.0)
HINGE = PinnedHinge(diameter=0.1, inner=0.2, outer=0.1, gap=0.01, play=0.001)
STEEL = PartStrength(tensile=800e6, yield_strength=500e6)


@pytest.mark.parametrize("centre", [-2.8, -2.0, 0.0, 0.5, 2.8])
def test_all_supports_carry_the_load_at_its_place(centre):
    pair = rollers.neighbours(centre, PLACES)
    for loads in (
        rollers.even_loads(6.5e6, centre, PLACES),
        rollers.two_loads(6.5e6, centre, PLACES, pair),
        rollers.end_load(6.5e6, centre, PLACES),
    ):
        assert loads.sum() == pytest.approx(6.5e6)
        assert (loads >= 0.0).all()
        assert loads @ PLACES == pytest.approx(6.5e6 * centre, abs=1e-3)
    alone = rollers.one_load(6.5e6, centre, PLACES)
    assert alone.max() == alone.sum() == 6.5e6


def test_even_loads_by_hand():
    """P / n + P e x / sum(x^2), sum(x^2) = 28 x 0.9025 m2."""
    found = rollers.even_loads(7e6, 0.5, PLACES)
    assert found == pytest.approx(1e6 + 3.5e6 * PLACES / (28.0 * 0.9025))


def test_a_bogie_bears_twice_as_much_as_a_roller():
    """Symmetric: bogie, roller, bogie."""
    found = rollers.even_loads(5e6, 0.0, np.array([-1.0, 0.0, 1.0]), np.array([2.0, 1.0, 2.0]))
    assert found == pytest.approx([2e6, 1e6, 2e6])
    aside = rollers.even_loads(5e6, 0.1, np.array([-1.0, 0.0, 1.0]), np.array([2.0, 1.0, 2.0]))
    assert aside @ [-1.0, 0.0, 1.0] == pytest.approx(0.5e6)


def test_outer_rollers_and_neighbours():
    outer = rollers.end_load(6e6, 0.95, PLACES)
    assert outer[[0, -1]] == pytest.approx([2e6, 4e6])
    assert rollers.neighbours(0.5, PLACES) == (3, 5)
    assert rollers.neighbours(-2.8, PLACES) == (0, 1)
    with pytest.raises(ValueError, match="between"):
        rollers.even_loads(1.0, 3.0, PLACES)


def test_a_corner_carries_half_the_weight_or_more():
    assert rollers.corner_load(14e6, 0.0, 0.0, 6.0, 8.0) == pytest.approx(7e6)
    assert rollers.corner_load(14e6, 0.6, 0.8, 6.0, 8.0) == pytest.approx(14e6 * 0.6)
    assert rollers.corner_load(14e6, -0.6, 0.4, 6.0, 8.0) == pytest.approx(14e6 * 0.55)
    # what tips over an end stands on that end alone
    assert rollers.corner_load(14e6, 3.5, -0.8, 6.0, 8.0) == pytest.approx(14e6 * 0.6)


def test_a_corner_carries_what_a_linear_programme_finds():
    """Greatest load of a corner of four that only push; sums of forces and of moments about a fifth point."""
    rng = np.random.default_rng(7)
    for _ in range(30):
        length, gauge = rng.uniform(1.0, 10.0, 2)
        ahead, aside = rng.uniform(-0.5, 0.5, 2) * (length, gauge)
        about = rng.uniform(-20.0, 20.0, 2)
        corners = 0.5 * np.array([(sx * length, sy * gauge) for sx in (1, -1) for sy in (1, -1)]) - about
        balance = np.vstack((np.ones(4), corners.T))
        wanted = 1e6 * np.array([1.0, ahead - about[0], aside - about[1]])
        greatest = max(
            -linprog(-np.eye(4)[corner], A_eq=balance, b_eq=wanted, method="highs").fun for corner in range(4)
        )
        assert rollers.corner_load(1e6, ahead, aside, length, gauge) == pytest.approx(greatest, rel=1e-9)


def test_pin_by_hand():
    """1 MN on 0.1 m: two sections of 7854 mm2, W = 98 175 mm3, M = F (0.2 + 0.04 + 0.2) / 8."""
    stress = utilisation.pin_stress(1e6, HINGE)
    assert stress.shear == pytest.approx(0.5e6 / 7.853982e-3)
    assert stress.bearing == pytest.approx(50e6)
    assert utilisation.pin_moment(1e6, HINGE) == pytest.approx(55e3)
    assert stress.bending == pytest.approx(55e3 / 9.817477e-5)
    resists = utilisation.pin_resistance(STEEL, PartStrength(600e6, 400e6))
    assert resists == pytest.approx((0.6 * 800e6 / 1.25, 1.5 * 400e6, 1.5 * 500e6))
    # narrower outer lugs bear more
    narrow = HINGE._replace(outer=0.08)
    assert utilisation.pin_stress(1e6, narrow).bearing == pytest.approx(1e6 / (0.1 * 0.16))
    # 0.591 sqrt(210 GPa x 1 MN x 1 mm / (0.01 m2 x 0.2 m))
    assert utilisation.hole_contact(1e6, HINGE, 210e9) == pytest.approx(0.591 * np.sqrt(2.1e14 / 2e-3))
    assert utilisation.chain_strength(HINGE, 2, STEEL) == pytest.approx(4.0 * 0.6 * 800e6 * 7.853982e-3)


def test_roller_on_a_rail_by_hand():
    """574 kN on 0.18 x 0.8 m: 4.0 MPa and 528 MPa, E = 200 GPa, nu = 0.3."""
    found = utilisation.roller_contact(574e3, RollerTread(0.4, 0.18), 690e6, 200e9)
    assert found.specific == pytest.approx(574e3 / 0.144)
    assert found.pressure == pytest.approx(np.sqrt(574e3 * 200e9 / (2.0 * np.pi * 0.4 * 0.18 * 0.91)))
    # Johnson: first yield by von Mises at 3.1 k, shakedown at 4 k, k = yield / sqrt(3)
    k = 690e6 / np.sqrt(3.0)
    assert found.to_yield * found.pressure == pytest.approx(3.1 * k, rel=0.01)
    assert found.to_shakedown * found.pressure == pytest.approx(4.0 * k, rel=0.01)


def test_bending_of_a_shoe():
    assert utilisation.bending_of_shoe(1e6, 3.5, 0.24) == pytest.approx(1e6 * 0.635)
