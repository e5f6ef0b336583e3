"""Measured loads over time from CSV files: a time and loads a row, with units in the heads of the columns."""

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from exudyn_crawler.case.parameters.reading import number_of
from exudyn_crawler.errors import CaseFileError

MOST_ROWS = 20_000
HEAD = re.compile(r"\s*(.+?)(?:\s*\[(.+)\]|\s*\((.+)\)|\s+in\s+(\S.*)|\s*[,/]\s*(\S.*))?\s*")
"""Head of a column: a name, and a unit in brackets or behind "in"."""
SHOE = re.compile(r"(?:load\s+(?:on\s+)?)?shoe\s*(\d+)")
TIME = ("time", "t")
EACH = ("load", "loads", "load on each shoe")
SUM = ("sum", "total", "total load", "sum of loads")
SHIFT = ("side shift", "side_shift")
KNOWN = "'time [s]', 'load [kN]' (on each shoe), 'sum [kN]', 'shoe 1 [kN]', ... or 'side shift [m]'"
COMMA = re.compile(r"[+-]?\d+,\d+")


class LoadRow(NamedTuple):
    """Loads at a time."""

    time: float  # s
    loads: tuple[float, ...]  # N, downward, on shoes 1..n
    side_shift: float  # m


class Column(NamedTuple):
    """Column of a file."""

    kind: str  # "time", "load", "sum", "shift" or "shoe"
    shoe: int  # its number, of a shoe
    size: float  # of its unit, in s, N or m


def read_loads(path: Path, shoe_count: int) -> list[LoadRow]:
    """Read the rows of a file; one load stands for those of `shoe_count` shoes.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    CaseFileError
        If it holds no loads over time.
    """
    if not path.is_file():
        raise FileNotFoundError(f"no load cycle {path}")
    try:
        # spreadsheets put a mark before the text
        text = path.read_bytes().decode("utf-8-sig")
        heads, *rows = _cells(text)
        columns = [_column(head) for head in heads]
        _check_columns(columns)
        return list(_rows(columns, heads, rows, shoe_count))
    except ValueError as error:
        reason = "it is no text" if isinstance(error, UnicodeDecodeError) else str(error)
        raise CaseFileError(path, [reason]) from None


def _cells(text: str) -> list[list[str]]:
    """Cells of all lines that have any, with a point in numbers."""
    lines = [line for line in text.splitlines() if line.strip(" ,;\t")]
    if len(lines) < 2:
        raise ValueError("it needs a line of heads and lines of numbers")
    if len(lines) > MOST_ROWS + 1:
        raise ValueError(f"it must have at most {MOST_ROWS} lines of numbers, got {len(lines) - 1}")
    delimiter = next((mark for mark in (";", "\t") if mark in lines[0]), ",")
    cells = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]
    if delimiter == ",":
        return cells
    return [
        cells[0],
        *([cell.replace(",", ".") if COMMA.match(cell) else cell for cell in row] for row in cells[1:]),
    ]


def _column(head: str) -> Column:
    """Column of its head."""
    match = HEAD.fullmatch(head)
    if match is None:
        raise ValueError(f"every column needs a head, such as {KNOWN}")
    name = match[1].lower()
    number = SHOE.fullmatch(name)
    kinds = {"time": TIME, "load": EACH, "sum": SUM, "shift": SHIFT}
    kind = "shoe" if number else next((kind for kind, names in kinds.items() if name in names), None)
    if kind is None:
        raise ValueError(f"column {head[:40]!r} must be one of {KNOWN}")
    unit = next(filter(None, match.groups()[1:]), None)
    wanted = {"time": "s", "shift": "m"}.get(kind, "N")
    example = {"s": "s", "m": "mm"}.get(wanted, "kN")
    if unit is None:
        raise ValueError(f"column {head[:40]!r} needs its unit, such as '{match[1][:40]} [{example}]'")
    size = number_of(f"1 {unit}", wanted)
    if not isinstance(size, float):
        raise ValueError(f"column {head[:40]!r} must be in a unit such as {example}, got {unit[:40]!r}")
    return Column(kind, int(number[1]) if number else 0, size)


def _check_columns(columns: Sequence[Column]) -> None:
    """Refuse columns that say too little, or a thing twice."""
    kinds = [column.kind for column in columns]
    if kinds.count("time") != 1:
        raise ValueError(f"it must have one column 'time [s]', got {kinds.count('time')}")
    if kinds.count("shift") > 1:
        raise ValueError("it must have at most one column 'side shift [m]'")
    shoes = [column.shoe for column in columns if column.kind == "shoe"]
    single = kinds.count("load") + kinds.count("sum")
    if single + bool(shoes) != 1:
        raise ValueError(
            "it must have a column 'load [kN]' or 'sum [kN]', or one for every shoe: 'shoe 1 [kN]', ..."
        )
    if sorted(shoes) != list(range(1, len(shoes) + 1)):
        raise ValueError(f"columns of shoes must be 1 to {len(shoes)}, each once, got {shoes[:20]}")


def _rows(
    columns: Sequence[Column], heads: Sequence[str], rows: Sequence[Sequence[str]], shoe_count: int
) -> Iterator[LoadRow]:
    """Rows of their cells, whose times rise from zero or later."""
    before = -1.0
    for line, cells in enumerate(rows, start=1):
        if len(cells) != len(columns):
            raise ValueError(f"row {line} must have {len(columns)} cells, as the heads, got {len(cells)}")
        loads: dict[int, float] = {}
        time = 0.0
        shift = 0.0
        for column, head, cell in zip(columns, heads, cells, strict=True):
            value = column.size * _number(line, head, cell)
            if column.kind == "time":
                time = value
            elif column.kind == "shift":
                shift = value
            elif column.kind == "shoe":
                loads[column.shoe] = value
            else:
                share = value / shoe_count if column.kind == "sum" else value
                loads = dict.fromkeys(range(1, shoe_count + 1), share)
        if time < 0.0 or time <= before:
            raise ValueError(f"times must rise from 0 s or later, got {time:g} s in row {line}")
        before = time
        yield LoadRow(time, tuple(loads[number] for number in sorted(loads)), shift)


def _number(line: int, head: str, cell: str) -> float:
    """Number of a cell."""
    try:
        value = float(cell)
    except ValueError:
        value = float("nan")
    if value - value != 0.0:
        raise ValueError(f"{head!r} must be a number in row {line}, got {cell[:40]!r}")
    return value
