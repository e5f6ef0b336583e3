"""Paths of parameters in a case, what files write of parameter classes, and units."""

import inspect
import json
import math
import re
import typing
from collections.abc import Callable, Iterator
from types import UnionType
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

KeyPath = tuple[int | str, ...]
"""Names and numbers on the way to a value: ("loads", "phases", 2, "end")."""
EVERY = "*"
"""In place of a number: all items of a list."""
NAME = re.compile(r"([A-Za-z_]\w*)((?:\[(?:\d+|\*)\])*)", re.ASCII)
NUMBER = re.compile(r"\[(\d+|\*)\]")


def parse_path(text: str) -> KeyPath:
    """Names and numbers of a path: ("loads", "phases", "*", "end") of ``loads.phases[*].end``.

    Raises
    ------
    ValueError
        If the text is not a path.
    """
    path: list[int | str] = []
    for part in text.split("."):
        match = NAME.fullmatch(part)
        if match is None:
            raise ValueError(
                f"a path must be like terrain.spring_stiffness or loads.phases[0].end, got {text!r}"
            )
        path.append(match[1])
        path += [number if number == EVERY else int(number) for number in NUMBER.findall(match[2])]
    return tuple(path)


def path_text(path: KeyPath) -> str:
    """Path as it is written: ``loads.phases[2].end``."""
    text = ""
    for part in path:
        if isinstance(part, int) or part == EVERY:
            text += f"[{part}]"
        else:
            # keys that need quotes in TOML have them here, and cannot break the line
            text += "." + (part if re.fullmatch(r"[\w-]+", part, re.ASCII) else json.dumps(part))
    return text.lstrip(".")


def with_value_at(values: Any, path: KeyPath, value: Any) -> Any:
    """Copy with another value at a path; see `with_change_at`."""
    return with_change_at(values, path, lambda _before: value)


def with_change_at(values: Any, path: KeyPath, change: Callable[[Any], Any], above: KeyPath = ()) -> Any:
    """Copy in which the value at a path, or each of those that ``*`` means, went through a function.

    Parameters
    ----------
    values : dict, list, tuple or parameters
        Parameters on the way become tables of their fields, to be validated again. A table that does not
        have a name gets it; the value before is None then.
    above : tuple
        Path of `values` itself, for errors.

    Raises
    ------
    ValueError
        If the path leads to an item that a list does not have, or into what is no table or list.
    """
    if not path:
        return change(values)
    part, below = path[0], path[1:]
    if isinstance(part, int) or part == EVERY:
        if not isinstance(values, list | tuple):
            raise ValueError(f"there is no list {path_text(above)} to change an item of")
        numbers = range(len(values)) if part == EVERY else [int(part)]
        items = list(values)
        for number in numbers:
            if number >= len(items):
                raise ValueError(f"{path_text(above)} has {len(items)} items, counted from 0, no [{number}]")
            items[number] = with_change_at(items[number], below, change, (*above, number))
        return type(values)(items)
    table = fields_of(values) if isinstance(values, BaseModel) else values
    if not isinstance(table, dict):
        raise ValueError(f"{path_text(above)} must be a table to change a value of it, got {values!r}")
    before = table.get(part, {} if below and isinstance(below[0], str) and below[0] != EVERY else None)
    return {**table, part: with_change_at(before, below, change, (*above, part))}


def fields_of(model: BaseModel) -> dict[str, Any]:
    """Values of a parameter object by name."""
    return {name: getattr(model, name) for name in type(model).model_fields}


BASE = "base"
"""Key of a file: the named value that gives what its table leaves out."""
NONE = "none"
"""What a file says where a field has no value, which TOML cannot."""
TAG = "model"
"""Field that tells which class of several a part is of."""

BESIDE = object()
"""Marks, in the annotation of a field, that a file has its fields beside those of the class that holds it."""


def is_beside(field: FieldInfo) -> bool:
    """Whether a file has the fields of a part beside those of the class that holds it."""
    return BESIDE in field.metadata


def with_change_in(
    kind: type[BaseModel], values: Any, path: KeyPath, change: Callable[[Any], Any]
) -> dict[str, Any]:
    """Values of a parameter class, one of them changed at a path as a file has it; see `with_change_at`.

    Parameters
    ----------
    kind : type of BaseModel
        Class that the values are of; a file may have the fields of a part beside its own.
    values : dict or BaseModel
    """
    table = fields_of(values) if isinstance(values, BaseModel) else values
    for name, field in kind.model_fields.items():
        if is_beside(field) and (path[0] == name or path[0] not in kind.model_fields):
            return {**table, name: with_change_at(table[name], path, change)}
    changed: dict[str, Any] = with_change_at(table, path, change)
    return changed


def with_value_in(kind: type[BaseModel], values: Any, path: KeyPath, value: Any) -> dict[str, Any]:
    """Values of a parameter class with another one at a path; see `with_change_in`."""
    return with_change_in(kind, values, path, lambda _before: value)


def key_paths(kind: type[BaseModel], start: str = "") -> Iterator[str]:
    """Paths of all values that a parameter class may have in a file, each once."""
    found: dict[str, None] = {}
    for name, field in kind.model_fields.items():
        parts, below = models_of(field.annotation), start if is_beside(field) else f"{start}{name}."
        for part in parts:
            found |= dict.fromkeys(key_paths(part, below))
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


MISTAKEN: dict[str, dict[str, float]] = {
    "": {"per cent": 0.01},
    "m": {"mm": 1e-3, "inch": 0.0254},
    "m/s": {"km/h": 1.0 / 3.6, "mm/s": 1e-3},
    "m/s2": {"mm/s2": 1e-3},
    "rad/s": {"deg/s": math.pi / 180.0},
    "s": {"ms": 1e-3},
    "kg": {"t": 1e3, "g": 1e-3},
    "kg/m3": {"t/m3": 1e3, "t/mm3": 1e12},
    "N": {"kN": 1e3},
    "N/m": {"kN/m": 1e3, "MN/m": 1e6},
    "N s/m": {"kN s/m": 1e3},
    "Pa": {"MPa": 1e6, "GPa": 1e9, "kPa": 1e3},
    "Hz": {"kHz": 1e3},
}
"""Units that numbers come in by mistake, with their size in that of the case."""


def plausible_range(field: FieldInfo) -> tuple[float, float] | None:
    """Least and greatest plausible value of a field; None for one that has none."""
    match field.json_schema_extra:
        case {"plausible": [int() | float() as least, int() | float() as greatest]}:
            return least, greatest
    return None


def unit_of(field: FieldInfo) -> str:
    """Unit of a field after a number: with a space before it, or nothing."""
    extra = field.json_schema_extra
    unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
    return "" if unit in ("", "1") else f" {unit}"


def likely_cause(value: float, field: FieldInfo) -> str:
    """Hint at the unit in which a value would be plausible; empty if there is none."""
    plausible = plausible_range(field)
    if plausible is None or not value:
        return ""
    own = unit_of(field).strip()
    for unit, size in MISTAKEN.get(own, {}).items():
        if plausible[0] <= value * size <= plausible[1]:
            return f"; is it in {unit}? It has to be {f'in {own}' if own else 'a fraction of 1'}"
    return ""
