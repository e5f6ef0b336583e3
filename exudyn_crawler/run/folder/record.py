"""Record and log of a run: versions, machine, timing and outcome in `run.json`, what went on in `run.log`."""

import importlib.metadata
import json
import logging
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from exudyn_crawler.files import whole_file

RECORD, LOG = "run.json", "run.log"
DONE = "done"
"""Status of a run that has ended well."""
PROGRAM = "exudyn-crawler"
THREAD_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

logger = logging.getLogger("exudyn_crawler")


def first_record() -> dict[str, Any]:
    """What is known of a run when it begins."""
    return {
        "status": "running",
        "command": sys.argv,
        "process": os.getpid(),
        "started": timestamp(),
        "machine": machine(),
        "versions": versions(),
        "commit": commit(),
    }


def finished_record(record: dict[str, Any]) -> dict[str, Any]:
    """When a run ended, and what it took."""
    took = datetime.now(UTC) - datetime.fromisoformat(record["started"])
    return {"finished": timestamp(), "wall_time_s": round(took.total_seconds(), 3)}


def earlier_record(folder: Path) -> dict[str, Any]:
    """What an earlier run recorded in a folder; nothing if there is no readable record."""
    try:
        found = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def named_files(record: dict[str, Any]) -> set[str]:
    """Names of files that a record lists, without such as lead out of its folder or are no names."""
    names = record.get("files")
    texts = {name for name in names if isinstance(name, str)} if isinstance(names, list) else set()
    return {name for name in texts if _stays(name)}


def _stays(name: str) -> bool:
    path = Path(name)
    return "\0" not in name and bool(path.parts) and not path.is_absolute() and ".." not in path.parts


def write_record(folder: Path, record: dict[str, Any]) -> None:
    """Write the record of a run."""
    with whole_file(folder / RECORD, overwrite=True) as temporary:
        temporary.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")


def timestamp() -> str:
    """Now, as a record says it."""
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


def commit() -> str:
    """Commit that the program is from; empty where nothing tells.

    A checkout asks git, and marks what was changed since; an installation knows it if it was made from a
    repository's address (PEP 610).
    """
    root = Path(__file__).parents[3]
    if (root / ".git").exists():
        return _commit_of(root)
    with suppress(importlib.metadata.PackageNotFoundError, ValueError, TypeError, AttributeError):
        told = json.loads(importlib.metadata.distribution(PROGRAM).read_text("direct_url.json") or "{}")
        return str(told.get("vcs_info", {}).get("commit_id", ""))
    return ""


def _commit_of(root: Path) -> str:
    """Commit that a checkout is at."""
    asked = [
        "git",
        "-C",
        str(root),
        "describe",
        "--always",
        "--dirty=, changed",
        "--abbrev=12",
        "--exclude=*",
    ]
    with suppress(OSError, subprocess.SubprocessError):
        return subprocess.run(asked, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
    return ""


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


class _LogFile(logging.FileHandler):
    """Log that does not stop a run where it cannot be written."""

    def handleError(self, _record: logging.LogRecord) -> None:  # noqa: N802
        pass

    def close(self) -> None:
        with suppress(OSError):
            super().close()


@contextmanager
def logged(out: Path) -> Iterator[None]:
    """Send the package's log into a folder, behind what is there."""
    handler = _LogFile(out / LOG, mode="a", encoding="utf-8")
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
