"""Files that appear whole or not at all, and are never overwritten unasked."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PARTIAL = ".partial-"
"""What the names of files begin with that are being written."""


def refuse_existing(path: Path, overwrite: bool = False) -> None:
    """Refuse to write over a file.

    Raises
    ------
    FileExistsError
        If `path` exists and `overwrite` is false.
    """
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} exists; ask for overwriting (--overwrite) to replace it")


@contextmanager
def whole_file(path: Path, overwrite: bool = False) -> Iterator[Path]:
    """Write to a temporary file beside `path` that takes its place when the block ends well.

    Raises
    ------
    FileExistsError
        If `path` exists and `overwrite` is false.
    OSError
        Naming `path`, if it cannot be written: the disk is full, say.
    """
    refuse_existing(path, overwrite)
    try:
        handle, name = tempfile.mkstemp(prefix=PARTIAL, suffix=f"-{path.name}", dir=path.parent)
    except OSError as error:
        raise _not_written(path, error) from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        if path.exists() and not overwrite:
            raise FileExistsError(f"{path} was written by somebody else in the meantime")
        # mkstemp keeps the file to its owner; give it the rights that a new file has here
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
        note_written(path)
    except FileExistsError:
        raise
    except OSError as error:
        raise _not_written(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def move_file(source: Path, path: Path, overwrite: bool = False) -> None:
    """Move a whole file to another place on the same disk; raises as `whole_file`."""
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} exists; ask for overwriting to replace it")
    try:
        source.replace(path)
    except OSError as error:
        raise _not_written(path, error) from error
    note_written(path)


_noting: list[set[Path]] = []
"""Sets of the blocks of `noted_files` that have not ended."""


@contextmanager
def noted_files() -> Iterator[set[Path]]:
    """Note the files that this process puts in place within the block, in the set that it gives."""
    noted: set[Path] = set()
    _noting.append(noted)
    try:
        yield noted
    finally:
        _noting.pop()


def note_written(path: Path) -> None:
    """Tell the blocks of `noted_files` of a file that was put in place."""
    for noted in _noting:
        noted.add(path)


def _not_written(path: Path, error: OSError) -> OSError:
    """Same error in words that name the file which was meant."""
    return type(error)(f"{path} could not be written: {error.strerror or error}")


def clear_partial_files(folder: Path, below: bool = True) -> None:
    """Remove what `whole_file` left in a folder, also those `below`, when its process was killed."""
    name = f"{PARTIAL}????????-*"
    for path in folder.rglob(name) if below else folder.glob(name):
        path.unlink(missing_ok=True)


def writable_folder(path: Path) -> Path:
    """Make a folder, where needed, and refuse one that cannot be written to.

    Raises
    ------
    NotADirectoryError, PermissionError
        Naming the folder.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except (FileExistsError, NotADirectoryError) as error:
        raise NotADirectoryError(f"output folder {path} is not a folder") from error
    except OSError as error:
        raise PermissionError(f"output folder {path} cannot be written to: {error}") from error
    return path
