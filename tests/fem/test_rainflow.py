"""Rainflow of repeated histories: published examples, and what repeating and shifting must not change."""

import numpy as np
import pytest
import rainflow

from fem.rainflow import CycleCounter, Cycles, joined_cycles, repeated_cycles


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


@pytest.mark.parametrize("shift", [1, 57, 111])
def test_where_a_repeated_history_begins_does_not_matter(shift):
    signal = np.random.default_rng(3).standard_normal(200)
    assert ranges(repeated_cycles(np.roll(signal, shift))) == ranges(repeated_cycles(signal))


def test_more_passes_have_as_many_times_the_cycles():
    signal = np.random.default_rng(4).standard_normal(150)
    once, thrice = (ranges(repeated_cycles(np.tile(signal, passes))) for passes in (1, 3))
    assert thrice == sorted(3 * once)


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


def test_two_times_hold_no_cycle():
    with pytest.raises(ValueError, match="at least 3 times to hold a cycle, got 2"):
        repeated_cycles(np.array([0.0, 1.0]))


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
