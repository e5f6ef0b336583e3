"""Report and record of a run (`run.json`, `run.log`) while it works in a folder, which it holds."""

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
"""The second in place of the first, of a run that stopped early."""
CHECKPOINTS, END = "checkpoints", "checkpoint.npz"
"""The second is what a longer run goes on with, where a finished one had more than one stage."""
OF_THE_SIMULATION = {CASE, RECORD, LOG, HISTORY, STOPPED_HISTORY, CHECKPOINTS, END}
"""What a run goes on with; all else is made of the history again."""
DONE = "done"  # status of a run that has ended well
PROGRAM = "exudyn-crawler"

logger = logging.getLogger("exudyn_crawler")


def earlier_record(folder: Path) -> dict[str, Any]:
    """Record of an earlier run in a folder; nothing if there is no readable one."""
    with suppress(OSError, ValueError, RecursionError):
        content = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        return content if isinstance(content, dict) else {}
    return {}


def recorded_files(folder: Path) -> set[str]:
    """Names of the files in a folder that its record lists; nothing outside of it."""
    whole = folder.resolve()
    listed = earlier_record(folder).get("files")
    names = [entry for entry in listed if isinstance(entry, str)] if isinstance(listed, list) else []
    return {
        name
        for name in names
        if (folder / name).is_file() and (folder / name).resolve().is_relative_to(whole)
    }


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a record of what was done."""
    with files.whole_file(path, overwrite=True) as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def timestamp() -> str:
    """Now, as a record says it."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def commit() -> str:
    """Commit that the program is from, by git; empty where it is installed."""
    root = Path(__file__).parents[3]
    if (root / ".git").exists():
        asked = ["git", "describe", "--always", "--abbrev=12", "--exclude=*", "--dirty=, changed"]
        with suppress(OSError, subprocess.SubprocessError):
            done = subprocess.run(asked, cwd=root, capture_output=True, text=True, check=True, timeout=10)
            return done.stdout.strip()
    return ""


def versions() -> dict[str, str]:
    """Versions of the package and of everything that it needs, as far as they are installed."""
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


@contextmanager
def logged(out: Path) -> Iterator[None]:
    """Send the package's log into a folder, behind what is there."""
    handler = logging.FileHandler(out / LOG, mode="a", encoding="utf-8")
    # a log that cannot be written stops no run
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
    """Parts that a folder holds of a run that is to go into it."""

    NOTHING = "nothing of it"
    STOPPED = "a part of its simulation"
    HISTORY = "all of its simulation"
    FINISHED = "all of it"


def quiet(_text: str) -> None:
    """Report nothing."""


@dataclass
class RunFolder:
    """Folder that a run works in, or none, and what the run reports meanwhile."""

    path: Path | None = None
    report: Callable[[str], None] = quiet  # gets the lines that the user is to read
    holds: Holds = Holds.NOTHING  # what the folder held of the run when it began
    overwrites: bool = False  # whether it was to replace another run, also if it was stopped and goes on now
    stages: dict[str, float] = field(default_factory=dict)  # wall time in s of those that have ended
    _record: Callable[[], None] = lambda: None

    def say(self, text: str) -> None:
        """Report to the user and the log."""
        logger.info(text)
        self.report(text)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Take the wall time of a stage."""
        logger.info("%s: begins", stage)
        start = time.perf_counter()
        begun = time.process_time()
        try:
            yield
        finally:
            self.stages[stage] = round(time.perf_counter() - start, 3)
            taken = time.process_time() - begun
            logger.info("%s: %.1f s, %.1f s of processor time", stage, self.stages[stage], taken)
            # who kills a run leaves files that are known all the same
            with suppress(OSError):
                self._record()


@contextmanager
def recorded(folder: RunFolder) -> Iterator[None]:
    """Log and record what goes on in a folder, and which files it leaves there."""
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
            # what went wrong matters more than a record that cannot be written either
            with suppress(OSError):
                write(status=status, error=str(error) or repr(error))
            raise
        write(status=DONE)
        logger.info("done")


def note_file(path: Path) -> None:
    """Add a file made of a run's results to a record beside it, so that overwriting the run removes it."""
    out = path.parent
    if earlier_record(out):
        # a run at work in the folder notes what is new by itself
        with suppress(BlockingIOError), held(out):
            named = {"files": sorted({*recorded_files(out), path.name})}
            write_json(out / RECORD, earlier_record(out) | named)


@contextmanager
def held(out: Path, what: str = "run") -> Iterator[None]:
    """Hold a folder's lock, which the operating system releases when the process ends, however it does.

    BlockingIOError, naming `what` works there, if another process holds it.
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
