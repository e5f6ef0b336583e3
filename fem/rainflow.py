"""Cycles of a repeated history of stress, counted by pyLife's four-point rainflow.

Cycles that the first pass leaves open (the residue) close in a second pass (C. Amzallag et al.,
Standardization of the rainflow counting method for fatigue analysis, Int. J. Fatigue 16, 1994): a pass then
has all cycles of every later one, and a history of n passes has n times as many.
"""

from typing import NamedTuple

import numpy as np
from pylife.stress.rainflow import FourPointDetector, FullRecorder

from fem.mesh import Floats, Integers


class Cycles(NamedTuple):
    """Closed cycles of a repeated history.

    Attributes
    ----------
    begin, end : array (n,)
        Stress at both ends of each.
    begin_row, end_row : int array (n,)
        Rows of the history where these are.
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
        """Cycles of larger amplitudes."""
        large = self.amplitude > amplitude
        return Cycles(self.begin[large], self.end[large], self.begin_row[large], self.end_row[large])


def repeated_cycles(signal: Floats) -> Cycles:
    """Cycles of one pass of a history (t,) that is repeated.

    Raises
    ------
    ValueError
        If it is too short for a cycle: less than three values.
    """
    if len(signal) < 3:
        raise ValueError(f"a history must have at least 3 times to hold a cycle, got {len(signal)}")
    first = FourPointDetector(FullRecorder()).process(signal)
    rows = np.tile(first.residual_index, 2).astype(np.int64)
    again = FourPointDetector(FullRecorder()).process(signal[rows])
    one, two = first.recorder, again.recorder
    return Cycles(
        np.concatenate((one.values_from, two.values_from)),
        np.concatenate((one.values_to, two.values_to)),
        np.concatenate((one.index_from, rows[two.index_from])).astype(np.int64),
        np.concatenate((one.index_to, rows[two.index_to])).astype(np.int64),
    )
