"""Measured loads over time from CSV files: each row has a time and loads, each column head has a unit."""

import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case.parameters import columns
from exudyn_crawler.errors import CaseFileError, ImplausibleWarning

MOST_ROWS = 20_000
SHOE = re.compile(r"(?:load\s+(?:on\s+)?)?shoe\s*(\d+)")
NAMES = {
    "time": ("time", "t"),
    "load": ("load", "loads", "load on each shoe"),
    "sum": ("sum", "total", "total load", "sum of loads"),
    "shift": ("side shift", "side_shift"),
}
KNOWN = "'time [s]', 'load [kN]' (on each shoe), 'sum [kN]', 'shoe 1 [kN]', ... or 'side shift [m]'"
WANTED = {"time": ("s", "s"), "shift": ("m", "mm")}
"""SI unit and example unit of each kind of column; all other kinds have a unit of force."""


class LoadRow(NamedTuple):
    """Loads at a time."""

    time: float  # s
    loads: tuple[float, ...]  # N, downward, on shoes 1..n
    side_shift: float  # m


class Column(NamedTuple):
    """Head of a column of a file."""

    kind: str  # "time", "load", "sum", "shift" or "shoe"
    shoe: int  # number of the shoe; 0 for other kinds
    size: float  # size of its unit, in s, N or m


def read_loads(path: Path, shoe_count: int) -> list[LoadRow]:
    """Read the rows of a file; a single column of loads applies to all of `shoe_count` shoes.

    Warns of loads that pull the shoes up.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    CaseFileError
        If the file has no loads over time.
    """
    try:
        heads, rows = columns.read_table(path)
        if len(rows) > MOST_ROWS:
            raise ValueError(f"it must have at most {MOST_ROWS} lines of numbers, got {len(rows)}")
        kinds = [_column(head) for head in heads]
        _check_columns(kinds)
        numbers = [
            column.size * columns.numbers([row[place] for row in rows], repr(heads[place][:40]))
            for place, column in enumerate(kinds)
        ]
    except ValueError as error:
        raise CaseFileError(path, [str(error).removeprefix(f"{path}").lstrip(": ")]) from None
    for head, column, values in zip(heads, kinds, numbers, strict=True):
        row = int(values.argmin())
        if column.kind not in WANTED and values[row] < 0.0:
            pulls = f"{head!r} is {values[row] / column.size:.4g} in row {row + 1} and pulls the shoes up"
            warnings.warn(
                f"{path}: {pulls}; loads press down and are positive", ImplausibleWarning, stacklevel=3
            )
    return _load_rows(path, kinds, numbers, shoe_count)


def _column(head: str) -> Column:
    """Return kind and unit of a column's head; raises `ValueError` for an unknown kind or unit."""
    name, unit = columns.head_parts(head)
    number = SHOE.fullmatch(name)
    kind = "shoe" if number else next((kind for kind, names in NAMES.items() if name in names), None)
    if kind is None:
        raise ValueError(f"column {head[:40]!r} must be one of {KNOWN}")
    wanted, example = WANTED.get(kind, ("N", "kN"))
    if not unit:
        raise ValueError(f"column {head[:40]!r} needs its unit, such as '{name[:40]} [{example}]'")
    try:
        size = columns.factor_of(unit, wanted)
    except ValueError:
        raise ValueError(
            f"column {head[:40]!r} must be in a unit such as {example}, got {unit[:40]!r}"
        ) from None
    return Column(kind, int(number[1]) if number else 0, size)


def _check_columns(kinds: Sequence[Column]) -> None:
    """Raise `ValueError` for a missing column, or for one that stands twice."""
    names = [column.kind for column in kinds]
    if names.count("time") != 1:
        raise ValueError(f"it must have one column 'time [s]', got {names.count('time')}")
    if names.count("shift") > 1:
        raise ValueError("it must have at most one column 'side shift [m]'")
    shoes = [column.shoe for column in kinds if column.kind == "shoe"]
    single = names.count("load") + names.count("sum")
    if single + bool(shoes) != 1:
        raise ValueError(
            "it must have a column 'load [kN]' or 'sum [kN]', or one for every shoe: 'shoe 1 [kN]', ..."
        )
    if sorted(shoes) != list(range(1, len(shoes) + 1)):
        raise ValueError(f"columns of shoes must be 1 to {len(shoes)}, each once, got {shoes[:20]}")


def _load_rows(
    path: Path, kinds: Sequence[Column], numbers: Sequence[np.ndarray], shoe_count: int
) -> list[LoadRow]:
    """Return the rows of loads; raises `CaseFileError` if the times do not rise from zero or later."""
    by_kind = {column.kind: values for column, values in zip(kinds, numbers, strict=True)}
    times = by_kind["time"]
    before = np.concatenate([[-np.inf], times[:-1]])
    wrong = np.flatnonzero((times < 0.0) | (times <= before))
    if wrong.size:
        row = wrong[0]
        raise CaseFileError(
            path, [f"times must rise from 0 s or later, got {times[row]:g} s in row {row + 1}"]
        )
    if "shoe" in by_kind:
        shoes = sorted((column.shoe, place) for place, column in enumerate(kinds) if column.kind == "shoe")
        loads = np.column_stack([numbers[place] for _, place in shoes])
    else:
        each = by_kind["load"] if "load" in by_kind else by_kind["sum"] / shoe_count
        loads = np.repeat(each[:, None], shoe_count, axis=1)
    shifts = by_kind.get("shift", np.zeros(len(times)))
    return [
        LoadRow(*row) for row in zip(times.tolist(), map(tuple, loads.tolist()), shifts.tolist(), strict=True)
    ]
