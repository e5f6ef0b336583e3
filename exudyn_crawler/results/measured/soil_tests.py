"""Tables of soil tests: plate sinkage, and shear under a pressure."""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from exudyn_crawler.case.parameters.columns import read_columns
from exudyn_crawler.errors import ImplausibleWarning
from exudyn_crawler.settings import fields

LOOP_SHARE, LOOP_DROP = 0.8, 0.1
"""Criteria of an unloading, as opposed to scatter. The pressure falls below the first fraction of the
greatest one before it, and by more than the second fraction of the test's greatest one. Chosen here."""
LIFTED = 0.02
"""Pressure below which a plate may be off the ground, fraction of that before unloading. Chosen here."""


DEEPEST, WIDEST, FARTHEST = 2.0, 3.0, 1.0
"""Greatest plausible sinkage, plate size and displacement in shear, m; beyond it the unit is likely wrong."""
OFF = 10.0  # greatest plausible ratio of a pressure or sinkage to both neighbours, or its reciprocal
HIGHEST = 1e7  # greatest plausible pressure or stress, Pa
LEAST_CURVE = 4  # least number of points of a shear test for a check of its curve
LIFTS = 0.5  # greatest rise of a plate under most of its pressure, fraction of the sinkage. Chosen here
CONVEX = 0.4  # least plausible area below stress over displacement, fraction of its rectangle. Chosen here
SWAPPED = "are the columns {} and {} swapped?"
STEEPEST, STICKIEST = 3.0, 1e5
"""Greatest plausible shear stress: its ratio to the pressure, plus a constant, Pa."""
PULLS = 0.05  # greatest value of the other sign, or of little weight, fraction of the greatest value


@dataclass(frozen=True)
class Loop:
    """Unloading of a plate and the reloading that follows."""

    deepest: float  # sinkage at the begin, m
    sinkage: np.ndarray  # (points,), m
    pressure: np.ndarray  # (points,), Pa


@dataclass(frozen=True)
class PlateTests:
    """Points of plate tests, in the order of the measurement."""

    sinkage: np.ndarray  # (points,), m
    pressure: np.ndarray  # (points,), Pa
    width: np.ndarray  # (points,), m, shorter side or diameter of the plate
    test: np.ndarray  # (points,), name of the test

    @property
    def widths(self) -> np.ndarray:
        """Different widths of plates, m."""
        return np.unique(self.width)

    def each(self) -> Iterator[np.ndarray]:
        """Yield the indices of the points of each test, in their order."""
        yield from _each(self.test)

    def implausible(self) -> Iterator[str]:
        """Yield lines about implausible points."""
        yield from _beyond("sinkage", self.sinkage, DEEPEST, "m")
        yield from _beyond("plate", self.width, WIDEST, "m")
        yield from _beyond("pressure", self.pressure, HIGHEST, "Pa")
        yield from _other_sign("pressure", self.pressure, "Pa")
        yield from _other_sign("sinkage", self.sinkage, "m")
        for points in self.each():
            # a plate comes up in an unloading
            sinkage = self.sinkage[points]
            pressure = self.pressure[points]
            deepest = np.maximum.accumulate(sinkage)
            up = np.flatnonzero(
                (sinkage < (1.0 - LIFTS) * deepest) & (pressure > LIFTS * np.maximum.accumulate(pressure))
            )
            if len(up) > 1:
                row = int(up[0])
                lifts = (
                    f"comes up from {deepest[row]:.4g} to {sinkage[row]:.4g} m under {pressure[row]:.4g} Pa"
                )
                yield f"at point {points[row] + 1} the plate {lifts}: {SWAPPED.format('sinkage', 'pressure')}"
            yield from _off_neighbours("pressure", "Pa", points, pressure, sinkage)
            yield from _off_neighbours("sinkage", "m", points, sinkage, pressure)

    def of(self, points: np.ndarray) -> Self:
        """Return some of the points, by their indices or as a mask."""
        return type(self)(self.sinkage[points], self.pressure[points], self.width[points], self.test[points])

    def split(self) -> tuple["PlateTests", list[Loop]]:
        """Return the points of first loading, and the loops of unloading and reloading."""
        first = np.ones(len(self.sinkage), dtype=bool)
        loops = []
        for points in self.each():
            pressure = self.pressure[points]
            greatest = np.maximum.accumulate(pressure)
            below = np.flatnonzero(pressure < greatest)
            for run in np.split(below, np.flatnonzero(np.diff(below) > 1) + 1):
                if not len(run):
                    continue
                top = greatest[run[0]]
                least = pressure[run].min()
                if least > LOOP_SHARE * top or top - least < LOOP_DROP * greatest[-1]:
                    continue
                first[points[run]] = False
                inside = points[run[pressure[run] > LIFTED * top]]
                start = points[run[0] - 1]
                loops.append(Loop(self.sinkage[start], self.sinkage[inside], self.pressure[inside]))
        return self.of(first & (self.sinkage > 0.0) & (self.pressure > 0.0)), loops


