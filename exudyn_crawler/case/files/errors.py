"""What is wrong in a file or a parameter, as lines that name it."""

import difflib
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from exudyn_crawler.case.parameters import fields
from exudyn_crawler.case.parameters.fields import KeyPath


def toml_content(path: str | Path, kind: str) -> dict[str, Any]:
    """Content of a TOML file; `kind` is what a file that is not there was to hold.

    Raises `FileNotFoundError` or, without the path, `ValueError` if it is not TOML.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no {kind} {path}")
    try:
        # some editors put a mark before the text
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"not TOML: {error}") from error


SHOWN = 60
"""Characters of a refused value that an error shows."""
MOST_UNKNOWN = 10
"""Unknown keys that errors name."""


def error_lines(error: ValidationError, model: type[BaseModel], in_file: bool = True) -> Iterator[str]:
    """Errors that a validation found, a line each: the key's path, what is wrong and what is allowed.

    `model` is the class that was to be made, of values in a file or of arguments.
    """
    found = error.errors(include_url=False)
    unknown = 0
    for one in found:
        loc = tuple(one["loc"])
        if one["type"] == "extra_forbidden":
            unknown += 1
            if unknown > MOST_UNKNOWN:
                continue
        if one["type"] == "too_short" and any(
            other["loc"][: len(loc)] == loc and other is not one for other in found
        ):
            continue  # what is in the list is wrong, not how much
        yield " ".join(_message(one, _spot(loc, model, in_file), model, in_file).split())
    if unknown > MOST_UNKNOWN:
        yield f"{unknown} keys are unknown, of which the first {MOST_UNKNOWN} are named"


class _Spot(NamedTuple):
    """Where an error is: its `place` as a file has it, and the class of the `table` there.

    The table might be of `others` instead, the field holds one of `held`; `around` is the class whose file
    has the table's keys beside its own.
    """

    place: KeyPath
    table: type[BaseModel]
    others: tuple[type[BaseModel], ...]
    held: tuple[type[BaseModel], ...]
    around: type[BaseModel] | None = None


def _spot(loc: KeyPath, model: type[BaseModel], in_file: bool) -> _Spot:
    """Where pydantic's place is, which names the tag of a part that may be of several classes, too."""
    spot = _Spot((), model, (), (model,))
    instead: tuple[type[BaseModel], ...] = ()
    for part in loc:
        if isinstance(part, int):
            spot = spot._replace(place=(*spot.place, part))
            continue
        tagged = [kind for kind in spot.held if len(spot.held) > 1 and fields.tag_of(kind) == part]
        if tagged:
            instead = tuple(kind for kind in spot.held if kind not in tagged)
            spot = spot._replace(held=tuple(tagged))
            continue
        table = spot.held[0] if spot.held else spot.table
        field = table.model_fields.get(part)
        held = fields.models_of(field.annotation) if field else ()
        if in_file and field and fields.is_beside(field):
            spot = _Spot(spot.place, table, instead, held, around=table)
        else:
            around = spot.around if spot.held and spot.around is spot.table else None
            spot = _Spot((*spot.place, part), table, instead, held, around)
        instead = ()
    return spot


def _message(one: ErrorDetails, spot: _Spot, model: type[BaseModel], in_file: bool) -> str:
    path, given = fields.path_text(spot.place), one["input"]
    head = f"{path}: " if path else ""
    message = one["msg"].removeprefix("Value error, ")
    if one["type"].endswith("_parsing"):
        message = message.partition(", unable to ")[0]
    if one["type"] == "extra_forbidden":
        return f"{path}: {_unknown(spot, model)}"
    if one["type"] == "missing":
        return f"{path}: {_missing(one, spot, in_file)}"
    if one["type"] == "value_error":
        return f"{head}{message}"
    if one["type"] in ("union_tag_invalid", "union_tag_not_found"):
        tag = given.get(fields.TAG) if isinstance(given, dict) else given
        allowed = " or ".join(repr(fields.tag_of(kind)) for kind in spot.held)
        return f"{path}.{fields.TAG}: Input should be {allowed}, got {shown(tag)}"
    if in_file:
        message = message.replace("be an object", "be a table")
    elif one["type"] in ("model_type", "model_attributes_type"):
        message = f"Input should be {' or '.join(kind.__name__ for kind in spot.held)}"
    return f"{head}{message}, got {shown(given)}{_cause(one, spot)}"


def _missing(one: ErrorDetails, spot: _Spot, in_file: bool) -> str:
    """What to do about a value that is not there."""
    if isinstance(spot.place[-1], int):
        return f"missing, got {shown(one['input'])}"
    if in_file:
        in_list = any(isinstance(part, int) for part in spot.place)
        return "missing" if in_list else "missing; give it, or a base for what is left out"
    named = " or ".join(f"{spot.table.__name__}.{name}()" for name in fields.named_values(spot.table))
    return f"missing; give it, or change a copy of {named}" if named else "missing"


def _cause(one: ErrorDetails, spot: _Spot) -> str:
    """Unit that a number beyond its bounds is likely in; empty for other errors."""
    name = next((part for part in reversed(spot.place) if isinstance(part, str)), "")
    field, given = spot.table.model_fields.get(name), one["input"]
    beyond = one["type"].startswith(("less_than", "greater_than"))
    if not beyond or field is None or not isinstance(given, int | float):
        return ""
    return fields.likely_cause(float(given), field)


def _unknown(spot: _Spot, model: type[BaseModel]) -> str:
    """Hint at the name that was meant: of the same table if one is near, else of another."""
    wrong, start = str(spot.place[-1]), spot.place[:-1]
    for other in spot.others:
        if wrong in other.model_fields:
            this, that = fields.tag_of(spot.table), fields.tag_of(other)
            return f"unknown key with {fields.TAG} = {this!r}; {fields.TAG} = {that!r} has it"
    names = list(spot.table.model_fields)
    if spot.around is not None:
        names += [name for name, field in spot.around.model_fields.items() if not fields.is_beside(field)]
    near = difflib.get_close_matches(wrong, names, n=1, cutoff=0.7)
    if near := near or [name for name in names if name.startswith(f"{wrong}_")]:
        return f"unknown key; did you mean {fields.path_text((*start, near[0]))}?"
    # of several the first
    elsewhere = {path.rpartition(".")[2]: path for path in reversed([*fields.key_paths(model)])}
    if near := difflib.get_close_matches(wrong, elsewhere, n=1, cutoff=0.7):
        return f"unknown key; did you mean {elsewhere[near[0]]}?"
    near = difflib.get_close_matches(wrong, names, n=1, cutoff=0.0) or names[:1]
    return f"unknown key; the nearest is {near[0]}, allowed are {', '.join(names)}"


def shown(value: object) -> str:
    """Value as an error shows it, on one line and cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN else text[: SHOWN - 4] + " ..."
