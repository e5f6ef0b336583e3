"""Files that appear whole or not at all and are overwritten only on request; NetCDF files with checksums."""

import io
import secrets
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from exudyn_crawler.errors import ASK_TO_OVERWRITE
from fem.interrupts import interrupts_wait

if TYPE_CHECKING:
    import xarray as xr

HISTORY = "history.nc"
"""File of a run in its folder, from which all its other outputs can be made again."""
PARTIAL = ".partial-"  # prefix of the names of unfinished files


def refuse_existing(path: Path, overwrite: bool = False) -> None:
    """Raise FileExistsError if a file exists and `overwrite` is false."""
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} exists; {ASK_TO_OVERWRITE} to replace it")


@contextmanager
def whole_file(path: Path, overwrite: bool = False) -> Iterator[Path]:
    """Yield a temporary file beside `path` that replaces it when the block ends without an error.

    Raises FileExistsError if the file exists and `overwrite` is false; OSError, with its name, if it cannot
    be written, for example on a full disk.
    """
    refuse_existing(path, overwrite)
    temporary = path.with_name(f"{PARTIAL}{secrets.token_hex(4)}-{path.name}")
    try:
        temporary.touch(exist_ok=False)
        try:
            yield temporary
            if path.exists() and not overwrite:
                raise FileExistsError(f"{path} was written by another program in the meantime")
            temporary.replace(path)
            note_written(path)
        finally:
            temporary.unlink(missing_ok=True)
    except FileExistsError:
        raise
    except OSError as error:
        raise type(error)(f"{path} could not be written: {error.strerror or error}") from error


_noting: list[set[Path]] = []  # sets of the open blocks of `noted_files`


@contextmanager
def noted_files() -> Iterator[set[Path]]:
    """Yield a set, to which all files that this process completes within the block are added."""
    noted: set[Path] = set()
    _noting.append(noted)
    try:
        yield noted
    finally:
        _noting.pop()


def note_written(path: Path) -> None:
    """Add a completed file to the sets of all open blocks of `noted_files`."""
    for noted in _noting:
        noted.add(path)


def clear_partial_files(folder: Path, below: bool = True) -> None:
    """Remove the files of a killed `whole_file` in a folder, also `below` it."""
    name = f"{PARTIAL}????????-*"
    for path in folder.rglob(name) if below else folder.glob(name):
        path.unlink(missing_ok=True)


def writable_folder(path: Path) -> Path:
    """Make a folder if it does not exist, and return it.

    Raises NotADirectoryError or PermissionError if it cannot be written to.
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


COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
"""Compression of every variable of a NetCDF file; higher levels save little. The checksum reveals altered
bytes."""
CHUNK_BYTES = 2**18
"""Size of the chunks of a file written along a dimension; HDF5 holds one chunk of every variable."""
TIMES_AT_ONCE = 1000  # stored times of a file held in memory together


def blocks(dataset: "xr.Dataset") -> "Iterator[xr.Dataset]":
    """Yield consecutive parts of a dataset with a time; each part fits into memory."""
    for start in range(0, max(1, dataset.sizes["time"]), TIMES_AT_ONCE):
        yield dataset.isel(time=slice(start, start + TIMES_AT_ONCE))


def write_netcdf(dataset: "xr.Dataset", path: Path, overwrite: bool = False) -> Path:
    """Write a dataset as compressed NetCDF, whole or not at all; raises as `whole_file`.

    The file is first made in memory: on a full disk, HDF5 does not fail but ends the process.
    """
    with whole_file(path, overwrite) as temporary, interrupts_wait():
        temporary.write_bytes(_netcdf_bytes(dataset))
    return path


def _netcdf_bytes(dataset: "xr.Dataset") -> memoryview:
    from xarray.backends import H5NetCDFStore, locks

    from fem.files.hdf5 import VERSIONS

    # a dataset from a file keeps its encoding there
    dataset = dataset.drop_encoding().copy()
    dataset.attrs = _in_headers(dataset.attrs)
    encoding: dict[Any, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        variable.attrs = _in_headers(variable.attrs)
        if variable.ndim and variable.dtype.kind in "biuf":
            encoding[name] = COMPRESSION
        elif variable.dtype.kind in "OUT":
            encoding[name] = COMPRESSION | {"dtype": "S1"}
    content = io.BytesIO()
    # in a Dask worker xarray would ask the cluster for a lock of this memory, and the cluster may be lost
    store = H5NetCDFStore.open(content, mode="w", lock=locks.HDF5_LOCK, driver_kwds={"libver": VERSIONS})
    dataset.dump_to_store(store, encoding=encoding)
    store.close()
    return content.getbuffer()


def _in_headers(attributes: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return attributes with texts of a fixed length: HDF5 keeps others in a heap without a checksum."""
    return {
        name: np.bytes_(value.encode()) if isinstance(value, str) and value.isascii() else value
        for name, value in attributes.items()
    }


def write_netcdf_along(
    dimension: str, size: int, parts: "Iterable[xr.Dataset]", path: Path, overwrite: bool = False
) -> Path:
    """Write a dataset from parts along a dimension, one in memory at a time; raises as `whole_file`.

    The dimension is the first one of all variables that have it; `size` is its length over all parts. There
    is at least one part, and parts are in order. Variables without the dimension are those of the first part.
    """
    import h5netcdf

    from fem.files.hdf5 import VERSIONS, Disk

    remaining = iter(parts)
    first = next(remaining)
    along = [name for name, variable in first.variables.items() if dimension in variable.dims]
    with (
        whole_file(path, overwrite) as temporary,
        interrupts_wait() as waiting,
        Disk(temporary, "r+") as disk,
    ):
        disk.write(_netcdf_bytes(first.drop_vars(along)))
        disk.check()
        with h5netcdf.File(disk, "r+", libver=VERSIONS) as file:
            file.dimensions[dimension] = size
            for name in along:
                _create(file, str(name), first.variables[name], size)
            start = 0
            for part in chain([first], remaining):
                end = start + part.sizes[dimension]
                for name in along:
                    file.variables[name][start:end] = part.variables[name].values
                disk.check()
                if waiting:
                    # also if an outer block lets interrupts wait
                    raise KeyboardInterrupt
                start = end
        disk.check()
    return path


def _create(file: Any, name: str, variable: "xr.Variable", size: int) -> None:
    """Add an empty variable of `size` rows to an open file."""
    for dimension, length in zip(variable.dims, variable.shape, strict=True):
        if dimension not in file.dimensions:
            file.dimensions[dimension] = length
    row_bytes = max(1, variable.dtype.itemsize * int(variable[0].size))
    rows = min(size, max(1, CHUNK_BYTES // row_bytes))
    # an empty variable cannot have chunks
    options = {"chunks": (rows, *variable.shape[1:])} | COMPRESSION if variable.size else {}
    made = file.create_variable(name, variable.dims, variable.dtype, **options)
    made.attrs.update(_in_headers(variable.attrs))
