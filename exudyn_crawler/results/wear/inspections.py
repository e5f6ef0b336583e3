"""Inspections: measured sizes of wearing parts over hours, from a CSV file.

Columns are date (2026-03-01), machine hours, and optionally propel hours and `hours NAME` of a run of the
duty. A row has the part, optionally side and place, and the value with its unit in the head (value in mm).
A chain is measured over `links` links. In place of a value "new" tells that the part was new then, "turned"
that pins and bushes were turned.
"""

import datetime
import difflib
import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from exudyn_crawler.case.parameters.columns import MISSING, factor_of, head_parts, numbers, read_table
from exudyn_crawler.results.wear.parts import PartName, parts

NEW, TURNED = "new", "turned"
REMARKS = f", {NEW!r} or {TURNED!r}"
HOURS = "hours "
"""Begin of the heads of columns with the hours of a run."""
MACHINE, PROPEL = "machine hours", "propel hours"
COLUMNS = ("date", MACHINE, PROPEL, "part", "side", "place", "value", "links")
NEEDED = ("date", MACHINE, "part", "value")
TURNED_PARTS = ("pitch", "bush")
"""Parts that are as new after pins and bushes were turned."""
Basis = Literal["machine hours", "propel hours"]


@dataclass(frozen=True)
class Reading:
    """Measured size of a part, or a remark that it was new or turned."""

    row: int
    date: datetime.date
    machine_hours: float
    propel_hours: float  # NaN if not counted
    part: str
    side: str
    place: str
    size: float  # m, of one link; NaN for a remark
    state: str  # "", "new" or "turned"
    of_runs: tuple[float, ...] = ()  # hours of the runs of `Inspections.runs`

    def hours(self, basis: Basis) -> float:
        """Return the hours of a basis."""
        return self.machine_hours if basis == MACHINE else self.propel_hours


@dataclass(frozen=True)
class Series:
    """Readings of one part since it was new or its pins and bushes were turned."""

    part: str
    side: str
    place: str
    readings: tuple[Reading, ...]
    begin: Reading | None  # remark that began it; None: the machine was new with it
    turned: bool  # True if pins and bushes were turned at its begin or before

    @property
    def name(self) -> str:
        """Name for reading: ``left roller 3``."""
        return " ".join(filter(None, (self.side, self.part, self.place)))

    def hours(self, basis: Basis) -> np.ndarray:
        """Return the hours of the readings since the begin: array (readings,)."""
        begin = 0.0 if self.begin is None else self.begin.hours(basis)
        return np.array([reading.hours(basis) for reading in self.readings]) - begin

    def hours_of_runs(self) -> np.ndarray:
        """Return the hours in each run since the begin: array (readings, runs)."""
        hours = np.array([reading.of_runs for reading in self.readings])
        return hours if self.begin is None else hours - np.array(self.begin.of_runs)

    @property
    def sizes(self) -> np.ndarray:
        """Measured sizes, (readings,), m."""
        return np.array([reading.size for reading in self.readings])


@dataclass(frozen=True)
class Inspections:
    """Readings of a machine in the order of their dates."""

    readings: tuple[Reading, ...]
    runs: tuple[str, ...]  # names of the runs whose hours were counted

    @property
    def basis(self) -> Basis:
        """Hours over which wear is fitted: propel hours if every row has them."""
        uncounted = np.isnan([reading.propel_hours for reading in self.readings])
        return "machine hours" if uncounted.any() else "propel hours"

    @property
    def last(self) -> Reading:
        """Last reading."""
        return self.readings[-1]

    @property
    def propel_share(self) -> float:
        """Propel hours over machine hours; NaN if not counted."""
        return self.last.propel_hours / self.last.machine_hours if self.last.machine_hours else np.nan

    @property
    def machine_hours_a_day(self) -> float:
        """Machine hours in a day, mean from the first to the last inspection; NaN for one day alone."""
        first = self.readings[0]
        days = (self.last.date - first.date).days
        return (self.last.machine_hours - first.machine_hours) / days if days else np.nan

    def series(self) -> list[Series]:
        """Return the series of each part, side and place, of the parts that are on the machine now."""
        measured = [reading for reading in self.readings if not reading.state]
        keys = dict.fromkeys(_key(reading) for reading in measured)
        return [series for key in keys if (series := self._series(*key)).readings]

    def _series(self, part: str, side: str, place: str) -> Series:
        """Return the readings of a part since its last remark."""
        remarks = [
            reading
            for reading in self.readings
            if reading.state and reading.part == part
            if reading.side in ("", side) and (reading.place in ("", place) or not parts()[part].each_place)
        ]
        begin = remarks[-1] if remarks else None
        states = [remark.state for remark in remarks]
        since_new = states[len(states) - 1 - states[::-1].index(NEW) :] if NEW in states else states
        readings = tuple(
            reading
            for reading in self.readings
            if not reading.state and _key(reading) == (part, side, place)
            if begin is None or reading.machine_hours > begin.machine_hours
        )
        return Series(part, side, place, readings, begin, TURNED in since_new)


def _key(reading: Reading) -> tuple[str, str, str]:
    """Return part, side and place of a reading; places of a part without parts of their own count as one."""
    return reading.part, reading.side, reading.place if parts()[reading.part].each_place else ""


