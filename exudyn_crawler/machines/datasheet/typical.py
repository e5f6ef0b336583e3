"""Typical values of undercarriages, with range, source and how well they are known: `typical.csv`."""

import csv
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pydantic

from exudyn_crawler.settings.parameters import Parameters, quantity

TABLE = Path(__file__).with_name("typical.csv")
OF_SIZES = ("pitch", "length", "rail", "weight", "diameter")  # what values may be measured by
WIDER = 10.0  # times least and greatest, beyond which nobody means a value


class TypicalValue(NamedTuple):
    """Row of the table: a value where a datasheet says nothing."""

    name: str
    of: str  # kind of machine; empty: of those that have no row
    value: float
    low: float
    high: float
    unit: str  # of the quantity, or what it is measured by, of `OF_SIZES`
    meaning: str
    source: str
    known: str  # seen in a source's text, remembered, of the project, or chosen here


@cache
def table() -> dict[tuple[str, str], TypicalValue]:
    """All rows by name and kind of machine."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = [_row(texts) for texts in csv.DictReader(file)]
    return {(row.name, row.of): row for row in rows}


def _row(texts: dict[str, Any]) -> TypicalValue:
    """Row of its texts by column."""
    numbers = {name: float(texts[name]) for name in ("value", "low", "high")}
    return TypicalValue(**(texts | numbers))


@cache
def names() -> tuple[str, ...]:
    """Names of all typical values."""
    return tuple(dict.fromkeys(name for name, _ in table()))


def row_of(name: str, kind: str) -> TypicalValue:
    """Row of a kind of machine, or that of all machines."""
    rows = table()
    return rows.get((name, kind)) or rows[name, ""]


def _fields() -> dict[str, Any]:
    """Field of every name; its plausible range is that of all kinds of machines."""
    fields: dict[str, Any] = {}
    for name in names():
        rows = [row for row in table().values() if row.name == name]
        low = min(row.low for row in rows)
        high = max(row.high for row in rows)
        least = low / WIDER if low > 0.0 else low - high
        meaning = f"{rows[0].meaning}; none: by the kind of machine"
        unit = rows[0].unit if rows[0].unit not in OF_SIZES else "1"
        fields[name] = (
            float | None,
            quantity(unit, meaning, (low, high), default=None, ge=least, le=WIDER * high),
        )
    return fields


class Typical(pydantic.create_model("TypicalValues", __base__=Parameters, **_fields())):  # type: ignore[misc]
    """Typical values that a file has in place of those of the table."""
