"""Time integration of a case from its static equilibrium."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, Solver
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.model.engine import exu
from exudyn_crawler.model.system import System, build
from exudyn_crawler.results.history import History
from exudyn_crawler.results.states import history_of
from exudyn_crawler.run.checkpoints import Checkpoint, Checkpoints
from exudyn_crawler.run.equilibrium import static_equilibrium
from exudyn_crawler.run.progress import progress_bar

TIME_TOLERANCE = 1e-9
"""Relative difference below which two times are the same."""
SETTLING = 1.0
"""s after the drive goes off until the track is quiet; its shoes swing at 8 Hz and more."""


def simulate(
    case: Case, duration: float, progress: bool | None = None, checkpoints: Checkpoints | None = None
) -> History:
    """Run a case from static equilibrium, or from the last of the checkpoints.

    The run is made of stages (`stage_times`); each starts from the end of the one before, whether in
    the same process or, after a kill, in a later one, so that both give the same numbers.

    Parameters
    ----------
    case : Case
        All that the run depends on.
    duration : float
        s, simulated time.
    progress : bool, optional
        Show a progress bar; None shows it on a terminal only.
    checkpoints : Checkpoints, optional
        Keeps every stage but the last; the run goes on behind those that are there.

    Raises
    ------
    ValueError
        Before anything runs, if `duration` is not positive and finite, the drive takes the track
        off the terrain within it or the checkpoints come from other parameters.
    EquilibriumError
        If the track finds no rest before t = 0.
    SimulationStopped
        If a step fails at its least size, if spheres of the second contact model sink through the ground,
        or on an interrupt; it carries the history up to there.
    """
    if not (math.isfinite(duration) and duration > 0.0):
        raise ValueError(f"duration must be positive and finite, got {duration!r} s")
    case.check_support(duration)
    if checkpoints is not None:
        checkpoints.load(case)
    system = build(case)
    system.set_initial(static_equilibrium(case))
    return integrate(system, duration, progress, checkpoints=checkpoints)


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


def integrate(
    system: System,
    duration: float,
    progress: bool | None = None,
    settings: "exu.SimulationSettings | None" = None,
    checkpoints: Checkpoints | None = None,
) -> History:
    """Integrate a built system from its initial state; see `simulate`.

    `settings` take the place of those that `solver_settings` makes of the case, their times apart.
    """
    case = system.case
    if settings is None:
        settings = solver_settings(case.solver)
    recorder = _Recorder(system, duration)
    reason = None
    with progress_bar(case.name, duration, progress) as tell:
        sunken = _watch(system, recorder, tell)
        saved = [] if checkpoints is None else checkpoints.load(case)
        for number, (start, end) in enumerate(pairwise(stage_times(case, duration))):
            if number < len(saved) and abs(saved[number].time - end) < TIME_TOLERANCE * duration:
                recorder.take(saved[number])
                system.set_state(saved[number].state)
                continue
            system.switch_drive(case.drive.drives_after(start))
            quiet = case.drive.off_since(start) >= SETTLING * (1.0 - TIME_TOLERANCE)
            set_times(settings, case.solver, start, end, quiet)
            settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = number == 0
            first = recorder.count
            reason = _solve(system, settings, sunken)
            if reason is not None:
                break
            state = system.state()
            system.set_state(state)
            if checkpoints is not None and end < duration:
                checkpoints.save(case, number, Checkpoint(state, recorder.rows_from(first)))
    history = history_of(system, recorder.rows)
    if reason is not None:
        raise SimulationStopped(recorder.time, reason, history)
    return history


def integrate_from(case: Case, state: NDArray, duration: float) -> History:
    """Integrate a case for some time from a state such as checkpoints keep.

    Parameters
    ----------
    state : array (1 + 3 coordinates or more,)
        Row as of `engine.System.state`; its multipliers are not needed.
    duration : float
        s, beyond the state's time.

    Raises
    ------
    SimulationStopped
        If a step fails at its least size.
    """
    system = build(case)
    start, end = float(state[0]), float(state[0]) + duration
    recorder = _Recorder(system, end, start)
    sunken = _watch(system, recorder)
    system.set_state(state)
    system.switch_drive(case.drive.drives_after(start))
    settings = solver_settings(case.solver)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
    set_times(settings, case.solver, start, end)
    reason = _solve(system, settings, sunken)
    history = history_of(system, recorder.rows)
    if reason is not None:
        raise SimulationStopped(recorder.time, reason, history)
    return history


def _watch(
    system: System, recorder: "_Recorder", tell: Callable[[float], None] = lambda _time: None
) -> list[int]:
    """Store the states after each step from now on, and end the run where spheres sink through the ground.

    Gives the list that the numbers of their shoes go into.
    """
    sunken: list[int] = []

    def after_step(_mbs: "exu.MainSystem", time: float) -> bool:
        recorder.store(time)
        tell(time)
        sunken[:] = system.sunken()
        return not sunken

    system.mbs.SetPostStepUserFunction(after_step)
    return sunken


def _solve(system: System, settings: "exu.SimulationSettings", sunken: list[int]) -> str | None:
    """Integrate one stage; gives why it stopped early, or None. `sunken` is what `_watch` gave."""
    reason = _solver_reason(system, settings)
    if sunken:
        return (
            f"spheres of shoes {sunken} sank through the ground; they need a greater "
            f"contact.radius than {system.case.sphere_contact().radius} m, or flatter ground"
        )
    return reason


def _solver_reason(system: System, settings: "exu.SimulationSettings") -> str | None:
    """Call the solver; gives why it failed, or None."""
    try:
        system.mbs.SolveDynamic(settings)
    except exu.SolverError:
        return f"Newton's method failed at the least step {system.case.solver.minimum_step:g} s"
    except KeyboardInterrupt:
        return "interrupted"
    except exu.ModelError as error:
        # where an interrupt meets a user function, Exudyn hands it on as an error of that function
        if "KeyboardInterrupt" not in str(error):
            raise
        return "interrupted"
    return None


class _Recorder:
    """Keeps the state at the start, unless it is another run's end, and after every output interval."""

    def __init__(self, system: System, duration: float, start: float | None = None) -> None:
        self._system = system
        self._interval = system.case.solver.output_interval
        self._duration = duration
        self._next = 0.0
        self._states: list[NDArray] = []
        self.time = 0.0
        if start is not None:
            self._end_of(start)

    def take(self, checkpoint: Checkpoint) -> None:
        """Go on behind a checkpoint."""
        self._states.extend(checkpoint.rows)
        self._end_of(checkpoint.time)

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

    @property
    def rows(self) -> NDArray:
        """All stored states, one a row."""
        return np.array(self._states)

    def rows_from(self, first: int) -> NDArray:
        """Stored states from a number on."""
        return np.array(self._states[first:])

    @property
    def count(self) -> int:
        """Number of stored states."""
        return len(self._states)


