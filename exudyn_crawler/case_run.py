"""Run of a case into its folder: simulation of the missing part, stress recovery, and writers of outputs."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import NamedTuple

from exudyn_crawler import errors, files
from exudyn_crawler.case import CellTerrain
from exudyn_crawler.case.parameters.checks import warn_of
from exudyn_crawler.case.parameters.terrain import CellContact
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.machines import CaseFile, check_case_file
from exudyn_crawler.machines.datasheet.discrepancies import machine_discrepancies
from exudyn_crawler.model import flexible_shoes, reductions as cache
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.stress import basis, recovery
from exudyn_crawler.run.folder import checkpoints, folder as folders, progress as parts, record
from exudyn_crawler.run.solve.simulation import compiled, simulate, solved_for_tension
from exudyn_crawler.views.outputs import write_origins, write_outputs
from fem.memory import give_back_memory


@dataclass(frozen=True)
class CaseRun:
    """Finished run of a case."""

    history: History
    stresses: recovery.StressResults | None  # of flexible shoes, if any
    folder: Path | None  # folder of the run, if it is stored

    def _repr_html_(self) -> str:
        """Return folder, hot spots if there are any, and history, for notebooks."""
        where = "kept nowhere" if self.folder is None else f"kept in {escape(str(self.folder))}"
        spots = {} if self.stresses is None else self.stresses.hot_spots
        tables = [f"<p>Shoe {shoe}</p>" + table.to_html(index=False) for shoe, table in spots.items()]
        return "".join([f"<p>Run {where}</p>", *tables, self.history._repr_html_()])

    def recovered(self) -> recovery.StressResults:
        """Return the stresses of a run with flexible shoes.

        Raises ValueError if the run has none.
        """
        if self.stresses is None:
            raise ValueError(f"case {self.history.case.name!r} must have flexible shoes to have stresses")
        return self.stresses


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
    """Simulate a case and write its folder: case, record, log, history, and the requested outputs.

    A stopped run continues when the same case is run into the same folder, with the same results as without a
    stop. With a longer duration a finished run continues, too.

    `out` is the folder of the run; None writes nothing. `overwrite` first empties the folder of an earlier
    run; `take_finished` returns a finished run of the same case as it is. The history of an earlier run in
    the folder `reuse` replaces the simulation. `progress` shows a bar for each part; None shows one on a
    terminal and a line every 10 s elsewhere. `say` gets a line on each activity. Reductions of flexible shoes
    are stored in the folder `reductions`, else in `model.reductions.reductions_folder`.

    Raises before anything is written: TypeError, FileNotFoundError or ValueError if `case_file` is none, a
    path is empty, `reuse` holds no history or one of other parameters, mesh or ruts do not fit, or
    checkpoints come from other parameters. Before anything runs: FileExistsError if the folder has results
    and `overwrite` is false, or BlockingIOError if another run works there. Later: EquilibriumError if the
    track finds no rest before t = 0, or SimulationStopped if the run ends early; its history stays there.
    """
    check_case_file(case_file)
    # an empty path would mean the current folder
    if "" in (out, reuse):
        raise ValueError("out and reuse must name folders, or be none, got ''")
    # a wrong mesh, or ruts of another ground, are refused before anything is solved or written
    case = case_file.case
    if case.flexible is not None:
        flexible_shoes.check_shoe(case)
    if isinstance(case.terrain, CellTerrain):
        case.terrain.earlier(case.part(CellContact).law)
    warn_of(machine_discrepancies(case_file))
    case = solved_for_tension(case, progress)
    case_file = case_file.with_(case=case)
    outputs = case_file.outputs
    path = None if out is None else Path(out)
    reused = None if reuse is None else folders.matching_history(Path(reuse), case_file)
    with cache.reductions_in(reductions):
        if path is not None and take_finished and folders.held_of(path, case_file) is record.Holds.FINISHED:
            say(f"{case.name}: finished already, in {path}")
            work = _Work(record.RunFolder(report=say), case_file, progress)
            history = folders.matching_history(path, case_file)
            return CaseRun(history, _stresses(history, work), path)
        with folders.run_in(path, case_file, overwrite, say) as folder, parts.noted_in(path):
            times = parts.rule_of_thumb(case_file)
            if reused is not None or folder.holds is record.Holds.HISTORY:
                times = {part: time for part, time in times.items() if part not in parts.SIMULATION}
            folder.say(parts.times_line(times))
            work = _Work(folder, case_file, progress)
            if case.flexible is not None:
                _reduce_shoe(work)
            if reused is None:
                history = _history(work)
            else:
                folder.say(f"{case.name}: reusing the history in {reuse}, whose parameters are the same")
                history = reused
                if path is not None:
                    history.save(path / record.HISTORY, overwrite=True)
            stresses = _stresses(history, work)
            if path is not None:
                with work.part(parts.WRITE):
                    write_origins(case_file, path)
                    write_outputs(history, stresses, path, outputs)
    return CaseRun(history, stresses, path)


class _Work(NamedTuple):
    """Run at work: its folder, case and progress display."""

    folder: record.RunFolder
    case_file: CaseFile
    progress: bool | None

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Time a part of the run, and show its progress."""
        title = f"{self.case_file.case.name}: {name}"
        expected = parts.rule_of_thumb(self.case_file).get(name)
        with self.folder.timed(name), parts.heartbeat(title, expected, self.progress):
            yield
        give_back_memory()


