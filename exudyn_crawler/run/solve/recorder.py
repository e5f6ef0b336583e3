"""States that a run stores as it goes."""

import math

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.model.formulation import TrackSystem
from exudyn_crawler.run.solve.stages import TIME_TOLERANCE


class Recorder:
    """Keeps the state at the start, unless it is another run's end, and after every output interval."""

    def __init__(self, system: TrackSystem, duration: float, start: float | None = None) -> None:
        self._system = system
        self._interval = system.case.solver.output_interval
        self._duration = duration
        self._next = 0.0
        self._states: list[NDArray] = []
        self.time = 0.0
        if start is not None:
            self._end_of(start)

    def go_on(self, time: float) -> None:
        """Go on behind the end of a stage, s."""
        self._end_of(time)

    def _end_of(self, time: float) -> None:
        self.time = time
        self._next = (math.floor(time / self._interval + 1e-6) + 1) * self._interval

    def store(self, time: float) -> None:
        """Store the state if its turn has come; the last one always."""
        self.time = time
        tolerance = TIME_TOLERANCE * max(1.0, self._duration)
        if time >= self._next - tolerance or time >= self._duration - tolerance:
            self._states.append(self._system.state())
            self._end_of(time)

    def end_stage(self) -> None:
        """Store the state at the end of a stage shorter than the output interval: each has one at least."""
        if not self._states:
            self._states.append(self._system.state())

    def taken(self) -> NDArray:
        """States stored since the last call, one a row; they are not kept any longer."""
        rows = np.array(self._states)
        self._states.clear()
        return rows

    @property
    def count(self) -> int:
        """Number of states stored since then."""
        return len(self._states)
