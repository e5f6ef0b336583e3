"""Folder of a run: one process at a time, and beside the results what they come from.

A folder holds the resolved case file, `run.json` with versions, machine, timing and outcome, `run.log`, and
what the run writes: its history (NetCDF), tables (CSV) and figures. A study's folder holds a folder a case
and its own record of all of them.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from exudyn_crawler.case import CaseFile, read_case, write_case
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.files import clear_partial_files, writable_folder
from exudyn_crawler.run.folder.keeper import LOCK, Keeper, quiet, recorded
from exudyn_crawler.run.folder.record import earlier_record, named_files, timestamp, write_record
from exudyn_crawler.run.folder.standing import CASE, Standing, standing, study_standing

RESULT_SUFFIXES = {".nc", ".csv", ".png", ".pdf", ".svg", ".vtu", ".pvd", ".mp4", ".gif"}


@contextmanager
def kept_run(
    out: Path | None,
    case_file: CaseFile | None = None,
    overwrite: bool = False,
    tell: Callable[[str], None] = quiet,
    cases: Mapping[str, CaseFile] | None = None,
) -> Iterator[Keeper]:
    """Hold a folder while a run writes into it, and keep what the results come from.

    A run that was stopped goes on in its folder, and one with a longer duration goes on with a finished one.

    Parameters
    ----------
    out : Path, optional
        Folder, made where it is missing; None keeps nothing.
    case_file : CaseFile, optional
        What is run; None for a study.
    overwrite : bool
        Replace what an earlier run left, unless it is this one that was stopped while it did so. Files of
        that run which this one does not write anew are removed when it has ended well, so that no result
        stands beside a case that it does not come from.
    tell : callable
        Gets the lines that the user is to read.
    cases : mapping, optional
        What a study runs into folders of their names in this one.

    Raises
    ------
    FileExistsError
        If the folder holds results or the case of another run, and `overwrite` is false.
    BlockingIOError
        If another run works in the folder.
    NotADirectoryError, PermissionError
        If it cannot be written to.
    """
    if out is None:
        yield Keeper(tell)
        return
    with held(writable_folder(out)):
        found = earlier_record(out)
        keeper = _keeper(out, case_file, cases or {}, found, overwrite, tell)
        if case_file is not None:
            _keep_case(out / CASE, case_file, keeper.replaces)
        clear_partial_files(out, below=case_file is not None)
        with recorded(out, keeper, found):
            yield keeper


def refuse_occupied(out: Path, case_file: CaseFile, overwrite: bool = False) -> None:
    """Refuse a folder that `kept_run` would not take for a case, before anything else is loaded.

    Raises
    ------
    FileExistsError
        If the folder holds results of another run, and `overwrite` is false.
    """
    if out.is_dir():
        _keeper(out, case_file, {}, earlier_record(out), overwrite, quiet)


def _keeper(
    out: Path,
    case_file: CaseFile | None,
    cases: Mapping[str, CaseFile],
    found: dict[str, Any],
    overwrite: bool,
    tell: Callable[[str], None],
) -> Keeper:
    """What a run may do in a folder, by the record of an earlier one; refuses one that it may not replace."""
    holds = study_standing(out, cases) if case_file is None else standing(out, case_file)
    stopped_overwriting = found.get("overwrites") is True
    goes_on = holds in (Standing.UNFINISHED, Standing.LONGER_ASKED) and (not overwrite or stopped_overwriting)
    longer = holds is Standing.SHORTER and not overwrite
    simulated = goes_on and found.get("simulated") is True
    longer |= simulated and holds is Standing.LONGER_ASKED
    begun = found.get("begun")
    keeper = Keeper(
        tell,
        anew=not (goes_on or longer),
        overwrites=overwrite or (goes_on and stopped_overwriting),
        extends=longer or (goes_on and found.get("extends") is True),
        simulated=simulated and not longer,
        begun=begun if goes_on and isinstance(begun, str) else timestamp(),
    )
    if not keeper.replaces:
        refuse_results(out, below=case_file is None)
    return keeper


def refuse_results(out: Path, below: bool = False) -> None:
    """Refuse a folder that holds results already, also one folder `below`.

    Raises
    ------
    FileExistsError
        Naming what is there.
    """
    paths = [*out.iterdir(), *(out.glob("*/*") if below else ())]
    found = sorted(
        path.relative_to(out).as_posix()
        for path in paths
        if path.suffix in RESULT_SUFFIXES and not path.name.startswith(".")
    )
    if found:
        raise FileExistsError(
            f"{out} holds results already ({', '.join(found[:3])}, ...): "
            f"choose another folder or ask for overwriting (--overwrite)"
        )


def note_file(path: Path) -> None:
    """Add a file made of a run's results to the record beside it, so that overwriting the run removes it.

    Nothing is noted where there is no record. A run at work in the folder notes what is new by itself.
    """
    out = path.parent
    if not earlier_record(out):
        return
    with suppress(BlockingIOError), held(out):
        found = earlier_record(out)
        write_record(out, found | {"files": sorted({*named_files(found, "files"), path.name})})


@contextmanager
def held(out: Path, what: str = "run") -> Iterator[None]:
    """Hold a folder's lock, which the operating system releases when the process ends, however it does.

    Parameters
    ----------
    what : str
        What works there, for the error.

    Raises
    ------
    BlockingIOError
        If another process holds it.
    """
    lock = FileLock(out / LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout as error:
        record = earlier_record(out)
        raise BlockingIOError(
            f"{out} is in use by another {what} (process {record.get('process', 'unknown')}, begun "
            f"{record.get('started', 'just now')}): choose another folder or wait"
        ) from error
    try:
        yield
    finally:
        lock.release()


def _keep_case(path: Path, case_file: CaseFile, replace: bool) -> None:
    """Write the resolved case file; one that says the same stays as its author wrote it."""
    try:
        same = path.exists() and read_case(path) == case_file
    except CaseFileError:
        same = False
    if path.exists() and not same and not replace:
        raise FileExistsError(
            f"{path} is the case of another run: choose another folder or ask for overwriting (--overwrite)"
        )
    if not same:
        write_case(case_file, path, replace)
