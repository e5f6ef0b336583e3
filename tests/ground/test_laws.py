"""The scalar laws of contact, point by point against the formulas of ADAMS and the papers."""

import math

import pytest

from exudyn_crawler import PairContact
from exudyn_crawler.ground.contact import pair_law
from exudyn_crawler.ground.laws import Coulomb, Impact, friction_per_slip, friction_torque, impact_force, step

K, E, C, D = 1.0e8, 2.0, 1.0e4, 1.0e-4
MU_S, MU_D, V_ST, V_D = 0.4, 0.3, 0.01, 0.1
LAW = Coulomb(MU_S, MU_D, V_ST, V_D)
SPRING = Impact(K, E, C, D)
TIGHT = 1e-13  # rounding of a dozen operations


def adams_step(x, x0, h0, x1, h1):
    if x <= x0:
        return h0
    if x >= x1:
        return h1
    delta = (x - x0) / (x1 - x0)
    return h0 + (h1 - h0) * (3.0 * delta**2 - 2.0 * delta**3)


def test_papers_law_has_the_values_used_here():
    law = pair_law(PairContact.oil_sand(), 2.0)
    assert (law.impact, law.coulomb) == (SPRING, LAW)
    assert (law.edge_width, law.whole_area) == (0.01, 0.0)
    assert pair_law(PairContact.oil_sand(sharing="area"), 2.0).whole_area == 2.0


@pytest.mark.parametrize("x", [-3.0, 1.0, 1.0 + 1e-9, 1.0 + 1e-5, 1.3, 2.0, 2.9, 3.0 - 1e-5, 3.0, 7.0])
@pytest.mark.parametrize(("h0", "h1"), [(0.0, 1.0), (-1.0, 1.0), (5.0, 2.0)])
def test_step_is_the_cubic_of_adams(x, h0, h1):
    assert step(x, 1.0, h0, 3.0, h1) == pytest.approx(adams_step(x, 1.0, h0, 3.0, h1), rel=TIGHT)


@pytest.mark.parametrize("depth", [1e-9, 1e-6, 3e-5, 5e-5, 1e-4, 2e-4, 0.01, 0.0657, 0.1])
@pytest.mark.parametrize("rate", [-0.05, 0.0, 0.02, 0.5])
@pytest.mark.parametrize("exponent", [2.0, 1.5])
def test_impact_force_is_spring_and_ramped_damper(depth, rate, exponent):
    expected = K * depth**exponent + C * rate * adams_step(depth, 0.0, 0.0, D, 1.0)
    found = impact_force(Impact(K, exponent, C, D), depth, rate)
    assert found == pytest.approx(max(0.0, expected), rel=1e-12)


def test_impact_force_never_pulls_and_ends_at_the_surface():
    assert impact_force(SPRING, 0.0, 1.0) == 0.0
    assert impact_force(SPRING, -0.01, 5.0) == 0.0
    # 1 N of spring against 500 N of full damping would be adhesion
    assert K * 1e-4**2 - C * 0.05 < 0.0
    assert impact_force(SPRING, 1e-4, -0.05) == 0.0


@pytest.mark.parametrize(
    "v",
    [0.0, 1e-9, 1e-6, 1e-4, 0.002, 0.005, 0.008, 0.0099, 0.0101, 0.015, 0.02, 0.03, 0.055, 0.0999, 0.5, 2.0]
    # both sides of where its pieces meet
    + [speed * (1.0 + e) for speed in (V_ST, V_D) for e in (-1e-9, 0.0, 1e-9)],
)
def test_friction_curve_is_that_of_adams(v):
    if v < V_ST:
        expected = MU_S * adams_step(v, -V_ST, -1.0, V_ST, 1.0)
    elif v <= V_D:
        expected = adams_step(v, V_ST, MU_S, V_D, MU_D)
    else:
        expected = MU_D
    # the STEP from -1 to 1 loses digits about zero, the ratio does not
    near = TIGHT if v > 1e-3 else 1e-12
    assert friction_per_slip(LAW, v) * v == pytest.approx(expected, rel=near, abs=1e-16)


def test_friction_per_slip_is_finite_at_rest():
    assert friction_per_slip(LAW, 0.0) == pytest.approx(1.5 * MU_S / V_ST, rel=TIGHT)


@pytest.mark.parametrize("spin", [-0.5, -0.004, -1e-6, 0.0, 1e-6, 0.004, 0.02, 0.5])
def test_friction_torque_is_two_thirds_of_radius_and_force_against_the_spin(spin):
    radius, force = 0.8552, 1.3e5
    area = math.pi * radius**2
    turned = adams_step(radius * spin, -V_ST, -1.0, V_ST, 1.0)
    torque = friction_torque(LAW, spin, area, force)
    assert torque == pytest.approx(-2.0 / 3.0 * radius * force * turned, rel=1e-9, abs=1e-9)
    assert torque * spin <= 0.0
    assert torque == pytest.approx(-friction_torque(LAW, -spin, area, force), rel=1e-9, abs=1e-9)


def test_friction_torque_is_full_beyond_the_stiction_speed_at_the_rim():
    area, expected = math.pi * 0.8**2, -2.0 / 3.0 * 0.8 * 3.0e5
    assert friction_torque(LAW, 1.0, area, 3.0e5) == pytest.approx(expected, rel=TIGHT)
