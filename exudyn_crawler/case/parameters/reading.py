"""Files of parameters: TOML whose tables may say only what differs from a `base`, a named constructor.

Within the program all is in SI units. In place of a number a file may have a text with one and a unit:
"20 MN/m" is the number of the field's own unit. Angles are no plain numbers here: revolutions a second are no
hertz, and degrees no slope.
"""

import difflib
import json
import re
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from exudyn_crawler.case.parameters import faults, fields
from exudyn_crawler.errors import CaseFileError

Model = TypeVar("Model", bound=BaseModel)
Content = dict[str, Any]
LINE = re.compile(r"\(at line (\d+),")
"""Place that the reader of TOML names."""
COMMA = re.compile(r"=\s*([+-]?\d+),(\d+)\s*(?:#.*)?$")
"""Number with a decimal comma in a line of TOML."""
PARTING = "[ '\u00a0\u202f]"
"""Marks between thousands that are no decimal marks anywhere."""
NUMBER = rf"[+-]?(?:\d{{1,3}}(?:{PARTING}\d{{3}})+(?:\.\d*)?|\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
NAME = r"[a-zµ°%_]+(?:\^?-?\d(?:\.\d+)?)?"
UNIT = rf"(?:1/)?{NAME}(?:\s*[*/ ]\s*{NAME})*"
TEXT = re.compile(rf"\s*({NUMBER})(?:\s*(?=[a-zµ°%])|\s+(?=1/))({UNIT})\s*", re.IGNORECASE)
POWER = re.compile(r"(?<=[A-Za-zµ°])\^?(-?\d)")  # m3 and s2, as units are written here, too
OPEN_POWER = re.compile(r"\^\(?exponent(?:\+(\d)\))?")  # of a law's modulus, by its exponent
DEFINITIONS = """
centi- = 1/100 = c-
milli- = 1/1000 = m-
micro- = 1/1000000 = µ- = u-
kilo- = 1000 = k-
mega- = 1000000 = M-
giga- = 1000000000 = G-
metre = [length] = m = meter
second = [time] = s
gram = [mass] = g
radian = [angle] = rad
percent = 1/100 = %
minute = 60 * second = min
hour = 3600 * second = h
day = 24 * hour = d
tonne = 1000000 * gram = t
degree = 0.017453292519943295 * radian = deg = °
revolution = 360 * degree = rev
rpm = revolution / minute
hertz = 1 / second = Hz
newton = 1000 * gram * metre / second ** 2 = N
pascal = newton / metre ** 2 = Pa
watt = newton * metre / second = W
horsepower = 745.6998715822702 * watt = hp
metric_horsepower = 735.49875 * watt = PS
kilogram_force = 9.80665 * newton = kgf
short_ton = 907184.74 * gram
bar = 100000 * pascal
inch = 0.0254 * metre = in
foot = 12 * inch = ft = feet
mile = 5280 * foot = mi
mph = mile / hour
kph = 1000 * metre / hour
pound = 453.59237 * gram = lb
pound_force = 4.4482216152605 * newton = lbf
psi = pound_force / inch ** 2
"""


def read_parameters(
    path: str | Path, kind: type[Model], name: str, values: Callable[[Content], Content]
) -> Model:
    """Parameter object of a file of a kind `name`; `values` makes its content values; or `CaseFileError`."""
    path = Path(path)
    with errors_named(path, kind):
        return from_content(kind, values(toml_content(path, name)), path.parent)


def toml_content(path: Path, name: str) -> Content:
    """Content of a TOML file; raises `FileNotFoundError` or, without the path, `ValueError` if it is none."""
    if not path.is_file():
        raise FileNotFoundError(f"{path} is a folder, no {name}" if path.is_dir() else f"no {name} {path}")
    # some editors put a mark before the text
    return content_of(path.read_bytes(), "utf-8-sig")


def content_of(source: str | bytes, coding: str = "utf-8") -> Content:
    """Content of TOML, a text or bytes in a coding; ValueError if it is none."""
    text = source if isinstance(source, str) else ""
    try:
        text = source if isinstance(source, str) else source.decode(coding)
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        message = str(error).replace("Cannot overwrite a value", "this key or table stands twice")
        raise ValueError(f"not TOML: {message}{_decimal_comma(text, message)}") from error


def _decimal_comma(text: str, message: str) -> str:
    """Hint at a decimal comma in the line of a text that an error of its reader names; empty if none is."""
    line = LINE.search(message)
    comma = COMMA.search(text.splitlines()[int(line[1]) - 1]) if line else None
    return f"; numbers have a point: {comma[1]}.{comma[2]}" if comma else ""


