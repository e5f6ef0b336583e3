"""Words for what is wrong with values: a line a fault, with its path, what is allowed and what is there."""

import difflib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from types import UnionType
from typing import Any, NamedTuple, Union, get_args, get_origin

import pydantic
from pydantic.fields import FieldInfo

from exudyn_crawler.errors import ParameterError
from exudyn_crawler.settings import fields, units

MOST_ERRORS = 100  # that are named
LISTED = 300  # characters of allowed names, beyond which a list is cut
NAMED = 5  # values that one table lacks which are named
MOST_UNKNOWN = 20  # keys that a table does not know which are named
MOST_HOMES = 3  # tables that have a key, which are named
LISTED_BY = "listed_by"  # of a class: the command that lists its keys
TYPED = "typed"
"""Key of a fault for what was typed in place of its input."""
OF_TABLES = ("missing", "extra_forbidden")
WORDS = (
    *(("a valid number", "a number"), ("a valid integer", "a whole number"), ("a valid string", "a text")),
    *(("a valid boolean", "true or false"), ("a valid array", "a list"), ("a valid tuple", "a list")),
    *(("a valid list", "a list"), (" after validation", ""), ("be an object", "be a table")),
    ("be a valid dictionary", "be a table"),
)
"""Those of pydantic, and what an engineer says."""
PROFILE = "values over time, such as {{times = [0, 5], values = [0, 0.1]}} (numbers in {units})"
OF_LIST = re.compile(r"([\w.\[\]]+\[)(\d+)(\]: .*)")
"""Line of a fault of an item of a list."""
OTHER_KIND = ("_type", "literal_error", "is_instance_of", "enum")
"""Ends of pydantic's names of faults of a value that is of another kind than what is wanted."""


class Spot(NamedTuple):
    """Place of an error."""

    place: fields.KeyPath  # as a file has it
    table: type[pydantic.BaseModel]  # class of the table there
    field: FieldInfo | None
    held: tuple[type[pydantic.BaseModel], ...]  # classes of which the field holds one
    choice: fields.KeyPath | None = None  # place of a value of several kinds, such as text or list


Pair = tuple[Spot, Mapping[str, Any]]
"""Fault of pydantic with its spot."""


def error_lines(
    error: pydantic.ValidationError,
    model: type[pydantic.BaseModel],
    typed: Mapping[str, Any] | None = None,
    above: fields.KeyPath = (),
) -> Iterator[str]:
    """Yield the errors of a validation of the values of `model`, a line each with its path.

    `typed` are the values as a file has them, whose texts are quoted in place of the numbers that they are.
    Values of a part of the model alone are `above` it.
    """
    places = [fault | {"loc": (*above, *fault["loc"])} for fault in error.errors(include_url=False)]
    faults = [fault | {TYPED: _typed(fault, model, typed or {})} for fault in places]
    lines = list(_joined(dict.fromkeys(" ".join(line.split()) for line in _lines(faults, model))))
    yield from lines[:MOST_ERRORS]
    if len(lines) > MOST_ERRORS:
        yield f"{len(lines) - MOST_ERRORS} more errors"


def _typed(fault: Mapping[str, Any], model: type[pydantic.BaseModel], values: Any) -> Any:
    """Return what was typed where a fault is: its text, if that is the number at fault."""
    spot = _spot(fault["loc"], model)
    value = fault["input"]
    for part in spot.place:
        if isinstance(values, str):
            return value
        try:
            values = values[part]
        except (KeyError, IndexError, TypeError):  # it follows from other values
            return value
    if not isinstance(values, str) or not isinstance(value, float) or spot.field is None:
        return value
    unit = fields.unit_of(spot.field)
    if value in (units.number_of(text, unit) for text in (values, *units.likely_texts(values))):
        return values
    # it was made of another text, of whose digits the first say enough
    return float(f"{value:.4g}")


def _joined(lines: Iterable[str]) -> Iterator[str]:
    """Lines in which equal faults of neighbours in a list are one: a load in place of all is wrong once."""
    for (head, tail, _), group in groupby(enumerate(lines), key=_run_of):
        together = [line for _, line in group]
        if len(together) == 1:
            yield together[0]
        else:
            first, last = (line.removeprefix(head).partition("]")[0] for line in (together[0], together[-1]))
            yield f"{head}{first}..{last}{tail}"


