"""Comparison of a run with measured series: given shift, rms difference, bias and ratios of peaks."""

import math
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.case.parameters import columns
from exudyn_crawler.errors import ImplausibleWarning
from exudyn_crawler.results.history.catalogue import READ_IN
from exudyn_crawler.results.history.history import History

OVER = {"time": "s", "distance": "m"}
"""First column of a measured table, the independent variable, and its unit."""
LEAST_POINTS = 3  # least number of points that run and measurement have in common
TURNED = 0.5  # greatest rms difference of a turned sign that fits, fraction of that as it is. Chosen here
LEAST_PEAK = 0.05  # least peak with a meaningful ratio, fraction of the greatest magnitude. Chosen here


@dataclass(frozen=True)
class Compared:
    """Measured series, and values of the run at the same times or distances."""

    head: str  # head of the column
    over: str  # "time" or "distance"
    unit: str  # for reading
    place: np.ndarray  # (points,), time or distance in the run, shift included, s or m
    measured: np.ndarray  # (points,), in the unit
    run: np.ndarray  # (points,), in the unit
    run_place: np.ndarray  # (times,), time or distance of the whole run, s or m
    run_values: np.ndarray  # (times,), in the unit

    @property
    def rms(self) -> float:
        """Root mean square of the difference."""
        return float(np.sqrt(np.mean((self.run - self.measured) ** 2)))

    @property
    def seems_turned(self) -> bool:
        """True if the difference would be far smaller with the other sign."""
        turned = float(np.sqrt(np.mean((self.run + self.measured) ** 2)))
        return turned < TURNED * self.rms

    @property
    def bias(self) -> float:
        """Mean of the run less that of the measurement."""
        return float(np.mean(self.run - self.measured))

    def peak_ratio(self, greatest: bool) -> float:
        """Return the greatest or least value of the run over the measured one; NaN for one near zero."""
        peak = np.max if greatest else np.min
        measured = float(peak(self.measured))
        if abs(measured) < LEAST_PEAK * float(np.abs(self.measured).max(initial=0.0)) or measured == 0.0:
            return math.nan
        return float(peak(self.run)) / measured


def distance_of(history: History) -> np.ndarray:
    """Return the distance along x of the side frame, or else of the middle of the shoes: (times,), m."""
    name = "side_frame_displacement" if history.has("side_frame_displacement") else "displacement"
    distance = history.quantity(name).sel(axis="x")
    others = [dimension for dimension in distance.dims if dimension != "time"]
    return distance.mean(others).values


def chosen(history: History, head: str) -> xr.DataArray:
    """Return the quantity over time of a column's head: its name, then the number or name of its item.

    Examples are ``side_frame_displacement x``, ``link_tension 12`` or ``wheel_force roller 3 z``. ValueError
    if a run has no such quantity, or the head does not determine the item.
    """
    name, _, rest = head.partition(" ")
    values = history.over_time([name])[name]
    if "time" not in values.dims:
        raise ValueError(f"{name} must be a quantity over time")
    rest = f" {rest.strip()} "
    dimensions = [dimension for dimension in values.dims if dimension != "time"]
    # names first, since numbers may be part of names
    for dimension in sorted(dimensions, key=lambda dimension: values[dimension].dtype.kind in "iu"):
        labels = {str(label).lower(): label for label in values[dimension].values}
        named = next((label for label in sorted(labels, key=len, reverse=True) if f" {label} " in rest), None)
        if named is None:
            some = ", ".join([*labels][:4])
            raise ValueError(f"{head!r} must name its {dimension}: {some}{', ...' * (len(labels) > 4)}")
        values = values.sel({dimension: labels[named]})
        rest = rest.replace(f" {named} ", " ", 1)
    if rest.strip():
        raise ValueError(f"{name} has no {rest.strip()!r}")
    return values


