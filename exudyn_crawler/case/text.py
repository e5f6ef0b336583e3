"""Case files as text: every value with its unit and meaning; and the same as a table."""

import inspect
from collections.abc import Iterator

import pandas as pd
import tomlkit
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from tomlkit.items import AoT, Array, Float, InlineTable, Item, Table, Trivia

from exudyn_crawler.case import Case, StepProfile
from exudyn_crawler.case.files import BASE, NONE, CaseFile, model_of, named_values

HEAD = 'Case of exudyn-crawler, in SI units; "none" stands for no value.'


def case_text(case_file: CaseFile) -> str:
    """Case file as TOML with a comment for every value."""
    document = tomlkit.document()
    for line in (HEAD, *_bases(Case)):
        document.add(tomlkit.comment(line))
    document.add(tomlkit.nl())
    fields = list(_fields(case_file.case)) + [one for one in _fields(case_file) if one[0] != "case"]
    values = [one for one in fields if not _is_table(one[2])]
    for name, field, value in values:
        document.add(name, _commented(_plain(value), field))
    for name, field, value in fields:
        if isinstance(value, BaseModel) and _is_table(value):
            document.add(name, _table(value, field))
    return tomlkit.dumps(document)


def _fields(model: BaseModel) -> Iterator[tuple[str, FieldInfo, object]]:
    for name, field in type(model).model_fields.items():
        yield name, field, getattr(model, name)


def _is_table(value: object) -> bool:
    """Whether a value has a table of its own; a quantity over time stands on one line."""
    return isinstance(value, BaseModel) and not isinstance(value, StepProfile)


def _are_tables(value: object) -> bool:
    return isinstance(value, tuple) and bool(value) and all(map(_is_table, value))


def _heading(model: BaseModel, field: FieldInfo | None) -> Iterator[str]:
    """What a table is, and the named values that its `base` may take."""
    yield (field and field.description) or _first_line(type(model))
    yield from _bases(type(model))


def _bases(kind: type[BaseModel]) -> Iterator[str]:
    if names := named_values(kind):
        yield f"{BASE} = " + " or ".join(f'"{name}"' for name in names) + " gives all that is left out"


def _table(model: BaseModel, field: FieldInfo | None = None, heading: bool = True) -> Table:
    table = tomlkit.table(is_super_table=False)
    for line in _heading(model, field) if heading else ():
        table.add(tomlkit.comment(line))
    for name, own, value in _fields(model):
        if not _is_table(value) and not _are_tables(value):
            table.add(name, _commented(_plain(value), own))
    for name, own, value in _fields(model):
        if _are_tables(value):
            array = AoT([])
            for one in value:  # type: ignore[attr-defined]
                array.append(_table(one, heading=False))
            table.add(name, array)
        elif isinstance(value, BaseModel) and _is_table(value):
            table.add(name, _table(value, own))
    return table


def _commented(item: Item, field: FieldInfo) -> Item:
    """Item with its unit and meaning behind it."""
    words = ", ".join(part for part in (unit_of(field), meaning_of(field)) if part)
    return item.comment(words) if words else item


def unit_of(field: FieldInfo) -> str:
    """Unit of a field; empty for what has none."""
    extra = field.json_schema_extra
    unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
    return "" if unit == "1" else unit


def meaning_of(field: FieldInfo) -> str:
    """Description of a field, or that of the parameter class which it holds."""
    kind = model_of(field.annotation)
    return field.description or (_first_line(kind) if kind else "")


def _first_line(kind: type[BaseModel]) -> str:
    return (inspect.getdoc(kind) or "").split("\n\n")[0].replace("\n", " ")


def _plain(value: object) -> Item:
    """Value as TOML."""
    if value is None:
        return tomlkit.string(NONE)
    if isinstance(value, bool | int | str):
        return tomlkit.item(value)
    if isinstance(value, float):
        return Float(value, Trivia(), number_text(value))
    if isinstance(value, BaseModel):
        inline: InlineTable = tomlkit.inline_table()
        for name, _, one in _fields(value):
            inline.append(name, _plain(one))
        return inline
    if isinstance(value, tuple):
        array: Array = tomlkit.array()
        for one in value:
            array.append(_plain(one))
        return array
    raise TypeError(f"no TOML for {value!r}")


def number_text(value: float) -> str:
    """Shortest text that reads back as the same number: ``20e6`` in place of ``20000000.0``."""
    if abs(value) >= 1e6:
        for power in (9, 6, 3):
            text = f"{value / 10.0**power:.6g}e{power}"
            if abs(value) >= 10.0**power and "e" not in text[:-2] and float(text) == value:
                return text
    return repr(value)


def case_table(case_file: CaseFile) -> pd.DataFrame:
    """Every value of a case file: columns key, value, unit, meaning."""
    rows = [
        (path, _shown(value), unit_of(field), meaning_of(field))
        for path, field, value in (*_rows(case_file.case, ""), *_rows(case_file, ""))
    ]
    return pd.DataFrame(rows, columns=["key", "value", "unit", "meaning"])


def _rows(model: BaseModel, start: str) -> Iterator[tuple[str, FieldInfo, object]]:
    for name, field, value in _fields(model):
        if isinstance(value, Case):
            continue
        if isinstance(value, BaseModel) and _is_table(value):
            yield from _rows(value, f"{start}{name}.")
        elif _are_tables(value):
            for number, one in enumerate(value):  # type: ignore[arg-type, var-annotated]
                yield from _rows(one, f"{start}{name}[{number}].")
        else:
            yield f"{start}{name}", field, value


def _shown(value: object) -> str:
    """Value of a table of values; equal numbers once."""
    if isinstance(value, StepProfile):
        return ", ".join(f"{v:g} at {t:g}" for t, v in zip(value.times, value.values, strict=True))
    if isinstance(value, tuple):
        if len(value) > 3 and len(set(value)) == 1:
            return f"{len(value)} x {_shown(value[0])}"
        return ", ".join(_shown(one) for one in value)
    if isinstance(value, float):
        return f"{value:.6g}"
    return NONE if value is None else str(value)
