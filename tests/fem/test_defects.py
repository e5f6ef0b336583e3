"""Casting defects: Murakami's published formula, growth against scipy's integration and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fem import SNCurve
from fem.defects import (
    GEOMETRY,
    MM15,
    CycleStage,
    Defect,
    defect_life,
    equivalent_amplitude,
    growth,
    murakami_limit,
    threshold,
)

MEGA = 1e6
CURVE = SNCurve(strength=200e6, slope=5.0, knee=1e6, mean_sensitivity=0.35, survival=0.975, scatter=1.4)


@pytest.mark.parametrize(
    ("hardness", "microns", "ratio"), [(270.0, 1000.0, 0.0), (120.0, 100.0, -1.0), (400.0, 50.0, 0.3)]
)
def test_limit_is_murakamis(hardness, microns, ratio):
    """1.43 (HV + 120) / sqrt(area)^(1/6) ((1 - R) / 2)^(0.226 + HV 1e-4), MPa and micrometres."""
    expected = 1.43 * (hardness + 120.0) / microns ** (1.0 / 6.0)
    expected *= ((1.0 - ratio) / 2.0) ** (0.226 + 1e-4 * hardness)
    assert murakami_limit(1e-6 * microns, hardness, ratio) == pytest.approx(expected * MEGA, rel=1e-12)


def test_numbers_of_murakamis_limit_by_hand():
    """HV 120 and 100 micrometres: 1.43 x 240 / 2.1544 = 159.3 MPa, at R = 0 134.9."""
    assert murakami_limit(100e-6, 120.0) == pytest.approx(159.3e6, rel=1e-3)
    assert murakami_limit(100e-6, 120.0, 0.0) == pytest.approx(159.3e6 * 0.5**0.238, rel=1e-3)


def test_equivalent_amplitudes_bear_as_much_at_their_stress_ratio():
    amplitude, mean = 100e6, np.array([0.0, 50e6, 100e6, 300e6])
    ratio = (mean - amplitude) / (mean + amplitude)
    limits = (
        murakami_limit(1e-3, 270.0, ratio)
        * equivalent_amplitude(270.0, np.full(4, amplitude), mean)
        / amplitude
    )
    np.testing.assert_allclose(limits, murakami_limit(1e-3, 270.0))
    compressed = equivalent_amplitude(270.0, np.full(3, 1.0), np.array([-0.5, -1.0, -5.0]))
    power = (1.0 - 0.5) ** (0.226 + 0.027)
    assert 1.0 > compressed[0] > power
    assert compressed[1] == compressed[2] > 0.0


def test_thresholds_are_those_of_bs_7910():
    """170 N/mm^1.5 up to R = 0, 170 - 214 R between, 63 from R = 0.5: 5.38 and 1.99 MPa m^0.5."""
    np.testing.assert_allclose(
        threshold(np.array([-1.0, 0.0, 0.25, 0.5, 0.9])) / MEGA,
        [5.376, 5.376, 3.684, 1.992, 1.992],
        rtol=1e-3,
    )


def by_scipy(low, high, rate, start, end) -> float:
    """Time from integrating d depth / dt of a half disc as an initial-value problem."""
    stress, bound, depths = high - low, threshold(low / high), np.sqrt(0.5 * np.pi)

    def speed(_time, depth):
        range_ = GEOMETRY * stress * np.sqrt(np.pi * depths * depth[0])
        grown = 5.21e-13 * 1e-3 * (range_ / MM15) ** 3
        return [float(rate[range_ > bound] @ grown[range_ > bound])]

    def whole(_time, depth):
        return depth[0] - end / depths

    whole.terminal = True
    steps = {"rtol": 1e-8, "atol": 1e-12, "first_step": 1.0, "max_step": 2e4}
    found = solve_ivp(speed, (0.0, 1e12), [start / depths], events=whole, **steps)
    return float(found.t_events[0][0])


def test_growth_of_one_range_is_the_closed_form():
    """Half a disc of depth a, K = 0.728 S sqrt(pi a): N = 2 (a0^-1/2 - a1^-1/2) / (C (0.728 dS)^3 pi^1.5)."""
    low, high, depths = np.zeros(1), np.array([200e6]), np.sqrt(0.5 * np.pi)
    geometry = 0.65 * np.sqrt(depths)
    assert geometry == pytest.approx(0.728, abs=1e-3)
    way = (0.01 / depths) ** -0.5 - (0.06 / depths) ** -0.5
    expected = 2.0 * way / (1.6475e-11 * (geometry * 200.0) ** 3 * np.pi**1.5)
    assert growth(low, high, np.ones(1), 0.01, 0.06)[0] == pytest.approx(expected, rel=1e-3)
    # 0.65 dS sqrt(pi s) = 5.376 MPa m^0.5
    asleep = 5.376 / 0.65 / np.sqrt(np.pi * 0.01)
    for factor, grows in ((0.999, False), (1.001, True)):
        time = growth(low, np.array([asleep * factor * MEGA]), np.ones(1), 0.01, 0.06)[0]
        assert np.isfinite(time) == grows


def test_growth_under_many_ranges_is_scipys_integral():
    """Some cycles join in only when the crack has grown."""
    random = np.random.default_rng(2)
    low = random.uniform(-100e6, 50e6, 40)
    high = low + random.uniform(20e6, 180e6, 40)
    high[0], low[0] = 150e6, 0.0
    rate = random.uniform(0.1, 3.0, 40)
    opens = high > 0.0
    expected = by_scipy(low[opens], high[opens], rate[opens], 0.003, 0.03)
    assert growth(low, high, rate, 0.003, 0.03)[0] == pytest.approx(expected, rel=1e-4)
    assert growth(low, high, 2.0 * rate, 0.003, 0.03)[0] == pytest.approx(0.5 * expected, rel=1e-4)
    assert growth(low - 400e6, high - 400e6, rate, 0.003, 0.03) == (np.inf, 0.003)


def test_a_small_defect_counts_by_its_limit_and_a_smaller_one_not_at_all():
    def life(size, residual=0.0, strength=CURVE.strength, lasts=np.inf):
        curve = SNCurve(strength, 5.0, 1e6, 0.35, 1.4, 0.975, residual_stress=residual)
        zero = np.zeros(1)
        stages = [CycleStage(zero, np.array([300e6]), np.ones(1), one) for one in (lasts, np.inf)]
        return defect_life(Defect(size, 270.0, 0.06), curve, stages, 0.975)

    limit = murakami_limit(1e-3, 270.0, 0.0)
    assert life(1e-3) == pytest.approx(1e6 * (limit / 150e6) ** 5, rel=1e-9)
    assert life(1e-6) == life(2e-6) > life(1e-3)
    assert life(1e-3, residual=200e6) < life(1e-3) < life(1e-3, residual=-200e6)
    assert life(1.1e-3) == growth(np.zeros(1), np.array([300e6]), np.ones(1), 1.1e-3, 0.06)[0]
    # the same twice is the same
    for size in (1e-3, 3e-3):
        assert life(size, lasts=0.4 * life(size)) == pytest.approx(life(size), rel=1e-9)
    assert life(3e-3, residual=-400e6) == np.inf


def test_residual_stress_adds_to_the_mean_of_a_curve():
    amplitude, mean = np.array([100e6, 180e6]), np.array([0.0, 50e6])
    shifted = SNCurve(200e6, 5.0, 1e6, 0.35, residual_stress=80e6)
    plain = SNCurve(200e6, 5.0, 1e6, 0.35)
    np.testing.assert_allclose(
        shifted.damage(amplitude, mean, (0.5,)), plain.damage(amplitude, mean + 80e6, (0.5,))
    )


def test_a_defect_grows_over_stages_of_other_cycles():
    """Twice: what is left of it after the first stage goes on, by scipy's integral, and Miner's damage."""
    defect, zero, one = Defect(3e-3, 270.0, 0.03), np.zeros(1), np.ones(1)
    new, worn = np.array([150e6]), np.array([250e6])

    def life(size: float, lasts: float) -> float:
        stages = [CycleStage(zero, new, one, lasts), CycleStage(zero, worn, 2.0 * one)]
        return defect_life(defect._replace(size=size), CURVE, stages, 0.975)

    hours = 0.3 * by_scipy(zero, new, one, 3e-3, 0.03)
    _, size = growth(zero, new, one, 3e-3, 0.03, hours)
    assert by_scipy(zero, new, one, 3e-3, size) == pytest.approx(hours, rel=1e-4)
    assert life(3e-3, hours) == pytest.approx(hours + by_scipy(zero, worn, 2.0 * one, size, 0.03), rel=1e-4)
    # a crack that sleeps in the first stage grows in the second one
    asleep = np.array([40e6])
    stages = [CycleStage(zero, asleep, one, 1e5), CycleStage(zero, worn, one)]
    awake = by_scipy(zero, worn, one, 3e-3, 0.03)
    assert defect_life(defect, CURVE, stages, 0.975) == pytest.approx(1e5 + awake, rel=1e-4)
    alone, then = life(5e-4, np.inf), life(5e-4, 0.0)
    assert life(5e-4, 0.25 * alone) == pytest.approx(0.25 * alone + 0.75 * then, rel=1e-9)
