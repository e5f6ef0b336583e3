"""What a run tells and records in its folder while it works, and what it removes there in the end."""

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.files import note_written, noted_files
from exudyn_crawler.run.folder.log import LOG, logged, logger
from exudyn_crawler.run.folder.record import (
    DONE,
    PROGRAM,
    RECORD,
    commit,
    earlier_record,
    machine,
    named_files,
    timestamp,
    versions,
    write_record,
)
from exudyn_crawler.run.folder.standing import CASE

LOCK = ".lock"


def quiet(_text: str) -> None:
    """Tell nobody."""


@dataclass
class Keeper:
    """What a run tells while it works: lines for the user and the log, and times of its stages.

    Attributes
    ----------
    stages : dict
        Wall time in s by stage, as far as they have ended.
    anew : bool
        Whether nothing is taken of what the folder holds.
    overwrites : bool
        Whether an earlier run is to be replaced, also if this one was stopped while it did so.
    extends : bool
        Whether the run goes on with a finished one of less time.
    simulated : bool
        Whether the history of this run is in the folder.
    begun : str
        When it was begun first, as records say it.
    """

    tell: Callable[[str], None] = quiet
    stages: dict[str, float] = field(default_factory=dict)
    anew: bool = True
    overwrites: bool = False
    extends: bool = False
    simulated: bool = False
    begun: str = ""
    _note: Callable[[], None] = lambda: None

    @property
    def replaces(self) -> bool:
        """Whether files may be replaced: those of an earlier run, or of this one before it was stopped."""
        return self.overwrites or not self.anew

    def say(self, text: str) -> None:
        """Tell the user and the log."""
        logger.info(text)
        self.tell(text)

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

    def note_history(self) -> None:
        """Record that the history of this run is in the folder."""
        self.simulated = True
        self._note()


@contextmanager
def recorded(out: Path, keeper: Keeper, found: dict[str, Any]) -> Iterator[None]:
    """Log and record what goes on in a folder, and remove in the end what a run replaces.

    `found` is the record of an earlier run, or of this one before it was stopped.
    """
    before = named_files(found, "files") if keeper.replaces else set()
    record: dict[str, Any] = {
        "status": "running",
        "command": sys.argv,
        "process": os.getpid(),
        "started": timestamp(),
        "machine": machine(),
        "versions": versions(),
        "commit": commit(),
        "begun": keeper.begun,
        "overwrites": keeper.overwrites,
        "extends": keeper.extends,
        "replaces": sorted(_replaced(keeper, found)),
    }

    def note() -> None:
        write_record(out, record | {"simulated": keeper.simulated})

    keeper._note = note
    with logged(out, keeper.anew and keeper.overwrites), noted_files() as noted:
        logger.info("%s %s, process %d", PROGRAM, record["versions"].get(PROGRAM, ""), os.getpid())
        note()
        for name in (CASE, LOG):
            note_written(out / name)
        try:
            yield
        except BaseException as error:
            stopped = isinstance(error, SimulationStopped | KeyboardInterrupt)
            outcome = {"status": "stopped" if stopped else "failed", "error": str(error) or repr(error)}
            logger.error("%s", outcome["status"], exc_info=error)
            # what went wrong matters more than a record that cannot be written either
            with suppress(OSError):
                _finish(out, record | outcome, keeper, _inside(out, noted) | before)
            raise
        written = _inside(out, noted)
        _remove(out, set(record["replaces"]) - written - _of_runs(out, keeper.begun))
        _finish(out, record | {"status": DONE}, keeper, written | before)
        logger.info("done")


def _replaced(keeper: Keeper, found: dict[str, Any]) -> set[str]:
    """Names of the files that a run takes the place of."""
    if not keeper.replaces:
        return set()
    names = named_files(found, "files")
    if not keeper.anew:
        # runs in folders of their own stay, also those that a study is not about this time
        own = {Path(name).parts[0] for name in names if Path(name).name == RECORD} - {RECORD}
        names = {name for name in names if Path(name).parts[0] not in own}
    return named_files(found, "replaces") | names


def _of_runs(out: Path, since: str) -> set[str]:
    """Names of what runs in folders of a folder have written that were begun since a time."""
    records = {path.parent.name: earlier_record(path.parent) for path in out.glob(f"*/{RECORD}")}
    return {
        f"{folder}/{name}"
        for folder, record in records.items()
        if str(record.get("begun", "")) >= since
        for name in named_files(record, "files")
    }


def _inside(out: Path, paths: set[Path]) -> set[str]:
    """Names within a folder of those of the paths that lie in it and are there."""
    whole = out.resolve()
    found = {path.resolve() for path in paths if path.exists()}
    return {path.relative_to(whole).as_posix() for path in found if path.is_relative_to(whole)}


def _finish(out: Path, record: dict[str, Any], keeper: Keeper, files: set[str]) -> None:
    """Complete the record."""
    took = datetime.now(UTC) - datetime.fromisoformat(record["started"])
    times = {"finished": timestamp(), "wall_time_s": round(took.total_seconds(), 3)}
    there = sorted(name for name in files if (out / name).is_file())
    outcome = {"simulated": keeper.simulated, "stages_s": keeper.stages, "files": there}
    write_record(out, record | times | outcome)


def _remove(out: Path, names: set[str]) -> None:
    """Remove files of an earlier run and folders that they leave empty, and nothing outside the folder."""
    whole = out.resolve()
    paths = [path for name in names if (path := (out / name).resolve()).is_relative_to(whole)]
    for path in paths:
        if path.is_file():
            path.unlink()
    for folder in {path.parent for path in paths} - {whole}:
        if folder.is_dir() and {path.name for path in folder.iterdir()} <= {LOCK}:
            (folder / LOCK).unlink(missing_ok=True)
            folder.rmdir()
