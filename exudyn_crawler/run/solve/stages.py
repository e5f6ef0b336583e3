"""Stages of a run, with a restart of the solver at each: times, stored states, history."""

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.drive import SETTLING
from exudyn_crawler.model.track_system import TrackSystem
from exudyn_crawler.results.history import History, files, ground_map, states
from exudyn_crawler.run.folder.checkpoints import Checkpoints, StageEnd

TIME_TOLERANCE = 1e-9
"""Greatest relative difference of times that count as the same."""


def stage_times(case: Case, duration: float) -> list[float]:
    """Return the ends of the stages of a run, from 0 to its duration, s.

    The integration restarts from its state at every multiple of the solver's checkpoint interval, and when
    the drive goes on or off.
    """
    interval = case.solver.checkpoint_interval
    times = {0.0, duration} | {k * interval for k in range(1, math.ceil(duration / interval))}
    for time in case.drive.switch_times:
        times |= {other for other in (time, time + SETTLING) if other < duration}
    ends: list[float] = []
    for time in sorted(times):
        if not ends or time - ends[-1] > TIME_TOLERANCE * duration:
            ends.append(time)
    ends[-1] = duration
    return ends


def is_quiet(case: Case, start: float) -> bool:
    """Return True if the track is quiet in the stage with a start time, s."""
    return case.drive.off_since(start) >= SETTLING * (1.0 - TIME_TOLERANCE)


SAME = 1e-6
"""Greatest difference of times that count as the same, fraction of a step."""
LEAST_PART = 0.1
"""Least distance of an output time from the ends of a stage for a step to end there, fraction of a step."""


def step_ends(start: float, end: float, step: float, interval: float) -> Callable[[float], float]:
    """Return a function of a time (s) within a stage that returns the next prescribed end of a step.

    Steps end at the end of the stage, and at every multiple of an output interval that is not shorter than a
    step. Each part between has equal steps, none longer than `step`. So stored states are those of the output
    times even after a halved step.
    """
    fixed: list[float] = []
    if interval > (1.0 - SAME) * step:
        numbers = range(math.floor(start / interval), math.ceil(end / interval) + 1)
        outputs = [number * interval for number in numbers]
        fixed = [time for time in outputs if min(time - start, end - time) > LEAST_PART * step]
    parts = pairwise([start, *fixed, end])
    ends: list[float] = []
    for first, last in parts:
        count = max(1, math.ceil((last - first) / step - SAME))
        size = (last - first) / count
        ends += [*(number * size + first for number in range(1, count)), last]

    def next_end(time: float) -> float:
        return ends[min(bisect_left(ends, time + SAME * step), len(ends) - 1)]

    return next_end


KEPT = "then"
"""Name of the cells' records at chosen times, in a stored memory."""


class Recorder:
    """Recorder of states at the start (unless it continues a run) and at every output interval.

    At the first steps after `ground_times` (s) it also records the memory of the ground, in `then` (cells,
    THEN). `ends` of the stages (s) go from 0 to the run's duration. Checkpoints store every stage but the
    last, and the history; without them both are in memory. The system is set to the end of their last stage;
    `first` is the number of the first stage to integrate.
    """

    def __init__(
        self,
        system: TrackSystem,
        duration: float,
        ground_times: Sequence[float] = (),
        checkpoints: Checkpoints | None = None,
    ) -> None:
        self._system = system
        self._duration = duration
        self._checkpoints = checkpoints
        self._interval = system.case.solver.output_interval
        self._tolerance = TIME_TOLERANCE * max(1.0, duration)
        self._next = 0.0
        self._states: list[np.ndarray] = []
        self._chunks: list[files.Chunk] = []  # chunks of the history, of earlier stages
        self._in_stage = False  # True if a state of the current stage is stored
        self._ground_times = list(ground_times)
        self.then = np.zeros((0, ground_map.THEN))
        self.time = 0.0
        self.ends = stage_times(system.case, duration)
        self.first = 0
        if checkpoints is not None:
            self._go_on_from(checkpoints)

    def _go_on_from(self, checkpoints: Checkpoints) -> None:
        """Set the system to the end of the last stored stage that this run has too, except its last one."""
        last = None
        case = self._system.case
        for stage in checkpoints.load(case, self._system.layout.to_json()):
            # a shorter run ends within a stage of a longer one
            is_last = stage.number >= len(self.ends) - 2
            if is_last or abs(stage.time - self.ends[stage.number + 1]) > TIME_TOLERANCE * self._duration:
                break
            last = stage
            self._chunks.append(stage.chunk)
        if last is not None:
            self.first, end = last.number + 1, last.read()
            self._system.set_state(end.state, end.memory)
            self.go_on(last.time, end.memory)
            checkpoints.say(f"{case.name}: going on from the checkpoint at t = {last.time:g} s")

    def go_on(self, time: float, memory: Mapping[str, np.ndarray] | None = None) -> None:
        """Continue after a time, s, whose state is stored; in another process with the stored `memory`."""
        self.time = time
        self._next = (math.floor(time / self._interval + 1e-6) + 1) * self._interval
        if memory is not None:
            self.then = memory.get(KEPT, self.then)
            self._ground_times = [
                ground_time for ground_time in self._ground_times if ground_time > time + self._tolerance
            ]

    def store(self, time: float) -> None:
        """Store the state if an output is due; the last state is always stored."""
        self.time = time
        if time >= min(self._next, self._duration) - self._tolerance:
            self._states.append(self._system.state())
            self._in_stage = True
            self.go_on(time)
        if self._ground_times and time >= self._ground_times[0] - self._tolerance:
            self._ground_times = [
                ground_time for ground_time in self._ground_times if ground_time > time + self._tolerance
            ]
            if memory := self._system.memory():
                self.then = np.concatenate((self.then, ground_map.memory_now(memory, time)))

    def end_stage(self, number: int) -> None:
        """End an integrated stage, with at least one state, and restart the system from its end."""
        if not self._in_stage:
            self._states.append(self._system.state())
        self._in_stage = False
        state = self._system.state()
        self._system.set_state(state)
        if self._checkpoints is None or number == len(self.ends) - 2:
            return
        memory = self._system.memory()
        stage = StageEnd(
            case=self._system.case.model_dump_json(),
            number=number,
            time=self.time,
            layout=self._system.layout.to_json(),
            state=state,
            memory=memory | {KEPT: self.then} if memory else memory,
            history=states.system_history(self._system, self.taken()).dataset,
        )
        self._chunks.append(self._checkpoints.save(stage).chunk)

    def taken(self) -> np.ndarray:
        """Return the states stored since the last call, one a row, and release them."""
        rows = np.array(self._states)
        self._states.clear()
        return rows

    @property
    def nothing(self) -> bool:
        """True before the first stored state."""
        return not (self._chunks or self._states)

    @property
    def first_state(self) -> np.ndarray:
        """First of the states stored since `taken`, a row."""
        return self._states[0]

    def history(self) -> History:
        """Return the history of all stages, with the stored states of a stage that stopped early.

        With checkpoints the history is written to their folder and read from there, so that a longer run
        takes no more memory.
        """
        case = self._system.case
        end = ground_map.end_memory(self._system.memory(), self.then)
        rows = self.taken()
        if self._checkpoints is None:
            return History(case, states.system_history(self._system, rows).dataset.assign(end))
        if len(rows):
            self._chunks.append(files.Chunk.of(states.system_history(self._system, rows).dataset))
        return History.load(self._checkpoints.save_history(case, self._chunks, end))