def read_inspections(path: str | Path) -> Inspections:
    """Read a file of inspections.

    Raises `FileNotFoundError` if there is no such file. Raises `ValueError`, with file, column and row, for a
    missing or unknown column, a wrong value, and for hours that contradict dates or each other.
    """
    path = Path(path)
    heads, rows = read_table(path)
    columns: dict[str, list[str]] = {}
    factors: dict[str, float] = {}
    for place, head in enumerate(heads):
        name, unit = head_parts(head)
        if name not in COLUMNS and not name.startswith(HOURS):
            near = difflib.get_close_matches(name, COLUMNS, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ValueError(
                f"{path}: columns must be among {', '.join(COLUMNS)}, or hours of a run, got {name!r}{hint}"
            )
        if name in columns:
            raise ValueError(f"{path}: column {name!r} must occur once")
        columns[name] = [row[place] for row in rows]
        if name == "value" or name.startswith(HOURS) or name in (MACHINE, PROPEL):
            wanted = "m" if name == "value" else "h"
            try:
                factors[name] = factor_of(unit or ("" if name == "value" else "h"), wanted, name)
            except ValueError as error:
                raise ValueError(f"{path}: column {name!r}: {error}") from None
    if missing := [name for name in NEEDED if name not in columns]:
        raise ValueError(f"{path}: column {missing[0]!r} must be given, got {', '.join(columns)}")

    def hours(name: str) -> np.ndarray:
        return factors[name] * numbers(columns[name], f"{path}: {name}", gaps=name == PROPEL)

    runs = tuple(name.removeprefix(HOURS) for name in columns if name.startswith(HOURS))
    of_runs = [hours(f"{HOURS}{name}") for name in runs]
    machine = hours(MACHINE)
    propel = hours(PROPEL) if PROPEL in columns else np.full(len(rows), np.nan)
    empty = [""] * len(rows)
    readings = []
    for row in range(len(rows)):
        where = f"{path}: row {row + 1}"
        part = _part(columns["part"][row], where)
        cell = columns["value"][row].lower()
        state = cell if cell in (NEW, TURNED) else ""
        if state == TURNED and part not in TURNED_PARTS:
            raise ValueError(f"{where}: only {' and '.join(TURNED_PARTS)} are turned, got part {part!r}")
        size = np.nan if state else _positive(cell, f"{where}: value", REMARKS) * factors["value"]
        link = columns.get("links", empty)[row]
        links = 1.0 if link.lower() in MISSING else _positive(link, f"{where}: links")
        if links != 1.0 and part != "pitch":
            raise ValueError(f"{where}: links are for a pitch, which is measured over several, got {part!r}")
        readings.append(
            Reading(
                row + 1,
                _date(columns["date"][row], where),
                float(machine[row]),
                float(propel[row]),
                part,
                _side(columns.get("side", empty)[row], where),
                columns.get("place", empty)[row].strip(),
                size / links,
                state,
                tuple(float(column[row]) for column in of_runs),
            )
        )
    readings += [
        replace(reading, part=other)
        for reading in readings
        if reading.state == TURNED
        for other in TURNED_PARTS
        if other != reading.part
        and not any(
            one.part == other and one.state == TURNED and one.machine_hours == reading.machine_hours
            for one in readings
        )
    ]
    ordered = sorted(readings, key=lambda reading: (reading.machine_hours, reading.row))
    for contradiction in _contradictions(ordered):
        raise ValueError(f"{path}: {contradiction}")
    return Inspections(tuple(ordered), runs)


def _contradictions(readings: list[Reading]) -> Iterator[str]:
    """Yield an error for each contradiction of readings in the order of their machine hours."""
    for before, after in itertools.pairwise(readings):
        rows = f"rows {before.row} and {after.row}"
        if after.date < before.date:
            yield (
                f"{rows}: machine hours must rise with the date, got {before.machine_hours:g} h on "
                f"{before.date} and {after.machine_hours:g} h on {after.date}"
            )
        if after.propel_hours < before.propel_hours:
            yield (
                f"{rows}: propel hours must rise with machine hours, got {before.propel_hours:g} and "
                f"{after.propel_hours:g} h"
            )
        if after.propel_hours - before.propel_hours > after.machine_hours - before.machine_hours + 1.0:
            yield (
                f"{rows}: propel hours must not grow by more than machine hours, got "
                f"{after.propel_hours - before.propel_hours:g} and "
                f"{after.machine_hours - before.machine_hours:g} h"
            )
    for reading in readings:
        if not reading.state and reading.machine_hours <= 0.0:
            yield f"row {reading.row}: machine hours must be greater than 0, got {reading.machine_hours:g} h"


def _part(cell: str, where: str) -> PartName:
    """Return the name of a part."""
    known = {str(name): name for name in get_args(PartName)}
    name = cell.strip().lower()
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"{where}: part must be one of {', '.join(known)}, got {cell!r}{hint}")
    return known[name]


def _side(cell: str, where: str) -> str:
    """Return a side: right, left or empty."""
    side = cell.strip().lower()
    if side not in ("", "right", "left"):
        raise ValueError(f"{where}: side must be right, left or empty, got {cell!r}")
    return side


def _date(cell: str, where: str) -> datetime.date:
    """Return a date."""
    try:
        return datetime.date.fromisoformat(cell.strip())
    except ValueError:
        raise ValueError(f"{where}: date must be as 2026-03-01, got {cell!r}") from None


def _positive(cell: str, name: str, words: str = "") -> float:
    """Return a positive number of a cell; `words` are what the column may have in its place."""
    try:
        value = float(cell)
    except ValueError:
        raise ValueError(f"{name} must be a number{words}, got {cell[:40]!r}") from None
    if not 0.0 < value < np.inf:
        raise ValueError(f"{name} must be greater than 0, got {cell!r}")
    return value
