"""Typical values of undercarriages, with range, source and state of knowledge: `typical.csv`."""

from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pydantic

from exudyn_crawler.settings.parameters import Parameters, quantity
from exudyn_crawler.settings.rows import read_rows

TABLE = Path(__file__).with_name("typical.csv")
OF_SIZES = ("pitch", "length", "rail", "weight", "diameter")  # reference sizes of values
WIDER = 10.0  # factor on the range to the limits of allowed values


class TypicalValue(NamedTuple):
    """Row of the table: a value for datasheets that do not give it."""

    name: str
    of: str  # kind of machine; empty: all kinds without a row
    value: float
    low: float
    high: float
    unit: str  # unit of the quantity, or its reference size, one of `OF_SIZES`
    meaning: str
    source: str
    known: str  # "seen" in a source's text, "remembered", of the "project", or "chosen" here


@cache
def table() -> dict[tuple[str, str], TypicalValue]:
    """Return all rows by name and kind of machine."""
    return {(row.name, row.of): row for row in read_rows(TABLE, TypicalValue)}


@cache
def names() -> tuple[str, ...]:
    """Return the names of all typical values."""
    return tuple(dict.fromkeys(name for name, _ in table()))


def row_of(name: str, kind: str) -> TypicalValue:
    """Return the row of a kind of machine, or that of all machines."""
    rows = table()
    return rows.get((name, kind)) or rows[name, ""]


def _fields() -> dict[str, Any]:
    """Return a field for every name; its plausible range is that over all kinds of machines."""
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
    """Typical values of a file that replace those of the table."""