def compare(history: History, path: Path, shift: float = 0.0) -> list[Compared]:
    """Compare a run with the series of a measured table; its first column is `time` or `distance`.

    The `shift` (s or m) is added to this column. Rows without a value of a series do not count for it.
    ValueError, with the file and the column, if a series is not in the run or has another unit. ValueError
    also for fewer than three points within the run. A series whose sign seems to be turned causes a warning.
    """
    heads, rows = columns.read_table(path)
    names = [columns.head_parts(head) for head in heads]
    over, unit = names[0]
    if over not in OVER or len(names) < 2:
        raise ValueError(
            f"{path} must have a first column 'time in s' or 'distance in m' and others, got {heads[0]!r}"
        )
    numbers = [
        columns.numbers([row[place] for row in rows], f"{path}: {head}", gaps=place > 0)
        for place, head in enumerate(heads)
    ]
    _check_places(path, heads[0], over, numbers[0])
    place = _factor(path, over, unit, OVER[over]) * numbers[0] + shift
    run_place = history.time.values if over == "time" else distance_of(history)
    if np.any(np.diff(run_place) < -1e-6 * np.ptp(run_place)):
        raise ValueError(f"{path} must be a series over time, since the run goes back and forth")
    inside = (place >= run_place[0]) & (place <= run_place[-1])
    compared = []
    for (head, unit), measured in zip(names[1:], numbers[1:], strict=True):
        within = inside & ~np.isnan(measured)
        if within.sum() < LEAST_POINTS:
            given = place[~np.isnan(measured)]
            reach = (
                f" is {given.min():g} to {given.max():g} {OVER[over]} with the shift" if len(given) else ""
            )
            raise ValueError(
                f"{path}: {within.sum()} points of {head!r} are within the run, at least {LEAST_POINTS} must "
                f"be: {over}{reach or ' has none'}, the run's {run_place[0]:g} to {run_place[-1]:g}"
            )
        try:
            values = chosen(history, head)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error
        stored = values.attrs.get("units", "1")
        read_in, size = READ_IN.get(stored, (stored, 1.0))
        factor = _factor(path, head, unit, stored) * size
        run_values = size * values.values
        run = np.interp(place[within], run_place, run_values)
        places = place[within], factor * measured[within], run
        beside = Compared(head, over, read_in, *places, run_place, run_values)
        if beside.seems_turned:
            turned = f"measured from {beside.measured.min():.4g} to {beside.measured.max():.4g} {read_in}"
            of_run = f"{run.min():.4g} to {run.max():.4g} {read_in} in the run"
            line = f"{path}: {head}: {turned}, {of_run}: is its sign turned?"
            warnings.warn(line, ImplausibleWarning, stacklevel=2)
        compared.append(beside)
    return compared


def _check_places(path: Path, head: str, over: str, places: np.ndarray) -> None:
    """Raise ValueError for times that do not rise, or distances that go back and forth, as in the file."""
    steps = np.diff(places)
    falls = over == "distance" and np.median(steps) < 0.0
    wrong = np.flatnonzero(steps > 0.0 if falls else steps < 0.0)
    if len(wrong):
        row = int(wrong[0])
        raise ValueError(
            f"{path}: {head} must {'fall' if falls else 'rise'} from row to row, got {places[row]:g} in row "
            f"{row + 1} of numbers and then {places[row + 1]:g}"
        )


def _factor(path: Path, head: str, unit: str, wanted: str) -> float:
    """Return the factor from a column's unit to the wanted one."""
    try:
        return columns.factor_of(unit, wanted, head)
    except ValueError as error:
        raise ValueError(f"{path}: column {head!r}: {error}") from None


def compared_table(series: list[Compared]) -> pd.DataFrame:
    """Return a table with a row for each series: unit, points, rms, bias, ratios of peaks."""
    rows = [
        {
            "series": beside.head,
            "unit": beside.unit,
            "points": len(beside.place),
            "measured mean": float(beside.measured.mean()),
            "run mean": float(beside.run.mean()),
            "rms difference": beside.rms,
            "bias": beside.bias,
            "greatest, run / measured": beside.peak_ratio(True),
            "least, run / measured": beside.peak_ratio(False),
        }
        for beside in series
    ]
    return pd.DataFrame(rows)
