"""Fields of the parameter classes: one walk over a case that files, tables and the report share."""

import inspect
import json
import re
import typing
from collections.abc import Callable, Iterator
from types import UnionType
from typing import Any, NamedTuple

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.profile import StepProfile

BASE = "base"
"""Key of a file: the named value that gives what its table leaves out."""
NONE = "none"
"""What a file says where a field has no value, which TOML cannot."""
TAG = "model"
"""Field that tells which class of several a part is of."""

Place = tuple[int | str, ...]
"""Names and numbers on the way to a value: ("loads", "phases", 2, "end")."""


class Entry(NamedTuple):
    """A table or a value of a case: its place, its field and what stands there."""

    place: Place
    field: FieldInfo
    value: object

    @property
    def path(self) -> str:
        """Place as it is written: ``loads.phases[2].end``."""
        return key_path(self.place)

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


def walk(model: BaseModel, place: Place = ()) -> Iterator[Entry]:
    """Every table and value of a parameter object, in order.

    A table comes before what it holds, its values before its tables. A quantity over time is a value. The
    fields of a `Case` that is in another object stand beside that object's own.
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
        if isinstance(value, Case):
            yield from _fields(value)
        else:
            yield name, field, value


def is_table(value: object) -> bool:
    """Whether a value has a table of its own; a quantity over time has not."""
    return isinstance(value, BaseModel) and not isinstance(value, StepProfile)


def are_tables(value: object) -> bool:
    """Whether a value is a list of tables."""
    return isinstance(value, tuple) and bool(value) and all(map(is_table, value))


def first_line(kind: type[BaseModel]) -> str:
    """What a parameter class is, in a line."""
    return (inspect.getdoc(kind) or "").split("\n\n")[0].replace("\n", " ")


def key_path(place: Place) -> str:
    """Place of a value as it is written: ``loads.phases[2].end``."""
    text = ""
    for part in place:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            # keys that need quotes in TOML have them here, and cannot break the line
            text += "." + (part if re.fullmatch(r"[\w-]+", part, re.ASCII) else json.dumps(part))
    return text.lstrip(".")


def key_paths(kind: type[BaseModel], start: str = "") -> Iterator[str]:
    """Paths of all values that a parameter class may have, each once."""
    found: dict[str, None] = {}
    for name, field in kind.model_fields.items():
        parts = models_of(field.annotation)
        for part in parts:
            found |= dict.fromkeys(key_paths(part, f"{start}{name}."))
        if not parts:
            found[f"{start}{name}"] = None
    yield from found


def models_of(annotation: Any) -> tuple[type[BaseModel], ...]:
    """Parameter classes that a field may hold one or many of; empty if it holds plain values."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return (annotation,)
    return tuple(model for part in typing.get_args(annotation) for model in models_of(part))


def tag_of(kind: type[BaseModel]) -> str:
    """What the field `model` says in a class that is one of several."""
    return str(kind.model_fields[TAG].default)


def allows_none(annotation: Any) -> bool:
    """Whether a field may have no value."""
    is_union = typing.get_origin(annotation) in (typing.Union, UnionType)
    return is_union and type(None) in typing.get_args(annotation)


def named_values(kind: type[BaseModel]) -> dict[str, Callable[[], BaseModel]]:
    """Constructors of a parameter class that need no argument, by name: ``Terrain.stress``, say."""
    found: dict[str, Callable[[], BaseModel]] = {}
    for name, attribute in vars(kind).items():
        if name.startswith("_") or not isinstance(attribute, classmethod):
            continue
        method = getattr(kind, name)
        arguments = inspect.signature(method).parameters.values()
        if all(argument.default is not inspect.Parameter.empty for argument in arguments):
            found[name] = method
    return found
