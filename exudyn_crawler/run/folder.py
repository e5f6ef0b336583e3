"""Folder of a run: one process at a time, and beside the results what they come from.

A folder holds the resolved case file, `run.json` with versions, machine, timing and outcome, `run.log`, and
what the run writes: its history (NetCDF), tables (CSV) and figures. A study's folder holds a folder a case
and its own record of all of them.
"""

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from exudyn_crawler.case import CaseFile, read_case, write_case
from exudyn_crawler.errors import CaseFileError, SimulationStopped
from exudyn_crawler.files import writable_folder
from exudyn_crawler.run.record import (
    PROGRAM,
    RECORD,
    earlier_record,
    machine,
    timestamp,
    versions,
    write_record,
)

CASE = "case.toml"
LOG = "run.log"
LOCK = ".lock"
RESULT_SUFFIXES = {".nc", ".csv", ".png", ".pdf", ".svg", ".vtu", ".pvd", ".mp4", ".gif"}

logger = logging.getLogger("exudyn_crawler")


def quiet(_text: str) -> None:
    """Tell nobody."""


class Keeper:
    """What a run tells while it works: lines for the user and the log, and times of its stages.

    Attributes
    ----------
    stages : dict
        Wall time in s by stage, as far as they have ended.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self.stages: dict[str, float] = {}

    def say(self, text: str) -> None:
        """Tell the user and the log."""
        logger.info(text)
        self._tell(text)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Take the wall time of a stage."""
        logger.info("%s: begins", stage)
        start = time.perf_counter()
        try:
            yield
        finally:
            self.stages[stage] = round(time.perf_counter() - start, 3)
            logger.info("%s: %.1f s", stage, self.stages[stage])


@contextmanager
def kept_run(
    out: Path | None,
    case_file: CaseFile | None = None,
    overwrite: bool = False,
    tell: Callable[[str], None] = quiet,
) -> Iterator[Keeper]:
    """Hold a folder while a run writes into it, and keep what the results come from.

    Parameters
    ----------
    out : Path, optional
        Folder, made where it is missing; None keeps nothing.
    case_file : CaseFile, optional
        What is run; None for a study, whose cases are run into folders of their own in this one.
    overwrite : bool
        Replace what an earlier run left. Files of that run which this one does not write anew are removed
        when it has ended well, so that no result stands beside a case that it does not come from.
    tell : callable
        Gets the lines that the user is to read.

    Raises
    ------
    FileExistsError
        If the folder holds results or the case of another run, and `overwrite` is false.
    BlockingIOError
        If another run works in the folder.
    NotADirectoryError, PermissionError
        If it cannot be written to.
    """
    keeper = Keeper(tell)
    if out is None:
        yield keeper
        return
    with _held(writable_folder(out)):
        if not overwrite:
            refuse_results(out, below=case_file is None)
        found = earlier_record(out)
        if case_file is not None:
            _keep_case(out / CASE, case_file, overwrite)
        with _recorded(out, keeper, overwrite) as written:
            yield keeper
        if overwrite:
            _remove(out, set(found.get("files", [])) - set(written))


def refuse_results(out: Path, below: bool = False) -> None:
    """Refuse a folder that holds results already, also one folder `below`.

    Raises
    ------
    FileExistsError
        Naming what is there.
    """
    paths = [*out.iterdir(), *(out.glob("*/*") if below else ())]
    found = sorted(path.relative_to(out).as_posix() for path in paths if path.suffix in RESULT_SUFFIXES)
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
    with suppress(BlockingIOError), _held(out):
        found = earlier_record(out)
        write_record(out, found | {"files": sorted({*found.get("files", []), path.name})})


