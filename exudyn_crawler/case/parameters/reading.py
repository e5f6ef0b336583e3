"""Files of parameters: TOML whose tables may say only what differs from a `base`, a named constructor.

Within the program all is in SI units. In place of a number a file may have a text with one and a unit:
"20 MN/m" is the number of the field's own unit. Angles are no plain numbers here: revolutions a second are no
hertz, and degrees no slope.
"""

import difflib
import json
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from exudyn_crawler.case.parameters import base, fields
from exudyn_crawler.errors import CaseFileError

Model = TypeVar("Model", bound=BaseModel)
Content = dict[str, Any]
MOST_NAMED = 3  # files of a folder that an error names
KINDS: dict[str, tuple[str, Callable[[Content], bool]]] = {
    "duty scatter file": ("scatter", lambda content: {"vary", "duty"} <= content.keys()),
    "sweep file": ("sweep", lambda content: "vary" in content),
    "duty file": ("life", lambda content: isinstance(content.get("runs"), list) or _names_cases(content)),
    "check file": ("check", lambda content: isinstance(content.get("cases"), list)),
    "law file": ("ground", lambda content: "model" in content),
    "case file": ("run", lambda content: not {"drive", "terrain", "duration", "track"}.isdisjoint(content)),
}
"""Files of the program: the command that takes one, and whether a content is one's."""


def _names_cases(content: Content) -> bool:
    """Whether check cases are named, as a duty has them, in place of their loads."""
    cases = content.get("cases")
    return isinstance(cases, list) and any(isinstance(one, dict) and "case" in one for one in cases)


def read_parameters(
    path: str | Path, kind: type[Model], name: str, values: Callable[[Content], Content]
) -> Model:
    """Parameter object of a file of a kind `name`; `values` makes its content values; or `CaseFileError`."""
    path = Path(path)
    with errors_named(path, kind):
        content = toml_content(path, name)
        others = {} if name in KINDS and KINDS[name][1](content) else KINDS
        for other, (command, is_one) in others.items():
            if other != name and is_one(content):
                raise ValueError(f"it is a {other}, not a {name}: exudyn-crawler {command} {path}")
        return from_content(kind, values(content))


def toml_content(path: Path, name: str) -> Content:
    """Content of a TOML file; raises `FileNotFoundError` or, without the path, `ValueError` if it is none."""
    if not path.is_file():
        inside = sorted(path.glob("*.toml"))
        names = ", ".join(map(str, inside[:MOST_NAMED])) + (", ..." if len(inside) > MOST_NAMED else "")
        hint = (
            f"; name one, such as {names}" if inside else f"; name a TOML file such as {path / 'mine.toml'}"
        )
        raise FileNotFoundError(
            f"{path} is a folder, no {name}{hint}" if path.is_dir() else f"no {name} {path}"
        )
    try:
        # some editors put a mark before the text
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise ValueError("not TOML: it is no text") from error
    except (ValueError, RecursionError) as error:
        text = str(error).replace("Cannot overwrite a value", "this key or table stands twice")
        raise ValueError(f"not TOML: {text}") from error


@contextmanager
def errors_named(path: Path, kind: type[BaseModel]) -> Iterator[None]:
    """Make what is wrong with the content of a file, of a parameter class, a `CaseFileError`."""
    try:
        yield
    except ValidationError as error:
        raise CaseFileError(path, list(base.error_lines(error, kind))) from None
    except CaseFileError:  # of another file that this one names
        raise
    except (ValueError, RecursionError) as error:
        raise CaseFileError(path, [str(error)]) from error


def from_content(kind: type[Model], content: Content) -> Model:
    """Parameter object of the values of a file; `ValidationError` for what is not allowed."""
    # strict JSON takes lists for tuples and whole numbers for any, but no text for numbers; it has no type
    # for TOML's dates and times, which no field takes
    text = json.dumps(in_si(content, kind), default=lambda value: {"date or time": str(value)})
    return kind.model_validate_json(text, strict=True)


