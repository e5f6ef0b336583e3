"""Folder of a run: one process at a time, one case, and beside the results what they come from.

It belongs to its case: the same case goes on where it was stopped, and with a longer duration behind the end;
all else is refused, unless the folder may be emptied. A study's folder holds a folder a case and its record.
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
SAME_TIME = 1e-6  # s by which durations may differ and be the same


@contextmanager
def run_in(
    out: Path | None,
    case_file: CaseFile | None = None,
    overwrite: bool = False,
    report: Callable[[str], None] = quiet,
    cases: Mapping[str, CaseFile] | None = None,
) -> Iterator[RunFolder]:
    """Hold a folder while a run works in it, and record what the results come from.

    The folder `out` is made where it is missing; None writes nothing. Without a case file a study runs
    `cases` into folders of their names in this one. `overwrite` empties the folder of what an earlier run
    recorded there, unless that is this one, stopped while it replaced another one. `report` gets lines for
    the user.

    FileExistsError if the folder holds results or the case of another run, and `overwrite` is false;
    BlockingIOError if another run works in it; NotADirectoryError or PermissionError if none can;
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
    """Refuse a folder with results of something else than a run of one case, before work on one begins."""
    if out.is_dir() and not (out / CASE).is_file():
        _refuse_results(out)


def held_of(out: Path, case_file: CaseFile) -> Holds:
    """Part of a case that a run's folder holds; nothing, too, if it holds another one, or a longer run."""
    noted = record.earlier_record(out)
    stored = _its_case(out / CASE) if noted else None
    case_file = tensioned_file(case_file)
    if stored is None or stored.case != case_file.case or stored.duration > case_file.duration + SAME_TIME:
        return Holds.NOTHING
    end = _end(out / HISTORY)
    is_shorter = end is not None and end < case_file.duration - SAME_TIME
    if noted.get("status") == record.DONE:
        return Holds.NOTHING if end is None else Holds.STOPPED if is_shorter else Holds.FINISHED
    # a history that cannot be read is refused where it is read
    return Holds.STOPPED if is_shorter or not (out / HISTORY).is_file() else Holds.HISTORY


def _its_case(path: Path) -> CaseFile | None:
    """Case of a folder as it is run, which is solved for its tension at rest; None if there is none."""
    with suppress(errors.CaseFileError, FileNotFoundError):
        return tensioned_file(read_case(path))
    return None


def _held_of_study(out: Path, cases: Mapping[str, CaseFile]) -> Holds:
    """True if the folder of a study holds a part of cases in folders of their names, and no other ones."""
    noted = record.earlier_record(out)
    if noted.get("status") != record.DONE:
        return Holds.STOPPED if noted else Holds.NOTHING
    there = {name for name in cases if (out / name / CASE).exists()}
    states = {held_of(out / name, cases[name]) for name in there}
    is_whole = states == {Holds.FINISHED} and len(there) == len(cases)
    return Holds.NOTHING if is_whole or Holds.NOTHING in states else Holds.STOPPED


@interrupts_wait()
def _end(path: Path) -> float | None:
    """Time of the last state of a history, s; None if there is none that can be read."""
    # altered bytes make the readers raise all kinds of errors
    with suppress(Exception), h5py.File(path, "r") as file:
        return float(file["time"][-1])
    return None


def _refuse_links(out: Path) -> None:
    """Refuse links in place of what a run adds to and removes from: it would do so outside of its folder."""
    for path in (out / record.LOG, out / record.CHECKPOINTS):
        if path.is_symlink():
            raise FileExistsError(
                f"{path} must be no link, which a run would follow to {path.readlink()}: remove it, or "
                "choose another folder"
            )


def _refuse_results(out: Path, below: bool = False) -> None:
    """Refuse a folder that holds results already, also one folder `below`."""
    paths = [*out.iterdir(), *(out.glob("*/*") if below else ())]
    results = [path for path in paths if path.suffix in RESULT_SUFFIXES and not path.name.startswith(".")]
    if names := ", ".join(sorted(path.relative_to(out).as_posix() for path in results)[:3]):
        raise FileExistsError(
            f"{out} holds results already ({names}, ...): choose another folder or {errors.ASK_TO_OVERWRITE}"
        )


def _write_case(path: Path, case_file: CaseFile, replace: bool) -> None:
    """Write the resolved case file; one that says the same stays as its author wrote it."""
    stored = _its_case(path)
    if path.exists() and stored != case_file and not replace:
        other = "" if stored is None else f" ({differences(stored, case_file)[0]})"
        raise FileExistsError(
            f"{path} is the case of another run{other}: choose another folder or {errors.ASK_TO_OVERWRITE}"
        )
    if stored != case_file:
        write_case(case_file, path, overwrite=True)


def _empty(out: Path) -> None:
    """Remove what an earlier run recorded in a folder, and what it was to go on with; the case file stays."""
    parts = {path.relative_to(out).as_posix() for path in out.glob(f"{record.CHECKPOINTS}/*.n[pc]*")}
    _remove(out, record.recorded_files(out) | parts | {HISTORY, record.STOPPED_HISTORY, record.END})


def _stays(out: Path, name: str) -> bool:
    """True for a file that is kept where a run goes on: also those of runs in folders of their own."""
    first = Path(name).parts[0]
    return first in record.OF_THE_SIMULATION or (out / first / record.RECORD).is_file()


def _remove(out: Path, names: set[str]) -> None:
    """Remove files of a folder, but for its case, and the folders below that they leave empty."""
    paths = [out / name for name in names - {CASE}]
    for path in paths:
        path.unlink(missing_ok=True)
    for folder in {path.parent for path in paths} - {out}:
        if folder.is_dir() and {path.name for path in folder.iterdir()} <= {record.LOCK}:
            (folder / record.LOCK).unlink(missing_ok=True)
            folder.rmdir()


SPREAD_FOLDER, SPREAD = "spread", "spread.nc"  # where a run's folder has the spread of its stresses


def matching_history(folder: Path, case_file: CaseFile) -> History:
    """History of the same case and duration in the folder of an earlier run, or of a study that ran it.

    FileNotFoundError if the folder holds none; ValueError, naming what differs, if it comes from other
    parameters or is shorter or longer.
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
        raise ValueError(f"{path} comes from other parameters: {'; '.join(changes[:5])}")
    return history
