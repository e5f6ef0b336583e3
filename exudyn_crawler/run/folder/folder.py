"""Folder of a run: one process at a time, one case, and the record of the results' origin.

A folder belongs to its case. The same case continues where it was stopped, and with a longer duration after
its end. Any other case is refused unless the folder may be emptied. A study's folder holds a folder for each
case and the study's record.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py

from exudyn_crawler import errors, files
from exudyn_crawler.machines import CaseFile, differences, read_case, write_case
from exudyn_crawler.results.history.history import History
from exudyn_crawler.run.folder import record
from exudyn_crawler.run.folder.record import CASE, HISTORY, Holds, RunFolder, quiet
from exudyn_crawler.run.solve.tension import tensioned_file
from fem.interrupts import interrupts_wait

RESULT_SUFFIXES = {".nc", ".csv", ".png", ".pdf", ".svg", ".vtu", ".pvd", ".mp4", ".gif"}
SAME_TIME = 1e-6  # greatest difference of durations that count as the same, s


@contextmanager
def run_in(
    out: Path | None,
    case_file: CaseFile | None = None,
    overwrite: bool = False,
    report: Callable[[str], None] = quiet,
    cases: Mapping[str, CaseFile] | None = None,
) -> Iterator[RunFolder]:
    """Hold a folder while a run works in it, and record the origin of the results.

    The folder `out` is created if it is missing; None writes nothing. Without a case file a study runs
    `cases` in folders of their names within this one. `overwrite` empties the folder of an earlier run's
    recorded files, unless the earlier run is this one, stopped while it replaced another. `report` gets lines
    for the user.

    FileExistsError if the folder holds results or the case of another run, and `overwrite` is false.
    BlockingIOError if another run works in it; NotADirectoryError or PermissionError if no run can.
    FileNotFoundError at the end if the folder was removed meanwhile.
    """
    if out is None:
        yield RunFolder(report=report)
        return
    with record.held(files.writable_folder(out)):
        _refuse_links(out)
        holds = _held_of_study(out, cases or {}) if case_file is None else held_of(out, case_file)
        goes_on = holds in (Holds.STOPPED, Holds.HISTORY)
        replaced = goes_on and record.earlier_record(out).get("overwrites") is True
        if overwrite and not replaced:
            goes_on = False
        if goes_on:
            _remove(out, {name for name in record.recorded_files(out) if not _stays(out, name)})
        elif overwrite:
            for path in (out, *(out / name for name in cases or ())):
                _empty(path)
        else:
            _refuse_results(out, below=case_file is None)
        folder = RunFolder(out, report, holds if goes_on else Holds.NOTHING, overwrite or replaced)
        if case_file is not None:
            _write_case(out / CASE, case_file, replace=overwrite or goes_on)
        files.clear_partial_files(out, below=case_file is not None)
        with record.recorded(folder):
            yield folder
            if case_file is not None and not (out / CASE).is_file():
                raise FileNotFoundError(
                    f"{out} was removed or emptied while the run worked in it: its results are incomplete"
                )


def refuse_other_results(out: Path) -> None:
    """Raise FileExistsError before a run if the folder has results of anything but a run of one case."""
    if out.is_dir() and not (out / CASE).is_file():
        _refuse_results(out)


def held_of(out: Path, case_file: CaseFile) -> Holds:
    """Return which part of a case's run a folder holds; nothing if it has another case or a longer run."""
    noted = record.earlier_record(out)
    stored = _its_case(out / CASE) if noted else None
    case_file = tensioned_file(case_file)
    if stored is None or stored.case != case_file.case or stored.duration > case_file.duration + SAME_TIME:
        return Holds.NOTHING
    end = _end(out / HISTORY)
    is_shorter = end is not None and end < case_file.duration - SAME_TIME
    if noted.get("status") == record.DONE:
        return Holds.NOTHING if end is None else Holds.STOPPED if is_shorter else Holds.FINISHED
    # an unreadable history is refused on reading
    return Holds.STOPPED if is_shorter or not (out / HISTORY).is_file() else Holds.HISTORY


def _its_case(path: Path) -> CaseFile | None:
    """Return a folder's case with its take-up solved for the tension at rest; None without a case."""
    with suppress(errors.CaseFileError, FileNotFoundError):
        return tensioned_file(read_case(path))
    return None