def with_base(
    content: Content,
    *kinds: type[BaseModel],
    below: Mapping[str, Any] | None = None,
    path: fields.KeyPath = (),
) -> Content:
    """What a table of one of the classes gives over its base, or over the values `below` it."""
    content, below = dict(content), below or {}
    tag = content.get(fields.TAG, below.get(fields.TAG))
    kind = next((one for one in kinds if len(kinds) > 1 and fields.tag_of(one) == tag), kinds[0])
    # values of another class say nothing of this one
    values = dict(below) if len(kinds) == 1 or below.get(fields.TAG) == fields.tag_of(kind) else {}
    if beside := fields.beside(kind):
        names = [key for key in content if key == beside or key not in kind.model_fields]
        inner = {key: content.pop(key) for key in names}
        values[beside] = with_base(inner, *fields.models_of(kind.model_fields[beside].annotation), path=path)
    if (name := content.pop(fields.BASE, None)) is not None:
        values = _named(name, kind, path)
    if len(kinds) > 1:
        values.setdefault(fields.TAG, fields.tag_of(kind))
    for key, value in content.items():
        field = kind.model_fields.get(key)
        parts = fields.models_of(field.annotation) if field else ()
        if field and value == fields.NONE and fields.allows_none(field.annotation):
            value = None
        elif parts and isinstance(value, dict):
            under = values.get(key)
            # none, or the list of a table given by mistake
            under = under if isinstance(under, dict) else None
            value = with_base(value, *parts, below=under, path=(*path, key))
        elif parts and isinstance(value, list):
            value = [
                with_base(one, *parts, path=(*path, key, number)) if isinstance(one, dict) else one
                for number, one in enumerate(value)
            ]
        values[key] = value
    return values


def _named(name: object, kind: type[BaseModel], path: fields.KeyPath) -> Content:
    """Values of a named constructor."""
    constructors = fields.named_values(kind)
    if isinstance(name, str) and name in constructors:
        return constructors[name]().model_dump(mode="json")
    near = difflib.get_close_matches(str(name), constructors, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    allowed = ", ".join(map(repr, constructors)) or "no names at all"
    raise ValueError(f"{fields.path_text((*path, fields.BASE))}: no {name!r}; {hint}allowed are {allowed}")


NUMBER, NAME = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?", r"[a-zµ°%_]+(?:\^?-?\d(?:\.\d+)?)?"
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
metre = [length] = m
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
bar = 100000 * pascal
inch = 0.0254 * metre = in
foot = 12 * inch = ft
mile = 5280 * foot = mi
mph = mile / hour
pound = 453.59237 * gram = lb
pound_force = 4.4482216152605 * newton = lbf
psi = pound_force / inch ** 2
"""


@cache
def _registry() -> Any:
    # half a second, for files alone that have units
    import pint

    registry: Any = pint.UnitRegistry(None, non_int_type=Fraction)
    registry.load_definitions(DEFINITIONS.strip().splitlines())
    return registry


@cache
def _size(unit: str, own: str) -> Fraction:
    """Size of a unit in a field's own; ValueError if there is no such unit, or it is of something else."""
    there, here = (_registry().parse_units(POWER.sub(r"^\1", one)) for one in (unit, own))
    return Fraction((Fraction(1) * there).to(here).magnitude)


def number_of(value: object, unit: str) -> object:
    """Number in a field's unit of a text with a number and a unit, as exact as may be; all else as it is."""
    if isinstance(value, list | tuple):
        return [number_of(one, unit) for one in value]
    match = TEXT.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return value
    # what is wrong with a unit raises all kinds of errors
    try:
        return float(Fraction(match[1]) * _size(match[2], unit))
    except Exception:
        return value


def is_measured(value: object) -> bool:
    """Whether a value is a text with a number and a unit."""
    return isinstance(value, str) and TEXT.fullmatch(value) is not None


def in_si(content: Any, *kinds: type[BaseModel], unit: str = "") -> Any:
    """Copy of the content of a table of one of some classes with numbers for texts that have units."""
    if not isinstance(content, dict):
        return content
    tag = content.get(fields.TAG)
    kind = next((one for one in kinds if len(kinds) > 1 and fields.tag_of(one) == tag), kinds[0])
    made, power = dict(content), content.get("exponent")
    power = power if fields.is_number(power) else 1.0
    for name, value in content.items():
        field = kind.model_fields.get(name)
        if field is None:
            continue
        parts, own = fields.models_of(field.annotation), fields.unit_of(field)
        own = OPEN_POWER.sub(lambda found: f"^{power + int(found[1] or 0)}", own)
        if getattr(kind, "is_value", False):
            made[name] = number_of(value, "s" if name == "times" else unit)
        elif parts:
            below = partial(in_si, unit=own)
            of_list = isinstance(value, list)
            made[name] = [below(one, *parts) for one in value] if of_list else below(value, *parts)
        elif isinstance(field.json_schema_extra, dict) and "unit" in field.json_schema_extra:
            made[name] = number_of(value, own)
    return made
