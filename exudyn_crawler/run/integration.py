"""Time integration of a built system, stage by stage."""

from collections.abc import Callable
from itertools import pairwise

from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.errors import INTERRUPTED, SimulationStopped
from exudyn_crawler.model.engine import exu
from exudyn_crawler.model.failure import NewtonError
from exudyn_crawler.model.formulation import TrackSystem, track_system
from exudyn_crawler.results.history import History
from exudyn_crawler.run.checkpoints import Checkpoints
from exudyn_crawler.run.faults import at_fault
from exudyn_crawler.run.progress import progress_bar
from exudyn_crawler.run.recorder import Recorder
from exudyn_crawler.run.run_stages import RunStages, system_history
from exudyn_crawler.run.settings import set_times, solver_settings
from exudyn_crawler.run.stages import is_quiet, stage_times


def integrate(
    system: TrackSystem,
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
    recorder = Recorder(system, duration)
    ends = stage_times(case, duration)
    stages = RunStages(system, recorder, ends, checkpoints)
    reason = None
    with progress_bar(case.name, duration, progress) as tell:
        sunken = _watch(system, recorder, tell)
        for number, (start, end) in enumerate(pairwise(ends)):
            if number < stages.first:
                continue
            system.switch_drive(case.drive.drives_after(start))
            set_times(settings, case.solver, start, end, is_quiet(case, start))
            settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = number == 0
            reason = _solve(system, settings, sunken)
            if reason is not None:
                break
            stages.end(number)
    if reason is not None:
        raise SimulationStopped(recorder.time, reason, None if stages.nothing else stages.history())
    return stages.history()


def integrate_from(case: Case, state: NDArray, duration: float) -> History:
    """Integrate a case for some time from a state such as checkpoints keep.

    Parameters
    ----------
    state : array (layout.size,)
        Row as of `System.state`; its multipliers do not matter.
    duration : float
        s, beyond the state's time.

    Raises
    ------
    SimulationStopped
        If a step fails at its least size.
    """
    system = track_system(case)
    start, end = float(state[0]), float(state[0]) + duration
    recorder = Recorder(system, end, start)
    sunken = _watch(system, recorder)
    system.set_state(state)
    system.switch_drive(case.drive.drives_after(start))
    settings = solver_settings(case.solver)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
    set_times(settings, case.solver, start, end)
    reason = _solve(system, settings, sunken)
    history = system_history(system, recorder.taken())
    if reason is not None:
        raise SimulationStopped(recorder.time, reason, history)
    return history


def _watch(
    system: TrackSystem, recorder: "Recorder", tell: Callable[[float], None] = lambda _time: None
) -> list[int]:
    """Store the states after each step from now on, and end the run where spheres sink through the ground.

    Gives the list that the numbers of their shoes go into.
    """
    sunken: list[int] = []

    def after_step(time: float) -> bool:
        recorder.store(time)
        tell(time)
        sunken[:] = system.sunken()
        return not sunken

    system.after_step(after_step)
    return sunken


def _solve(system: TrackSystem, settings: "exu.SimulationSettings", sunken: list[int]) -> str | None:
    """Integrate one stage; gives why it stopped early, or None. `sunken` is what `_watch` gave."""
    reason = _solver_reason(system, settings)
    if sunken:
        return (
            f"spheres of shoes {sunken} sank through the ground; they need a greater "
            f"contact.radius than {system.case.sphere_contact().radius} m, or flatter ground"
        )
    return reason


def _solver_reason(system: TrackSystem, settings: "exu.SimulationSettings") -> str | None:
    """Call the solver; gives why it failed, or None."""
    try:
        system.solve(settings)
    except NewtonError as failed:
        least, fault = system.case.solver.minimum_step, at_fault(system.layout, failed)
        return f"Newton's method failed at the least step {least:g} s; {fault}"
    except KeyboardInterrupt:
        return INTERRUPTED
    except exu.ModelError as error:
        # where an interrupt meets a user function, Exudyn hands it on as an error of that function
        if "KeyboardInterrupt" not in str(error):
            raise
        return INTERRUPTED
    return None
