"""Error lines for refused values: one line a fault, with its path, the allowed values and the given value."""

import difflib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from types import UnionType
from typing import Any, NamedTuple, Union, get_args, get_origin

import pydantic
from pydantic.fields import FieldInfo

from exudyn_crawler.errors import ParameterError
from exudyn_crawler.settings import fields, sentences, units

MOST_ERRORS = 100  # greatest number of errors in a report
LISTED = 300  # characters after which a list of allowed names is cut
NAMED = 5  # greatest number of missing values that a line names
MOST_UNKNOWN = 20  # greatest number of unknown keys that a line names
MOST_HOMES = 3  # greatest number of tables that a line names as the place of a key
LISTED_BY = "listed_by"  # attribute of a class: the command that lists its keys
TYPED = "typed"
"""Key of a fault for its input as the file spells it."""
OF_TABLES = ("missing", "extra_forbidden")
TAGGED = ("union_tag_invalid", "union_tag_not_found")
"""Types of errors of the key that selects the class of a part."""
OF_CLASS = ("model_type", "model_attributes_type", *TAGGED)
"""Types of errors of a value that is not a table of a field's classes."""
PROFILE = "values over time, such as {{times = [0, 5], values = [0, 0.1]}} (numbers in {units})"
OF_LIST = re.compile(r"([\w.\[\]]+\[)(\d+)(\]: .*)")
"""Error line of a list item: text before the item's number, number, text behind it."""


class Spot(NamedTuple):
    """Location of an error: path in the file, class of the table, field, and classes of the field's value."""

    place: fields.KeyPath  # path in the file
    table: type[pydantic.BaseModel]  # class of the table that has the key
    field: FieldInfo | None
    held: tuple[type[pydantic.BaseModel], ...]  # candidate classes of the field's value
    choice: fields.KeyPath | None = None  # path of a value with several allowed kinds, such as text or list


Pair = tuple[Spot, Mapping[str, Any]]
"""Location and pydantic's fault."""


def error_lines(
    error: pydantic.ValidationError,
    model: type[pydantic.BaseModel],
    typed: Mapping[str, Any] | None = None,
    above: fields.KeyPath = (),
) -> Iterator[str]:
    """Yield a line with its path for each error of a validation of `model`.

    `typed` holds the values as the file spells them. The lines quote these texts in place of the converted
    numbers. `above` is the path of the validated part if it is not the whole file.
    """
    places = [fault | {"loc": (*above, *fault["loc"])} for fault in error.errors(include_url=False)]
    faults = [fault | {TYPED: _typed(fault, model, typed or {})} for fault in places]
    lines = list(_joined(dict.fromkeys(" ".join(line.split()) for line in _lines(faults, model))))
    yield from lines[:MOST_ERRORS]
    if len(lines) > MOST_ERRORS:
        yield f"{len(lines) - MOST_ERRORS} more errors"


def _typed(fault: Mapping[str, Any], model: type[pydantic.BaseModel], values: Any) -> Any:
    """Return the refused value as the file spells it, if that text has the refused number."""
    spot = _spot(fault["loc"], model)
    value = fault["input"]
    for part in spot.place:
        if isinstance(values, str):
            return value
        try:
            values = values[part]
        except (KeyError, IndexError, TypeError):  # derived from other values
            return value
    if not isinstance(values, str) or not isinstance(value, float) or spot.field is None:
        return value
    unit = fields.unit_of(spot.field)
    if value in (units.number_of(text, unit) for text in (values, *units.candidate_texts(values))):
        return values
    # the number was derived from another text; four digits are enough
    return float(f"{value:.4g}")


def _joined(lines: Iterable[str]) -> Iterator[str]:
    """Yield the lines, with equal faults of adjacent list items merged into one line."""
    for (head, tail, _), group in groupby(enumerate(lines), key=_run_of):
        together = [line for _, line in group]
        if len(together) == 1:
            yield together[0]
        else:
            first, last = (line.removeprefix(head).partition("]")[0] for line in (together[0], together[-1]))
            yield f"{head}{first}..{last}{tail}"


def _run_of(numbered: tuple[int, str]) -> tuple[str, str, int]:
    """Return a line's text before and behind its list index, and a number equal for consecutive indices."""
    number, line = numbered
    match = OF_LIST.fullmatch(line)
    return (match[1], match[3], int(match[2]) - number) if match else ("", line, 0)


