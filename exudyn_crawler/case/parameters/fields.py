"""Fields of the parameter classes: one walk over a case that files, tables and the report share."""

import inspect
from collections.abc import Iterator
from typing import NamedTuple

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from exudyn_crawler.case.parameters.base import StepProfile
from exudyn_crawler.case.parameters.paths import EVERY, KeyPath, is_beside, models_of, path_text


class Entry(NamedTuple):
    """A table or a value of a case: its place, its field and what stands there."""

    place: KeyPath
    field: FieldInfo
    value: object

    @property
    def path(self) -> str:
        """KeyPath as it is written: ``loads.phases[2].end``."""
        return path_text(self.place)

    @property
    def unit(self) -> str:
        """Unit; empty for what has none."""
        extra = self.field.json_schema_extra
        unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
        return "" if unit == "1" else unit

    @property
    def meaning(self) -> str:
        """Description of the field, or that of the parameter class that it holds."""
        kinds = [type(self.value)] if isinstance(self.value, BaseModel) else models_of(self.field.annotation)
        return self.field.description or (first_line(kinds[0]) if kinds else "")


def walk(model: BaseModel, place: KeyPath = ()) -> Iterator[Entry]:
    """Every table and value of a parameter object, in order.

    A table comes before what it holds, its values before its tables. A quantity over time is a value. The
    fields of a case that a case file holds stand beside that file's own.
    """
    entries = [Entry((*place, name), field, value) for name, field, value in _fields(model)]
    yield from (entry for entry in entries if not (is_table(entry.value) or are_tables(entry.value)))
    for entry in entries:
        if isinstance(entry.value, BaseModel) and is_table(entry.value):
            yield entry
            yield from walk(entry.value, entry.place)
        elif isinstance(entry.value, tuple) and are_tables(entry.value):
            for number, part in enumerate(entry.value):
                yield Entry((*entry.place, number), entry.field, part)
                yield from walk(part, (*entry.place, number))


def _fields(model: BaseModel) -> Iterator[tuple[str, FieldInfo, object]]:
    for name, field in type(model).model_fields.items():
        value = getattr(model, name)
        if is_beside(field) and isinstance(value, BaseModel):
            yield from _fields(value)
        else:
            yield name, field, value


def entry_at(model: BaseModel, path: KeyPath) -> Entry | None:
    """Table or value at a path, or that holds the list which the path leads into; None if there is none."""
    wanted = tuple(0 if part == EVERY else part for part in path)
    within = [entry for entry in walk(model) if wanted[: len(entry.place)] == entry.place]
    if not within:
        return None
    deepest = max(within, key=lambda entry: len(entry.place))
    return deepest if all(isinstance(part, int) for part in wanted[len(deepest.place) :]) else None


def is_table(value: object) -> bool:
    """Whether a value has a table of its own; a quantity over time has not."""
    return isinstance(value, BaseModel) and not isinstance(value, StepProfile)


def are_tables(value: object) -> bool:
    """Whether a value is a list of tables."""
    return isinstance(value, tuple) and bool(value) and all(map(is_table, value))


def first_line(kind: type[BaseModel]) -> str:
    """What a parameter class is, in a line."""
    return (inspect.getdoc(kind) or "").split("\n\n")[0].replace("\n", " ")
