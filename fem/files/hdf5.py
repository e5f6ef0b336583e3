"""HDF5 files, written whole or not at all, readable in parts with a checksum each."""

import io
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

import h5py

from fem.interrupts import interrupts_wait

if TYPE_CHECKING:
    from fem.body.mesh import Floats, Integers

KIND = "format"
"""Attribute with the kind of a file."""
REDUCED_BODY, STATIC_FIELDS = "fem reduced body 4", "fem static fields 2"
PIN_PRESSURES = "fem pin pressures 1"
"""Kinds of files of this package."""
VERSIONS = ("v110", "v110")
"""Versions of the format: the first one with checksums for the indices of chunks."""
CHUNK_BYTES = 2**16
"""Size of an array's chunks, bytes, if single rows are to be read."""

SEARCHED_BYTES = 2**20
"""Size of the parts of a file that are searched at once, bytes."""

HEAP = b"GCOL\x01\0\0\0"
"""Start of a heap of texts and references; its size follows, then objects with heads of `HEAD` bytes."""
HEAD = 16
Read = TypeVar("Read")


class Disk(io.FileIO):
    """File for HDF5 that hides write failures, since HDF5 does not survive one; `check` raises them."""

    failure: OSError | None = None

    def write(self, content: Any) -> int:
        """Write all of the content; write nothing after a failure."""
        try:
            rest = memoryview(content)
            while self.failure is None and len(rest):
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.failure = error
        return len(content)

    def truncate(self, size: int | None = None) -> int:
        """Set the file's size; hide failures like `write`."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.failure = self.failure or error
            return size or 0

    def check(self) -> None:
        """Raise the first failure, if any."""
        if self.failure is not None:
            raise self.failure


@interrupts_wait()
def write_whole(path: Path, kind: str, fill: Callable[[h5py.File], None]) -> None:
    """Write an HDF5 file of a kind whole or not at all; `fill` writes its content."""
    handle, part = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
    try:
        with Disk(handle, "r+") as disk:
            with h5py.File(disk, "w", libver=VERSIONS) as file:
                file.attrs[KIND] = kind
                fill(file)
            disk.check()
        os.replace(part, path)
    except BaseException:
        os.unlink(part)
        raise


def check_heaps(path: Path) -> None:
    """Raise an error for a broken heap: heaps have no checksums, and HDF5 would read a broken one for ever.

    Raises
    ------
    OSError
        If an object is smaller than its head (HDF5 File Format Specification 3.0, III.E).
    """
    length = path.stat().st_size
    with path.open("rb") as searched, path.open("rb") as file:
        for start in _places(searched, HEAP):
            file.seek(start)
            end = start + int.from_bytes(file.read(HEAD)[8:], "little")
            place = start + HEAD
            while place + HEAD <= min(end, length):
                file.seek(place)
                head = file.read(HEAD)
                number = int.from_bytes(head[:2], "little")
                size = int.from_bytes(head[8:], "little")
                # free space has the number 0, and its head counts
                size += 0 if number == 0 else HEAD + -size % 8
                if size < HEAD:
                    raise OSError(f"its heap at byte {start} is broken at byte {place}")
                place += size


def _places(file: BinaryIO, pattern: bytes) -> Iterator[int]:
    """Yield the positions of a pattern in a file; memory holds a part of the file at a time."""
    start = 0
    content = b""
    while part := file.read(SEARCHED_BYTES):
        content += part
        place = content.find(pattern)
        while place >= 0:
            yield start + place
            place = content.find(pattern, place + len(pattern))
        # a pattern may begin in one part and end in the next
        rest = content[1 - len(pattern) :]
        start += len(content) - len(rest)
        content = rest


def write_rows(file: h5py.Group, name: str, array: "Floats | Integers") -> None:
    """Write an array in chunks of rows with checksums, so that single rows can be read."""
    if array.size == 0:  # no chunk that could have a checksum
        file[name] = array
        return
    rows = min(len(array), max(1, CHUNK_BYTES // array[0].nbytes))
    file.create_dataset(name, data=array, chunks=(rows, *array.shape[1:]), fletcher32=True)


@interrupts_wait()
def check_objects(path: Path) -> None:
    """Raise `ValueError` for an HDF5 file with unreadable objects or attributes; other files pass.

    Readers of NetCDF leave such a file half open, and report it later.
    """
    if not h5py.is_hdf5(path):
        return
    check_heaps(path)
    try:
        with h5py.File(path, "r") as file:
            dict(file.attrs)
            file.visititems(lambda _name, item: dict(item.attrs) and None)
    # altered bytes make the reader raise all kinds of errors
    except Exception as error:
        raise ValueError(f"it is broken: {' '.join(str(error).split())}") from error


@interrupts_wait()
def read_whole(path: Path, kind: str, read: Callable[[h5py.File], Read]) -> Read:
    """Return the result of `read` for an HDF5 file.

    Parameters
    ----------
    path : Path
    kind : str
        Required value of the file's attribute `KIND`.
    read : callable

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file is of another kind or broken.
    """
    if not path.is_file():
        raise FileNotFoundError(f"no file {path}")
    try:
        check_heaps(path)
        file = h5py.File(path, "r")
    except OSError as error:
        raise ValueError(f"{path} must be an HDF5 file, got: {error}") from error
    try:
        with file:
            stored_kind = file.attrs.get(KIND)
            if stored_kind != kind:
                raise ValueError(f"{path} must be a {kind!r} file, got {stored_kind!r}")
            return read(file)
    except (OSError, KeyError, TypeError, RuntimeError) as error:
        raise ValueError(f"{path} must be whole, got a broken file: {error}") from error
