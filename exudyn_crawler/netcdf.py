"""NetCDF files: compressed, whole or not at all, with checksums of all numbers and texts."""

import io
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from exudyn_crawler.files import whole_file
from fem.hdf5 import VERSIONS
from fem.interrupts import interrupts_wait

if TYPE_CHECKING:
    import xarray as xr

COMPRESSION = {"zlib": True, "complevel": 1, "shuffle": True, "fletcher32": True}
"""Of every variable of a NetCDF file; higher levels take longer and save little. A checksum tells of altered
bytes."""
CHUNK_BYTES = 2**18
"""Size of the chunks of a file that is written along a dimension; HDF5 holds one of every variable."""


def write_netcdf(dataset: "xr.Dataset", path: Path, overwrite: bool = False) -> Path:
    """Write a dataset as compressed NetCDF, whole or not at all; raises as `whole_file`.

    The file is made in memory first: where a disk is full, HDF5 does not fail but ends the process.
    """
    with whole_file(path, overwrite) as temporary, interrupts_wait():
        temporary.write_bytes(_netcdf_bytes(dataset))
    return path


def _netcdf_bytes(dataset: "xr.Dataset") -> memoryview:
    from xarray.backends import H5NetCDFStore

    # what was read from a file remembers how it was stored there
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
    store = H5NetCDFStore.open(content, mode="w", driver_kwds={"libver": VERSIONS})
    dataset.dump_to_store(store, encoding=encoding)
    store.close()
    return content.getbuffer()


def _in_headers(attributes: Mapping[Any, Any]) -> dict[Any, Any]:
    """Attributes whose texts have a fixed length: HDF5 keeps others in a heap that has no checksum."""
    return {
        name: np.bytes_(value.encode()) if isinstance(value, str) and value.isascii() else value
        for name, value in attributes.items()
    }


def write_netcdf_along(
    dimension: str, size: int, parts: "Iterable[xr.Dataset]", path: Path, overwrite: bool = False
) -> Path:
    """Write a dataset that comes in parts along a dimension, holding one at a time.

    Parameters
    ----------
    dimension : str
        The first one of all variables that have it.
    size : int
        Length of the dimension, all parts together.
    parts : iterable of xarray.Dataset
        One or more, in order; what lacks the dimension is that of the first.

    Raises
    ------
    FileExistsError, OSError
        As of `whole_file`.
    """
    import h5netcdf

    remaining = iter(parts)
    first = next(remaining)
    along = [name for name, variable in first.variables.items() if dimension in variable.dims]
    with (
        whole_file(path, overwrite) as temporary,
        interrupts_wait() as waiting,
        _Disk.opened(temporary) as disk,
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
                    # also where a block around this one lets it wait
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
    filters = {"compression": "gzip", "compression_opts": COMPRESSION["complevel"]}
    filters |= {name: COMPRESSION[name] for name in ("shuffle", "fletcher32")}
    # nothing can be cut into chunks that holds no number
    options = {"chunks": (rows, *variable.shape[1:]), **filters} if variable.size else {}
    made = file.create_variable(name, variable.dims, variable.dtype, **options)
    for key, value in _in_headers(variable.attrs).items():
        made.attrs[key] = value


class _Disk:
    """File for HDF5, which does not survive a write that fails: it is told of none, and `check` is."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._failure: OSError | None = None
        self.seek, self.tell, self.readinto = file.seek, file.tell, file.readinto  # type: ignore[attr-defined]
        self.read, self.truncate, self.flush = file.read, file.truncate, file.flush

    @classmethod
    @contextmanager
    def opened(cls, path: Path) -> "Iterator[_Disk]":
        """Open a file; a failure is raised when it is closed."""
        with path.open("r+b", buffering=0) as file:
            disk = cls(file)
            yield disk
            disk.check()

    def write(self, content: bytes | memoryview) -> int:
        """Write all of the content; after a failure, nothing."""
        try:
            rest = memoryview(content)
            while self._failure is None and len(rest):
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self._failure = error
        return len(content)

    def check(self) -> None:
        """Raise the first failure."""
        if self._failure is not None:
            raise self._failure
