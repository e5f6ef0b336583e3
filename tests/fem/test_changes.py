"""Cycles of mixed histories: hand counts, the worst of all orders, and what must not change them."""

import itertools

import numpy as np
import pytest

from fem import SNCurve, repeated_cycles
from fem.fatigue.changes import EndsTracker, PassEnds, changes
from fem.fatigue.damage import damage_of_changes

CURVE = SNCurve(strength=100e6, slope=5.0, knee=1e6)


def ends_of(passes):
    """Ends (h, 1) of signals, which are followed in two parts."""
    ends = []
    for signal in passes:
        tracker = EndsTracker(1)
        for rows in (slice(0, 2), slice(2, None)):
            tracker.add(slice(1), np.array(signal[rows], dtype=float)[None], rows.start)
        rows = np.concatenate(tracker.rows)
        assert np.array(signal, dtype=float)[rows].tolist() == np.concatenate(tracker.ends).tolist()
        ends.append(tracker.ends)
    return PassEnds.stacked(ends)


def cycles_of(passes, rates, most=np.inf):
    """Cycles of mixed passes by their ends, and how often each happens, in increasing order."""
    count = {}
    for signal, rate in zip(passes, rates, strict=True):
        cycles = repeated_cycles(np.array(signal, dtype=float))
        for pair in zip(cycles.begin, cycles.end, strict=True):
            pair = tuple(sorted(map(float, pair)))
            count[pair] = count.get(pair, 0.0) + rate
    found = changes(ends_of(passes), np.array(rates, dtype=float), most)
    for low, high, rate in zip(found.begin, found.end, found.rate, strict=True):
        count[float(low), float(high)] = count.get((float(low), float(high)), 0.0) + rate
    return {pair: count[pair] for pair in sorted(count) if abs(count[pair]) > 1e-12}


def damage(count):
    return sum(rate * (high - low) ** 5 for (low, high), rate in count.items())


@pytest.mark.parametrize(
    ("signal", "lowest", "highest", "valley", "peak"),
    [
        ((0, 10, 0), 0, 10, 0, 0),
        ((5, 7, 3, 10, 0, 6, 5), 0, 10, 3, 6),
        ((0, -4, 0), -4, 0, 0, 0),
        ((2, 2, 2), 2, 2, 2, 2),
    ],
)
def test_ends_are_the_extremes_and_the_turns_on_their_other_sides(signal, lowest, highest, valley, peak):
    assert [float(end[0, 0]) for end in ends_of([signal])] == [lowest, highest, valley, peak]


@pytest.mark.parametrize(
    ("passes", "rates", "expected"),
    [
        # one holds both ends
        ([(0, 10, 0), (0, 6, 0)], (2, 3), {(0, 6): 3, (0, 10): 2}),
        # both begin and end between: one cycle in place of two
        ([(0, 6, 0), (0, -4, 0)], (2, 3), {(-4, 0): 1, (-4, 6): 2}),
        # from unloaded and from a load: that which comes from the load is replaced
        ([(0, 10, 0), (5, 12, 5)], (2, 3), {(0, 10): 2, (0, 12): 2, (5, 12): 1}),
        # levels apart: what goes on within either stays
        ([(0, 3, 0), (8, 9, 8)], (1, 1), {(0, 3): 1, (0, 9): 1}),
        # others follow where the widest begins and ends
        ([(-7, 2, -7), (-5, 1, -5)], (1, 3), {(-7, 1): 1, (-7, 2): 1, (-5, 1): 2}),
        ([(0, 6, 0)], (2,), {(0, 6): 2}),
    ],
)
def test_cycles_of_mixed_passes_by_hand(passes, rates, expected):
    assert cycles_of(passes, rates) == pytest.approx(expected)


def test_no_more_changes_than_there_are():
    passes = (0, 6, 0), (0, -4, 0)
    assert cycles_of(passes, (2, 3), 0.5) == pytest.approx({(-4, 0): 2.5, (-4, 6): 0.5, (0, 6): 1.5})
    assert cycles_of(passes, (2, 3), 0.0) == pytest.approx({(-4, 0): 3, (0, 6): 2})


@pytest.mark.parametrize("seed", range(12))
def test_no_order_of_passes_does_more_damage(seed):
    """Passes from unloaded to unloaded in every order, by rainflow; one of the orders does about as much."""
    random = np.random.default_rng(seed)
    count = random.integers(2, 4)
    passes = [(0, *random.integers(-9, 10, random.integers(1, 4)), 0) for _ in range(count)]
    rates = random.integers(1, 4 if len(passes) == 2 else 3, len(passes))
    rows = [signal for signal, rate in zip(passes, rates, strict=True) for _ in range(rate)]
    worst = 0.0
    for order in set(itertools.permutations(rows[1:])):
        whole = np.concatenate((rows[0], *order)).astype(float)
        worst = max(worst, damage(cycles_of([whole], (1,))))
    found = damage(cycles_of(passes, rates))
    assert found >= worst * (1.0 - 1e-12)
    assert found <= 1.3 * worst


@pytest.mark.parametrize("most", [np.inf, 2.5])
def test_neither_order_nor_cutting_of_the_rows_matters(most):
    random = np.random.default_rng(4)
    for _ in range(200):
        passes = [tuple(random.integers(-9, 10, random.integers(3, 8))) for _ in range(random.integers(1, 6))]
        rates = random.uniform(0.1, 4.0, len(passes))
        rows = [
            (signal, rate * part)
            for signal, rate in zip(passes, rates, strict=True)
            for part in random.dirichlet(np.ones(random.integers(1, 4)))
        ]
        cut = [rows[k] for k in random.permutation(len(rows))]
        whole, again = cycles_of(passes, rates, most), cycles_of(*zip(*cut, strict=True), most)
        assert damage(again) == pytest.approx(damage(whole), rel=1e-9)
        # none is taken off that was not there
        assert min(whole.values(), default=0.0) >= 0.0


def test_damage_of_many_places_is_that_of_each():
    random = np.random.default_rng(9)
    signals = random.normal(0.0, 80e6, (4, 500, 7))
    rates = np.array([3.0, 1.0, 0.2, 5.0])
    together = []
    for signal in signals:
        tracker = EndsTracker(500)
        tracker.add(slice(500), signal, 0)
        together.append(tracker.ends)
    ends = PassEnds.stacked(together)
    found = damage_of_changes(changes(ends, rates), CURVE, (0.5, 0.9), 500)
    for place in (0, 17, 499):
        alone = changes(PassEnds(*(end[:, place : place + 1] for end in ends)), rates)
        assert damage_of_changes(alone, CURVE, (0.5, 0.9), 1)[:, 0] == pytest.approx(found[:, place])
    assert (found > 0.0).mean() > 0.9
