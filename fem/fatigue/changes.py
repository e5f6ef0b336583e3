"""Cycles of mixed histories: their passes follow each other in an unknown order.

A repeated history closes its own cycles. If another history follows, the highest peak of one may close a
cycle with the lowest valley of the other; this cycle replaces cycles of each alone. As in the
maximum-minimum counting of ASME VIII-2, annex 5-B, the highest peak is paired with the lowest valley of all,
at the rate of the rarer. Then the next peak and valley are paired at the remaining rates. Here a pass stays
whole, from its start to its end. After its peak or valley is paired, the remainder closes a cycle with its
turn beside these (`PassEnds`). A pass that closes the widest cycle alone may be followed by others at these
turns. Only rates enter, so that neither the order nor the cutting of the histories matters.
"""

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from fem.body.mesh import Floats, Integers
from fem.compiling import compiler

LOW, HIGH = 0, 1
"""Indices of the lowest and the highest extreme."""
WHOLE, PEAK, VALLEY = 0, 1, 2
"""Remainders of a pass: all of it, its peak, its valley."""
EVENTS = 5  # greatest number of cycles that appear and vanish as a peak is paired with a valley
PAIRS = 12  # pairs per history, many more than ever occur
BUFFER = 1 << 18  # number of events gathered in one call


class PassEnds(NamedTuple):
    """Stresses of one pass of histories that decide how they may be joined to others.

    Attributes
    ----------
    lowest, highest : array (...)
        Extremes of the pass.
    valley : array (...)
        Turn beside the highest stress: the lowest stress that the history reaches both before and after it.
        It is the valley left to the peak's own pass if another history's peak takes the lowest stress.
    peak : array (...)
        Turn beside the lowest stress: the highest stress that the history reaches both before and after it.
    """

    lowest: Floats
    highest: Floats
    valley: Floats
    peak: Floats

    @classmethod
    def stacked(cls, passes: Sequence["PassEnds"]) -> Self:
        """Return the ends (h, ...) of h histories."""
        return cls(*map(np.stack, zip(*passes, strict=True)))


class EndsTracker:
    """Ends of n histories with values in parts."""

    def __init__(self, count: int) -> None:
        self._values = np.full((count, 2, 3), np.nan)
        self._rows = np.zeros((count, 2, 3), dtype=np.int64)

    def add(self, of: slice, signals: Floats, start: int) -> None:
        """Update the ends with the next values (k, t) of some histories; the first is in row `start`."""
        _follow(signals, start, self._values[of], self._rows[of])

    @property
    def _other(self) -> Integers:
        """Side (n, 2) of the lesser turn beside each extreme: 1 before it, 2 after it."""
        before, after = self._values[..., 1], self._values[..., 2]
        is_before = np.stack([before[:, LOW] <= after[:, LOW], before[:, HIGH] >= after[:, HIGH]], axis=1)
        return np.where(is_before, 1, 2)

    def _chosen(self, values: np.ndarray) -> tuple[np.ndarray, ...]:
        turns = np.take_along_axis(values, self._other[..., None], axis=2)[..., 0]
        return values[:, LOW, 0], values[:, HIGH, 0], turns[:, HIGH], turns[:, LOW]

    @property
    def ends(self) -> PassEnds:
        """Ends (n,) of the histories."""
        return PassEnds(*self._chosen(self._values))

    @property
    def rows(self) -> PassEnds:
        """Rows (n,) of the ends."""
        return PassEnds(*self._chosen(self._rows))


@compiler(nogil=True)
def _follow(signals, start, values, rows):
    """Update extremes of signals (k, t), and the widest opposite turns before and after, in (k, 2, 3)."""
    for k in range(signals.shape[0]):
        for t in range(signals.shape[1]):
            value = np.float64(signals[k, t])
            row = start + t
            for sense in range(2):
                sign = 1.0 if sense == 1 else -1.0
                extreme, before, after = values[k, sense, 0], values[k, sense, 1], values[k, sense, 2]
                if row == 0:
                    values[k, sense, :] = value
                    rows[k, sense, :] = 0
                elif sign * value > sign * extreme:
                    # all turns so far come before it
                    if sign * after < sign * before:
                        values[k, sense, 1] = after
                        rows[k, sense, 1] = rows[k, sense, 2]
                    values[k, sense, 0] = value
                    values[k, sense, 2] = value
                    rows[k, sense, 0] = row
                    rows[k, sense, 2] = row
                elif sign * value < sign * after:
                    values[k, sense, 2] = value
                    rows[k, sense, 2] = row


class Changes(NamedTuple):
    """Cycles that appear as histories are mixed, and cycles that vanish, with negative rates.

    Attributes
    ----------
    place : int array (m,)
        Column of each cycle's ends.
    begin, end : array (m,)
        Stress at the cycle's valley and at its peak.
    rate : array (m,)
        Rate of the cycle.
    low, high : int array (m,)
        History of the valley and of the peak; plus the number of histories for a turn in place of an extreme.
    """

    place: Integers
    begin: Floats
    end: Floats
    rate: Floats
    low: Integers
    high: Integers


