"""Parameter files: TOML whose tables may give only the differences from a `base`, a named constructor.

All values of the program are in SI units. In place of a number a file may have a text with number and unit,
which `units` reads.
"""

import json
import re
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from exudyn_crawler.errors import CaseFileError, did_you_mean
from exudyn_crawler.settings import error_lines, fields, units

Model = TypeVar("Model", bound=BaseModel)
Content = dict[str, Any]
LINE = re.compile(r"\(at line (\d+),")
"""Line number in an error of the TOML reader."""
COMMA = re.compile(r"=\s*([+-]?\d+),(\d+)\s*(?:#.*)?$")
"""Number with a decimal comma in a line of TOML."""
BACKSLASH = re.compile(r'"([^"]*\\[^"]*)"')
"""Text with a backslash in double quotes."""
BARE_UNIT = re.compile(r"=\s*([+-]?\d[\d.]*\s*[A-Za-zµ°%][^\s\"#,\]}]*)")
"""Number with a unit that lacks its quotes."""
INCHES = re.compile(r'"(?:([\d.]+) *(?:ft|\') *-? *)?([\d.]+) *""')
"""Text in double quotes that ends at an inch mark."""


def read_parameters(
    path: str | Path, kind: type[Model], name: str, values: Callable[[Content], Content]
) -> Model:
    """Return the parameter object of a file; raises `CaseFileError` for refused content.

    `name` says in errors what kind of file is expected. `values` converts the content of the file to the
    values of the class `kind`.
    """
    path = Path(path)
    content: Content = {}
    with errors_named(path, kind, content):
        content |= toml_content(path, name)
        return from_content(kind, values(content), path.parent)


def toml_content(path: Path, name: str) -> Content:
    """Return the content of a TOML file.

    Raises `FileNotFoundError` if there is no file, or `ValueError`, without the path, if it is not TOML.
    """
    if not path.is_file():
        raise FileNotFoundError(
            f"{path} is a folder, not a {name}" if path.is_dir() else f"there is no {name} {path}"
        )
    # some editors write a byte order mark
    return content_of(path.read_bytes(), "utf-8-sig")


def content_of(source: str | bytes, coding: str = "utf-8") -> Content:
    """Return the content of TOML text, or of bytes in an encoding; raises `ValueError` if it is not TOML."""
    text = source if isinstance(source, str) else ""
    try:
        text = source if isinstance(source, str) else source.decode(coding)
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        message = str(error).replace("Cannot overwrite a value", "this key or table stands twice")
        raise ValueError(f"not TOML: {message}{_of_line(text, message)}") from error


def _of_line(text: str, message: str) -> str:
    """Describe the likely meaning of the line that a TOML error names; empty if none is likely."""
    place = LINE.search(message)
    lines = [line for line in text.splitlines() if line.strip()] if place is None else text.splitlines()
    line = lines[int(place[1]) - 1 if place else -1] if lines else ""
    if comma := COMMA.search(line):
        return f"; numbers have a point: {comma[1]}.{comma[2]}"
    if path := BACKSLASH.search(line):
        return f"; a path stands in single quotes: '{path[1]}'"
    if inches := INCHES.search(line):
        length = f"{inches[1]} ft {inches[2]} in" if inches[1] else f"{inches[2]} in"
        return f'; the sign for inches ends the text: "{length}"'
    if number := BARE_UNIT.search(line):
        return f'; a number with a unit stands in quotes: "{number[1]}"'
    return ""


@contextmanager
def errors_named(path: Path, kind: type[BaseModel], typed: Content | None = None) -> Iterator[None]:
    """Raise errors of the block, about the content of a file of a parameter class, as `CaseFileError`.

    `typed` is the content as the file spells it; errors quote values from it.
    """
    try:
        yield
    except ValidationError as error:
        raise CaseFileError(path, list(error_lines.error_lines(error, kind, typed))) from None
    except CaseFileError:  # an error of another file that this one names
        raise
    except RecursionError as error:
        raise CaseFileError(path, [str(error)]) from error
    except ValueError as error:
        raise CaseFileError(path, fields.lines_of(error)) from error


