"""Columns of a measured table: CSV with a unit in the head of every column, as ``pressure in kPa``."""

import csv
import difflib
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from exudyn_crawler.case.parameters.units import number_of

HEAD = re.compile(r"\s*(?P<name>.*?)\s*(?:\[(?P<a>.*)\]|\((?P<b>.*)\)|(?:,|/| in )\s*(?P<c>[^,]+?))?\s*")
"""Name of a column with its unit: ``force [N]``, ``force (N)``, ``force, N``, ``force/N``, ``force in N``."""
GREATEST = 1e15
"""Size of numbers beyond which nothing is measured, and sums of squares fail."""
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+")


def head_parts(head: str) -> tuple[str, str]:
    """Name and unit of a column's head; the unit is empty where it has none."""
    match = HEAD.fullmatch(head)
    assert match is not None  # the name takes whatever is there
    unit = next((match[group] for group in "abc" if match[group]), "")
    return match["name"].lower(), unit.strip()


def factor_of(unit: str, wanted: str) -> float:
    """Size of a unit in the `wanted` one; ValueError if it is no unit, or one of something else."""
    if unit == wanted or (wanted == "1" and not unit):
        return 1.0
    factor = number_of(f"1 {unit}", wanted)
    if not isinstance(factor, float):
        raise ValueError(f"unit must be one of {wanted}, got {unit or 'none'!r}")
    return factor


def read_table(path: str | Path) -> tuple[list[str], list[list[str]]]:
    """Heads and rows of a CSV file with commas, semicolons or tabs; lines that begin with # are remarks.

    Numbers between semicolons or tabs may have decimal commas. FileNotFoundError if there is no such file,
    ValueError if it has no rows, or rows of another length.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no table {path}")
    try:
        # spreadsheets put a mark before the text
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is no text in UTF-8: {error.reason}") from error
    lines = [line for line in text.splitlines() if line.strip(" ,;\t") and not line.lstrip().startswith("#")]
    if len(lines) < 2:
        raise ValueError(f"{path} must have a line of heads and rows below it, got {len(lines)} lines")
    delimiter = next((mark for mark in ";\t" if mark in lines[0]), ",")
    heads, *rows = ([cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter))
    for number, row in enumerate(rows, start=1):
        if len(row) != len(heads):
            raise ValueError(
                f"{path}: row {number} must have {len(heads)} cells, as its head, got {len(row)}"
            )
    if delimiter != ",":
        rows = [
            [cell.replace(",", ".") if DECIMAL_COMMA.match(cell) else cell for cell in row] for row in rows
        ]
    return heads, rows


def read_columns(
    path: str | Path, units: Mapping[str, str], labels: tuple[str, ...] = ()
) -> dict[str, np.ndarray]:
    """Columns of a table by name in the wanted `units`, those that it has; `labels` stay texts.

    ValueError, with the file, the column and the row, for what is no number, for a unit that does not fit,
    for a column of another name and for one that stands twice.
    """
    heads, rows = read_table(path)
    known = {**units, **dict.fromkeys(labels, "")}
    columns = {}
    for place, head in enumerate(heads):
        name, unit = head_parts(head)
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ValueError(f"{path}: columns must be of {', '.join(known)}, got {name!r}{hint}")
        if name in columns:
            raise ValueError(f"{path}: column {name!r} must stand once")
        cells = [row[place] for row in rows]
        if name in labels:
            columns[name] = np.array(cells)
            continue
        try:
            factor = factor_of(unit, units[name])
        except ValueError as error:
            raise ValueError(f"{path}: column {name!r}: {error}") from None
        columns[name] = factor * numbers(cells, f"{path}: {name}")
    return columns


def numbers(cells: list[str], name: str) -> np.ndarray:
    """Numbers of cells: array (rows,); ValueError, with the `name` and the row, for what is none."""
    values = np.empty(len(cells))
    for row, cell in enumerate(cells):
        try:
            values[row] = float(cell)
        except ValueError:
            raise ValueError(f"{name} must be a number in row {row + 1}, got {cell[:40]!r}") from None
        if not abs(values[row]) <= GREATEST:
            size = f"finite and at most {GREATEST:g} in size"
            raise ValueError(f"{name} must be {size} in row {row + 1}, got {cell[:40]!r}")
    return values