@contextmanager
def _held(out: Path) -> Iterator[None]:
    """Hold a folder's lock, which the operating system releases when the process ends, however it does."""
    lock = FileLock(out / LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout as error:
        record = earlier_record(out)
        raise BlockingIOError(
            f"{out} is in use by another run (process {record.get('process', 'unknown')}, begun "
            f"{record.get('started', 'just now')}): choose another folder or wait"
        ) from error
    try:
        yield
    finally:
        lock.release()


def _keep_case(path: Path, case_file: CaseFile, overwrite: bool) -> None:
    """Write the resolved case file; one that says the same stays as its author wrote it."""
    try:
        same = path.exists() and read_case(path) == case_file
    except CaseFileError:
        same = False
    if path.exists() and not same and not overwrite:
        raise FileExistsError(
            f"{path} is the case of another run: choose another folder or ask for overwriting (--overwrite)"
        )
    if not same:
        write_case(case_file, path, overwrite)


@contextmanager
def _recorded(out: Path, keeper: Keeper, overwrite: bool) -> Iterator[list[str]]:
    """Log and record what goes on in a folder; gives a list that gets the files that were written."""
    record: dict[str, Any] = {
        "status": "running",
        "command": sys.argv,
        "process": os.getpid(),
        "started": timestamp(),
        "machine": machine(),
        "versions": versions(),
    }
    before = _stamps(out)
    written: list[str] = []
    with _logged(out, overwrite):
        logger.info("%s %s, process %d", PROGRAM, record["versions"].get(PROGRAM, ""), os.getpid())
        write_record(out, record)
        try:
            yield written
        except BaseException as error:
            stopped = isinstance(error, SimulationStopped)
            outcome = {"status": "stopped" if stopped else "failed", "error": str(error) or repr(error)}
            logger.error("%s", outcome["status"], exc_info=error)
            # what went wrong matters more than a record that cannot be written either
            with suppress(OSError):
                _finish(out, record | outcome, keeper, before)
            raise
        written += _finish(out, record | {"status": "done"}, keeper, before)
        logger.info("done")


def _finish(
    out: Path, record: dict[str, Any], keeper: Keeper, before: dict[str, tuple[int, int]]
) -> list[str]:
    """Complete the record; the names of the files that the run wrote."""
    after = _stamps(out)
    written = sorted(name for name in after if name in (CASE, LOG, RECORD) or before.get(name) != after[name])
    took = datetime.now(UTC) - datetime.fromisoformat(record["started"])
    times = {"finished": timestamp(), "wall_time_s": round(took.total_seconds(), 3)}
    write_record(out, record | times | {"stages_s": keeper.stages, "files": written})
    return written


def _stamps(out: Path) -> dict[str, tuple[int, int]]:
    """Visible files of a folder; one that was replaced has another inode or time of writing."""
    stamps = {}
    for path in out.rglob("*"):
        if path.is_file() and not path.name.startswith("."):
            found = path.stat()
            stamps[path.relative_to(out).as_posix()] = (found.st_ino, found.st_mtime_ns)
    return stamps


def _remove(out: Path, names: set[str]) -> None:
    """Remove files of an earlier run and folders that they leave empty, and nothing outside the folder."""
    whole = out.resolve()
    paths = [path for name in names if (path := (out / name).resolve()).is_relative_to(whole)]
    for path in paths:
        path.unlink(missing_ok=True)
    for folder in {path.parent for path in paths} - {whole}:
        if folder.is_dir() and {path.name for path in folder.iterdir()} <= {LOCK}:
            (folder / LOCK).unlink(missing_ok=True)
            folder.rmdir()


class _LogFile(logging.FileHandler):
    """Log that does not stop a run where it cannot be written."""

    def handleError(self, _record: logging.LogRecord) -> None:  # noqa: N802
        pass

    def close(self) -> None:
        with suppress(OSError):
            super().close()


@contextmanager
def _logged(out: Path, overwrite: bool) -> Iterator[None]:
    """Send the package's log into the folder; an earlier log is continued unless it may be replaced."""
    handler = _LogFile(out / LOG, mode="w" if overwrite else "a", encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        handler.close()
