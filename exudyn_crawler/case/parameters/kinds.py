"""Parameter classes and what files write of them."""

import inspect
import typing
from collections.abc import Callable, Iterator
from types import UnionType
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from exudyn_crawler.case.files.paths import KeyPath, fields_of, with_change_at

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
