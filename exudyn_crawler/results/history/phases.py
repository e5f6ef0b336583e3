"""Phases of a run: those of its load cycle, as far as the run goes."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import LoadCycle, MachineCycle
from exudyn_crawler.results.history.history import History


class Phase(NamedTuple):
    """Part of a run: name, and begin and end in s."""

    name: str
    begin: float
    end: float

    def rows(self, time: NDArray) -> NDArray:
        """Whether each time (s) belongs to it: array of bool (times,); its begin is the one before's."""
        after = time >= 0.0 if self.begin == 0.0 else time > self.begin * (1.0 + 1e-9)
        return after & (time <= self.end * (1.0 + 1e-9))


def phases(cycle: LoadCycle | MachineCycle, duration: float) -> list[Phase]:
    """Phases that a run of some duration (s) reaches.

    The first begins with the run; the last of the cycle, whose loads stay, ends with it. A phase that ends
    as the run begins is no part of it, unless it is the only one.
    """
    names = [phase.name for phase in cycle.phases]
    ends = [phase.end for phase in cycle.phases]
    ends[-1] = max(ends[-1], duration)
    begins = [0.0, *ends[:-1]]
    return [
        Phase(name, begin, min(end, duration))
        for name, begin, end in zip(names, begins, ends, strict=True)
        if begin < duration and end > begin
    ]


def common_phases(*histories: History) -> list[Phase]:
    """Phases that runs go through together, to the end of the longest; none where those of two differ.

    They are those of the machine where it acts on a side frame, and else of the loads on the shoes.
    """
    duration = max(one.duration for one in histories)
    cycles = (one.case.machine or one.case.loads for one in histories)
    first, *others = (phases(cycle, duration) for cycle in cycles)
    return first if all(one == first for one in others) else []


def phase_ends(loads: LoadCycle, duration: float) -> list[float]:
    """Begin of a run and the ends of its phases, s."""
    return [0.0, *np.unique([phase.end for phase in phases(loads, duration)]).tolist()]
