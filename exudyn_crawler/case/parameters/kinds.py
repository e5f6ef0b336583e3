"""Parameter classes and the paths of their values, as files write them."""

import inspect
import json
import re
import typing
from collections.abc import Callable, Iterator
from types import UnionType
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

BASE = "base"
"""Key of a file: the named value that gives what its table leaves out."""
NONE = "none"
"""What a file says where a field has no value, which TOML cannot."""
TAG = "model"
"""Field that tells which class of several a part is of."""

BESIDE = object()
"""Marks, in the annotation of a field, that a file has its fields beside those of the class that holds it."""

Place = tuple[int | str, ...]
"""Names and numbers on the way to a value: ("loads", "phases", 2, "end")."""


def is_beside(field: FieldInfo) -> bool:
    """Whether a file has the fields of a part beside those of the class that holds it."""
    return BESIDE in field.metadata


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
