"""Fields of the parameter classes: paths, units, and the traversal for files, tables and errors."""

import inspect
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Literal, NamedTuple, TypeGuard, get_args, get_origin

from pydantic import AliasChoices, BaseModel
from pydantic.fields import FieldInfo

from exudyn_crawler.errors import ParameterError

KeyPath = tuple[int | str, ...]  # names and indices that lead to a value: ("loads", "phases", 2, "end")
EVERY = "*"  # index that stands for all items of a list
BASE = "base"  # key of a file: name of the values that complete its table
NONE = "none"  # a file's text for no value, because TOML has no null
TAGS = ("model", "kind")  # names of the field that selects the class of a part
BESIDE = object()
"""Mark in a field's annotation: in a file, the keys of its part stand among those of the owner's table."""
SHOWN = 60  # greatest number of characters of a refused value in an error
NAME = r"[A-Za-z_]\w*(?:\[(?:\d+|\*)\])*"
PATH = re.compile(rf"{NAME}(?:\.{NAME})*", re.ASCII)


def parse_path(text: str) -> KeyPath:
    """Return the names and indices of a path: ("loads", "phases", "*", "end") for ``loads.phases[*].end``."""
    if PATH.fullmatch(text) is None:
        like = "terrain.spring_stiffness or loads.phases[0].end"
        raise ValueError(f"a path must be like {like}, got {text!r}")
    return tuple(int(part) if part.isdigit() else part for part in re.findall(r"\w+|\*", text))


def path_text(path: KeyPath) -> str:
    """Return the text of a path: ``loads.phases[2].end``."""
    text = ""
    for part in path:
        if isinstance(part, int) or part == EVERY:
            text += f"[{part}]"
        else:
            # keys that need quotes in TOML are quoted, so that they cannot break the line
            text += "." + (part if re.fullmatch(r"[\w-]+", part, re.ASCII) else json.dumps(part))
    return text.lstrip(".")


def names_of(path: KeyPath) -> list[str]:
    """Return the names on a path, without the indices."""
    return [part for part in path if isinstance(part, str) and part != EVERY]


def with_change(
    values: Any,
    path: KeyPath,
    change: Callable[[Any], Any],
    kind: type[BaseModel] | None = None,
    above: KeyPath = (),
) -> Any:
    """Return a copy in which `change` replaces the value at a path, or each value that ``*`` stands for.

    Parameter objects on the path become tables of their fields, to be validated again. A missing key is
    added; `change` then gets None. `kind` is the class of `values`; one of its parts may have its keys among
    those of the class. Raises `ValueError`, with the path `above`, for a missing item or table.
    """
    if not path:
        return change(values)
    if kind is not None:
        path = present_path(kind, path)
    part = path[0]
    below = path[1:]
    if isinstance(part, int) or part == EVERY:
        if not isinstance(values, list | tuple):
            raise ValueError(f"{path_text(above)} must be a list to change an item of it")
        items = list(values)
        for number in range(len(items)) if part == EVERY else [int(part)]:
            if number >= len(items):
                raise ValueError(
                    f"{path_text(above)} has {len(items)} items, counted from 0: there is no [{number}]"
                )
            items[number] = with_change(items[number], below, change, above=(*above, number))
        return type(values)(items)
    table = dict(iter(values)) if isinstance(values, BaseModel) else values
    if not isinstance(table, dict):
        raise ValueError(f"{path_text(above)} must be a table to change a value of it, got {shown(values)}")
    if kind is not None and (name := beside(kind)) and (part == name or part not in kind.model_fields):
        return table | {name: with_change(table[name], path, change)}
    before = table.get(part, {} if below and isinstance(below[0], str) and below[0] != EVERY else None)
    return table | {part: with_change(before, below, change, above=(*above, part))}


def with_value(values: Any, path: KeyPath, value: Any, kind: type[BaseModel] | None = None) -> Any:
    """Return a copy with another value at a path; see `with_change`."""
    return with_change(values, path, lambda _before: value, kind)