def changes(ends: PassEnds, rates: Floats, most: float = np.inf) -> Changes:
    """Find the changes of the cycles of h histories that are mixed in an unknown order.

    Parameters
    ----------
    ends : PassEnds
        Ends (h, n) at n places.
    rates : array (h,)
        Rate of each history.
    most : float
        Greatest rate of changes between histories, there and back.
    """
    lows = np.ascontiguousarray(np.concatenate((ends.lowest, ends.valley)), dtype=np.float64)
    highs = np.ascontiguousarray(np.concatenate((ends.highest, ends.peak)), dtype=np.float64)
    count, n = lows.shape
    room = EVENTS * PAIRS * count
    where = np.empty((3, max(BUFFER, room)), dtype=np.int64)
    often = np.empty(where.shape[1])
    gathered = [(np.empty((3, 0), dtype=np.int64), np.empty(0))]
    first = 0
    while first < n:
        first, found = _pair_ends(lows, highs, np.asarray(rates, dtype=np.float64), most, first, where, often)
        gathered.append((where[:, :found].copy(), often[:found].copy()))
    place, low, high = np.concatenate([part for part, _ in gathered], axis=1)
    rate = np.concatenate([part for _, part in gathered])
    return Changes(place, lows[low, place], highs[high, place], rate, low, high)


@compiler(nogil=True)
def _pair_ends(lows, highs, rates, most, first, where, often):
    """Write the events of places from `first` while there is room; return the next place and their number.

    `lows` and `highs` (2 h, n) are the lowest and highest stresses of h histories, then their turns: index
    k + h is history k with its turns in place of its extremes. At each place the highest remaining peak (of
    history `top`) and the lowest remaining valley (of `bottom`) are paired at the lesser of their rates,
    until no peak remains above a valley. An event (lower, higher, rate) is a cycle that appears, with the
    valley of `lower` and the peak of `higher`, or, with a negative rate, one that vanishes.
    """
    both, n = lows.shape
    h = both // 2
    count = 0
    # rates at which histories remain: whole passes, passes of which the peak, and of which the valley is left
    left = np.empty((3, both))
    for place in range(first, n):
        if count + EVENTS * PAIRS * both > often.shape[0]:
            return place, count
        low = lows[:, place]
        high = highs[:, place]
        left[:] = 0.0
        left[WHOLE, :h] = rates
        changes_left = most
        for _ in range(PAIRS * both):
            top = _outermost(high, low, left[WHOLE], left[PEAK], 1.0)
            bottom = _outermost(low, high, left[WHOLE], left[VALLEY], -1.0)
            if top < 0 or bottom < 0 or high[top] <= low[bottom]:
                break
            own = _holder(low, high, left[WHOLE], low[bottom], high[top])
            if own >= 0:
                # it closes this cycle alone, and others may follow at its start and end
                if own < h:
                    left[WHOLE, own + h] += left[WHOLE, own]
                left[WHOLE, own] = 0.0
                continue
            peak_from = PEAK if left[PEAK, top] > 0.0 else WHOLE
            valley_from = VALLEY if left[VALLEY, bottom] > 0.0 else WHOLE
            # what is left of a pass closes with its own turn a cycle at least as wide: it is not paired
            peak_stays = peak_from == PEAK and low[top + h] <= low[bottom]
            valley_stays = valley_from == VALLEY and high[bottom + h] >= high[top]
            if peak_stays:
                left[PEAK, top] = 0.0
            if valley_stays:
                left[VALLEY, bottom] = 0.0
            if peak_stays or valley_stays:
                continue
            rate = min(left[peak_from, top], left[valley_from, bottom], changes_left)
            if rate <= 0.0:
                break
            changes_left -= rate
            left[peak_from, top] -= rate
            left[valley_from, bottom] -= rate
            # the new cycle, and those that both histories closed, or their remainders, in its place
            events = [(bottom, top, rate)]
            if peak_from == PEAK:
                events.append((top + h, top, -rate))
            elif top < h:
                left[VALLEY, top] += rate
                events.append((top, top, -rate))
                events.append((top, top + h, rate))
            if valley_from == VALLEY:
                events.append((bottom, bottom + h, -rate))
            elif bottom < h:
                left[PEAK, bottom] += rate
                events.append((bottom, bottom, -rate))
                events.append((bottom + h, bottom, rate))
            for lower, higher, each in events:
                if high[higher] > low[lower]:
                    where[0, count] = place
                    where[1, count] = lower
                    where[2, count] = higher
                    often[count] = each
                    count += 1
    return n, count


@compiler(nogil=True)
def _outermost(level, other, whole, half, sense):
    """Find the remaining history with the highest (sense 1) or lowest (-1) level; -1 if none remains.

    Ties do not depend on the order of histories: a half pass comes first, then the wider one, then the one
    with the wider turns.
    """
    h = len(level) // 2
    best = -1
    for k in range(len(level)):
        if whole[k] <= 0.0 and half[k] <= 0.0:
            continue
        if best < 0 or sense * level[k] > sense * level[best]:
            best = k
            continue
        if level[k] != level[best]:
            continue
        if (half[k] > 0.0) != (half[best] > 0.0):
            if half[k] > 0.0:
                best = k
        elif other[k] != other[best]:
            if sense * other[k] < sense * other[best]:
                best = k
        elif k < h and best < h:
            if other[k + h] != other[best + h]:
                if sense * other[k + h] < sense * other[best + h]:
                    best = k
            elif sense * level[k + h] > sense * level[best + h]:
                best = k
    return best


@compiler(nogil=True)
def _holder(low, high, whole, lowest, highest):
    """Find a history with a whole pass left that holds both extremes; -1 if there is none."""
    for k in range(len(low)):
        if whole[k] > 0.0 and low[k] == lowest and high[k] == highest:
            return k
    return -1