def _run_of(numbered: tuple[int, str]) -> tuple[str, str, int]:
    """Line before and behind its place in a list, and a number that rising places share."""
    number, line = numbered
    match = OF_LIST.fullmatch(line)
    return (match[1], match[3], int(match[2]) - number) if match else ("", line, 0)


def _lines(faults: Sequence[Mapping[str, Any]], model: type[pydantic.BaseModel]) -> Iterator[str]:
    """Lines of pydantic's faults, in their order; those of a value of several kinds, or a table, are one."""
    spots = [(_spot(fault["loc"], model), fault) for fault in faults]
    # a table of a class with bases lacks values in several places of the order
    keys = [_together(pair) for pair in spots]
    order = [keys.index(key) if key[1] is not None else number for number, key in enumerate(keys)]
    spots = [spots[number] for number in sorted(range(len(spots)), key=order.__getitem__)]
    for (choice, table), group in groupby(spots, key=_together):
        together = list(group)
        if choice is not None:
            yield from _of_choice(choice, together, model)
        elif table is not None and len(together) > 1:
            say = _all_missing if together[0][1]["type"] == "missing" else _all_unknown
            yield say(table[0], [spot for spot, _ in together], model)
        else:
            for spot, fault in together:
                # what is in a list may be wrong, and not how many
                loc = fault["loc"]
                inside = (other for other in faults if other["loc"][: len(loc)] == loc and other is not fault)
                if fault["type"] != "too_short" or not any(inside):
                    yield from _messages(spot, fault, model)


def _of_choice(
    choice: fields.KeyPath, together: Sequence[Pair], model: type[pydantic.BaseModel]
) -> Iterator[str]:
    """Lines of a value that may be of several kinds: what is wrong within one, else what it may be."""
    inner = [pair for pair in together if pair[0].place != choice or not _is_other_kind(pair[1])]
    if inner:
        for spot, fault in inner:
            yield from _messages(spot, fault, model)
        return
    first, *others = [_wanted(fault) for _, fault in together]
    words = " or ".join([first, *(word.removeprefix("must be ") for word in others)])
    yield f"{fields.path_text(choice)}: {words}, got {fields.shown(together[0][1]['input'])}"


def _together(pair: Pair) -> tuple[fields.KeyPath | None, tuple[fields.KeyPath, str] | None]:
    """Places of a value of several kinds and of a table, whose faults are one line, and what kind it is.

    A table lacks values, or has keys that it does not know.
    """
    spot, fault = pair
    is_of_table = fault["type"] in OF_TABLES and spot.place and isinstance(spot.place[-1], str)
    return spot.choice, (spot.place[:-1], fault["type"]) if is_of_table else None


def _all_missing(table: fields.KeyPath, spots: Sequence[Spot], _model: type[pydantic.BaseModel]) -> str:
    """Line of several values that a table lacks."""
    return f"{_names(table, spots)} are missing{_start_from(spots[0].table, 'them')}"


def _all_unknown(table: fields.KeyPath, spots: Sequence[Spot], model: type[pydantic.BaseModel]) -> str:
    """Line of several keys that a table does not know; those of older files alone, if there are any."""
    renamed = [name for name in _last_names(spots) if name in RENAMED] if not table else []
    if renamed:
        return "; ".join(f"{name} {RENAMED[name]}" for name in renamed)
    allowed = fields.file_fields(model) if not table else spots[0].table.model_fields
    homes = {str(spot.place[-1]): _home(spot.place, model, allowed) for spot in spots[:MOST_UNKNOWN]}
    nearest = {
        name: difflib.get_close_matches(name, allowed, n=1) for name, home in homes.items() if not home
    }
    meant = [f"{name}: {home}; " for name, home in homes.items() if home]
    meant += [f"did you mean {near[0]} for {name}? " for name, near in nearest.items() if near]
    known = _listed(allowed, getattr(spots[0].table, LISTED_BY, ""))
    return f"{_names(table, spots, MOST_UNKNOWN)}: unknown keys; {''.join(meant)}allowed are {known}"