def from_content(kind: type[Model], content: Content, folder: Path | None = None) -> Model:
    """Return the parameter object of a file's content; raises `ValidationError` for refused values.

    Relative paths in the content start from `folder`.
    """
    # strict JSON accepts lists for tuples and whole numbers for floats, but no text for numbers; it has no
    # type for TOML's dates and times, which no field accepts
    text = json.dumps(filled(content, kind), default=lambda value: {"date or time": str(value)})
    return kind.model_validate_json(text, strict=True, context=folder)


def stated(content: Content, above: fields.KeyPath = ()) -> Iterator[fields.KeyPath]:
    """Yield the paths of all values in a file; a list is one value."""
    for key, value in content.items():
        if isinstance(value, dict):
            yield from stated(value, (*above, key))
        else:
            yield (*above, key)


def filled(
    content: Content,
    *kinds: type[BaseModel],
    below: Content | None = None,
    path: fields.KeyPath = (),
    unit: str = "",
) -> Content:
    """Return the values of a table of one of the classes, completed from its base or from `below`.

    Texts with units become numbers, and "none" becomes None; a second call changes nothing. `unit` is the
    unit of values over time. Raises `ValueError`, with the path, for an unknown base.
    """
    below = below or {}
    values = dict(below)
    kind = kinds[0]
    if len(kinds) > 1:
        tag_field = fields.tag_field(kind)
        tag = content.get(tag_field, below.get(tag_field))
        kind = next((model for model in kinds if fields.tag_of(model) == tag), kind)
        # values of another class do not apply to this one
        values = values if below.get(tag_field) == fields.tag_of(kind) else {}
    if fields.BASE in content:
        values = _named(content[fields.BASE], kind, path)
    if len(kinds) > 1:
        values.setdefault(tag_field, fields.tag_of(kind))
    entries = {name: value for name, value in content.items() if name != fields.BASE}
    exponent = (values | entries).get("exponent")
    for key, value in entries.items():
        name = fields.present_name(kind, key)
        field = kind.model_fields.get(name)
        if field is not None:
            value_unit = _unit_of(field, exponent)
            if getattr(kind, "is_value", False):
                value_unit = "s" if name == "times" else unit
            value = _filled_value(value, field, values.get(name), (*path, name), value_unit)
        values[name] = value
    return values


def _filled_value(value: Any, field: FieldInfo, below: Any, path: fields.KeyPath, unit: str | None) -> Any:
    """Return the value of a field, with its table or tables completed by `filled`."""
    kinds = fields.models_of(field.annotation)
    if value == fields.NONE and fields.allows_none(field.annotation):
        return None
    if not kinds:
        if unit is None:
            return value
        with fields.errors_at(fields.path_text(path)):
            return units.number_of(value, unit)
    if isinstance(value, list):
        return [_filled_value(element, field, None, (*path, k), unit) for k, element in enumerate(value)]
    if not isinstance(value, dict):
        return value
    # below is None, or a list where the file has a table by mistake
    return filled(value, *kinds, below=below if isinstance(below, dict) else None, path=path, unit=unit or "")


def _named(name: object, kind: type[BaseModel], path: fields.KeyPath) -> Content:
    """Return the values of a named constructor; raises `ValueError`, with the path, for an unknown name."""
    constructors = fields.named_values(kind)
    if isinstance(name, str) and name in constructors:
        return constructors[name]().model_dump(mode="json")
    hint = did_you_mean(name, constructors)
    allowed = ", ".join(map(repr, constructors)) or "no names at all"
    raise ValueError(
        f"{fields.path_text((*path, fields.BASE))}: no {fields.shown(name)}; {hint}allowed are {allowed}"
    )


def _unit_of(field: FieldInfo, exponent: object) -> str | None:
    """Return the unit of a field, with the law's exponent inserted; None if it is not a quantity."""
    if not fields.has_unit(field):
        return None
    power = exponent if fields.is_number(exponent) else 1.0
    return units.OPEN_POWER.sub(lambda found: f"^{power + int(found[1] or 0)}", fields.unit_of(field))
