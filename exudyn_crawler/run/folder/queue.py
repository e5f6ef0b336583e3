"""Queue of a folder's runs, each in its own process, one after another; all its state is in their folders.

A waiting, running or finished run looks the same to every program that reads its folder. A run continues when
the program that started it ends.
"""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from exudyn_crawler import files
from exudyn_crawler.machines import CaseFile, write_case
from exudyn_crawler.run.folder import record
from exudyn_crawler.run.folder.progress import PROGRESS

if sys.platform == "win32":
    # Ctrl-C in this console does not reach such a process, as elsewhere one of a new session
    NEW_GROUP = subprocess.CREATE_NEW_PROCESS_GROUP
else:
    import fcntl

    NEW_GROUP = 0

RESULTS = "results"
WAITS = "waits"  # empty file of a run that waits for its turn
QUEUE_LOCK = ".queue.lock"
SERVER = ".queue.json"
"""File with the process that holds the queue, and its start; beside the lock, in the folder of the runs."""
CONSOLE = "console.txt"
"""File with the lines that a run has written for its user; the run's process holds a lock on it."""
STARTED = ".process"  # file with the number of the process that the queue started last
LINES = 3  # number of last lines shown of a failed run
WAITING, RUNNING, STOPPED, FAILED, DONE = "waiting", "running", "stopped", "failed", record.DONE
GOES_ON = (STOPPED, FAILED)
IN_UTF8 = {"PYTHONUTF8": "1"}
"""Variable of a command whose lines this program reads: Windows would encode them otherwise."""
COMMAND = (sys.executable, "-m", "exudyn_crawler")


class Run:
    """Run by the state of its folder."""

    def __init__(self, folder: Path, works: bool = False) -> None:
        self.name = folder.name
        self.folder = folder
        self.record = record.earlier_record(folder)
        self.status = self._status(works)

    def _status(self, works: bool) -> str:
        if works:
            return RUNNING
        if (self.folder / WAITS).exists():
            return WAITING
        if self.record.get("status") != RUNNING:
            return str(self.record.get("status", FAILED))
        # a killed run also has this status, but does not hold its folder
        try:
            with record.held(self.folder):
                return STOPPED
        except BlockingIOError:
            return RUNNING

    @property
    def page(self) -> Path:
        """Page of the results."""
        return self.folder / "report.html"

    @property
    def progress(self) -> dict[str, Any]:
        """Progress of the current part; empty if unknown."""
        with suppress(OSError, ValueError):
            content = json.loads((self.folder / PROGRESS).read_text(encoding="utf-8"))
            return content if isinstance(content, dict) else {}
        return {}

    @property
    def error(self) -> str:
        """Reason of the end of a run that can continue; else empty."""
        if self.status not in GOES_ON:
            return ""
        with suppress(OSError):
            text = (self.folder / CONSOLE).read_text(encoding="utf-8", errors="replace")
            return "\n".join(text.strip().splitlines()[-LINES:])
        return str(self.record.get("error", ""))


class Runs:
    """Queue of the runs in the folder `results` of a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / RESULTS
        self._started: dict[str, subprocess.Popen[bytes]] = {}

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the queue, so that its runs start one after another.

        BlockingIOError, with the process, if another one holds the queue. The lock ends with its process.
        """
        lock = FileLock(files.writable_folder(self.folder) / QUEUE_LOCK)
        server = self.folder / SERVER
        try:
            lock.acquire(timeout=0)
        except Timeout as error:
            holder = {"process": "unknown", "started": "just now"}
            with suppress(OSError, ValueError, TypeError):
                holder |= json.loads(server.read_text(encoding="utf-8"))
            raise BlockingIOError(
                f"{self.folder.parent} has a page already, of process {holder['process']}, started "
                f"{holder['started']}: use that page, end its process, or choose another folder"
            ) from error
        try:
            record.write_json(server, {"process": os.getpid(), "started": record.timestamp()})
            yield
        finally:
            server.unlink(missing_ok=True)
            lock.release()

    def all(self) -> list[Run]:
        """Return every run, the newest first."""
        cases = sorted(self.folder.glob(f"*/{record.CASE}"), key=lambda path: -path.stat().st_mtime)
        return [self.named(path.parent.name) for path in cases]

    def named(self, name: str) -> Run:
        """Return the run of a name."""
        return Run(self.folder / name, self._works(name))

    def _works(self, name: str) -> bool:
        """Return whether a process that a queue has started for a run, now or before, has not ended."""
        process = self._started.get(name)
        if process is not None and process.poll() is None:
            return True
        if sys.platform != "win32":
            with suppress(FileNotFoundError), (self.folder / name / CONSOLE).open("rb") as console:
                try:
                    fcntl.flock(console, fcntl.LOCK_SH | fcntl.LOCK_NB)
                except BlockingIOError:
                    return True
        return False

    def add(self, case_file: CaseFile, name: str) -> str:
        """Add a case to the queue; return its name, with a number if the name is taken."""
        number = 1
        free = name
        while (self.folder / free).exists():
            number += 1
            free = f"{name}_{number}"
        home = files.writable_folder(self.folder / free)
        write_case(case_file, home / record.CASE)
        (home / WAITS).touch()
        return free

    def go_on(self, name: str) -> None:
        """Add a stopped run to the queue again; it continues from its last stage."""
        (self.folder / name / WAITS).touch()

    def stop(self, name: str) -> None:
        """Remove a run from the queue, or stop it and keep its results so far.

        A run that has not begun loses its case file, and its folder if this is then empty.
        """
        run = self.named(name)
        if run.status == RUNNING:
            # a process that starts has no record yet, or that of an earlier one
            if self._works(name):
                number = (run.folder / STARTED).read_text(encoding="utf-8")
            else:
                number = run.record["process"]
            with suppress(OSError):
                os.kill(int(number), signal.SIGTERM)
            return
        (run.folder / WAITS).unlink(missing_ok=True)
        if not run.record:
            (run.folder / record.CASE).unlink(missing_ok=True)
            with suppress(OSError):
                run.folder.rmdir()

    def start_next(self) -> None:
        """Start the run that has waited longest, if no run is running."""
        waiting = sorted(self.folder.glob(f"*/{WAITS}"), key=lambda path: path.stat().st_mtime)
        if not waiting or any(run.status == RUNNING for run in self.all()):
            return
        home = waiting[0].parent
        words = [*COMMAND, "run", str(home / record.CASE), "--out", str(home)]
        with (home / CONSOLE).open("wb") as console:
            if sys.platform != "win32":
                # the process inherits the file, and so the lock, until it ends
                fcntl.flock(console, fcntl.LOCK_EX)
            process = subprocess.Popen(
                words,
                stdin=subprocess.DEVNULL,
                stdout=console,
                stderr=subprocess.STDOUT,
                cwd=self.folder.parent,
                start_new_session=True,
                creationflags=NEW_GROUP,
                env=os.environ | IN_UTF8,
            )
        (home / STARTED).write_text(str(process.pid), encoding="utf-8")
        (home / WAITS).unlink(missing_ok=True)
        self._started[home.name] = process
