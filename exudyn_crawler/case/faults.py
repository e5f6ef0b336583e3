"""Faults of a case in words: the key's path, what is wrong there and what is allowed."""

import difflib
from collections.abc import Iterator
from typing import NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from exudyn_crawler.case.base import Parameters
from exudyn_crawler.case.case import Case
from exudyn_crawler.case.case_file import CaseFile
from exudyn_crawler.case.fields import TAG, Place, key_path, key_paths, models_of, tag_of
from exudyn_crawler.case.plausible import likely_cause

SHOWN = 60
"""Characters of a refused value that an error shows."""


def faults(error: ValidationError, model: type[BaseModel] = Case) -> Iterator[str]:
    """Every fault that a validation found, a line each: the key's path, what is wrong and what is allowed."""
    found = error.errors(include_url=False)
    for one in found:
        loc = tuple(one["loc"])
        within = [other for other in found if other["loc"][: len(loc)] == loc and other is not one]
        if one["type"] == "too_short" and within:
            continue  # what is in the list is at fault, not how much
        yield _told(one, model)


class _Spot(NamedTuple):
    """Where a fault is.

    `place` is as a file has it, `table` the class of the table there, `others` are those that it might be of
    instead, `held` those of the field.
    """

    place: Place
    table: type[BaseModel]
    others: tuple[type[BaseModel], ...]
    held: tuple[type[BaseModel], ...]


def _spot(loc: Place, model: type[BaseModel]) -> _Spot:
    """Where pydantic's place is, which names the tag of a part that may be of several classes, too."""
    spot = _Spot((), model, (), (model,))
    instead: tuple[type[BaseModel], ...] = ()
    for part in loc:
        if isinstance(part, int):
            spot = spot._replace(place=(*spot.place, part))
            continue
        tagged = [kind for kind in spot.held if len(spot.held) > 1 and tag_of(kind) == part]
        if tagged:
            instead = tuple(kind for kind in spot.held if kind not in tagged)
            spot = spot._replace(held=tuple(tagged))
            continue
        table = spot.held[0] if spot.held else spot.table
        field = table.model_fields.get(part)
        spot = _Spot((*spot.place, part), table, instead, models_of(field.annotation) if field else ())
        instead = ()
    return spot


def _told(one: ErrorDetails, model: type[BaseModel]) -> str:
    loc = tuple(one["loc"])
    in_file = model is CaseFile
    # a file has the fields of the case beside its own
    spot = _spot(loc[1:], Case) if in_file and loc[:1] == ("case",) else _spot(loc, model)
    path = key_path(spot.place)
    message = one["msg"].removeprefix("Value error, ").replace("be an object", "be a table")
    if one["type"] == "extra_forbidden":
        return f"{path}: {_unknown(spot, in_file)}"
    if one["type"] == "missing":
        return f"{path}: missing; give it, or a base for what is left out"
    if one["type"] == "value_error":
        return f"{path}: {message}" if path else message
    if one["type"] in ("union_tag_invalid", "union_tag_not_found"):
        given = one["input"].get(TAG) if isinstance(one["input"], dict) else one["input"]
        allowed = " or ".join(repr(tag_of(kind)) for kind in spot.held)
        return f"{path}.{TAG}: Input should be {allowed}, got {shown(given)}"
    return f"{path}: {message}, got {shown(one['input'])}{_cause(one, spot)}"


def _cause(one: ErrorDetails, spot: _Spot) -> str:
    """Unit that a number beyond its bounds is likely in; empty for other faults."""
    name = next((part for part in reversed(spot.place) if isinstance(part, str)), "")
    field, given = spot.table.model_fields.get(name), one["input"]
    beyond = one["type"].startswith(("less_than", "greater_than"))
    if not beyond or field is None or not isinstance(given, int | float):
        return ""
    return likely_cause(float(given), field)


def _unknown(spot: _Spot, in_file: bool) -> str:
    """Hint at the name that was meant: of the same table if one is near, else of another."""
    wrong, start = str(spot.place[-1]), spot.place[:-1]
    for other in spot.others:
        if wrong in other.model_fields:
            return f"unknown key with {TAG} = {tag_of(spot.table)!r}; {TAG} = {tag_of(other)!r} has it"
    names = list(spot.table.model_fields)
    if spot.table is Case and in_file:
        names += [name for name in CaseFile.model_fields if name != "case"]
    if near := difflib.get_close_matches(wrong, names, n=1, cutoff=0.7):
        return f"unknown key; did you mean {key_path((*start, near[0]))}?"
    # of several the first
    elsewhere = {path.rpartition(".")[2]: path for path in reversed([*key_paths(Case)])}
    if near := difflib.get_close_matches(wrong, elsewhere, n=1, cutoff=0.7):
        return f"unknown key; did you mean {elsewhere[near[0]]}?"
    near = difflib.get_close_matches(wrong, names, n=1, cutoff=0.0) or names[:1]
    return f"unknown key; the nearest is {near[0]}, allowed are {', '.join(names)}"


def validated_model(error: ValidationError) -> type[BaseModel]:
    """Parameter class whose construction failed."""
    return next((kind for kind in Parameters.__subclasses__() if kind.__name__ == error.title), Case)


def shown(value: object) -> str:
    """Value as an error shows it, on one line and cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN else text[: SHOWN - 4] + " ..."
