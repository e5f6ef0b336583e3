"""Stages of a run, each of which the solver starts anew: times, stored states, history."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.model.track_system import TrackSystem
from exudyn_crawler.results.history import History, files, ground_map, states
from exudyn_crawler.run.folder.checkpoints import Checkpoint, Checkpoints

TIME_TOLERANCE = 1e-9
"""Relative difference below which two times are the same."""
SETTLING = 1.0
"""s after the drive goes off until the track is quiet; its shoes swing at 8 Hz and more."""


def stage_times(case: Case, duration: float) -> list[float]:
    """Ends of the stages of a run, from 0 to its duration, s.

    The integration starts anew from its state at every multiple of the solver's checkpoint interval and
    where the drive goes on or off.
    """
    interval = case.solver.checkpoint_interval
    times = {0.0, duration} | {k * interval for k in range(1, math.ceil(duration / interval))}
    for time in case.drive.switch_times:
        times |= {other for other in (time, time + SETTLING) if other < duration}
    kept: list[float] = []
    for time in sorted(times):
        if not kept or time - kept[-1] > TIME_TOLERANCE * duration:
            kept.append(time)
    kept[-1] = duration
    return kept


def is_quiet(case: Case, start: float) -> bool:
    """Whether the track is quiet in the stage that starts at a time, s."""
    return case.drive.off_since(start) >= SETTLING * (1.0 - TIME_TOLERANCE)


KEPT = "then"
"""Name of what cells remembered at chosen times, in a memory."""


class Recorder:
    """Keeps the state at the start, unless it goes on behind another one's end, and every output interval.

    At the first steps behind `ground_times` (s) also what the ground remembers, in `then` (cells, THEN).
    """

    def __init__(self, system: TrackSystem, duration: float, ground_times: Sequence[float] = ()) -> None:
        self._system = system
        self._interval = system.case.solver.output_interval
        self._duration = duration
        self._tolerance = TIME_TOLERANCE * max(1.0, duration)
        self._next = 0.0
        self._states: list[np.ndarray] = []
        self._in_stage = False  # whether one of them is of the stage that goes on
        self._ground_times = list(ground_times)
        self.then = np.zeros((0, ground_map.THEN))
        self.time = 0.0

    def go_on(self, time: float, memory: Mapping[str, np.ndarray] | None = None) -> None:
        """Go on behind a time, s, of which the state is stored, in another process with a stored memory."""
        self.time = time
        self._next = (math.floor(time / self._interval + 1e-6) + 1) * self._interval
        if memory is not None:
            self.then = memory.get(KEPT, self.then)
            self._ground_times = [one for one in self._ground_times if one > time + self._tolerance]

    def memory(self) -> dict[str, np.ndarray]:
        """Memory of the ground, with that of chosen times."""
        memory = self._system.memory()
        return memory | {KEPT: self.then} if memory else memory

    def store(self, time: float) -> None:
        """Store the state if its turn has come; the last one always."""
        self.time = time
        if time >= min(self._next, self._duration) - self._tolerance:
            self._states.append(self._system.state())
            self._in_stage = True
            self.go_on(time)
        if self._ground_times and time >= self._ground_times[0] - self._tolerance:
            self._ground_times = [one for one in self._ground_times if one > time + self._tolerance]
            if memory := self._system.memory():
                self.then = np.concatenate((self.then, ground_map.memory_now(memory, time)))

    def end_stage(self) -> None:
        """Store the state at the end of a stage shorter than the output interval: each has one at least."""
        if not self._in_stage:
            self._states.append(self._system.state())
        self._in_stage = False

    def taken(self) -> np.ndarray:
        """States stored since the last call, one a row; they are not kept any longer."""
        rows = np.array(self._states)
        self._states.clear()
        return rows

    @property
    def count(self) -> int:
        """Number of states stored since then."""
        return len(self._states)


class RunStages:
    """Stages of a run; with checkpoints, what a recorder stored leaves its memory with each.

    The system is brought to the end of the last stage that the checkpoints hold; `first` is the number of the
    first stage that is to be integrated. `ends` of the stages (s) go from 0 to the run's duration.
    Checkpoints take every stage but the last, and the history; without them both are in memory.
    """

    def __init__(
        self, system: TrackSystem, recorder: Recorder, ends: Sequence[float], checkpoints: Checkpoints | None
    ) -> None:
        self._system, self._recorder, self._checkpoints = system, recorder, checkpoints
        self._last = len(ends) - 2
        self._chunks: list[files.Chunk] = []
        self.first = 0
        if checkpoints is not None:
            self._go_on(checkpoints, ends)

    def _go_on(self, checkpoints: Checkpoints, ends: Sequence[float]) -> None:
        tolerance, kept = TIME_TOLERANCE * ends[-1], list[Checkpoint]()
        for stage in checkpoints.load(self._system.case, self._system.layout.to_json()):
            # a shorter run ends within a stage of a longer one
            if stage.number >= self._last or abs(stage.time - ends[stage.number + 1]) > tolerance:
                break
            kept.append(stage)
        if kept:
            last = kept[-1]
            self._chunks, self.first = checkpoints.chunks(kept), last.number + 1
            state, memory = last.end()
            self._system.set_state(state, memory)
            self._recorder.go_on(last.time, memory)
            checkpoints.say(f"{self._system.case.name}: going on from the checkpoint at t = {last.time:g} s")

    def end(self, number: int) -> None:
        """End a stage that was integrated, and start the next one from its state."""
        self._recorder.end_stage()
        state = self._system.state()
        self._system.set_state(state)
        if self._checkpoints is None or number == self._last:
            return
        history = states.system_history(self._system, self._recorder.taken()).dataset
        layout = self._system.layout.to_json()
        case, time = self._system.case, self._recorder.time
        memory = self._recorder.memory()
        stage = self._checkpoints.save(case, number, time, layout, state, memory, history)
        self._chunks.append(stage.chunk)

    @property
    def nothing(self) -> bool:
        """Whether no state was stored yet."""
        return not (self._chunks or self._recorder.count)

    def history(self) -> History:
        """History of all stages, and of as much of one that stopped early as was stored.

        With checkpoints it is written into their folder, which takes no more memory for a longer run, and
        read from there.
        """
        case, end = self._system.case, ground_map.end_memory(self._system.memory(), self._recorder.then)
        rows = self._recorder.taken()
        if self._checkpoints is None:
            return History(case, states.system_history(self._system, rows).dataset.assign(end))
        if len(rows):
            self._chunks.append(files.Chunk.of(states.system_history(self._system, rows).dataset))
        return History.load(self._checkpoints.save_history(case, self._chunks, end))
