"""Simulation of a case into its folder: what is there is taken, what is missing computed."""

from pathlib import Path

from exudyn_crawler.case import CaseFile
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.files import move_file, note_written
from exudyn_crawler.results.history.history import MOST_IN_MEMORY, History
from exudyn_crawler.run.folder.checkpoints import Checkpoints
from exudyn_crawler.run.folder.histories import HISTORY, STOPPED_HISTORY, matching_history
from exudyn_crawler.run.folder.keeper import Keeper
from exudyn_crawler.run.solve.simulation import simulate

CHECKPOINTS = "checkpoints"
END = "checkpoint.npz"
"""What a longer run goes on with, where a finished one had more than one stage."""


def simulate_into(folder: Path, case_file: CaseFile, progress: bool | None, keeper: Keeper) -> History:
    """Simulate a case into the folder that `keeper` holds, from its last checkpoint if there is one.

    Raises
    ------
    ValueError
        If what is there was altered or comes from other parameters, naming it.
    EquilibriumError, SimulationStopped
        As of `simulate`; what a run that stops early has is kept.
    """
    case = case_file.case
    checkpoints = Checkpoints(folder / CHECKPOINTS, keeper.say)
    if keeper.simulated:
        keeper.say(f"{case.name}: simulated already, going on with what is made of it")
        history = matching_history(folder, case_file)
    else:
        history = _simulated(case_file, folder, progress, keeper, checkpoints)
    checkpoints.settle(case, folder / END)
    # these are the run's, also where it was stopped after them
    for path in (folder / HISTORY, folder / END):
        note_written(path)
    return history


def _simulated(
    case_file: CaseFile, folder: Path, progress: bool | None, keeper: Keeper, checkpoints: Checkpoints
) -> History:
    """Simulate what is missing."""
    case, end = case_file.case, folder / END
    if keeper.anew and keeper.replaces:
        checkpoints.remove()
    elif keeper.extends and end.is_file() and not checkpoints.load(case):
        checkpoints.begin_from(end, folder / HISTORY)
    with keeper.timed("simulate"):
        try:
            history = simulate(case, case_file.duration, progress, checkpoints)
        except SimulationStopped as stop:
            if stop.history is not None:
                move_file(checkpoints.history, folder / STOPPED_HISTORY, overwrite=True)
            raise
    move_file(checkpoints.history, folder / HISTORY, keeper.replaces)
    keeper.note_history()
    (folder / STOPPED_HISTORY).unlink(missing_ok=True)
    # a large one is read from its file time and again
    return History.load(folder / HISTORY) if history.dataset.nbytes > MOST_IN_MEMORY else history