def _home(place: fields.KeyPath, model: type[pydantic.BaseModel], allowed: Collection[str]) -> str:
    """Say where in a file the key belongs that stands at a place; empty where it belongs nowhere.

    In a table that has a similar key among those `allowed`, that one is meant.
    """
    name = str(place[-1])
    if len(place) > 1:
        of_top = fields.file_fields(model).get(name)
        is_of_top = of_top is not None and not fields.models_of(of_top.annotation)
        is_of_top = is_of_top and not difflib.get_close_matches(name, allowed, n=1)
        return "it belongs to the top of the file, before all tables" if is_of_top else ""
    tables = [path.rpartition(".")[0] for path in fields.key_paths(model) if path.rpartition(".")[2] == name]
    if not 0 < len(tables) <= MOST_HOMES:
        return ""
    return f"it belongs into {' or '.join(f'[{table}]' for table in dict.fromkeys(tables))}"


def _listed(names: Collection[str], listed_by: str = "") -> str:
    """Names of a list that is cut where it gets long, with the command that lists all."""
    shown: list[str] = []
    for name in names:
        if sum(len(other) + 2 for other in shown) > LISTED:
            how = f"; {listed_by} lists them" if listed_by else ""
            return f"{', '.join(shown)} and {len(names) - len(shown)} more{how}"
        shown.append(name)
    return ", ".join(shown)


def _names(table: fields.KeyPath, spots: Sequence[Spot], most: int = NAMED) -> str:
    """Return the path of a table and the last names of some places in it, as many as `most`."""
    names = _last_names(spots)
    more = f" and {len(names) - most} more" if len(names) > most else ""
    head = f"{fields.path_text(table)}: " if table else ""
    return f"{head}{', '.join(names[:most])}{more}"


def _last_names(spots: Sequence[Spot]) -> list[str]:
    """Names at the ends of some places."""
    return [str(spot.place[-1]) for spot in spots]


def _start_from(table: type[pydantic.BaseModel], what: str) -> str:
    """Where what a table lacks can come from; empty where it has no named values."""
    names = " or ".join(f'"{name}"' for name in fields.named_values(table))
    return f"; give {what}, or start from {names}" if names else ""


def _is_other_kind(fault: Mapping[str, Any]) -> bool:
    """True where a value is of another kind than what is wanted."""
    return str(fault["type"]).endswith(OTHER_KIND)


def _spot(loc: fields.KeyPath, model: type[pydantic.BaseModel]) -> Spot:
    """Spot of pydantic's place, which also names the class or the kind that was tried of several."""
    spot = Spot((), model, None, (model,))
    for part in loc:
        tagged = [kind for kind in spot.held if len(spot.held) > 1 and fields.tag_of(kind) == part]
        if tagged:
            spot = spot._replace(held=tuple(tagged))
        elif isinstance(part, int):
            spot = spot._replace(place=(*spot.place, part))
        elif spot.choice is None and _has_kinds(spot):
            spot = spot._replace(choice=spot.place)
        else:
            table = spot.held[0] if spot.held else spot.table
            field = table.model_fields.get(part)
            is_beside = part and part == fields.beside(table)
            place = spot.place if is_beside else (*spot.place, part)
            held = fields.models_of(field.annotation) if field else ()
            spot = Spot(place, table, field, held, spot.choice)
    return spot


def _has_kinds(spot: Spot) -> bool:
    """True where a value of a field may be of several kinds, none of them a table."""
    if spot.field is None or spot.held:
        return False
    if get_origin(spot.field.annotation) not in (Union, UnionType):
        return False
    return sum(kind is not type(None) for kind in get_args(spot.field.annotation)) > 1


def _messages(spot: Spot, fault: Mapping[str, Any], model: type[pydantic.BaseModel]) -> Iterator[str]:
    """Lines of a fault: one, or those of a part that was made with faults of its own."""
    path = fields.path_text(spot.place)
    cause = fault.get("ctx", {}).get("error")
    if isinstance(cause, ParameterError):
        yield from (f"{path}.{line}" for line in cause.errors)
    else:
        yield _message(spot, fault, model, f"{path}: " if path else "")


