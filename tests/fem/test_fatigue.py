"""S-N curve, mean stress and Miner's rule against closed forms and pyLife's own transform."""

import numpy as np
import pandas as pd
import pytest
from pylife.strength.meanstress import HaighDiagram

from fem.fatigue import MINERS, SNCurve

CURVE = SNCurve(strength=150e6, slope=5.0, knee=1e6, mean_sensitivity=0.3, scatter=1.25, survival=0.975)


def test_the_curve_goes_through_its_knee_with_its_slope():
    alternating = CURVE.damage(np.array([150e6, 300e6]), np.zeros(2), (0.975,))[0]
    assert alternating == pytest.approx([1e-6, 32e-6], rel=1e-12)


def test_below_the_knee_miners_rules_differ_by_their_slopes():
    small = np.array([75e6])
    found = {
        miner: SNCurve(150e6, 5.0, 1e6, survival=0.5, miner=miner).damage(small, np.zeros(1), (0.5,)).item()
        for miner in MINERS
    }
    assert found["elementary"] == pytest.approx(1e-6 / 2**5)
    assert found["haibach"] == pytest.approx(1e-6 / 2**9)
    assert found["original"] == 0.0


def test_mean_stress_counts_as_fkm_says():
    """R = 0: 1 + M; R = 0.5 and beyond: 3 (1 + M)^2 / (3 + M); R > 1: 1 - M."""
    m = CURVE.mean_sensitivity
    mean = np.array([0.0, 1.0, 3.0, 9.0, -1.0, -7.0])
    most = 3.0 * (1.0 + m) ** 2 / (3.0 + m)
    expected = [1.0, 1.0 + m, most, most, 1.0 - m, 1.0 - m]
    assert CURVE.equivalent(np.ones(6), mean) == pytest.approx(expected, rel=1e-12)


def test_interpolation_is_pylifes_transform():
    rng = np.random.default_rng(1)
    amplitude, mean = rng.random(500), rng.uniform(-5.0, 5.0, 500)
    slopes = {"M0": 0.3, "M1": 0.1, "M2": 0.0, "M3": 0.0, "M4": 0.0, "R12": 0.5, "R23": 0.9}
    cycles = pd.DataFrame({"range": 2.0 * amplitude, "mean": mean})
    exact = HaighDiagram.five_segment(pd.Series(slopes)).transform(cycles, -1.0)
    assert CURVE.equivalent(amplitude, mean) == pytest.approx(0.5 * exact["range"].to_numpy(), rel=1e-12)


def test_scatter_says_how_the_strength_goes_with_survival():
    strengths = [CURVE.strength_at(survival) for survival in (0.1, 0.9)]
    assert strengths[0] / strengths[1] == pytest.approx(1.25, rel=1e-9)
    assert CURVE.strength_at(0.975) == pytest.approx(150e6)
    at_strength = CURVE.damage(np.array([CURVE.strength_at(0.5)]), np.zeros(1), (0.5,))
    assert at_strength == pytest.approx(np.array([[1e-6]]))  # the knee keeps its cycles


@pytest.mark.parametrize("miner", MINERS)
def test_no_cycle_up_to_the_harmless_amplitude_does_more(miner):
    curve = SNCurve(150e6, 5.0, 1e6, 0.3, 1.25, 0.975, miner)
    most = curve.harmless(1e-9, 0.975)
    means = np.linspace(-5.0, 8.0, 200) * most
    assert curve.damage(np.full(200, 0.9999999 * most), means, (0.975,)).max() <= 1e-9
    if miner != "original":
        assert curve.damage(np.full(200, 1.001 * most), means, (0.975,)).max() > 1e-9


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"strength": 0.0}, "strength must be positive"),
        ({"slope": 0.5}, "slope must be at least 1"),
        ({"mean_sensitivity": 1.0}, r"mean_sensitivity must lie in \[0, 1\)"),
        ({"survival": 1.0}, r"survival must be inside \(0, 1\)"),
        ({"miner": "palmgren"}, "miner must be one of"),
    ],
)
def test_what_is_no_curve_is_refused(options, words):
    with pytest.raises(ValueError, match=words):
        SNCurve(**{"strength": 1e8, "slope": 5.0, "knee": 1e6} | options)
