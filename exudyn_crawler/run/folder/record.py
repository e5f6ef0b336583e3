"""Report and record of a run (`run.json`, `run.log`) while it works in a folder and holds it."""

import importlib.metadata
import json
import logging
import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from enum import Enum
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from exudyn_crawler import errors, files

CASE = "case.toml"
RECORD = "run.json"
LOG = "run.log"
LOCK = ".lock"
HISTORY, STOPPED_HISTORY = files.HISTORY, "history_stopped.nc"
"""Files of the history of a finished run, and of a run that stopped early."""
CHECKPOINTS, END = "checkpoints", "checkpoint.npz"
"""Folder of the stages, and checkpoint for a longer run; a finished run of several stages leaves it."""
OF_THE_SIMULATION = {CASE, RECORD, LOG, HISTORY, STOPPED_HISTORY, CHECKPOINTS, END}
"""Files from which a run continues; all others are made of the history again."""
DONE = "done"  # status of a successful run
PROGRAM = "exudyn-crawler"

logger = logging.getLogger("exudyn_crawler")


def earlier_record(folder: Path) -> dict[str, Any]:
    """Return the record of an earlier run in a folder; empty without a readable one."""
    with suppress(OSError, ValueError, RecursionError):
        content = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        return content if isinstance(content, dict) else {}
    return {}


def recorded_files(folder: Path) -> set[str]:
    """Return the names of the files that a folder's record lists, without files outside of the folder."""
    whole = folder.resolve()
    listed = earlier_record(folder).get("files")
    names = [entry for entry in listed if isinstance(entry, str)] if isinstance(listed, list) else []
    return {
        name
        for name in names
        if (folder / name).is_file() and (folder / name).resolve().is_relative_to(whole)
    }


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a record as JSON."""
    with files.whole_file(path, overwrite=True) as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def timestamp() -> str:
    """Return the present time in the form of a record."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def commit() -> str:
    """Return the program's commit by git; empty for an installed program."""
    root = Path(__file__).parents[3]
    if (root / ".git").exists():
        command = ["git", "describe", "--always", "--abbrev=12", "--exclude=*", "--dirty=, changed"]
        with suppress(OSError, subprocess.SubprocessError):
            done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True, timeout=10)
            return done.stdout.strip()
    return ""


def versions() -> dict[str, str]:
    """Return the versions of the package and of its installed requirements."""
    needed: list[str] = []
    with suppress(importlib.metadata.PackageNotFoundError):
        needed = importlib.metadata.requires(PROGRAM) or []
    names = [
        re.split(r"[\s<>=!~;\[(]", requirement, maxsplit=1)[0]
        for requirement in needed
        if "extra ==" not in requirement
    ]
    installed = {}
    for name in (PROGRAM, *sorted(names, key=str.lower)):
        with suppress(importlib.metadata.PackageNotFoundError):
            installed[name] = importlib.metadata.version(name)
    return installed


def program_line() -> str:
    """Return the program's version, its commit if it is known, and the present time, for a report."""
    made = f"made {datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    known = commit()
    version = importlib.metadata.version(PROGRAM)
    return "; ".join((f"{PROGRAM} {version}", *([f"commit {known}"] if known else []), made))


@contextmanager
def logged(out: Path) -> Iterator[None]:
    """Append the package's log to the log file of a folder."""
    handler = logging.FileHandler(out / LOG, mode="a", encoding="utf-8")
    # a failure to write the log does not stop a run
    handler.handleError = lambda _record: None  # type: ignore[assignment, method-assign]
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        with suppress(OSError):
            handler.close()


class Holds(Enum):
    """Part of a planned run that its folder holds already."""

    NOTHING = "nothing of it"
    STOPPED = "a part of its simulation"
    HISTORY = "all of its simulation"
    FINISHED = "all of it"


def quiet(_text: str) -> None:
    """Report nothing."""


@dataclass
class RunFolder:
    """Folder of a run at work, or none, and reports of the run."""

    path: Path | None = None
    report: Callable[[str], None] = quiet  # gets lines for the user
    holds: Holds = Holds.NOTHING  # part of the run in the folder at the start
    overwrites: bool = False  # True for a run that replaces another one, also if it was stopped and continues
    stages: dict[str, float] = field(default_factory=dict)  # wall time of the finished stages, s
    _record: Callable[[], None] = lambda: None

    def say(self, text: str) -> None:
        """Report to the user and the log."""
        logger.info(text)
        self.report(text)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Measure the wall time of a stage."""
        logger.info("%s: begins", stage)
        start = time.perf_counter()
        begun = time.process_time()
        try:
            yield
        finally:
            self.stages[stage] = round(time.perf_counter() - start, 3)
            taken = time.process_time() - begun
            logger.info("%s: %.1f s, %.1f s of processor time", stage, self.stages[stage], taken)
            # the record lists the files of a killed run, too
            with suppress(OSError):
                self._record()


@contextmanager
def recorded(folder: RunFolder) -> Iterator[None]:
    """Log and record the work in a folder, and the files that it leaves there."""
    out = folder.path
    assert out is not None
    before = recorded_files(out)
    begun = time.perf_counter()
    installed = versions()
    record = {
        "status": "running",
        "command": sys.argv,
        "process": os.getpid(),
        "started": timestamp(),
        "machine": {
            "platform": platform.platform(),
            "processor": platform.processor() or platform.machine(),
            "cpu_count": os.cpu_count(),
            "python": platform.python_version(),
        },
        "versions": installed,
        "commit": commit(),
        "overwrites": folder.overwrites,
    }
    with logged(out), files.noted_files() as noted:

        def write(**outcome: str) -> None:
            whole = out.resolve()
            paths = [path.resolve() for path in noted]
            inside = {path.relative_to(whole).as_posix() for path in paths if path.is_relative_to(whole)}
            left = sorted(name for name in inside | before if (out / name).is_file())
            if outcome:
                taken = round(time.perf_counter() - begun, 3)
                record.update(finished=timestamp(), wall_time_s=taken, **outcome)
            write_json(out / RECORD, record | {"stages_s": folder.stages, "files": left})

        folder._record = write
        logger.info("%s %s, process %d", PROGRAM, installed.get(PROGRAM, ""), os.getpid())
        for name in (CASE, LOG):
            files.note_written(out / name)
        write()
        try:
            yield
        except BaseException as error:
            status = (
                "stopped" if isinstance(error, errors.SimulationStopped | KeyboardInterrupt) else "failed"
            )
            logger.error("%s", status, exc_info=error)
            # the error matters more than a failure to write the record
            with suppress(OSError):
                write(status=status, error=str(error) or repr(error))
            raise
        write(status=DONE)
        logger.info("done")


def note_file(path: Path) -> None:
    """Add a file made from a run's results to the record beside it, so that it goes with the run's files."""
    out = path.parent
    if earlier_record(out):
        # a run at work in the folder notes new files by itself
        with suppress(BlockingIOError), held(out):
            named = {"files": sorted({*recorded_files(out), path.name})}
            write_json(out / RECORD, earlier_record(out) | named)


@contextmanager
def held(out: Path, what: str = "run") -> Iterator[None]:
    """Hold a folder's lock; the operating system releases it at any end of the process.

    BlockingIOError, with the word `what` for the work there, if another process holds it.
    """
    lock = FileLock(out / LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout as error:
        record = {"process": "unknown", "started": "just now"} | earlier_record(out)
        raise BlockingIOError(
            f"{out} is in use by another {what} (process {record['process']}, started {record['started']}): "
            "choose another folder or wait"
        ) from error
    try:
        yield
    finally:
        lock.release()
