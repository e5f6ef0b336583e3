"""Files that appear whole or not at all, and are never overwritten unasked."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


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
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
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
    except FileExistsError:
        raise
    except OSError as error:
        raise _not_written(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def _not_written(path: Path, error: OSError) -> OSError:
    """Same error in words that name the file which was meant."""
    return type(error)(f"{path} could not be written: {error.strerror or error}")


COMPRESSION = {"zlib": True, "complevel": 1, "shuffle": True}
"""Of every variable of a NetCDF file; higher levels take longer and save little."""


def write_netcdf(dataset: "xr.Dataset", path: Path, overwrite: bool = False) -> Path:
    """Write a dataset as compressed NetCDF, whole or not at all; raises as `whole_file`.

    The file is made in memory first: where a disk is full, HDF5 does not fail but ends the process.
    """
    encoding = dict.fromkeys(dataset.data_vars, COMPRESSION)
    with whole_file(path, overwrite) as temporary:
        temporary.write_bytes(dataset.to_netcdf(None, engine="h5netcdf", encoding=encoding))
    return path


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
