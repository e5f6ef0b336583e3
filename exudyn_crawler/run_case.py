"""Run of one case file, from the case to its folder."""

from collections.abc import Callable
from pathlib import Path

from exudyn_crawler.case.files import CaseFile
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.model.flexible_shoes import shoe_model
from exudyn_crawler.results.extremes import extremes
from exudyn_crawler.results.history import History
from exudyn_crawler.results.stresses import PICTURE_TIMES, recover_stresses
from exudyn_crawler.run.folder import kept_run
from exudyn_crawler.run.simulation import simulate
from exudyn_crawler.runs import (
    HISTORY,
    STOPPED_HISTORY,
    keep_history,
    kept_checkpoints,
    matching_history,
)
from exudyn_crawler.views.animation import write_animation
from exudyn_crawler.views.tables import write_table
from studies.forces import write_force_figures, write_forces
from studies.kinematics import write_kinematic_figures
from studies.stress import write_stresses

ANIMATION = "track.mp4"
"""Animation in the folder of a run that asks for one."""


def run_case(
    case_file: CaseFile,
    out: Path,
    overwrite: bool = False,
    reuse: Path | None = None,
    progress: bool | None = None,
    say: Callable[[str], None] = lambda _text: None,
) -> History:
    """Simulate a case and leave its folder: case, record, log, history, and what its outputs ask for.

    A run that was killed goes on from its last checkpoint when the same case is run into the same folder.

    Parameters
    ----------
    out : Path
        Folder of the run.
    overwrite : bool
        Replace an earlier run.
    reuse : Path, optional
        Folder whose history takes the place of the simulation.
    say : callable
        Is told, in a line, what is going on.

    Raises
    ------
    FileNotFoundError, ValueError
        Before anything is written, if `reuse` holds no history or one of other parameters, or if
        the flexible shoes' mesh does not fit the track.
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError
        If the track finds no rest before t = 0.
    SimulationStopped
        If the run ends early; its history is saved.
    """
    case, duration = case_file.case, case_file.duration
    reused = None if reuse is None else matching_history(reuse, case, duration)
    if case.flexible is not None:
        shoe_model(case.flexible, case.track)  # refuses a mesh that does not fit while nothing is written yet
    with kept_run(out, {"case": case_file}, overwrite, say) as keeper:
        checkpoints = kept_checkpoints(out, case, overwrite, keeper)
        if reused is not None:
            keeper.say(f"reusing the history in {reuse}, whose parameters are the same")
            history = reused
        else:
            with keeper.timed("simulate"):
                try:
                    history = simulate(case, duration, progress, checkpoints)
                except SimulationStopped as stop:
                    keep_history(stop.history, out / STOPPED_HISTORY, overwrite=True)
                    raise
        keep_history(history, out / HISTORY, overwrite)
        with keeper.timed("tables and figures"):
            _write(history, case_file, out, overwrite)
        checkpoints.remove()
    return history


def _write(history: History, case_file: CaseFile, out: Path, overwrite: bool) -> None:
    """Write what derives from the history."""
    outputs = case_file.outputs
    if case_file.case.flexible is not None:
        times = PICTURE_TIMES if outputs.picture_times is None else outputs.picture_times
        write_stresses(history, recover_stresses(history, times), out, overwrite, outputs)
    if outputs.forces:
        write_forces(history, out / "forces.nc", overwrite)
    if outputs.tables:
        write_table(extremes(history), out / "extremes.csv", overwrite)
        write_table(case_file.case.loads.table(), out / "loads.csv", overwrite)
    if outputs.figures:
        shoes = outputs.drawn_shoes(case_file.case.track.shoe_count)
        joints = sorted({min(shoe, case_file.case.track.shoe_count - 1) for shoe in shoes})
        write_kinematic_figures(history, out, "", overwrite, shoes, outputs.figure_format)
        write_force_figures(history, out, "", overwrite, shoes, joints, outputs.figure_format)
    if outputs.animation:
        write_animation(history, out / ANIMATION, overwrite)
