"""NetCDF files: compressed, whole or not at all, and sealed with a digest of all their bytes."""

import hashlib
import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

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
SEAL = b"SHA-256 of all before: "
"""Before the digest, in hexadecimal, at the end of a file, where HDF5 does not look."""
SEALED = len(SEAL) + 2 * hashlib.sha256().digest_size
PROVED_AT_ONCE = 2**24
"""Bytes of a file that are read together."""
MOST_PROVED = 2 * 10**9
"""Bytes of the greatest file whose seal is proved, a second of it; beyond, HDF5's checksums must do."""


def write_netcdf(dataset: "xr.Dataset", path: Path, overwrite: bool = False) -> Path:
    """Write a dataset as compressed NetCDF, whole or not at all; raises as `whole_file`.

    The file is made in memory first: where a disk is full, HDF5 does not fail but ends the process.
    """
    with whole_file(path, overwrite) as temporary, interrupts_wait():
        temporary.write_bytes(_netcdf_bytes(dataset))
        _seal(temporary)
    return path


def _netcdf_bytes(dataset: "xr.Dataset") -> memoryview:
    from xarray.backends import H5NetCDFStore

    encoding = {
        name: COMPRESSION for name, one in dataset.variables.items() if one.ndim and one.dtype.kind in "biuf"
    }
    content = io.BytesIO()
    store = H5NetCDFStore.open(content, mode="w", driver_kwds={"libver": VERSIONS})
    # what was read from a file remembers how it was kept there
    dataset.drop_encoding().dump_to_store(store, encoding=encoding)
    store.close()
    return content.getbuffer()


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
        _seal(temporary)
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
    for key, value in variable.attrs.items():
        made.attrs[key] = value


def _seal(path: Path) -> None:
    """Append the digest of a file."""
    with path.open("r+b") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        file.write(SEAL + digest.encode())


def sealed_digest(path: Path) -> bytes | None:
    """Digest in the seal of a file, in hexadecimal, not proved; None if it has no seal."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - SEALED))
        seal = file.read()
    return seal[len(SEAL) :] if seal.startswith(SEAL) and len(seal) == SEALED else None


def check_seal(path: Path) -> None:
    """Refuse a NetCDF file of which a bit was altered since it was written.

    HDF5's checksums guard most of a file but not all: altered bytes may give other numbers, or an endless
    loop. A file without a seal, of an earlier version say, is let pass.

    Raises
    ------
    ValueError
        If the digest is not that of the file.
    """
    length = path.stat().st_size - SEALED
    if length > MOST_PROVED:
        return
    digest = sealed_digest(path)
    if digest is None:
        return
    sha = hashlib.sha256()
    with path.open("rb") as file:
        while length:
            block = file.read(min(length, PROVED_AT_ONCE))
            sha.update(block)
            length -= len(block)
    if sha.hexdigest().encode() != digest:
        raise ValueError("its bytes were altered: the digest at its end is not theirs")


def open_netcdf(path: Path, **options: Any) -> "xr.Dataset":
    """Open a NetCDF file whose seal is right; options and further errors are those of xarray.

    Raises
    ------
    ValueError
        As of `check_seal`.
    """
    import xarray as xr

    check_seal(path)
    return xr.open_dataset(path, engine="h5netcdf", **options)


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
