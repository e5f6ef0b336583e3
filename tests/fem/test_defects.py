"""Casting defects: Murakami's published formula, growth against scipy's integration and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import norm

from fem import SNCurve
from fem.fatigue.defects import (
    GEOMETRY,
    MM15,
    CycleStage,
    Defect,
    defect_life,
    growing_size,
    growth,
    growth_law,
    murakami_limit,
    threshold,
)

MEGA = 1e6
CURVE = SNCurve(strength=200e6, slope=5.0, knee=1e6, mean_sensitivity=0.35, survival=0.975, scatter=1.4)


def test_limit_is_murakamis():
    """1.43 (HV + 120) / sqrt(area)^(1/6) ((1 - R) / 2)^(0.226 + HV 1e-4), MPa and micrometres."""
    for hardness, microns, ratio in ((270.0, 1000.0, 0.0), (120.0, 100.0, -1.0), (400.0, 50.0, 0.3)):
        expected = 1.43 * (hardness + 120.0) / microns ** (1.0 / 6.0)
        expected *= ((1.0 - ratio) / 2.0) ** (0.226 + 1e-4 * hardness)
        assert murakami_limit(1e-6 * microns, hardness, ratio) == pytest.approx(expected * MEGA, rel=1e-12)
    # by hand, HV 120 and 100 micrometres: 1.43 x 240 / 2.1544 = 159.3 MPa, at R = 0 134.9
    assert murakami_limit(100e-6, 120.0) == pytest.approx(159.3e6, rel=1e-3)
    assert murakami_limit(100e-6, 120.0, 0.0) == pytest.approx(159.3e6 * 0.5**0.238, rel=1e-3)


def test_a_defect_sleeps_up_to_murakamis_limit_and_a_crack_up_to_the_threshold():
    """Kitagawa and Takahashi: the lesser of both, which meet at 125 micrometres (HV 270, R = 0)."""
    for ratio in (-1.0, 0.0, 0.4):
        # both limits of the one curve
        for size in (1e-6, 1e-5, 3e-3, 0.03):
            small = 2.0 * murakami_limit(size, 270.0, ratio)
            crack = threshold(ratio) / (GEOMETRY * np.sqrt(np.pi * size))
            stress = min(small, crack)
            assert stress == (small if size < 1e-4 else crack)
            assert growing_size(270.0, stress, np.array(ratio)) == pytest.approx(size, rel=1e-9)
        # without a step between
        stress = np.geomspace(1e7, 2e9, 2001)
        sizes = growing_size(270.0, stress, np.full(2001, ratio))
        assert np.abs(np.diff(np.log(sizes))).max() < 6.1 * np.log(stress[1] / stress[0])
    meet = 1e-6 * (170.0 * MM15 / (2e6 * 1.43 * 390.0 * 0.5**0.253 * GEOMETRY * np.sqrt(np.pi * 1e-6))) ** 3
    assert meet == pytest.approx(125e-6, rel=0.01)
    of_both = 2.0 * murakami_limit(meet, 270.0, 0.0) * GEOMETRY * np.sqrt(np.pi * meet)
    assert of_both == pytest.approx(threshold(0.0), rel=1e-9)
    # more compression than R = -1 does not help
    assert growing_size(270.0, 6e8, np.array(-5.0)) == growing_size(270.0, 6e8, np.array(-1.0))


def test_thresholds_are_those_of_bs_7910():
    """170 N/mm^1.5 up to R = 0, 170 - 214 R between, 63 from R = 0.5: 5.38 and 1.99 MPa m^0.5."""
    found = threshold(np.array([-1.0, 0.0, 0.25, 0.5, 0.9])) / MEGA
    np.testing.assert_allclose(found, [5.376, 5.376, 3.684, 1.992, 1.992], rtol=1e-3)


@pytest.mark.parametrize(("of_high_ratio", "mean", "upper"), [(False, 363.0, 315.0), (True, 196.0, 144.0)])
def test_both_stages_meet_where_the_guideline_says(of_high_ratio, mean, upper):
    """Its table has the ranges (N/mm^1.5) beside the constants: an independent check of all of them."""
    for survival, expected in ((0.5, mean), (norm.cdf(2.0), upper)):
        (slow, at_slow), (fast, at_fast) = growth_law(of_high_ratio, survival)
        assert (at_fast / at_slow) ** (1.0 / (slow - fast)) / MM15 == pytest.approx(expected, abs=0.5)


def by_scipy(low, high, rate, start, end, survival=0.9) -> float:
    """Time from integrating d depth / dt of a half disc as an initial-value problem."""
    stress, ratio, depths = high - low, low / high, np.sqrt(0.5 * np.pi)
    wakes = growing_size(270.0, stress, ratio)
    laws = [growth_law(bool(one), survival) for one in ratio >= 0.5]

    def speed(size):
        range_ = GEOMETRY * stress * np.sqrt(np.pi * size)
        each = [min(c * x**m for m, c in law) for x, law in zip(range_, laws, strict=True)]
        return float(rate[wakes <= size] @ np.array(each)[wakes <= size])

    def over_size(_time, log_size):
        return [depths * speed(np.exp(log_size[0])) / np.exp(log_size[0])]

    def whole(_time, log_size):
        return log_size[0] - np.log(end)

    whole.terminal = True
    options = {"events": whole, "rtol": 1e-8, "atol": 1e-11, "max_step": 2e4}
    return float(solve_ivp(over_size, (0.0, 1e14), [np.log(start)], **options).t_events[0][0])


def grown(size, low, high, rate, crack=0.06, survival=0.9, lasts=np.inf):
    return growth(Defect(size, 270.0, crack), low, high, rate, survival, lasts)


def test_growth_of_one_range_is_the_closed_form():
    """Half a disc of depth a, K = 0.728 S sqrt(pi a), a stage after the other, each by its power law."""
    depths, stress = np.sqrt(0.5 * np.pi), 200.0
    low, high = np.zeros(1), np.array([stress * MEGA])
    geometry = 0.65 * np.sqrt(depths)
    assert geometry == pytest.approx(0.728, abs=1e-3)
    (slow, at_slow), (fast, at_fast) = growth_law(False, 0.975)
    turn = (at_fast / at_slow) ** (1.0 / (slow - fast))
    depth = (turn / (geometry * stress * MEGA)) ** 2 / np.pi
    assert 1e-3 < depth * depths < 0.01
    expected = 0.0
    for power, rate, a, b in ((slow, at_slow, 1e-3 / depths, depth), (fast, at_fast, depth, 0.06 / depths)):
        way = (a ** (1.0 - power / 2.0) - b ** (1.0 - power / 2.0)) / (power / 2.0 - 1.0)
        expected += way / (rate * (geometry * stress * MEGA * np.sqrt(np.pi)) ** power)
    assert grown(1e-3, low, high, np.ones(1), survival=0.975)[0] == pytest.approx(expected, rel=1e-6)
    # 0.65 dS sqrt(pi s) = 5.376 MPa m^0.5
    asleep = 5.376 / 0.65 / np.sqrt(np.pi * 0.01)
    for factor, grows in ((0.999, False), (1.001, True)):
        time = grown(0.01, low, np.array([asleep * factor * MEGA]), np.ones(1))[0]
        assert np.isfinite(time) == grows


def test_growth_under_many_ranges_is_scipys_integral():
    """Some cycles join in only when the crack has grown, some are of a high stress ratio."""
    random = np.random.default_rng(2)
    low = random.uniform(-100e6, 150e6, 40)
    high = low + random.uniform(20e6, 180e6, 40)
    high[0], low[0] = 150e6, 0.0
    rate = random.uniform(0.1, 3.0, 40)
    opens = high > 0.0
    assert 5 < (low / high > 0.5).sum() < 35
    expected = by_scipy(low[opens], high[opens], rate[opens], 0.003, 0.03)
    assert grown(0.003, low, high, rate, 0.03)[0] == pytest.approx(expected, rel=1e-4)
    assert grown(0.003, low, high, 2.0 * rate, 0.03)[0] == pytest.approx(0.5 * expected, rel=1e-4)
    assert grown(0.003, low - 400e6, high - 400e6, rate, 0.03) == (np.inf, 0.003)


def test_one_curve_of_life_goes_from_a_sound_surface_to_a_growing_crack():
    def life(size, stress=300e6, residual=0.0, strength=CURVE.strength, lasts=np.inf):
        curve = SNCurve(strength, 5.0, 1e6, 0.35, 1.4, 0.975, residual_stress=residual)
        zero = np.zeros(1)
        stages = [CycleStage(zero, np.array([stress]), np.ones(1), one) for one in (lasts, np.inf)]
        return defect_life(Defect(size, 270.0, 0.06), curve, stages, 0.975)

    def sound(stress):
        return 1.0 / CURVE.damage(np.array([stress / 2]), np.array([stress / 2]), (0.975,))[0, 0]

    def cracked(size, stress):
        return grown(size, np.zeros(1), np.array([stress]), np.ones(1), survival=0.975)[0]

    # both limits
    for stress in (100e6, 300e6, 600e6):
        assert life(1e-6, stress) == pytest.approx(sound(stress), rel=1e-9)
        assert life(0.02, stress) == cracked(0.02, stress) < 0.1 * sound(stress)
    # between them the lesser, which falls as the size grows, and has no step where a convention ends
    sizes = np.geomspace(1e-5, 0.05, 300)
    lives = np.array([life(size, 500e6) for size in sizes])
    expected = [min(sound(500e6), cracked(size, 500e6)) for size in sizes]
    np.testing.assert_allclose(lives, expected, rtol=1e-9)
    assert (np.diff(lives) <= 0.0).all()
    assert np.diff(np.log(lives))[sizes[1:] > 2e-4].min() > -0.2
    assert life(1.001e-3) == pytest.approx(life(0.999e-3), rel=0.01)
    # the law knows the ratio by its threshold, and from R = 0.5 on
    assert life(1e-3, residual=400e6) < life(1e-3) == life(1e-3, residual=200e6) < life(1e-3, residual=-400e6)
    # the same twice is the same
    for size in (1e-6, 3e-3):
        assert life(size, lasts=0.4 * life(size)) == pytest.approx(life(size), rel=1e-4)
    assert life(3e-3, residual=-400e6, strength=1e12) > 1e20


def test_residual_stress_adds_to_the_mean_of_a_curve():
    amplitude, mean = np.array([100e6, 180e6]), np.array([0.0, 50e6])
    shifted = SNCurve(200e6, 5.0, 1e6, 0.35, residual_stress=80e6).damage(amplitude, mean, (0.5,))
    plain = SNCurve(200e6, 5.0, 1e6, 0.35).damage(amplitude, mean + 80e6, (0.5,))
    np.testing.assert_allclose(shifted, plain)


def test_a_defect_grows_over_stages_of_other_cycles():
    """Twice: what is left of it after the first stage goes on, by scipy's integral, and Miner's damage."""
    defect, zero, one = Defect(3e-3, 270.0, 0.03), np.zeros(1), np.ones(1)
    new, worn = np.array([150e6]), np.array([250e6])

    def life(size: float, lasts: float) -> float:
        stages = [CycleStage(zero, new, one, lasts), CycleStage(zero, worn, 2.0 * one)]
        return defect_life(defect._replace(size=size), CURVE, stages, 0.975)

    hours = 0.3 * by_scipy(zero, new, one, 3e-3, 0.03, 0.975)
    _, size = grown(3e-3, zero, new, one, 0.03, 0.975, hours)
    assert by_scipy(zero, new, one, 3e-3, size, 0.975) == pytest.approx(hours, rel=1e-4)
    rest = by_scipy(zero, worn, 2.0 * one, size, 0.03, 0.975)
    assert life(3e-3, hours) == pytest.approx(hours + rest, rel=1e-4)
    # a crack that sleeps in the first stage grows in the second one
    asleep = np.array([40e6])
    stages = [CycleStage(zero, asleep, one, 1e5), CycleStage(zero, worn, one)]
    awake = by_scipy(zero, worn, one, 3e-3, 0.03, 0.975)
    assert defect_life(defect, CURVE, stages, 0.975) == pytest.approx(1e5 + awake, rel=1e-4)
    alone, then = life(1e-5, np.inf), life(1e-5, 0.0)
    assert life(1e-5, 0.25 * alone) == pytest.approx(0.25 * alone + 0.75 * then, rel=1e-9)
