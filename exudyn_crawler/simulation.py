"""Time integration of a case from its static equilibrium."""

import math
from collections.abc import Callable

import exudyn as exu
import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.engine import System, build
from exudyn_crawler.equilibrium import static_equilibrium
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.history import History
from exudyn_crawler.parameters import Case, Solver
from exudyn_crawler.progress import progress_bar
from exudyn_crawler.states import history_of


class CrawlerModel:
    """A track on its terrain, ready to run.

    Parameters
    ----------
    case : Case
        All that the model depends on.
    """

    def __init__(self, case: Case) -> None:
        self.case = case

    def equilibrium(self) -> NDArray:
        """Coordinates at rest before t = 0; see `equilibrium.static_equilibrium`."""
        return static_equilibrium(self.case)

    def simulate(self, duration: float, progress: bool | None = None) -> History:
        """Run from static equilibrium.

        Parameters
        ----------
        duration : float
            s, simulated time.
        progress : bool, optional
            Show a progress bar; None shows it on a terminal only.

        Raises
        ------
        ValueError
            Before anything runs, if `duration` is not positive and finite or the drive takes the track
            off the terrain within it.
        EquilibriumError
            If the track finds no rest before t = 0.
        SimulationStopped
            If a step fails at its least size, if spheres of the second contact model sink through the ground,
            or on an interrupt; it carries the history up to there.
        """
        if not (math.isfinite(duration) and duration > 0.0):
            raise ValueError(f"duration must be positive and finite, got {duration!r} s")
        self.case.check_support(duration)
        system = build(self.case)
        system.set_initial(self.equilibrium())
        return integrate(system, duration, progress)


def integrate(
    system: System,
    duration: float,
    progress: bool | None = None,
    settings: "exu.SimulationSettings | None" = None,
) -> History:
    """Integrate a built system from its initial state; see `CrawlerModel.simulate`.

    `settings` take the place of those that `solver_settings` makes of the case.
    """
    if settings is None:
        settings = solver_settings(system.case.solver, duration)
    recorder = _Recorder(system, system.case.solver.output_interval, duration)
    reason = None
    sunken: list[int] = []
    with progress_bar(system.case.name, duration, progress) as tell:

        def after_step(_mbs: "exu.MainSystem", time: float) -> bool:
            recorder.store(time)
            tell(time)
            sunken[:] = system.sunken()
            return not sunken

        system.mbs.SetPostStepUserFunction(after_step)
        off_time = system.case.drive.off_time
        if off_time is not None and off_time < duration:
            system.mbs.SetPreStepUserFunction(_release_at(system, off_time))
        try:
            system.mbs.SolveDynamic(settings)
        except exu.SolverError:
            reason = f"Newton's method failed at the least step {system.case.solver.minimum_step:g} s"
        except KeyboardInterrupt:
            reason = "interrupted"
        except exu.ModelError as error:
            # where an interrupt meets a user function, Exudyn hands it on as an error of that function
            if "KeyboardInterrupt" not in str(error):
                raise
            reason = "interrupted"
    if sunken:
        reason = (
            f"spheres of shoes {sunken} sank through the ground; they need a greater "
            f"general_contact.radius than {system.case.general_contact.radius} m, or flatter ground"
        )
    history = history_of(system, recorder.rows)
    if reason is not None:
        raise SimulationStopped(recorder.time, reason, history)
    return history


def _release_at(system: System, off_time: float) -> Callable[["exu.MainSystem", float], bool]:
    """Exudyn's user function that leaves the front shoe free in the steps that end after a time."""
    released = False

    def before_step(_mbs: "exu.MainSystem", step_end: float) -> bool:
        nonlocal released
        if not released and step_end > off_time * (1.0 + 1e-9):
            system.release_drive()
            released = True
        return True

    return before_step


class _Recorder:
    """Keeps the state at the start and after every output interval."""

    def __init__(self, system: System, interval: float, duration: float) -> None:
        self._system = system
        self._interval = interval
        self._duration = duration
        self._next = 0.0
        self._states: list[NDArray] = []
        self.time = 0.0

    def store(self, time: float) -> None:
        """Store the state if its turn has come; the last one always."""
        self.time = time
        tolerance = 1e-9 * max(1.0, self._duration)
        if time >= self._next - tolerance or time >= self._duration - tolerance:
            self._states.append(self._system.state())
            self._next = (math.floor(time / self._interval + 1e-6) + 1) * self._interval

    @property
    def rows(self) -> NDArray:
        """All stored states, one a row."""
        return np.array(self._states)


def solver_settings(solver: Solver, duration: float) -> "exu.SimulationSettings":
    """Exudyn's settings for a run."""
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.active = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    # every factorization has the same pattern
    settings.linearSolver.reuseAnalyzedPattern = True
    time = settings.timeIntegration
    time.endTime = duration
    time.numberOfSteps = max(1, math.ceil(duration / solver.step - 1e-9))
    time.minimumStepSize = min(solver.minimum_step, duration)
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