@contextmanager
def errors_at(key: str) -> Iterator[None]:
    """Raise errors of the block as `ParameterError` with `key`, the path as written, before each line."""
    try:
        yield
    except ValueError as error:
        raise ParameterError("\n".join(f"{key}: {line}" for line in lines_of(error))) from error


def lines_of(error: ValueError) -> list[str]:
    """Return a line for each fault of an error."""
    return error.errors if isinstance(error, ParameterError) else [str(error)]


def beside(kind: type[BaseModel]) -> str:
    """Return the field whose keys stand among those of its class in a file; empty if there is none."""
    return next((name for name, field in kind.model_fields.items() if BESIDE in field.metadata), "")


def file_fields(kind: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the fields of a class by their keys in a file."""
    name = beside(kind)
    infos = dict(kind.model_fields)
    return file_fields(models_of(infos.pop(name).annotation)[0]) | infos if name else infos


def renamed_keys(kind: type[BaseModel]) -> dict[str, str]:
    """Return the keys of older files of a class, each with the present place of its value."""
    name = beside(kind)
    inner = renamed_keys(models_of(kind.model_fields[name].annotation)[0]) if name else {}
    return inner | getattr(kind, "renamed", {})


def key_paths(kind: type[BaseModel], start: str = "") -> Iterator[str]:
    """Yield the paths of all values that a parameter class may have in a file, each once."""
    for name, field in file_fields(kind).items():
        parts = models_of(field.annotation)
        below = (path for part in parts for path in key_paths(part, f"{start}{name}."))
        yield from dict.fromkeys(below if parts else [f"{start}{name}"])


def present_name(kind: type[BaseModel], key: str) -> str:
    """Return the name of a field of a class for its key in a file, which may be that of earlier versions."""
    for name, field in kind.model_fields.items():
        alias = field.validation_alias
        if isinstance(alias, AliasChoices) and key in alias.choices:
            return name
    return key


def present_path(kind: type[BaseModel], path: KeyPath) -> KeyPath:
    """Return a path in a class or its file with the present names of its fields."""
    kinds: tuple[type[BaseModel], ...] = (kind,)
    found: list[int | str] = []
    for part in path:
        if isinstance(part, str) and part != EVERY:
            part = next((name for one in kinds if (name := present_name(one, part)) != part), part)
            tables = [{**one.model_fields, **file_fields(one)} for one in kinds]
            field = next((table[part] for table in tables if part in table), None)
            kinds = () if field is None else models_of(field.annotation)
        found.append(part)
    return tuple(found)


def unit_at(kind: type[BaseModel], path: KeyPath) -> str | None:
    """Return the unit of a value at a path of a class; None if it is not a quantity with one unit."""
    kinds: tuple[type[BaseModel], ...] = (kind,)
    unit: str | None = None
    for name in names_of(path):
        if any(getattr(one, "is_value", False) for one in kinds):
            # values over time have the unit of their field
            unit = "s" if name == "times" else unit
            continue
        field = next((known[name] for known in map(file_fields, kinds) if name in known), None)
        if field is None:
            return None
        kinds = models_of(field.annotation)
        unit = unit_of(field) if has_unit(field) and "exponent" not in unit_of(field) else None
    return unit


def models_of(annotation: Any) -> tuple[type[BaseModel], ...]:
    """Return the parameter classes that an annotation allows; empty for plain values."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        # a class with plugged-in classes lists them
        return tuple(annotation.plugged_in()) if hasattr(annotation, "plugged_in") else (annotation,)
    return tuple(model for part in get_args(annotation) for model in models_of(part))


def literals(annotation: Any) -> list[Any]:
    """Return the values of all literals in an annotation."""
    if get_origin(annotation) is Literal:
        return list(get_args(annotation))
    return [choice for part in get_args(annotation) for choice in literals(part)]


def tag_field(kind: type[BaseModel]) -> str:
    """Return the field that selects a class among the alternatives of a part."""
    return next(name for name in TAGS if name in kind.model_fields)


def tag_of(kind: type[BaseModel]) -> str:
    """Return the value that selects a class among the alternatives of a part."""
    return str(kind.model_fields[tag_field(kind)].default)


def allows_none(annotation: Any) -> bool:
    """Return whether a field may have no value."""
    return type(None) in get_args(annotation)


def named_values(kind: type[BaseModel]) -> dict[str, Callable[[], BaseModel]]:
    """Return the constructors of a parameter class that need no argument, by name, as ``Terrain.stress``."""
    parts = reversed(kind.__mro__[: kind.__mro__.index(BaseModel)])
    members = {name: member for part in parts for name, member in vars(part).items()}
    names = [name for name, member in members.items() if isinstance(member, classmethod) and name[0] != "_"]
    makers = {name: getattr(kind, name) for name in names}
    arguments = {name: inspect.signature(make).parameters.values() for name, make in makers.items()}
    empty = inspect.Parameter.empty
    return {
        name: makers[name]
        for name in names
        if all(argument.default is not empty for argument in arguments[name])
    }


class Item(NamedTuple):
    """Table or value of a case: its path, its field and its content."""

    place: KeyPath
    field: FieldInfo
    value: Any

    @property
    def path(self) -> str:
        """Text of the path: ``loads.phases[2].end``."""
        return path_text(self.place)

    @property
    def unit(self) -> str:
        """Unit of the field; empty if it has none."""
        return unit_of(self.field)

    @property
    def meaning(self) -> str:
        """Description of the field, else of its parameter class."""
        kinds = [type(self.value)] if isinstance(self.value, BaseModel) else models_of(self.field.annotation)
        about = (inspect.getdoc(kinds[0]) or "") if kinds else ""
        return self.field.description or about.split("\n\n")[0].replace("\n", " ")


def walk(model: BaseModel, place: KeyPath = ()) -> Iterator[Item]:
    """Yield every table and value of a parameter object, in order.

    A table comes before its content, and values come before tables. A quantity over time is a value.
    """
    values = dict(iter(model))
    tables = []
    if name := beside(type(model)):
        values = dict(iter(values.pop(name))) | values
    for name, field in file_fields(type(model)).items():
        entry = Item((*place, name), field, values[name])
        if is_table(entry.value):
            tables.append(entry)
        elif isinstance(entry.value, tuple) and any(map(is_table, entry.value)):
            tables += [Item((*entry.place, k), field, part) for k, part in enumerate(entry.value)]
        else:
            yield entry
    for table in tables:
        yield table
        yield from walk(table.value, table.place)


def entry_at(model: BaseModel, path: KeyPath) -> Item | None:
    """Return the table or value at a path, else the value that is the list of the path; None if neither."""
    place = tuple(0 if part == EVERY else part for part in present_path(type(model), path))
    entries = {entry.place: entry for entry in walk(model)}
    while place not in entries and place and isinstance(place[-1], int):
        place = place[:-1]
    return entries.get(place)


def is_table(value: object) -> bool:
    """Return whether a value has a table of its own; a quantity over time has none."""
    return isinstance(value, BaseModel) and not getattr(value, "is_value", False)


def is_number(value: object) -> TypeGuard[int | float]:
    """Return whether a value is a number; true and false are not."""
    return isinstance(value, int | float) and not isinstance(value, bool)


ENGINEERING = (
    *(("N( m)?$", "k", 1e3), ("Pa", "G", 1e10), ("Pa", "M", 1e6), ("Pa", "k", 1e3)),
    *(("N/|N s", "M", 1e6), ("N/|N s", "k", 1e3)),
)
"""Units with prefix for readers, such as kN, MPa, MN/m: start of the unit, prefix, least number with it."""
PREFIXES = {"": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}


def prefix_of(value: object, unit: str) -> str:
    """Return the prefix of the unit for a number, or for the greatest of a list; may be empty."""
    numbers = value if isinstance(value, tuple | list) else [value]
    greatest = max((abs(number) for number in numbers if is_number(number)), default=0.0)
    return next(
        (prefix for start, prefix, least in ENGINEERING if re.match(start, unit) and greatest >= least), ""
    )


def shown(value: object) -> str:
    """Return the text of a value for an error: one line, cut at `SHOWN` characters."""
    text = " ".join(repr(value).split())
    if len(text) <= SHOWN:
        return text
    many = f" ({len(value)} values)" if isinstance(value, list | tuple) and len(value) > 1 else ""
    return f"{text[: SHOWN - 4]} ...{many}"


def value_text(value: object, unit: str = "") -> str:
    """Return the text of a value for readers, with its unit if one is given; equal numbers once."""
    if not unit or value is None or value == () or isinstance(value, str | bool):
        return _scaled_text(value)
    prefix = prefix_of(value, unit)
    return f"{_scaled_text(value, PREFIXES[prefix])} {prefix}{unit}"


def _scaled_text(value: object, size: float = 1.0) -> str:
    """Return the text of a value, or of a list of values, divided by a unit's size."""
    if isinstance(value, tuple | list) and value:
        if len(value) > 3 and all(element == value[0] for element in value):
            return f"{len(value)} x {_scaled_text(value[0], size)}"
        return ", ".join(_scaled_text(element, size) for element in value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        value /= size
        return number_text(float(f"{value:.10g}")) if abs(value) >= 1e6 else f"{value:.8g}"
    return NONE if value is None or value == () else str(value)


def number_text(value: float) -> str:
    """Return the shortest text that reads back as the same number: ``20e6``, not ``20000000.0``."""
    for power in (9, 6, 3) if abs(value) >= 1e6 else ():
        text = f"{value / 10.0**power:.6g}e{power}"
        if abs(value) >= 10.0**power and "e" not in text[:-2] and float(text) == value:
            return text
    return repr(value)


READ_IN: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "mm": 1e-3},
    "kg": {"t": 1e3, "kg": 1.0},
    "N": {"MN": 1e6, "kN": 1e3, "N": 1.0},
    "Pa": {"MPa": 1e6, "kPa": 1e3, "Pa": 1.0},
    "W": {"MW": 1e6, "kW": 1e3, "W": 1.0},
    "N m": {"kN m": 1e3, "N m": 1.0},
}
"""Units for readers, greatest first, with their size in the SI unit."""


