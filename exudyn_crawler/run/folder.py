"""Folder of a run: one process at a time, and beside the results what they come from.

A folder holds the resolved case file, `run.json` with versions, machine, timing and outcome, `run.log`, and
what the run writes: its history (NetCDF), tables (CSV) and figures. A study's folder holds a folder a case
and its own record of all of them.
"""

import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from exudyn_crawler.case import CaseFile, read_case, write_case
from exudyn_crawler.errors import CaseFileError, SimulationStopped
from exudyn_crawler.files import clear_partial_files, note_written, noted_files, writable_folder
from exudyn_crawler.run.log import LOG, logged, logger
from exudyn_crawler.run.record import (
    DONE,
    PROGRAM,
    RECORD,
    earlier_record,
    machine,
    named_files,
    timestamp,
    versions,
    write_record,
)
from exudyn_crawler.run.standing import CASE, Standing, standing, study_standing

LOCK = ".lock"
RESULT_SUFFIXES = {".nc", ".csv", ".png", ".pdf", ".svg", ".vtu", ".pvd", ".mp4", ".gif"}


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
    with _held(writable_folder(out)):
        found = earlier_record(out)
        holds = study_standing(out, cases or {}) if case_file is None else standing(out, case_file)
        keeper = _keeper(holds, found, overwrite, tell)
        if not keeper.replaces:
            refuse_results(out, below=case_file is None)
        if case_file is not None:
            _keep_case(out / CASE, case_file, keeper.replaces)
        clear_partial_files(out, below=case_file is not None)
        with _recorded(out, keeper, found):
            yield keeper


def _keeper(holds: Standing, found: dict[str, Any], overwrite: bool, tell: Callable[[str], None]) -> Keeper:
    """What a run may do in a folder that holds something, of which there is a record."""
    stopped_overwriting = found.get("overwrites") is True
    goes_on = holds in (Standing.UNFINISHED, Standing.LONGER_ASKED) and (not overwrite or stopped_overwriting)
    longer = holds is Standing.SHORTER and not overwrite
    simulated = goes_on and found.get("simulated") is True
    longer |= simulated and holds is Standing.LONGER_ASKED
    begun = found.get("begun")
    return Keeper(
        tell,
        anew=not (goes_on or longer),
        overwrites=overwrite or (goes_on and stopped_overwriting),
        extends=longer or (goes_on and found.get("extends") is True),
        simulated=simulated and not longer,
        begun=begun if goes_on and isinstance(begun, str) else timestamp(),
    )


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
            f"choose another folder or ask for overwriting"
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
        write_record(out, found | {"files": sorted({*named_files(found, "files"), path.name})})


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


def _keep_case(path: Path, case_file: CaseFile, replace: bool) -> None:
    """Write the resolved case file; one that says the same stays as its author wrote it."""
    try:
        same = path.exists() and read_case(path) == case_file
    except CaseFileError:
        same = False
    if path.exists() and not same and not replace:
        raise FileExistsError(
            f"{path} is the case of another run: choose another folder or ask for overwriting"
        )
    if not same:
        write_case(case_file, path, replace)


@contextmanager
def _recorded(out: Path, keeper: Keeper, found: dict[str, Any]) -> Iterator[None]:
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