@dataclass(frozen=True)
class ShearTests:
    """Points of shear tests."""

    displacement: np.ndarray  # (points,), m
    stress: np.ndarray  # (points,), Pa
    pressure: np.ndarray  # (points,), Pa
    test: np.ndarray  # (points,), name of the test

    def implausible(self) -> Iterator[str]:
        """Yield lines about implausible points."""
        yield from _beyond("displacement", self.displacement, FARTHEST, "m")
        yield from _beyond("pressure", self.pressure, HIGHEST, "Pa")
        yield from _other_sign("displacement", self.displacement, "m")
        yield from _other_sign("stress", self.stress, "Pa")
        if (share := self._area_share) < CONVEX:
            rises = "stress rises ever faster with displacement, and tends to no strength"
            yield f"{rises} ({share:.2g} of the rectangle): {SWAPPED.format('displacement', 'stress')}"
        for points in _each(self.test):
            displacement = self.displacement[points]
            stress = self.stress[points]
            yield from _off_neighbours("displacement", "m", points, displacement, np.arange(len(points)))
            yield from _off_neighbours("stress", "Pa", points, stress, displacement)
        over = self.stress - STEEPEST * self.pressure
        row = int(over.argmax())
        if over[row] > STICKIEST:
            under = f"under a pressure of {self.pressure[row]:.4g} Pa: are their units right?"
            yield f"point {row + 1} has a stress of {self.stress[row]:.4g} Pa {under}"

    def of(self, points: np.ndarray) -> Self:
        """Return some of the points, by their indices or as a mask."""
        values = self.displacement, self.stress, self.pressure, self.test
        return type(self)(*(array[points] for array in values))

    @property
    def _area_share(self) -> float:
        """Area below stress over displacement, fraction of its rectangle: mean of tests, 1 without tests."""
        shares = []
        for points in _each(self.test):
            displacement = np.append(0.0, self.displacement[points])
            stress = np.append(0.0, self.stress[points])
            rectangle = displacement.max() * stress.max()
            if len(points) >= LEAST_CURVE and rectangle > 0.0 and np.all(np.diff(displacement) >= 0.0):
                shares.append(np.trapezoid(stress, displacement) / rectangle)
        return float(np.mean(shares)) if shares else 1.0

    @property
    def pressures(self) -> np.ndarray:
        """Mean pressures of the tests, Pa."""
        return np.array([self.pressure[self.test == name].mean() for name in np.unique(self.test)])