def set_times(
    settings: "exu.SimulationSettings", solver: Solver, start: float, end: float, quiet: bool = False
) -> None:
    """Put the times of a stage into Exudyn's settings; a quiet one takes longer steps."""
    time = settings.timeIntegration
    step = max(solver.step, solver.quiet_step) if quiet else solver.step
    time.startTime = start
    time.endTime = end
    time.numberOfSteps = max(1, math.ceil((end - start) / step - 1e-6))
    time.minimumStepSize = min(solver.minimum_step, end - start)


def solver_settings(solver: Solver) -> "exu.SimulationSettings":
    """Exudyn's settings for a run; `set_times` gives it its times."""
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.active = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    # every factorization has the same pattern
    settings.linearSolver.reuseAnalyzedPattern = True
    time = settings.timeIntegration
    # a stage starts from the accelerations that the one before ended with
    time.generalizedAlpha.resetAccelerations = False
    time.adaptiveStepRecoverySteps = 1
    time.adaptiveStepRecoveryIterations = solver.maximum_iterations
    time.verboseMode = 0
    time.generalizedAlpha.spectralRadius = solver.spectral_radius
    newton = time.newton
    # one Jacobian a step, another where the iteration slows down
    newton.useModifiedNewton = True
    newton.modifiedNewtonJacUpdatePerStep = True
    newton.absoluteTolerance = solver.residual
    # the absolute tolerance alone decides: the first residual of a step is no measure
    newton.relativeTolerance = 1e-16
    newton.weightTolerancePerCoordinate = True
    newton.maxIterations = solver.maximum_iterations
    return settings
