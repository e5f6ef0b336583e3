"""Sections of gmsh files, and the numbers in them, as text or binary."""

import re

import numpy as np

from fem.body.mesh import Floats, Integers, MeshError

SAVE_AGAIN = "save it in version 4.1 or 2.2 (gmsh: Mesh.MshFileVersion = 4.1)"
LARGEST_NUMBER = 2.0**53
"""Limit of whole numbers: larger ones are not exact in 8 bytes."""
_OPENING = re.compile(rb"\s*\$(MeshFormat|Comments|NOD|PhysicalNames)\b")


def is_gmsh(content: bytes) -> bool:
    """Return True for the content of a gmsh file."""
    return _OPENING.match(content) is not None


class Scanner:
    """Scanner of a file's sections and of the numbers in the current section, as text or binary."""

    def __init__(self, content: bytes) -> None:
        self.content = content
        self.place = 0
        self.version = ""
        self.is_text = True
        self._size = "u8"
        self._order = "<"
        self._numbers: Floats | None = None
        self._next = 0

    def next_section(self) -> str:
        """Return the name of the next section, empty at the end; read the format section by the way."""
        while True:
            start = self.content.find(b"$", self.place)
            if start < 0:
                return ""
            end = self.content.find(b"\n", start)
            name = self.content[start + 1 : end if end >= 0 else None].decode(errors="replace").strip()
            self.place = end + 1 if end >= 0 else len(self.content)
            self._numbers = None
            if name != "MeshFormat":
                if not self.version:
                    raise MeshError(f"it must begin with $MeshFormat, got ${name}; {SAVE_AGAIN}")
                return name
            self._read_format()
            self.leave_section(name)

    def leave_section(self, name: str) -> None:
        """Move behind the end of a section."""
        end = self.content.find(f"$End{name}".encode(), self.place)
        if end < 0:
            raise MeshError(f"it must have the end of its section ${name}, it ends early")
        self.place = end + len(name) + 4

    def rest_of_section(self) -> bytes:
        """Return the text up to the end of the section."""
        end = self.content.find(b"\n$End", self.place)
        return self.content[self.place : end if end >= 0 else None]

    def _read_format(self) -> None:
        end = self.content.find(b"\n", self.place)
        version, binary, size = (*self.content[self.place : end].split(), b"", b"", b"")[:3]
        self.version = {b"4.1": "4.1", b"2.2": "2.2", b"2": "2.2", b"2.1": "2.2"}.get(version, "")
        if not self.version or size not in (b"4", b"8") or binary not in (b"0", b"1"):
            raise MeshError(
                f"its version must be 4.1 or 2.2, got {version.decode(errors='replace')}; {SAVE_AGAIN}"
            )
        self.place = end + 1
        self.is_text = binary == b"0"
        self._size = f"u{size.decode()}"
        if not self.is_text:
            self._order = "<" if self.content[self.place : self.place + 4] == b"\1\0\0\0" else ">"

    def line(self) -> str:
        """Return the next line of the section."""
        end = self.content.find(b"\n", self.place)
        text = self.content[self.place : end]
        self.place = end + 1
        return text.decode(errors="replace")

    def integers(self, count: int) -> Integers:
        """Return the next whole numbers, of 4 bytes."""
        return self._take(count, "i4").astype(np.int64)

    def sizes(self, count: int) -> Integers:
        """Return the next whole numbers, of the size that the file declares."""
        return self._take(count, self._size).astype(np.int64)

    def reals(self, count: int) -> Floats:
        """Return the next numbers of 8 bytes."""
        return self._take(count, "f8").astype(np.float64)

    def rows(self, count: int, columns: list[str]) -> list[np.ndarray]:
        """Return the columns of the next records."""
        type_ = np.dtype([(str(k), self._order + column) for k, column in enumerate(columns)])
        records = self._bytes(count, type_)
        return [records[str(k)] for k in range(len(columns))]

    def _take(self, count: int, type_: str) -> np.ndarray:
        if not self.is_text:
            return self._bytes(count, np.dtype(self._order + type_))
        if self._numbers is None:
            self._numbers = np.array(self.rest_of_section().split(), dtype=np.float64)
            self._next = 0
        taken = self._numbers[self._next : self._next + max(count, 0)]
        if count < 0 or len(taken) < count:
            raise MeshError("it ends early")
        self._next += count
        if type_ != "f8" and not (np.abs(taken) < LARGEST_NUMBER).all():
            raise MeshError(f"its numbers must be less than {LARGEST_NUMBER:g}")
        return taken

    def _bytes(self, count: int, type_: np.dtype) -> np.ndarray:
        if count < 0 or count * type_.itemsize > len(self.content) - self.place:
            raise MeshError("it ends early")
        taken = np.frombuffer(self.content, type_, count, self.place)
        self.place += count * type_.itemsize
        return taken
