"""Files that are made once and kept in a folder, safe among processes, made anew where broken.

They end in ``.h5``, are named by the digest of all that they depend on, and may be removed at will.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from filelock import FileLock

LIMIT = 3e9
"""Bytes that a folder may hold; what was not used for longest goes first. The study mesh takes 0.4e9."""
NAMED_BY = 32
"""Characters of a digest in the name of its file."""

Made = TypeVar("Made")


def kept_path(folder: str | Path, digest: str, suffix: str = "") -> Path:
    """File of a digest in a folder; `suffix` tells kinds of files apart."""
    return Path(folder) / f"{digest[:NAMED_BY]}{suffix}.h5"


def taken_or_made(
    path: Path,
    load: Callable[[], Made],
    make: Callable[[], Made],
    save: Callable[[Made], None],
    warn: Callable[[str], None],
    what: str,
) -> tuple[Made, bool]:
    """What a file holds, or what is made anew and kept in it, and whether it was there.

    Processes that want the same file at the same time wait for the first of them. A broken file is replaced.
    Where the folder cannot be written to, nothing is kept.

    Parameters
    ----------
    path : Path
        Of `kept_path`.
    load : callable
        Reads the file; raises `FileNotFoundError` where there is none, `ValueError` where it is broken.
    make : callable
        Makes what it holds anew.
    save : callable
        Writes what was made; raises `OSError` where it cannot.
    warn : callable
        Gets a line about a file that is broken or cannot be written.
    what : str
        What the file holds, for these lines.
    """
    with _alone(path, warn):
        try:
            found = load()
        except FileNotFoundError:
            pass
        except ValueError as error:
            warn(f"{what} is made anew: {error}")
        else:
            note_used(path)
            return found, True
        made = make()
        try:
            save(made)
            _make_room(path.parent)
        except OSError as error:
            warn(f"{what} is not kept, {path} cannot be written: {error}")
    return made, False


def note_used(path: Path) -> None:
    """Make a file the one that was used last."""
    with suppress(OSError):
        os.utime(path)


def kept_files(folder: str | Path) -> list[Path]:
    """Files that are kept in a folder, those used last first."""
    used = {}
    for path in Path(folder).glob("[!.]*.h5"):  # a dot before what is being written
        with suppress(FileNotFoundError):  # another process made room
            used[path] = path.stat().st_mtime
    return sorted(used, key=used.__getitem__, reverse=True)


@contextmanager
def _alone(path: Path, warn: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of a file, if there can be one; the operating system releases it when a process ends."""
    lock = FileLock(path.with_suffix(".lock"))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except (OSError, NotImplementedError) as error:
        warn(f"nothing can be kept in {path.parent}: {error}")
    try:
        yield
    finally:
        lock.release()


def _make_room(folder: Path) -> None:
    """Remove what was not used for longest, as far as a folder holds more than its limit."""
    total = 0
    for path in kept_files(folder):
        with suppress(OSError):
            total += path.stat().st_size
            if total > LIMIT:
                path.unlink()
                path.with_suffix(".lock").unlink(missing_ok=True)