def in_units(value: float, units: Mapping[str, float], digits: int = 3) -> str:
    """Return the text of a number in the first unit (greatest first) that is not above it, else the last."""
    unit = unit_among(value, units)
    return f"{value / units[unit]:.{digits}g} {unit}"


def unit_among(value: float, units: Mapping[str, float]) -> str:
    """Return the first unit (greatest first) that is not above a value, else the last."""
    return next((name for name, size in units.items() if abs(value) >= size), [*units][-1])


def quantity_text(value: float, unit: str) -> str:
    """Return the text of a quantity with four digits and a unit for readers: 35.37 t, 140 mm."""
    return span_text(value, value, unit)


def span_text(least: float, greatest: float, unit: str) -> str:
    """Return the text of a span with four digits, in the unit of its end: 0.8188 to 4.094 m."""
    units = READ_IN.get(unit, {unit: 1.0})
    name = unit_among(greatest, units)
    texts = dict.fromkeys(four_digits(value / units[name]) for value in (least, greatest))
    return f"{' to '.join(texts)} {name}".rstrip()


def four_digits(value: float) -> str:
    """Return the text of a number with four digits, without an exponent up to six places."""
    return f"{float(f'{value:.4g}'):g}"


class Row(NamedTuple):
    """Row of a table for readers: key, value and meaning."""

    key: str
    value: str  # with its unit
    meaning: str


