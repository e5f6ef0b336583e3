"""Folder of a run: one process at a time, and beside the results what they come from.

A folder holds the resolved case files, `run.json` with versions, machine, timing and outcome, `run.log`, and
what the run writes: histories (NetCDF), tables (CSV) and figures.
"""

import importlib.metadata
import json
import logging
import os
import platform
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from exudyn_crawler.case import CaseFile, read_case, write_case
from exudyn_crawler.errors import CaseFileError, SimulationStopped
from exudyn_crawler.files import whole_file, writable_folder

RECORD = "run.json"
LOG = "run.log"
LOCK = ".lock"
RESULT_SUFFIXES = {".nc", ".csv", ".png", ".pdf", ".svg"}
PROGRAM = "exudyn-crawler"
THREAD_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

logger = logging.getLogger("exudyn_crawler")


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
    cases: Mapping[str, CaseFile],
    overwrite: bool = False,
    tell: Callable[[str], None] = lambda _text: None,
) -> Iterator[Keeper]:
    """Hold a folder while a run writes into it, and keep what the results come from.

    Parameters
    ----------
    out : Path, optional
        Folder, made where it is missing; None keeps nothing.
    cases : mapping
        What is run, by the names that the case files get (without suffix).
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
        refuse_results(out, overwrite)
        found = earlier_record(out)
        _keep_cases(out, cases, overwrite)
        record = _start(cases)
        before = _stamps(out)
        with _logged(out, overwrite):
            logger.info("%s %s, process %d", PROGRAM, record["versions"].get(PROGRAM, ""), os.getpid())
            _write_record(out, record)
            try:
                yield keeper
            except BaseException as error:
                stopped = isinstance(error, SimulationStopped)
                outcome = {"status": "stopped" if stopped else "failed", "error": str(error) or repr(error)}
                logger.error("%s", outcome["status"], exc_info=error)
                # what went wrong matters more than a record that cannot be written either
                with suppress(OSError):
                    _finish(out, record | outcome, keeper, before)
                raise
            written = _finish(out, record | {"status": "done"}, keeper, before)
            if overwrite:
                _remove(out, [name for name in found.get("files", []) if name not in written])
            logger.info("done")


def note_file(path: Path) -> None:
    """Add a file made of a run's results to the record beside it, so that overwriting the run removes it.

    Nothing is noted where there is no record. A run at work in the folder notes what is new by itself.
    """
    out = path.parent
    if not (found := earlier_record(out)):
        return
    with suppress(BlockingIOError), _held(out):
        found = earlier_record(out)
        _write_record(out, found | {"files": sorted({*found.get("files", []), path.name})})


def refuse_results(out: Path, overwrite: bool) -> None:
    """Refuse a folder that holds results already.

    Raises
    ------
    FileExistsError
        Naming what is there, unless `overwrite`.
    """
    found = sorted(path.name for path in out.iterdir() if path.suffix in RESULT_SUFFIXES)
    if found and not overwrite:
        raise FileExistsError(
            f"{out} holds results already ({', '.join(found[:3])}, ...): "
            f"choose another folder or ask for overwriting"
        )


def earlier_record(folder: Path) -> dict[str, Any]:
    """What an earlier run recorded in a folder; nothing if there is no readable record."""
    try:
        found = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


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


def _keep_cases(out: Path, cases: Mapping[str, CaseFile], overwrite: bool) -> None:
    """Write the resolved case files; one that says the same stays as its author wrote it."""
    new = {}
    for name, case_file in cases.items():
        path = out / f"{name}.toml"
        try:
            same = path.exists() and read_case(path) == case_file
        except CaseFileError:
            same = False
        if path.exists() and not same and not overwrite:
            raise FileExistsError(
                f"{path} is the case of another run: choose another folder or ask for overwriting"
            )
        if not same:
            new[path] = case_file
    for path, case_file in new.items():
        write_case(case_file, path, overwrite)


def _start(cases: Mapping[str, CaseFile]) -> dict[str, Any]:
    return {
        "status": "running",
        "command": sys.argv,
        "cases": {name: f"{name}.toml" for name in cases},
        "process": os.getpid(),
        "started": _now(),
        "machine": machine(),
        "versions": versions(),
    }


def _finish(
    out: Path, record: dict[str, Any], keeper: Keeper, before: dict[str, tuple[int, int]]
) -> list[str]:
    """Complete the record; the names of the files that the run wrote."""
    after = _stamps(out)
    kept = {LOG, RECORD, *record["cases"].values()}
    written = sorted(name for name in after if name in kept or before.get(name) != after[name])
    took = datetime.now(UTC) - datetime.fromisoformat(record["started"])
    times = {"finished": _now(), "wall_time_s": round(took.total_seconds(), 3), "stages_s": keeper.stages}
    _write_record(out, record | times | {"files": written})
    return written


def _write_record(out: Path, record: dict[str, Any]) -> None:
    with whole_file(out / RECORD, overwrite=True) as temporary:
        temporary.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")


def _stamps(out: Path) -> dict[str, tuple[int, int]]:
    """Visible files of a folder; one that was replaced has another inode or time of writing."""
    stamps = {}
    for path in out.rglob("*"):
        if path.is_file() and not path.name.startswith("."):
            found = path.stat()
            stamps[path.relative_to(out).as_posix()] = (found.st_ino, found.st_mtime_ns)
    return stamps


def _remove(out: Path, names: list[str]) -> None:
    """Remove files of an earlier run, and nothing outside the folder."""
    for name in names:
        path = (out / name).resolve()
        if path.is_relative_to(out.resolve()):
            path.unlink(missing_ok=True)


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


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def machine() -> dict[str, Any]:
    """What the run works on."""
    return {
        "platform": platform.platform(),
        "processor": _processor(),
        "cpu_count": os.cpu_count(),
        "python": platform.python_version(),
        "threads": {name: os.environ[name] for name in THREAD_VARIABLES if name in os.environ},
    }


def _processor() -> str:
    """Name of the processor; Linux tells it in a file only."""
    with suppress(OSError):
        if found := re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8")):
            return found[1]
    return platform.processor() or platform.machine()


def versions() -> dict[str, str]:
    """Versions of the package and of everything that it needs, as far as they are installed."""
    try:
        needed = importlib.metadata.requires(PROGRAM) or []
    except importlib.metadata.PackageNotFoundError:
        needed = []
    names = [re.split(r"[\s<>=!~;\[(]", one, maxsplit=1)[0] for one in needed if "extra ==" not in one]
    found = {}
    for name in (PROGRAM, *sorted(names, key=str.lower)):
        with suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found