def _message(spot: Spot, fault: Mapping[str, Any], model: type[pydantic.BaseModel], head: str) -> str:
    """Line of a fault, behind its path."""
    kind = fault["type"]
    value = fault["input"]
    if kind == "extra_forbidden":
        allowed = fields.file_fields(model) if len(spot.place) == 1 else spot.table.model_fields
        home = _home(spot.place, model, allowed)
        return head + (
            f"unknown key; {home}"
            if home
            else unknown_key(spot.place, [*allowed], getattr(spot.table, LISTED_BY, ""))
        )
    if kind == "missing":
        return _missing(spot, fault, head)
    if kind == "value_error":
        return head + fault["msg"].removeprefix("Value error, ").partition(", unable to ")[0]
    if kind.startswith("union_tag") and isinstance(value, dict):
        tags = " or ".join(repr(fields.tag_of(held)) for held in spot.held)
        tag = fields.tag_field(spot.held[0])
        return f"{fields.path_text((*spot.place, tag))}: must be {tags}, got {fields.shown(value.get(tag))}"
    unit = fields.unit_of(spot.field) if spot.field else ""
    words = _wanted(fault)
    cause = ""
    if kind.startswith(("model", "union_tag")):
        words = f"must be {_table(spot, unit)}"
    elif kind == "float_type" and isinstance(value, str):
        words = _number_words(unit)
    elif spot.field is not None and fields.has_unit(spot.field) and isinstance(value, str) and not spot.held:
        words = f"{words} of numbers{f' in {unit}' if unit else ''}" if words == "must be a list" else words
    if spot.field is not None and _is_other_kind(fault) and isinstance(spot.place[-1], str):
        other = fields.in_place(spot.field)
        words += f", or {other}" if other else ""
    if isinstance(value, str) and kind.endswith("_type") and kind != "bool_type":
        cause = units.hint(value, unit)
    is_bare = isinstance(value, int | float) and not isinstance(fault[TYPED], str)
    if kind.startswith(("less_than", "greater_than")) and spot.field and is_bare:
        cause = fields.likely_cause(float(value), spot.field)
    return f"{head}{words}, got {fields.shown(fault[TYPED])}{cause}"


def _missing(spot: Spot, fault: Mapping[str, Any], head: str) -> str:
    """Line of a value that is missing, with where one can come from."""
    if spot.place and isinstance(spot.place[-1], int):
        return f"{head}missing, got {fields.shown(fault['input'])}"
    # a part whose values a file has beside the others has no path there
    return f"{head or fields.path_text(fault['loc']) + ': '}missing{_start_from(spot.table, 'it')}"


def _wanted(fault: Mapping[str, Any]) -> str:
    """Say what a value must be, in an engineer's words."""
    words = str(fault["msg"]).partition(", unable to ")[0]
    for word, plain in WORDS:
        words = words.replace(word, plain)
    return re.sub("^[A-Z][a-z]+ should", "must", words)


def _number_words(unit: str) -> str:
    """Say what a number must be where a text stands."""
    example = f", or such as '1 {next(iter(fields.MISTAKEN[unit]))}'" if unit in fields.MISTAKEN else ""
    return f"must be a number{f' in {unit}' if unit else ''}{example}"


def _table(spot: Spot, unit: str) -> str:
    """Say what a table, or values over time, must be."""
    if any(getattr(held, "is_value", False) for held in spot.held):
        return PROFILE.format(units=f"s and {unit}" if unit else "s, and without a unit")
    return f"a table ({' or '.join(held.__name__ for held in spot.held)})"


RENAMED = {
    "undercarriage": "is now [gear] with kind = 'rolled'",
    "closed_track": "is now [gear] with kind = 'closed', or 'machine' for two tracks",
    "car_body": "is now [gear.car_body] of a [gear] with kind = 'machine'",
}
"""Keys of older case files, and where their values are now."""


def unknown_key(path: fields.KeyPath, allowed: Sequence[str], listed_by: str = "") -> str:
    """Say what is wrong with a path whose last name is none of those that are allowed there.

    `listed_by` is the command that lists all of these.
    """
    if len(path) == 1 and path[0] in RENAMED:
        return RENAMED[str(path[0])]
    near = difflib.get_close_matches(str(path[-1]), allowed, n=1)
    meant = fields.path_text((*path[:-1], *near))
    return (
        f"unknown key; did you mean {meant}?"
        if near
        else f"unknown key; allowed are {_listed(allowed, listed_by)}"
    )