def values_of(case: BaseModel) -> Iterator[Item]:
    """Yield every value of a case or a case file."""
    return (entry for entry in walk(case) if not is_table(entry.value))


def case_rows(case: BaseModel) -> list[Row]:
    """Return every value of a case or a case file as rows for readers."""
    return [Row(entry.path, value_text(entry.value, entry.unit), entry.meaning) for entry in values_of(case)]


MISTAKEN: dict[str, dict[str, float]] = {
    "": {"%": 0.01},
    "m": {"mm": 1e-3, "cm": 1e-2, "inch": 0.0254, "ft": 0.3048},
    "m/s": {"km/h": 1.0 / 3.6, "mm/s": 1e-3},
    "m/s2": {"mm/s2": 1e-3},
    "rad/s": {"deg/s": math.pi / 180.0},
    "s": {"ms": 1e-3},
    "kg": {"t": 1e3, "g": 1e-3},
    "W": {"kW": 1e3, "hp": 745.7},
    "kg/m3": {"t/m3": 1e3, "t/mm3": 1e12},
    "N": {"kN": 1e3},
    "N m": {"kN m": 1e3},
    "N/m": {"MN/m": 1e6, "kN/m": 1e3},
    "N s/m": {"kN s/m": 1e3},
    "Pa": {"MPa": 1e6, "GPa": 1e9, "kPa": 1e3},
    "Hz": {"kHz": 1e3},
}
"""Other units in which users give numbers, by mistake or as texts, with their size in the field's unit."""