def _reduce_shoe(work: _Work) -> None:
    """Reduce the flexible shoe and solve for its static fields with the same factors, if not cached."""
    case = work.case_file.case
    with flexible_shoes.factors_held(case):
        with work.part(parts.REDUCE):
            stored = flexible_shoes.whole_reduction(case)
        if stored.existed:
            work.folder.say(f"{case.name}: the reduced shoe is taken from {stored.path}")
        if case.part(FlexibleShoes).static_fields:
            with work.part(parts.FIELDS):
                # the simulation does not need them
                basis.store_static_fields(case)
    # frees the factors
    give_back_memory()


def _stresses(history: History, work: _Work) -> recovery.StressResults | None:
    """Return the stresses of the flexible shoes, if there are any."""
    if history.case.flexible is None:
        return None
    with work.part(parts.RECOVER):
        return recovery.recover_stresses(history, work.case_file.outputs.picture_times)


def _history(work: _Work) -> History:
    """Simulate a case, or its missing part in the folder of the run; raises as `run_case`."""
    folder = work.folder
    case_file = work.case_file
    case = case_file.case
    path = folder.path
    if path is None:
        return _simulated(work, None)
    points = checkpoints.Checkpoints(path, folder.say)
    history = None
    if folder.holds is record.Holds.HISTORY:
        folder.say(f"{case.name}: simulated already, continuing with tables, figures and page")
    else:
        try:
            history = _simulated(work, points)
        except errors.SimulationStopped as stop:
            if stop.history is not None:
                points.hand_over(path / record.STOPPED_HISTORY)
            raise
        points.hand_over(path / record.HISTORY)
        (path / record.STOPPED_HISTORY).unlink(missing_ok=True)
    # a history out of memory refers to checkpoints that were handed over: it is read again
    if history is None or not history.in_memory:
        history = folders.matching_history(path, case_file)
    points.settle(case)
    # these belong to the run, also if it was stopped after they were written
    for file in (path / record.HISTORY, path / record.END):
        files.note_written(file)
    return history


def _simulated(work: _Work, points: checkpoints.Checkpoints | None) -> History:
    """Simulate and return the history; time the simulation, and before it the compilation if needed."""
    case_file = work.case_file
    progress = work.progress
    with work.folder.timed(parts.COMPILE):
        compiled(case_file.case, progress)
    with work.folder.timed(parts.SIMULATE):
        return simulate(case_file.case, case_file.duration, progress, points, case_file.outputs.ground_times)
