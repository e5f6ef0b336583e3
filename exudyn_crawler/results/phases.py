"""Phases of a run: those of its load cycle, as far as the run goes."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import LoadCycle


class Phase(NamedTuple):
    """Part of a run: name, and begin and end in s."""

    name: str
    begin: float
    end: float

    def rows(self, time: NDArray) -> NDArray:
        """Whether each time (s) belongs to it: array of bool (times,); its begin is the one before's."""
        after = time >= 0.0 if self.begin == 0.0 else time > self.begin * (1.0 + 1e-9)
        return after & (time <= self.end * (1.0 + 1e-9))


def phases(loads: LoadCycle, duration: float) -> list[Phase]:
    """Phases that a run of some duration (s) reaches.

    The first begins with the run; the last of the cycle, whose loads stay, ends with it. A phase that ends
    as the run begins is no part of it, unless it is the only one.
    """
    ends = [phase.end for phase in loads.phases]
    ends[-1] = max(ends[-1], duration)
    begins = [0.0, *ends[:-1]]
    return [
        Phase(phase.name, begin, min(end, duration))
        for phase, begin, end in zip(loads.phases, begins, ends, strict=True)
        if begin < duration and end > begin
    ]


def phase_ends(loads: LoadCycle, duration: float) -> list[float]:
    """Begin of a run and the ends of its phases, s."""
    return [0.0, *np.unique([phase.end for phase in phases(loads, duration)]).tolist()]
