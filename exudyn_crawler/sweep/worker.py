"""Run of a sweep on a worker, in its folder, and its outcome."""

import json
import os
import platform
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from exudyn_crawler import case_run, errors
from exudyn_crawler.machines import CaseFile
from exudyn_crawler.model.reductions import program_digest
from exudyn_crawler.run.folder.record import LOCK, note_file, timestamp, write_json
from exudyn_crawler.sweep import answers, definition

LOCK_WAIT = 600.0
"""Time (s) that a run waits for another process on it, such as a worker that the scheduler took for dead."""
DONE = "done"
FAILED = "failed"
OUTCOME = "outcome.json"  # outcome of a run of a sweep, in its folder
SEEN = ".seen"  # in the folder of all runs while a sweep is at work
Outcome = dict[str, Any]
"""Outcome of a run: digest, status ("done" or "failed"), reason, answers by name, asked (definitions of the
answers), wall_time_s, processor_time_s, host, process and finished."""


@dataclass(frozen=True)
class Task:
    """Task of a worker: a run with all its inputs."""

    digest: str
    case: str  # case file as JSON
    answers: str  # as JSON
    runs: str  # folder of the folders of runs
    reductions: str | None  # folder of reductions of flexible shoes; None: that of the worker's machine
    versions: dict[str, str]  # of the client
    again: bool = False  # True: repeat a failed run
    token: str | None = None  # text of `SEEN` that the worker has to read in the folder; None: unchecked


@cache
def own_versions() -> dict[str, str]:
    """Return the versions, by name, that must be equal on client and workers."""
    names = ("exudyn-crawler", "exudyn", "numpy", "scipy", "distributed")
    python = {"Python": ".".join(platform.python_version_tuple()[:2])}
    return python | {name: version(name) for name in names} | {"sources": program_digest()[:12]}


def check_versions(wanted: dict[str, str], there: dict[str, str], where: str) -> None:
    """Raise ValueError for a worker with other versions than the client."""
    pairs = [(name, there.get(name, "missing"), here) for name, here in wanted.items()]
    differing = [f"{name} {other} there, {here} here" for name, other, here in pairs if other != here]
    if differing:
        raise ValueError(f"worker {where} has other versions: {', '.join(differing)}")


@contextmanager
def token_in(runs: Path, token: str) -> Iterator[None]:
    """Keep a token in the folder of a sweep's runs for a while; workers that read it see the folder."""
    path = runs / SEEN
    path.write_text(token, encoding="ascii")
    try:
        yield
    finally:
        path.unlink(missing_ok=True)


def sees(runs: str | Path, token: str) -> bool:
    """Return True if this machine sees the folder with a token."""
    try:
        return (Path(runs) / SEEN).read_text(encoding="ascii") == token
    except (OSError, ValueError):
        return False


def run_task(task: Task) -> Outcome:
    """Run a case, or its missing parts, into its folder, and answer; raises only as `check_versions`."""
    check_versions(task.versions, own_versions(), platform.node())
    begun = time.perf_counter()
    computed = time.process_time()
    error = None
    numbers = {}
    try:
        numbers = _answered(task)
    except Exception as raised:
        error = raised
    here: dict[str, Any] = {"host": platform.node(), "process": os.getpid()}
    here |= {"wall_time_s": round(time.perf_counter() - begun, 3)}
    here |= {"processor_time_s": round(time.process_time() - computed, 3)}
    outcome = write_outcome(task, error, numbers, **here)
    note_file(folder_of(task.runs, task.digest) / OUTCOME)
    return outcome


def folder_of(runs: str | Path, digest: str) -> Path:
    """Return the folder of a run in that of all runs."""
    return Path(runs) / digest[: definition.FOLDER_DIGITS]


def read_outcome(runs: str | Path, digest: str) -> Outcome | None:
    """Return the outcome of a run; None if there is none, it cannot be read, or it is that of another run."""
    try:
        outcome = json.loads((folder_of(runs, digest) / OUTCOME).read_text(encoding="utf-8"))
        return outcome if outcome["digest"] == digest else None
    except (OSError, ValueError, TypeError, KeyError):
        return None


def write_outcome(
    task: Task, error: BaseException | None, numbers: dict[str, float | None], **more: Any
) -> Outcome:
    """Write the outcome of a run into its folder; a run with an error has failed."""
    reason = "" if error is None else " ".join(str(error).split())
    if error is not None and not (isinstance(error, errors.CrawlerError | ValueError | OSError) and reason):
        reason = f"{type(error).__name__}: {reason}"
    status = DONE if error is None else FAILED
    outcome = {"digest": task.digest, "asked": json.loads(task.answers), "status": status, "reason": reason}
    outcome |= {"answers": numbers, **more, "finished": timestamp()}
    folder = folder_of(task.runs, task.digest)
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / OUTCOME, outcome)
    return outcome


def _answered(task: Task) -> dict[str, float | None]:
    """Run the case of a task and return its answers by name; None if a run has none."""
    case_file = CaseFile.model_validate_json(task.case)
    folder = folder_of(task.runs, task.digest)
    has_failed = (read_outcome(task.runs, task.digest) or {}).get("status") == FAILED
    how: dict[str, Any] = {"overwrite": task.again and has_failed, "take_finished": True, "progress": False}
    folder.mkdir(parents=True, exist_ok=True)
    with suppress(Timeout), FileLock(folder / LOCK, timeout=LOCK_WAIT):
        pass
    with warnings.catch_warnings():
        # the sweep warns of them once
        warnings.simplefilter("ignore", errors.ImplausibleWarning)
        run = case_run.run_case(case_file, folder, reductions=task.reductions, **how)
        numbers = {answer.label: answer.of_run(run) for answer in answers.ANSWERS.validate_json(task.answers)}
    return {name: None if value != value else value for name, value in numbers.items()}
