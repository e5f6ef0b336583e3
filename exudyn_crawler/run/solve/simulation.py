"""Run of a case from its static equilibrium."""

from contextlib import nullcontext

from threadpoolctl import threadpool_limits

from exudyn_crawler.case import Case
from exudyn_crawler.case.case_file import check_run
from exudyn_crawler.case.parameters.checks import warn_implausible
from exudyn_crawler.model.flexible_shoes import whole_reduction
from exudyn_crawler.model.formulation import EQUATIONS, compile_equations, track_system
from exudyn_crawler.results.history.history import History
from exudyn_crawler.run.folder.checkpoints import Checkpoints
from exudyn_crawler.run.folder.progress import note
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.integration import integrate
from fem.compiling import notify_compiling

COMPILING = "compiling the equations of motion, once on a machine: half a minute or more (a stop waits)"


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
        Show a progress bar; None shows one on a terminal and a line every 10 s elsewhere.
    checkpoints : Checkpoints, optional
        Keeps every stage but the last; the run goes on behind those that are there.

    Raises
    ------
    TypeError
        If `case` is no case.
    ValueError
        Before anything runs, if `duration` is not positive and finite, the run would take more memory than
        there is, the drive takes the track off the terrain or the checkpoints come from other parameters.
    EquilibriumError
        If the track finds no rest before t = 0.
    SimulationStopped
        If a step fails at its least size, if spheres of the second contact model sink through the ground,
        or on an interrupt; it carries the history up to there.

    Warns
    -----
    ImplausibleWarning
        Before anything runs, of what no machine and no ground is known to have.
    """
    check_run(case, duration)
    warn_implausible(case, duration)
    if checkpoints is not None:
        checkpoints.load(case)
    told = nullcontext() if progress is False else notify_compiling(EQUATIONS, lambda: note(COMPILING))
    if case.flexible is not None:
        whole_reduction(case)  # large enough for several threads, as nothing behind it is
    # matrices of a step are so small that threads wait for each other, and round by how many they are
    with told, threadpool_limits(1, user_api="blas"):
        if case.is_compiled:
            compile_equations(case.is_rolled)
        system = track_system(case)
        system.set_initial(static_equilibrium(case))
        return integrate(system, duration, progress, checkpoints=checkpoints)