@contextmanager
def errors_named(path: Path, kind: type[BaseModel]) -> Iterator[None]:
    """Make what is wrong with the content of a file, of a parameter class, a `CaseFileError`."""
    try:
        yield
    except ValidationError as error:
        raise CaseFileError(path, list(faults.error_lines(error, kind))) from None
    except CaseFileError:  # of another file that this one names
        raise
    except (ValueError, RecursionError) as error:
        raise CaseFileError(path, [str(error)]) from error


def from_content(kind: type[Model], content: Content, folder: Path | None = None) -> Model:
    """Parameter object of the content of a file in a folder; `ValidationError` for what is not allowed."""
    # strict JSON takes lists for tuples and whole numbers for any, but no text for numbers; it has no type
    # for TOML's dates and times, which no field takes
    text = json.dumps(filled(content, kind), default=lambda value: {"date or time": str(value)})
    return kind.model_validate_json(text, strict=True, context=folder)


def filled(
    content: Content,
    *kinds: type[BaseModel],
    below: Content | None = None,
    path: fields.KeyPath = (),
    unit: str = "",
) -> Content:
    """Values of a table of one of the classes over its base, or over the values `below` it.

    Texts with units become numbers and "none" no value; what is filled already stays as it is. `unit` is that
    of values over time.
    """
    below = below or {}
    values = dict(below)
    kind = kinds[0]
    if len(kinds) > 1:
        tag_field = fields.tag_field(kind)
        tag = content.get(tag_field, below.get(tag_field))
        kind = next((model for model in kinds if fields.tag_of(model) == tag), kind)
        # values of another class say nothing of this one
        values = values if below.get(tag_field) == fields.tag_of(kind) else {}
    if fields.BASE in content:
        values = _named(content[fields.BASE], kind, path)
    if len(kinds) > 1:
        values.setdefault(tag_field, fields.tag_of(kind))
    entries = {name: value for name, value in content.items() if name != fields.BASE}
    exponent = (values | entries).get("exponent")
    for name, value in entries.items():
        field = kind.model_fields.get(name)
        if field is not None:
            value_unit = _unit_of(field, exponent)
            if getattr(kind, "is_value", False):
                value_unit = "s" if name == "times" else unit
            value = _filled_value(value, field, values.get(name), (*path, name), value_unit)
        values[name] = value
    return values


def _filled_value(value: Any, field: FieldInfo, below: Any, path: fields.KeyPath, unit: str | None) -> Any:
    """Value of a field, which may be a table or tables, as `filled` has it."""
    kinds = fields.models_of(field.annotation)
    if value == fields.NONE and fields.allows_none(field.annotation):
        return None
    if not kinds:
        return value if unit is None else number_of(value, unit)
    if isinstance(value, list):
        return [_filled_value(element, field, None, (*path, k), unit) for k, element in enumerate(value)]
    if not isinstance(value, dict):
        return value
    # below is none, or the list of a table given by mistake
    return filled(value, *kinds, below=below if isinstance(below, dict) else None, path=path, unit=unit or "")


def _named(name: object, kind: type[BaseModel], path: fields.KeyPath) -> Content:
    """Values of a named constructor."""
    constructors = fields.named_values(kind)
    if isinstance(name, str) and name in constructors:
        return constructors[name]().model_dump(mode="json")
    near = difflib.get_close_matches(str(name), constructors, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    allowed = ", ".join(map(repr, constructors)) or "no names at all"
    raise ValueError(
        f"{fields.path_text((*path, fields.BASE))}: no {fields.shown(name)}; {hint}allowed are {allowed}"
    )


def _unit_of(field: FieldInfo, exponent: object) -> str | None:
    """Unit of a field of a law with this exponent; None for what is no quantity."""
    if not fields.has_unit(field):
        return None
    power = exponent if fields.is_number(exponent) else 1.0
    return OPEN_POWER.sub(lambda found: f"^{power + int(found[1] or 0)}", fields.unit_of(field))


@cache
def _registry() -> Any:
    # half a second, for files alone that have units
    import pint

    registry: Any = pint.UnitRegistry(None, non_int_type=Fraction)
    registry.load_definitions(DEFINITIONS.strip().splitlines())
    return registry


@cache
def _size(unit: str, unit_here: str) -> Fraction:
    """Size of a unit in a field's own; ValueError if there is no such unit, or it is of something else."""
    there, here = (_registry().parse_units(POWER.sub(r"^\1", text)) for text in (unit, unit_here))
    return Fraction((Fraction(1) * there).to(here).magnitude)


def number_of(value: object, unit: str) -> object:
    """Number in a field's unit of a text with a number and a unit, as exact as may be; all else as it is."""
    if isinstance(value, list | tuple):
        return [number_of(element, unit) for element in value]
    match = TEXT.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return value
    # what is wrong with a unit raises all kinds of errors
    try:
        return float(Fraction(re.sub(PARTING, "", match[1])) * _size(match[2], unit))
    except Exception:
        return value
