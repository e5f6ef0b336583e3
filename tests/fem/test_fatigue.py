"""Fatigue: rainflow of repeated histories, S-N curve, mean stress and Miner's rule."""

import numpy as np
import pandas as pd
import pytest
import rainflow
from pylife.strength.meanstress import HaighDiagram

from fem.fatigue.rainflow import CycleCounter, Cycles, joined_cycles, repeated_cycles
from fem.fatigue.sn_curve import MINERS, SNCurve
from tests.fem.refusals import refused


def ranges(cycles: Cycles) -> list[tuple[float, float]]:
    """Ranges and means, the smallest first."""
    return sorted(zip((2.0 * cycles.amplitude).tolist(), cycles.mean.tolist(), strict=True))


@pytest.mark.parametrize(
    ("signal", "expected"),
    [
        # ASTM E1049-85, figure 7 (repeating history): one cycle each of 3, 4, 7 and 9 units
        ([-2, 1, -3, 5, -1, 3, -4, 4, -2], [(3.0, -0.5), (4.0, 1.0), (7.0, 0.5), (9.0, 0.5)]),
        # small cycles stand apart from the large one that they interrupt
        ([0, 8, 3, 5, 0], [(2.0, 4.0), (8.0, 4.0)]),
        ([0, 1, 2], [(2.0, 1.0)]),
        ([1, 1, 1, 1, 1], []),
    ],
    ids=["astm", "interrupted", "rising", "constant"],
)
def test_examples(signal, expected):
    assert ranges(repeated_cycles(np.array(signal, dtype=float))) == expected


def test_a_repeated_history_may_begin_anywhere_and_more_passes_have_as_many_times_the_cycles():
    signal = np.random.default_rng(3).standard_normal(200)
    once = ranges(repeated_cycles(signal))
    for shift in (1, 57, 111):
        assert ranges(repeated_cycles(np.roll(signal, shift))) == once
    assert ranges(repeated_cycles(np.tile(signal, 3))) == sorted(3 * once)


def test_rows_are_where_the_ends_of_cycles_are():
    signal = np.random.default_rng(5).standard_normal(300)
    found = repeated_cycles(signal)
    assert (signal[found.begin_row] == found.begin).all()
    assert (signal[found.end_row] == found.end).all()
    larger = found.larger_than(1.0)
    assert len(larger.begin) == (found.amplitude > 1.0).sum() > 0
    assert larger.amplitude.min() > 1.0


@pytest.mark.parametrize("seed", range(5))
def test_another_library_counts_the_same(seed):
    """That of P. Janiszewski and others by ASTM E1049-85, from the greatest value on and back to it."""
    signal = np.random.default_rng(seed).standard_normal(400).cumsum()
    start = int(signal.argmax())
    once = np.append(np.roll(signal, -start), signal[start])
    counts: dict[tuple[float, float], float] = {}
    for range_, mean, count, _, _ in rainflow.extract_cycles(once):
        key = (round(range_, 9), round(mean, 9))
        counts[key] = counts.get(key, 0.0) + count
    assert set(counts.values()) == {1.0}
    found = [(round(a, 9), round(b, 9)) for a, b in ranges(repeated_cycles(signal))]
    assert found == sorted(counts)


def in_parts(signal: np.ndarray, size: int, amplitude: float = 0.0) -> Cycles:
    counter = CycleCounter(1, amplitude)
    closed = [counter.add(0, signal[k : k + size], k) for k in range(0, len(signal), size)]
    return joined_cycles([*closed, counter.close(0)])


def listed(cycles: Cycles) -> list[tuple[float, ...]]:
    return sorted(zip(*(one.tolist() for one in cycles), strict=True))


@pytest.mark.parametrize("size", [1, 2, 7, 64, 399, 400])
@pytest.mark.parametrize("seed", range(3))
def test_cycles_of_a_history_in_parts_are_those_of_the_whole(size, seed):
    """To the last bit, with rows, also where values stay as they are for a while."""
    signal = np.round(np.random.default_rng(seed).standard_normal(400).cumsum(), 0 if seed == 0 else 9)
    assert listed(in_parts(signal, size)) == listed(repeated_cycles(signal))


@pytest.mark.parametrize("seed", range(20))
def test_small_cycles_that_are_left_out_at_once_change_no_larger_one(seed):
    rng = np.random.default_rng(seed)
    signal = rng.standard_normal(300).cumsum() + rng.standard_normal(300)
    whole = repeated_cycles(signal)
    for amplitude in np.quantile(whole.amplitude, [0.2, 0.5, 0.9, 1.0]):
        assert ranges(in_parts(signal, 50, amplitude)) == ranges(whole.larger_than(amplitude))


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


def test_what_holds_no_cycle_or_is_no_curve_is_refused():
    refused("at least 3 times to hold a cycle, got 2", repeated_cycles, np.array([0.0, 1.0]))
    for words, change in (
        ("strength must be positive", {"strength": 0.0}),
        ("slope must be at least 1", {"slope": 0.5}),
        (r"mean_sensitivity must lie in \[0, 1\)", {"mean_sensitivity": 1.0}),
        (r"survival must be inside \(0, 1\)", {"survival": 1.0}),
        ("miner must be one of", {"miner": "palmgren"}),
    ):
        refused(words, SNCurve, **{"strength": 1e8, "slope": 5.0, "knee": 1e6} | change)
