"""Rows of CSV tables as objects, each value in the type of its column."""

import csv
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

Row = TypeVar("Row")


def read_rows(path: Path, kind: type[Row]) -> list[Row]:
    """Return the rows of a CSV table whose columns are the fields of a class.

    Fields may be texts, numbers, ``int | None``, tuples of words or truths (``yes`` is true).
    """
    types = get_type_hints(kind)
    with path.open(encoding="utf-8", newline="") as file:
        return [
            kind(**{name: _value(text, types[name]) for name, text in row.items()})
            for row in csv.DictReader(file)
        ]


def _value(text: str, kind: object) -> Any:
    """Return the value of a cell in the type of its column."""
    if kind == tuple[str, ...]:
        return tuple(text.split())
    if kind is bool:
        return text == "yes"
    if kind == int | None:
        return int(text) if text else None
    return float(text) if kind is float else text
