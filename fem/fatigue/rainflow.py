"""Cycles of a repeated stress history, counted by pyLife's four-point rainflow method.

Cycles that the first pass leaves open (the residue) close in a second pass (C. Amzallag et al.,
Standardization of the rainflow counting method for fatigue analysis, Int. J. Fatigue 16, 1994). One pass then
has all cycles of every later pass, and a history of n passes has n times as many.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fem.body.mesh import Floats, Integers
from fem.compiling import compiler


class Cycles(NamedTuple):
    """Closed cycles of a repeated history.

    Attributes
    ----------
    begin, end : array (n,)
        Stress at both ends of each cycle.
    begin_row, end_row : int array (n,)
        Rows of the ends in the history.
    """

    begin: Floats
    end: Floats
    begin_row: Integers
    end_row: Integers

    @property
    def amplitude(self) -> Floats:
        """Half the range of each cycle."""
        return 0.5 * np.abs(self.end - self.begin)

    @property
    def mean(self) -> Floats:
        """Mean stress of each cycle."""
        return 0.5 * (self.begin + self.end)

    def larger_than(self, amplitude: float) -> "Cycles":
        """Return the cycles with larger amplitudes."""
        large = self.amplitude > amplitude
        return Cycles(self.begin[large], self.end[large], self.begin_row[large], self.end_row[large])


def joined_cycles(parts: Sequence[Cycles]) -> Cycles:
    """Join the cycles of all parts, at least one, in order."""
    return Cycles(*map(np.concatenate, zip(*parts, strict=True)))


NO_CYCLES = Cycles(np.empty(0), np.empty(0), *2 * (np.empty(0, dtype=np.int64),))


class CycleCounter:
    """Cycles of n repeated histories with values in parts; memory holds the open cycles of each.

    Cycles up to an amplitude are left out. Smaller reversals are left out too: they are ends of no other
    cycles.
    """

    def __init__(self, count: int, amplitude: float = 0.0) -> None:
        self._amplitude, self._sense = amplitude, np.zeros((count, 1), dtype=np.int8)
        self._values, self._rows = np.zeros((count, 2)), np.zeros((count, 2), dtype=np.int64)
        self._open = [(np.empty(0), np.empty(0, dtype=np.int64))] * count

    def add(self, number: int, signal: Floats, start: int) -> Cycles:
        """Return the cycles that the next values (t,) of a history close; the first is in row `start`."""
        values = np.empty(len(signal))
        rows = np.empty(len(signal), dtype=np.int64)
        state = self._sense[number], self._values[number], self._rows[number]
        count = _reversals(signal, start, 2.0 * self._amplitude, *state, values, rows)
        return self._closed(number, values[:count], rows[:count]) if count else NO_CYCLES

    def close(self, number: int) -> Cycles:
        """Return the cycles that a history closes by its end and its repetition."""
        if self._sense[number] == 0:
            return NO_CYCLES
        last = self._sense[number] > 0
        last = np.append(~last, last)
        ended = self._closed(number, self._values[number, last], self._rows[number, last])
        again = self._closed(number, *self._open[number])
        return joined_cycles((ended, again))

    def _closed(self, number: int, values: Floats, rows: Integers) -> Cycles:
        """Return the cycles that further reversals of a history close."""
        values, rows = (np.concatenate(pair) for pair in zip(self._open[number], (values, rows), strict=True))
        if len(values) < 4:
            self._open[number] = values, rows
            return NO_CYCLES
        from pylife.stress.rainflow import FourPointDetector, FullRecorder

        counted = FourPointDetector(FullRecorder()).process(values)
        loops = counted.recorder
        left = counted.residual_index.astype(np.int64)
        self._open[number] = values[left], rows[left]
        begin = loops.index_from.astype(np.int64)
        end = loops.index_to.astype(np.int64)
        return Cycles(loops.values_from, loops.values_to, rows[begin], rows[end]).larger_than(self._amplitude)


@compiler(nogil=True)
def _reversals(signal, start, least, sense, extremes, places, values, rows):
    """Write reversals of a signal (t,) by more than `least` into values and rows; return their number.

    `sense` (1,) is 1 while the signal rises, -1 while it falls, 0 before its first reversal. `extremes` (low,
    high), in the rows `places`, are the candidate for the next reversal and the last value. Both are
    candidates before the first reversal.
    """
    count = 0
    for row in range(start, start + len(signal)):
        value = np.float64(signal[row - start])
        if row == 0 or value < extremes[0] or sense[0] > 0:
            extremes[0] = value
            places[0] = row
        if row == 0 or value > extremes[1] or sense[0] < 0:
            extremes[1] = value
            places[1] = row
        if extremes[1] - extremes[0] > least:
            past = 0 if places[0] < places[1] else 1
            values[count] = extremes[past]
            rows[count] = places[past]
            count = count + 1
            sense[0] = 1 - 2 * past
    return count


def repeated_cycles(signal: Floats) -> Cycles:
    """Return the cycles of one pass of a repeated history (t,).

    Raises
    ------
    ValueError
        If the history is too short for a cycle: fewer than three values.
    """
    if len(signal) < 3:
        raise ValueError(f"a history must have at least 3 times to hold a cycle, got {len(signal)}")
    counter = CycleCounter(1)
    return joined_cycles((counter.add(0, signal, 0), counter.close(0)))