def _each(tests: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the indices of the points of each test, from the test's name of each point (points,)."""
    for name in dict.fromkeys(tests.tolist()):
        yield np.flatnonzero(tests == name)


def _beyond(name: str, values: np.ndarray, greatest: float, unit: str) -> Iterator[str]:
    row = int(values.argmax())
    if values[row] > greatest:
        more = f"more than {greatest:g} {unit}: is its unit right?"
        yield f"point {row + 1} has a {name} of {values[row]:.4g} {unit}, {more}"


def _off_neighbours(
    name: str, unit: str, points: np.ndarray, values: np.ndarray, rising: np.ndarray
) -> Iterator[str]:
    """Yield a line about a test's first point far off both neighbours while another value rises."""
    before, value, after = (values[k : len(points) - 2 + k] for k in range(3))
    rises = (np.diff(rising) > 0.0)[:-1] & (np.diff(rising) > 0.0)[1:]
    low = OFF * value < np.minimum(before, after)
    high = value > OFF * np.maximum(before, after)
    wrong = np.flatnonzero(rises & (np.minimum(before, after) > 0.0) & (low | high))
    if len(wrong):
        row = int(wrong[0])
        beside = f"beside {before[row]:.4g} and {after[row]:.4g} {unit}: is its decimal point right?"
        yield f"point {points[row + 1] + 1} has a {name} of {value[row]:.4g} {unit} {beside}"


def _other_sign(name: str, values: np.ndarray, unit: str) -> Iterator[str]:
    row = int(values.argmin())
    if values[row] < -PULLS * values.max():
        yield f"point {row + 1} has a {name} of {values[row]:.4g} {unit}, against all others"


def _warn_of_odd(path: str | Path, tests: PlateTests | ShearTests) -> None:
    for line in tests.implausible():
        warnings.warn(f"{path}: {line}", ImplausibleWarning, stacklevel=3)


def read_plates(path: str | Path) -> PlateTests:
    """Read plate tests from a CSV file with `sinkage`, `pressure` or `force`, `width` or `diameter`, `test`.

    A force is divided by the area of a round plate of this diameter, or of a plate of ``width`` and
    ``length``. Without `test` the points of a plate size are one test. FileNotFoundError if there is no such
    file; ValueError with the file and its fault.
    """
    units = {"sinkage": "m", "pressure": "Pa", "force": "N", "width": "m", "length": "m", "diameter": "m"}
    columns = read_columns(path, units, ("test",))
    if "sinkage" not in columns:
        raise ValueError(f"{path} must have a column 'sinkage', such as 'sinkage in mm'")
    if ("width" in columns) == ("diameter" in columns):
        raise ValueError(f"{path} must have a column 'width' (of the shorter side) or 'diameter'")
    if ("pressure" in columns) == ("force" in columns):
        raise ValueError(f"{path} must have a column 'pressure' or 'force'")
    if "diameter" in columns:
        width = columns["diameter"]
        area = 0.25 * np.pi * width**2
    else:
        width = columns["width"]
        area = width * columns.get("length", width)
    if (area <= 0.0).any():
        raise ValueError(f"{path}: sizes of plates must be greater than zero, got {width.min():.4g} m")
    if "force" in columns and "diameter" not in columns and "length" not in columns:
        raise ValueError(f"{path}: forces on plates with a 'width' need a column 'length', too")
    pressure = columns["pressure"] if "pressure" in columns else columns["force"] / area
    test = columns.get("test", np.array([f"{1e3 * size:.4g} mm" for size in width]))
    tests = PlateTests(columns["sinkage"], pressure, width, test)
    for points in tests.each():
        if len(np.unique(width[points])) > 1:
            raise ValueError(f"{path}: test {str(test[points[0]])!r} must have one plate")
    _warn_of_odd(path, tests)
    return tests


def read_shear(path: str | Path) -> ShearTests:
    """Read shear tests from a CSV file with `displacement`, `stress`, `pressure`, and `test`.

    Without `test` the points of a pressure are one test. FileNotFoundError if there is no such file;
    ValueError with the file and its fault.
    """
    columns = read_columns(path, {"displacement": "m", "stress": "Pa", "pressure": "Pa"}, ("test",))
    for name in ("displacement", "stress", "pressure"):
        if name not in columns:
            raise ValueError(f"{path} must have a column {name!r}")
    if (columns["pressure"] <= 0.0).any():
        swapped = f"; {SWAPPED.format('pressure', 'stress')}" if (columns["stress"] > 0.0).all() else ""
        least = fields.four_digits(columns["pressure"].min())
        raise ValueError(f"{path}: pressure must be greater than zero, got {least} Pa{swapped}")
    test = columns.get("test", np.array([f"{1e-3 * value:.4g} kPa" for value in columns["pressure"]]))
    tests = ShearTests(columns["displacement"], columns["stress"], columns["pressure"], test)
    _warn_of_odd(path, tests)
    return tests
