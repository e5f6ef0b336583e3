"""What a report goes on without: files of a folder that cannot be read."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")


class LeftOut(list[str]):
    """Lines that name the files that were left out, and why."""

    def unless_broken(self, path: Path, read: Callable[[Path], T]) -> T | None:
        """What a file holds; None, and a line, if it cannot be read."""
        try:
            return read(path)
        # altered bytes make the readers of tables, pictures and NetCDF raise all kinds of errors
        except Exception as error:
            reason = " ".join(str(error).split()) or repr(error)
            # a file that is read for several sections is told of once
            if not any(line.startswith(f"{path} ") for line in self):
                self.append(reason if reason.startswith(f"{path} ") else f"{path} cannot be read: {reason}")
            return None

    def of_all(self, paths: Iterable[Path], read: Callable[[Path], T]) -> list[T]:
        """What those of the files hold that can be read."""
        found = [self.unless_broken(path, read) for path in paths]
        return [one for one in found if one is not None]
