"""One case into one folder: simulate what is missing, recover stresses, then a list of writers."""

from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from pathlib import Path

from exudyn_crawler.case import Case, CaseFile, CellTerrain
from exudyn_crawler.case.case_file import check_case_file
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.files import move_file, note_written
from exudyn_crawler.model.flexible_shoes import check_shoe, whole_reduction
from exudyn_crawler.model.reductions import reductions_in
from exudyn_crawler.results.history.history import MOST_IN_MEMORY, History
from exudyn_crawler.results.stress.recovery import StressResults, recover_stresses
from exudyn_crawler.run.folder import record
from exudyn_crawler.run.folder.checkpoints import Checkpoints
from exudyn_crawler.run.folder.folder import held_of, matching_history, run_in
from exudyn_crawler.run.folder.progress import heartbeat
from exudyn_crawler.run.solve.simulation import simulate
from exudyn_crawler.views.outputs import write_outputs


@dataclass(frozen=True)
class CaseRun:
    """A case that was run."""

    history: History
    stresses: StressResults | None  # of the flexible shoes, if there are any
    folder: Path | None  # where all of it is kept, if it is

    def _repr_html_(self) -> str:
        """Folder, hot spots if there are any, and history, for notebooks."""
        where = "kept nowhere" if self.folder is None else f"kept in {escape(str(self.folder))}"
        spots = {} if self.stresses is None else self.stresses.hot_spots
        tables = [f"<p>Shoe {shoe}</p>" + table.to_html(index=False) for shoe, table in spots.items()]
        return "".join([f"<p>Run {where}</p>", *tables, self.history._repr_html_()])

    def recovered(self) -> StressResults:
        """Stresses of a run with flexible shoes; ValueError if it has none."""
        if self.stresses is None:
            raise ValueError(f"case {self.history.case.name!r} must have flexible shoes to have stresses")
        return self.stresses


def _folder(path: str | Path | None) -> Path | None:
    """Folder of a path; an empty one, which would be where the program runs, is refused."""
    if path == "":
        raise ValueError("out and reuse must name folders, or be None, got ''")
    return None if path is None else Path(path)


def _check_files(case: Case) -> None:
    """Refuse a mesh that does not fit, or ruts of another ground, while nothing is written yet."""
    if case.flexible is not None:
        check_shoe(case)
    if isinstance(case.terrain, CellTerrain):
        case.terrain.earlier(case.cell_contact().law)


def run_case(
    case_file: CaseFile,
    out: str | Path | None = None,
    *,
    overwrite: bool = False,
    take_finished: bool = False,
    reuse: str | Path | None = None,
    progress: bool | None = None,
    say: Callable[[str], None] = record.quiet,
    reductions: str | Path | None = None,
) -> CaseRun:
    """Simulate a case and leave its folder: case, record, log, history, and what its outputs ask for.

    A run that was stopped goes on when the same case is run into the same folder, and gives what it would
    have given; with a longer duration a finished run goes on, too.

    Parameters
    ----------
    case_file : CaseFile
        Case, duration and outputs.
    out : path, optional
        Folder of the run; None writes nothing.
    overwrite : bool
        Empty the folder of an earlier run first.
    take_finished : bool
        Take a run of the same case that has finished in `out` as it is, in place of refusing the folder or
        emptying it.
    reuse : path, optional
        Folder of an earlier run whose history takes the place of the simulation.
    progress : bool, optional
        Show a progress bar; None shows one on a terminal and a line every 10 s elsewhere.
    say : callable
        Gets a line on each thing that goes on.
    reductions : path, optional
        Folder in which reductions of flexible shoes are stored; `model.reductions.reductions_folder` says
        which otherwise.

    Raises
    ------
    TypeError
        If `case_file` is none.
    FileNotFoundError, ValueError
        Before anything is written, if a path is empty, `reuse` holds no history or one of other parameters,
        or the mesh of flexible shoes or the ruts do not fit; or if checkpoints come from other parameters.
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError
        If the track finds no rest before t = 0.
    SimulationStopped
        If the run ends early; its history stays in the folder.
    """
    check_case_file(case_file)
    case, outputs = case_file.case, case_file.outputs
    path, source = _folder(out), _folder(reuse)
    reused = None if source is None else matching_history(source, case_file)
    _check_files(case)
    with reductions_in(reductions):
        if path is not None and take_finished and held_of(path, case_file) is record.Holds.FINISHED:
            say(f"{case.name}: finished already, in {path}")
            history = matching_history(path, case_file)
            return CaseRun(history, _stresses(history, case_file, record.RunFolder(report=say)), path)
        with run_in(path, case_file, overwrite, say) as folder:
            if case.flexible is not None:
                with folder.timed("reduce the flexible shoe"):
                    stored = whole_reduction(case)
                if stored.found:
                    folder.say(f"{case.name}: the reduced shoe is taken from {stored.path}")
            if reused is None:
                history = _history(case_file, progress, folder)
            else:
                folder.say(f"{case.name}: reusing the history in {reuse}, whose parameters are the same")
                history = reused
                if path is not None:
                    history.save(path / record.HISTORY, overwrite=True)
            stresses = _stresses(history, case_file, folder)
            if path is not None:
                with folder.timed("tables and figures"), heartbeat(f"{case.name}: tables and figures"):
                    write_outputs(history, stresses, path, outputs)
    return CaseRun(history, stresses, path)


def _stresses(history: History, case_file: CaseFile, folder: record.RunFolder) -> StressResults | None:
    """Stresses of the flexible shoes, if there are any."""
    case = history.case
    if case.flexible is None:
        return None
    with folder.timed("recover stresses"), heartbeat(f"{case.name}: recovering stresses"):
        return recover_stresses(history, case_file.outputs.picture_times)


def _history(case_file: CaseFile, progress: bool | None, folder: record.RunFolder) -> History:
    """Simulate a case, or what is missing of it in the folder that the run holds; raises as `simulate`.

    ValueError, naming it, if what is there was altered or comes from other parameters.
    """
    case, path = case_file.case, folder.path
    if path is None:
        with folder.timed("simulate"):
            return simulate(case, case_file.duration, progress)
    checkpoints = Checkpoints(path / record.CHECKPOINTS, folder.say)
    if folder.simulated:
        folder.say(f"{case.name}: simulated already, going on with what is made of it")
        history = matching_history(path, case_file)
    else:
        history = _simulated(folder, path, case_file, progress, checkpoints)
    checkpoints.settle(case, path / record.END)
    # these are the run's, also where it was stopped after them
    for one in (path / record.HISTORY, path / record.END):
        note_written(one)
    return history


def _simulated(
    folder: record.RunFolder, path: Path, case_file: CaseFile, progress: bool | None, checkpoints: Checkpoints
) -> History:
    """Simulate what is missing."""
    case, end, whole = case_file.case, path / record.END, path / record.HISTORY
    is_shorter = folder.holds is not record.Holds.NOTHING and end.is_file() and whole.is_file()
    if is_shorter and not checkpoints.load(case):
        checkpoints.begin_from(end, whole)
    with folder.timed("simulate"):
        try:
            history = simulate(case, case_file.duration, progress, checkpoints)
        except SimulationStopped as stop:
            if stop.history is not None:
                move_file(checkpoints.history, path / record.STOPPED_HISTORY, overwrite=True)
            raise
    move_file(checkpoints.history, whole, overwrite=True)
    folder.note_history()
    (path / record.STOPPED_HISTORY).unlink(missing_ok=True)
    # a large one is read from its file time and again
    return History.load(whole) if history.dataset.nbytes > MOST_IN_MEMORY else history