def _held_of_study(out: Path, cases: Mapping[str, CaseFile]) -> Holds:
    """Return which part of a study's cases its folder holds, in folders of their names, without others."""
    noted = record.earlier_record(out)
    if noted.get("status") != record.DONE:
        return Holds.STOPPED if noted else Holds.NOTHING
    there = {name for name in cases if (out / name / CASE).exists()}
    states = {held_of(out / name, cases[name]) for name in there}
    is_whole = states == {Holds.FINISHED} and len(there) == len(cases)
    return Holds.NOTHING if is_whole or Holds.NOTHING in states else Holds.STOPPED


@interrupts_wait()
def _end(path: Path) -> float | None:
    """Return the time of the last state of a history, s; None without a readable one."""
    # altered bytes make the readers raise all kinds of errors
    with suppress(Exception), h5py.File(path, "r") as file:
        return float(file["time"][-1])
    return None


def _refuse_links(out: Path) -> None:
    """Raise FileExistsError for links in place of files that a run changes: their targets are elsewhere."""
    for path in (out / record.LOG, out / record.CHECKPOINTS):
        if path.is_symlink():
            raise FileExistsError(
                f"{path} must not be a link, which a run would follow to {path.readlink()}: remove it, or "
                "choose another folder"
            )


def _refuse_results(out: Path, below: bool = False) -> None:
    """Raise FileExistsError if a folder holds results already, or with `below` one of its folders."""
    paths = [*out.iterdir(), *(out.glob("*/*") if below else ())]
    results = [path for path in paths if path.suffix in RESULT_SUFFIXES and not path.name.startswith(".")]
    if names := ", ".join(sorted(path.relative_to(out).as_posix() for path in results)[:3]):
        raise FileExistsError(
            f"{out} holds results already ({names}, ...): choose another folder or {errors.ASK_TO_OVERWRITE}"
        )


def _write_case(path: Path, case_file: CaseFile, replace: bool) -> None:
    """Write the resolved case file; an equal one stays as its author wrote it."""
    stored = _its_case(path)
    if path.exists() and stored != case_file and not replace:
        other = "" if stored is None else f" ({differences(stored, case_file)[0]})"
        raise FileExistsError(
            f"{path} is the case of another run{other}: choose another folder or {errors.ASK_TO_OVERWRITE}"
        )
    if stored != case_file:
        write_case(case_file, path, overwrite=True)


def _empty(out: Path) -> None:
    """Remove the recorded files of an earlier run and its checkpoints from a folder; the case file stays."""
    parts = {path.relative_to(out).as_posix() for path in out.glob(f"{record.CHECKPOINTS}/*.n[pc]*")}
    _remove(out, record.recorded_files(out) | parts | {HISTORY, record.STOPPED_HISTORY, record.END})


def _stays(out: Path, name: str) -> bool:
    """Return True for a file that stays when a run continues, also in the folder of another run."""
    first = Path(name).parts[0]
    return first in record.OF_THE_SIMULATION or (out / first / record.RECORD).is_file()


def _remove(out: Path, names: set[str]) -> None:
    """Remove files of a folder, except its case, and the folders below that become empty."""
    paths = [out / name for name in names - {CASE}]
    for path in paths:
        path.unlink(missing_ok=True)
    for folder in {path.parent for path in paths} - {out}:
        if folder.is_dir() and {path.name for path in folder.iterdir()} <= {record.LOCK}:
            (folder / record.LOCK).unlink(missing_ok=True)
            folder.rmdir()


SPREAD_FOLDER, SPREAD = "spread", "spread.nc"  # folder and file of the spread of a run's stresses


def matching_history(folder: Path, case_file: CaseFile) -> History:
    """Return the history of the same case and duration from the folder of an earlier run or study.

    FileNotFoundError if the folder holds none; ValueError, with the differences, if it comes from other
    parameters or has another duration.
    """
    case = tensioned_file(case_file).case
    paths = (folder / HISTORY, folder / case.name / HISTORY)
    path = next(filter(Path.is_file, paths), None)
    if path is None:
        raise FileNotFoundError(f"no history at {paths[0]} or {paths[1]}")
    history = History.load(path)
    changes = [str(difference) for difference in differences(history.case, case)]
    if abs(history.duration - case_file.duration) > SAME_TIME:
        changes.append(f"duration is {history.duration:g} s, not {case_file.duration:g} s")
    if changes:
        raise ValueError(f"{path} comes from another case: {'; '.join(changes[:5])}")
    return history