def _lines(faults: Sequence[Mapping[str, Any]], model: type[pydantic.BaseModel]) -> Iterator[str]:
    """Yield the lines of pydantic's faults in their order.

    Faults of one value with several allowed kinds share a line, and so do missing or unknown keys of a table.
    """
    spots = [(_spot(fault["loc"], model), fault) for fault in faults]
    # the missing values of a class with bases are not adjacent in pydantic's order
    keys = [_together(pair) for pair in spots]
    order = [keys.index(key) if key[1] is not None else number for number, key in enumerate(keys)]
    spots = [spots[number] for number in sorted(range(len(spots)), key=order.__getitem__)]
    for (choice, table), group in groupby(spots, key=_together):
        together = list(group)
        if choice is not None:
            yield from _of_choice(choice, together, model)
        elif table is not None and len(together) > 1:
            found = [spot for spot, _ in together]
            if table[1] == "missing":
                yield f"{_names(table[0], found)} are missing{_start_from(found[0].table, 'them')}"
            else:
                yield _all_unknown(table[0], found, model)
        else:
            for spot, fault in together:
                # refused items are absent from a list, which then counts as too short
                loc = fault["loc"]
                inside = (other for other in faults if other["loc"][: len(loc)] == loc and other is not fault)
                if fault["type"] != "too_short" or not any(inside):
                    yield from _messages(spot, fault, model)


def _of_choice(
    choice: fields.KeyPath, together: Sequence[Pair], model: type[pydantic.BaseModel]
) -> Iterator[str]:
    """Yield the lines of a value with several allowed kinds: the faults within one kind, else all kinds."""
    inner = [pair for pair in together if pair[0].place != choice or pair[1]["type"] not in sentences.OF_KIND]
    if inner:
        for spot, fault in inner:
            yield from _messages(spot, fault, model)
        return
    first, *others = dict.fromkeys(_sentence(spot, fault) for spot, fault in together)
    words = " or ".join([first, *(word.removeprefix("must be ") for word in others)])
    yield f"{fields.path_text(choice)}: {words}, got {fields.shown(together[0][1]['input'])}"


def _together(pair: Pair) -> tuple[fields.KeyPath | None, tuple[fields.KeyPath, str] | None]:
    """Return the group of a fault whose members share one line.

    The group is the path of a value with several allowed kinds, and the path of a table with the type of the
    fault: missing or unknown keys.
    """
    spot, fault = pair
    is_of_table = fault["type"] in OF_TABLES and spot.place and isinstance(spot.place[-1], str)
    return spot.choice, (spot.place[:-1], fault["type"]) if is_of_table else None


def _all_unknown(table: fields.KeyPath, spots: Sequence[Spot], model: type[pydantic.BaseModel]) -> str:
    """Return the line of several unknown keys of a table; only the keys of older files if there are any."""
    renamed = fields.renamed_keys(model) if not table else {}
    if older := [name for name in _last_names(spots) if name in renamed]:
        return "; ".join(f"{name} {renamed[name]}" for name in older)
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
    """Describe the right table of a misplaced key; empty if no table has the key.

    If the key resembles one of those `allowed` in its table, it is a misspelling and not misplaced.
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
    """Return the names as a list that is cut at `LISTED` characters, with the command that lists all."""
    shown: list[str] = []
    for name in names:
        if sum(len(other) + 2 for other in shown) > LISTED:
            how = f"; {listed_by} lists them" if listed_by else ""
            return f"{', '.join(shown)} and {len(names) - len(shown)} more{how}"
        shown.append(name)
    return ", ".join(shown)


def _names(table: fields.KeyPath, spots: Sequence[Spot], most: int = NAMED) -> str:
    """Return the path of a table and at most `most` of the keys at the given locations in it."""
    names = _last_names(spots)
    more = f" and {len(names) - most} more" if len(names) > most else ""
    head = f"{fields.path_text(table)}: " if table else ""
    return f"{head}{', '.join(names[:most])}{more}"


def _last_names(spots: Sequence[Spot]) -> list[str]:
    """Return the last name on the path of each location."""
    return [str(spot.place[-1]) for spot in spots]


def _start_from(table: type[pydantic.BaseModel], what: str) -> str:
    """Describe the source of a table's missing values; empty if its class has no named values."""
    names = " or ".join(f'"{name}"' for name in fields.named_values(table))
    return f"; give {what}, or start from {names}" if names else ""


def _spot(loc: fields.KeyPath, model: type[pydantic.BaseModel]) -> Spot:
    """Return the location of pydantic's path, without the class or kind that pydantic tried."""
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
    """Return whether a field allows several kinds of values, none of them a table."""
    if spot.field is None or spot.held:
        return False
    if get_origin(spot.field.annotation) not in (Union, UnionType):
        return False
    return sum(kind is not type(None) for kind in get_args(spot.field.annotation)) > 1


