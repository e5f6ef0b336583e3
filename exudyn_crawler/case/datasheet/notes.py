"""Notes on where every value of a case comes from: given, derived by a rule, or assumed with its range."""

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

from exudyn_crawler.case.datasheet import typical
from exudyn_crawler.case.parameters import fields

Origin = Literal["given", "derived", "assumed"]


TYPICAL = "datasheet.typical"


class Note(NamedTuple):
    """Where a value comes from."""

    path: str  # of the case, or the name of a value that stands in no case
    value: Any
    unit: str
    origin: Origin
    how: str  # rule and source, or range and source

    @property
    def words(self) -> str:
        """Origin and how, for reading."""
        return f"{self.origin}: {self.how}" if self.how else self.origin


class Notes:
    """Notes in the order in which values come; values of the datasheet and typical ones are asked of it."""

    def __init__(self, kind: str, overrides: dict[str, float | None]) -> None:
        self.kind = kind
        self.overrides = overrides
        self.used: dict[str, typical.TypicalValue] = {}
        self.notes: dict[str, Note] = {}

    def __iter__(self) -> Iterator[Note]:
        return iter(self.notes.values())

    def typical(self, name: str) -> float:
        """Typical value of a name, which the file may override; it is noted as assumed, or as given."""
        row = typical.row_of(name, self.kind)
        value = self.overrides.get(name)
        path = f"{TYPICAL}.{name}"
        if value is not None:
            self.notes[path] = Note(path, value, "", "given", "the file")
            return value
        self.used[name] = row
        unit = "" if row.unit == "1" else row.unit
        span = f"{row.low:g} to {row.high:g} {unit}".rstrip()
        self.notes[path] = Note(
            path, row.value, unit, "assumed", f"{row.meaning}; {span}; {row.source} [{row.known}]"
        )
        return row.value

    def sized(self, path: str, name: str, size: float, unit: str = "m") -> float:
        """Value of a case that is a typical one times a size: of the pitch, say."""
        value = size * self.typical(name)
        del self.notes[f"{TYPICAL}.{name}"]
        row = self.used.get(name)
        if row is None:
            self.note(path, value, unit, "derived", f"{name} of the file")
        else:
            bounds = tuple(float(f"{bound * size:.4g}") for bound in (row.low, row.high))
            span = fields.value_text(bounds, unit).replace(", ", " to ")
            how = f"{name} {row.value:g}, {span}; {row.source} [{row.known}]"
            self.note(path, value, unit, "assumed", how)
        return value

    def note(self, path: str, value: Any, unit: str, origin: Origin, how: str) -> Any:
        """Note a value; it comes back."""
        self.notes[path] = Note(path, value, unit, origin, how)
        return value
