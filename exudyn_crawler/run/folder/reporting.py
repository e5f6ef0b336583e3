"""What a run reports and records while it works in a folder, which one process at a time may do."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.files import note_written, noted_files
from exudyn_crawler.run.folder.record import (
    DONE,
    LOG,
    PROGRAM,
    earlier_record,
    finished_record,
    first_record,
    logged,
    logger,
    named_files,
    write_record,
)

CASE, LOCK = "case.toml", ".lock"
HISTORY = "history.nc"
STOPPED_HISTORY = "history_stopped.nc"
"""In place of the history, of a run that stopped early."""
CHECKPOINTS = "checkpoints"
END = "checkpoint.npz"
"""What a longer run goes on with, where a finished one had more than one stage."""


class Holds(Enum):
    """What a folder holds of a run that is to go into it."""

    NOTHING = "nothing of it"
    STOPPED = "the run, stopped in its simulation"
    HISTORY = "the run, stopped after its simulation"
    SHORTER = "a finished run of less time"
    FINISHED = "all of it"


def quiet(_text: str) -> None:
    """Report nothing."""


@dataclass
class RunFolder:
    """Folder that a run works in, or none, and what the run reports meanwhile.

    Attributes
    ----------
    path : Path or None
    report : callable
        Gets the lines that the user is to read.
    holds : Holds
        What the folder held of the run when it began.
    overwrites : bool
        Whether the run was to replace another one, also if it was stopped and goes on now.
    stages : dict
        Wall time in s by stage, as far as they have ended.
    simulated : bool
        Whether the history of the run is in the folder.
    """

    path: Path | None = None
    report: Callable[[str], None] = quiet
    holds: Holds = Holds.NOTHING
    overwrites: bool = False
    stages: dict[str, float] = field(default_factory=dict)
    simulated: bool = False
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
        try:
            yield
        finally:
            self.stages[stage] = round(time.perf_counter() - start, 3)
            logger.info("%s: %.1f s", stage, self.stages[stage])
            # who kills a run leaves files that are known all the same
            with suppress(OSError):
                self._record()

    def note_history(self) -> None:
        """Record that the history of the run is in the folder."""
        self.simulated = True
        self._record()


@contextmanager
def recorded(folder: RunFolder) -> Iterator[None]:
    """Log and record what goes on in a folder, and which files it leaves there."""
    out = folder.path
    assert out is not None
    before = named_files(earlier_record(out))
    record = first_record() | {"overwrites": folder.overwrites}
    with logged(out), noted_files() as noted:

        def write(outcome: dict[str, Any]) -> None:
            files = {name for name in _inside(out, noted) | before if (out / name).is_file()}
            known = {"simulated": folder.simulated, "stages_s": folder.stages, "files": sorted(files)}
            write_record(out, record | outcome | known)

        folder._record = lambda: write({})
        logger.info("%s %s, process %d", PROGRAM, record["versions"].get(PROGRAM, ""), record["process"])
        for name in (CASE, LOG):
            note_written(out / name)
        write({})
        try:
            yield
        except BaseException as error:
            stopped = isinstance(error, SimulationStopped | KeyboardInterrupt)
            outcome = {"status": "stopped" if stopped else "failed", "error": str(error) or repr(error)}
            logger.error("%s", outcome["status"], exc_info=error)
            # what went wrong matters more than a record that cannot be written either
            with suppress(OSError):
                write(finished_record(record) | outcome)
            raise
        write(finished_record(record) | {"status": DONE})
        logger.info("done")


def _inside(out: Path, paths: set[Path]) -> set[str]:
    """Names within a folder of those of the paths that lie in it."""
    whole = out.resolve()
    found = {path.resolve() for path in paths}
    return {path.relative_to(whole).as_posix() for path in found if path.is_relative_to(whole)}


def note_file(path: Path) -> None:
    """Add a file made of a run's results to the record beside it, so that overwriting the run removes it.

    Nothing is noted where there is no record. A run at work in the folder notes what is new by itself.
    """
    out = path.parent
    if not earlier_record(out):
        return
    with suppress(BlockingIOError), held(out):
        found = earlier_record(out)
        write_record(out, found | {"files": sorted({*named_files(found), path.name})})


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