def _messages(spot: Spot, fault: Mapping[str, Any], model: type[pydantic.BaseModel]) -> Iterator[str]:
    """Yield the line of a fault, or the lines of a part whose construction raised a `ParameterError`."""
    path = fields.path_text(spot.place)
    cause = fault.get("ctx", {}).get("error")
    if isinstance(cause, ParameterError):
        yield from (f"{path}.{line}" for line in cause.errors)
    else:
        yield _message(spot, fault, model, path)


def _message(spot: Spot, fault: Mapping[str, Any], model: type[pydantic.BaseModel], path: str) -> str:
    """Return the line of a fault at a path."""
    kind = fault["type"]
    if kind == "extra_forbidden":
        return f"{path}: {_unknown(spot, model)}"
    if kind == "missing":
        return f"{path}: {_missing(spot, fault)}"
    if kind == "value_error":
        # a contradiction within the whole content names its paths itself
        return f"{path}: {fault['ctx']['error']}" if path else str(fault["ctx"]["error"])
    if kind in TAGGED and isinstance(fault["input"], dict):
        tags = " or ".join(repr(fields.tag_of(held)) for held in spot.held)
        tag = fields.tag_field(spot.held[0])
        got = fields.shown(fault["input"].get(tag))
        return f"{fields.path_text((*spot.place, tag))}: must be {tags}, got {got}"
    # a part whose values stand among those of its owner has no path in the file
    path = path or fields.path_text(fault["loc"])
    return f"{path}: {_wanted(spot, fault)}, got {fields.shown(fault[TYPED])}{_cause(spot, fault)}"


def _wanted(spot: Spot, fault: Mapping[str, Any]) -> str:
    """Describe the allowed value: the sentence of the error, and the field's alternative if it has one."""
    kind = fault["type"]
    unit = fields.unit_of(spot.field) if spot.field else ""
    words = _sentence(spot, fault)
    if kind in OF_CLASS:
        words = f"must be {_table(spot, unit)}"
    elif kind == "float_type" and isinstance(fault["input"], str):
        words = _number_words(unit)
    elif spot.field and fields.has_unit(spot.field) and isinstance(fault["input"], str) and not spot.held:
        words += f" of numbers{f' in {unit}' if unit else ''}" if words == sentences.LIST else ""
    of_item = not spot.place or isinstance(spot.place[-1], int)
    other = fields.in_place(spot.field) if spot.field and kind in sentences.OF_KIND and not of_item else ""
    return f"{words}, or {other}" if other else words


def _sentence(spot: Spot, fault: Mapping[str, Any]) -> str:
    """Return the sentence for the type of a fault."""
    return sentences.sentence(fault["type"], fault.get("ctx", {}), spot.field)


def _cause(spot: Spot, fault: Mapping[str, Any]) -> str:
    """Describe the likely meaning of a refused value; empty if none is likely."""
    value = fault["input"]
    if isinstance(value, str) and fault["type"] in sentences.UNREAD:
        return units.hint(value, fields.unit_of(spot.field) if spot.field else "")
    if fault["type"] in sentences.BOUNDED and spot.field and not isinstance(fault[TYPED], str):
        return fields.likely_cause(float(value), spot.field)
    return ""


def _unknown(spot: Spot, model: type[pydantic.BaseModel]) -> str:
    """Describe the right table or the likely meaning of an unknown key."""
    is_of_top = len(spot.place) == 1
    name = str(spot.place[-1])
    allowed = fields.file_fields(model) if is_of_top else spot.table.model_fields
    if home := _home(spot.place, model, allowed):
        return f"unknown key; {home}"
    if is_of_top and (renamed := fields.renamed_keys(model).get(name)):
        return renamed
    if near := difflib.get_close_matches(name, allowed, n=1):
        return f"unknown key; did you mean {fields.path_text((*spot.place[:-1], *near))}?"
    return f"unknown key; allowed are {_listed(allowed, getattr(spot.table, LISTED_BY, ''))}"


def _missing(spot: Spot, fault: Mapping[str, Any]) -> str:
    """Describe the source of a missing value."""
    if spot.place and isinstance(spot.place[-1], int):
        return f"missing, got {fields.shown(fault['input'])}"
    return f"missing{_start_from(spot.table, 'it')}"


def _number_words(unit: str) -> str:
    """Describe the number that a field needs in place of a text."""
    example = f", or such as '1 {next(iter(fields.MISTAKEN[unit]))}'" if unit in fields.MISTAKEN else ""
    return f"{sentences.NUMBER}{f' in {unit}' if unit else ''}{example}"


def _table(spot: Spot, unit: str) -> str:
    """Describe the table, or the values over time, that a field needs."""
    if any(getattr(held, "is_value", False) for held in spot.held):
        return PROFILE.format(units=f"s and {unit}" if unit else "s, and without a unit")
    return f"a table ({' or '.join(held.__name__ for held in spot.held)})"
