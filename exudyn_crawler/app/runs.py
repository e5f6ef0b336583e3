"""Runs of a folder as processes of their own, one after the other; their folders say all of them.

A run that waits, works or has ended is the same for every page and for the next start of the program: a
closed page ends none, and neither does the end of the program.
"""

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from exudyn_crawler import files
from exudyn_crawler.case import CaseFile, write_case
from exudyn_crawler.run.folder import checkpoints, record
from exudyn_crawler.run.folder.progress import PROGRESS

RESULTS = "results"
WAITS = "waits"  # empty file of a run that waits for its turn
CONSOLE = "console.txt"
"""Lines that a run has written for its user."""
WAITING, RUNNING, STOPPED, FAILED, DONE = "waiting", "running", "stopped", "failed", record.DONE
GOES_ON = (STOPPED, FAILED)
COMMAND = (sys.executable, "-m", "exudyn_crawler")


class Run(NamedTuple):
    """Run as its folder has it."""

    name: str
    folder: Path
    status: str
    record: dict[str, Any]
    progress: dict[str, Any]  # of the part that it is at
    stages: tuple[Path, ...]  # files of the parts of the history that are there so far

    @property
    def has_page(self) -> bool:
        """True where its page is there."""
        return (self.folder / "report.html").is_file()

    @property
    def has_history(self) -> bool:
        """True where all of its history is there."""
        return (self.folder / record.HISTORY).is_file()

    def last_lines(self, count: int = 3) -> str:
        """Last lines that it has written for its user."""
        with suppress(OSError):
            text = (self.folder / CONSOLE).read_text(encoding="utf-8", errors="replace")
            return "\n".join(text.strip().splitlines()[-count:])
        return ""


class Runs:
    """Runs in the folder `results` of a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / RESULTS
        self._started: dict[str, subprocess.Popen[bytes]] = {}

    def all(self) -> list[Run]:
        """Every run, the newest first."""
        if not self.folder.is_dir():
            return []
        homes = [path for path in self.folder.iterdir() if (path / record.CASE).is_file()]
        homes.sort(key=lambda path: (path / record.CASE).stat().st_mtime, reverse=True)
        return [self.named(path.name) for path in homes]

    def named(self, name: str) -> Run:
        """Run of a name."""
        home = self.folder / name
        noted = record.earlier_record(home)
        return Run(
            name,
            home,
            self._status(home, noted),
            noted,
            _progress(home),
            tuple(checkpoints.stage_files(home)),
        )

    def _status(self, home: Path, noted: dict[str, Any]) -> str:
        process = self._started.get(home.name)
        if process is not None and process.poll() is None:
            return RUNNING
        if (home / WAITS).exists():
            return WAITING
        if noted.get("status") == RUNNING:
            return RUNNING if _is_held(home, noted.get("process")) else STOPPED
        return str(noted.get("status", FAILED))

    def free_name(self, name: str) -> str:
        """Name, with a number behind it if a run has it already."""
        number = 1
        free = name
        while (self.folder / free).exists():
            number += 1
            free = f"{name}_{number}"
        return free

    def add(self, case_file: CaseFile, name: str) -> Path:
        """Let a case wait for its turn; FileExistsError if there is a run of the name."""
        home = files.writable_folder(self.folder / name)
        write_case(case_file, home / record.CASE)
        (home / WAITS).touch()
        return home

    def go_on(self, name: str) -> None:
        """Let a run that was stopped wait for its turn again; it goes on from its last stage."""
        (self.folder / name / WAITS).touch()

    def withdraw(self, name: str) -> None:
        """Take a run that waits out of the queue; one that has not begun is forgotten."""
        home = self.folder / name
        (home / WAITS).unlink(missing_ok=True)
        if not (home / record.RECORD).exists():
            (home / record.CASE).unlink(missing_ok=True)
            with suppress(OSError):
                home.rmdir()

    def stop(self, name: str) -> None:
        """Ask a run to stop, which keeps what it has."""
        run = self.named(name)
        process = self._started.get(name)
        number = run.record.get("process") if process is None else process.pid
        if run.status == RUNNING and isinstance(number, int):
            with suppress(OSError):
                os.kill(number, signal.SIGTERM)

    def start_next(self) -> None:
        """Start the run that has waited longest, if none is at work."""
        found = self.all()
        if any(run.status == RUNNING for run in found):
            return
        waiting = [run for run in found if run.status == WAITING]
        if not waiting:
            return
        first = min(waiting, key=lambda run: (run.folder / WAITS).stat().st_mtime)
        words = [*COMMAND, "run", str(first.folder / record.CASE), "--out", str(first.folder)]
        with (first.folder / CONSOLE).open("wb") as console:
            self._started[first.name] = subprocess.Popen(
                words,
                stdin=subprocess.DEVNULL,
                stdout=console,
                stderr=subprocess.STDOUT,
                cwd=self.folder.parent,
                start_new_session=True,
            )
        (first.folder / WAITS).unlink(missing_ok=True)


def _progress(home: Path) -> dict[str, Any]:
    """How far the part of a run at work has come; nothing where it says nothing."""
    with suppress(OSError, ValueError):
        content = json.loads((home / PROGRESS).read_text(encoding="utf-8"))
        return content if isinstance(content, dict) else {}
    return {}


def _is_held(home: Path, number: object) -> bool:
    """True where the process of a number works in a folder."""
    if not isinstance(number, int):
        return False
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    # another process may have the number by now, which does not hold the folder
    try:
        with record.held(home):
            return False
    except BlockingIOError:
        return True