TENS = (10.0, 0.1, 100.0, 0.01, 1e3, 1e-3)
"""Candidate factors for a slipped decimal point."""


def _extra(field: FieldInfo) -> dict[str, Any]:
    return field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}


def has_unit(field: FieldInfo) -> bool:
    """Return whether a field is a quantity; a plain number counts as one if its unit is given as 1."""
    return "unit" in _extra(field)


def unit_of(field: FieldInfo) -> str:
    """Return the unit of a field; empty if it has none."""
    unit = _extra(field).get("unit", "")
    return "" if unit == "1" else unit


def in_place(field: FieldInfo) -> str:
    """Describe the alternative that a file may have in place of a field's value; empty if there is none."""
    of_class = (getattr(kind, "in_place", "") for kind in models_of(field.annotation))
    return _extra(field).get("in_place") or next(filter(None, of_class), "")


def plausible_range(field: FieldInfo) -> tuple[float, float] | None:
    """Return the least and greatest plausible value of a field; None if it has no such range."""
    bounds = _extra(field).get("plausible")
    return bounds and tuple(bounds)


def likely_cause(value: float, field: FieldInfo) -> str:
    """Describe the units in which a value would be plausible; empty if there are none."""
    span = plausible_range(field) or (value, value)
    if not value or span[0] <= value <= span[1]:
        return ""
    unit = unit_of(field)
    likely = " or ".join(_likely_units(value, unit, span))
    return (
        f"; is it in {likely}? It has to be {f'in {unit}' if unit else 'a fraction of 1'}" if likely else ""
    )


def _likely_units(value: float, unit: str, span: tuple[float, float]) -> list[str]:
    """Return the other units in which a number lies within a span, which is in the field's unit."""
    return [name for name, size in MISTAKEN.get(unit, {}).items() if span[0] <= value * size <= span[1]]


def meant(value: float, unit: str, span: tuple[float, float]) -> str:
    """Suggest a likely meaning of a value outside a span: another unit, or a slipped decimal point."""
    likely = [f"{four_digits(value)} {name}" for name in _likely_units(value, unit, span)]
    if not likely:
        tens = [value * power for power in TENS if span[0] <= value * power <= span[1]]
        units = READ_IN.get(unit, {unit: 1.0})
        name = unit_among(value, units)
        likely = [f"{four_digits(ten / units[name])} {name}".rstrip() for ten in tens[:1]]
    return f"; did you mean {' or '.join(likely)}?" if likely else ""
