"""Measured terrain: a height grid from a file, smoothed and placed below the track."""

from functools import lru_cache
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Le
from scipy import interpolate, ndimage

from exudyn_crawler.case.parameters.grids import PROJECT, HeightGrid, Units, read_grid, size_of
from exudyn_crawler.settings.parameters import Errors, File, Parameters, option, quantity

STEEPEST = 1.0  # greatest rise over run; steeper heights are a wall, which cells do not allow
STEP = 0.2
"""Greatest second difference of slopes without smoothing; splines then overshoot by 1 % of a spacing.

A step has a second difference of twice its slope.
"""
GREATER_UNITS = ("km", "mi")
"""Candidate units of coordinates for a grid that is too small for a track in m."""
SMALLER_UNITS = ("ft", "cm", "mm")
"""Candidate units of heights that are too steep in m."""
MOST_DEGREES = 360.0
FINEST = 0.02
"""Spacing (m) below which coordinates may be in degrees or km; cells of the ground are not finer."""

Shift = Annotated[float, Ge(-1e8), Le(1e8)]  # m, shift of a map; northings of all national grids are within
Bounds = tuple[tuple[float, float], tuple[float, float]]
"""Least and greatest x, least and greatest y, m."""


class MeasuredGrid(Parameters):
    """Heights of a file, smoothed: a step between two of them has no slope of its own."""

    file: File = quantity(
        "", "file of the grid: ESRI ASCII grid (.asc), NumPy array (.npy), NetCDF (.nc) or GeoTIFF (.tif)"
    )
    smoothing: float = quantity(
        "m",
        "standard deviation of the Gaussian smoothing; about the size of a cell",
        ge=0,
        le=100,
        default=0.1,
    )
    spacing: float | None = quantity(
        "m",
        "spacing of the points of a file without positions: NPY, or NetCDF; array (x, y)",
        gt=0,
        le=1e4,
        default=None,
    )
    origin: tuple[Shift, Shift] = quantity(
        "m",
        "x and y of the first point of a file without positions; shift of the points of other files",
        default=(0.0, 0.0),
    )
    place_unit: str | None = option(
        "unit of the file's positions, such as km; none: as stated in the file, or m", None
    )
    height_unit: str | None = option(
        "unit of the file's heights, such as mm or ft; none: as stated in the file, or m", None
    )

    def _errors(self) -> Errors:
        try:
            surface = self._surface
        except (OSError, KeyError, ValueError) as error:
            yield f"file: {self.file} cannot be used: {' '.join(str(error).split())}"
            return
        sides = surface.grid.sides
        known = np.where(surface.known, surface.grid.z, np.nan)
        steepest, bend = (
            [np.nanmax(abs(np.diff(known, n, axis=k)), initial=0.0) / side for k, side in enumerate(sides)]
            for n in (1, 3)
        )
        bent = [side for side, rise in zip(sides, bend, strict=True) if rise > STEP]
        least = 0.5 * max(bent, default=0.0)
        if (rise := float(max(steepest))) > STEEPEST:
            yield (
                f"smoothing: heights of {self.file} must not rise by more than {STEEPEST:g} m a metre, since "
                f"cells know no walls, got {rise:.3g} with smoothing = {self.smoothing:g} m"
                f"{self._unit_of(rise)}"
            )
        elif self.smoothing < least:
            yield (
                f"smoothing: must be at least {least:g} m, half a spacing of {self.file}, since its heights "
                f"have steps, got {self.smoothing:g} m"
            )

    def _unit_of(self, rise: float) -> str:
        """Describe the likely unit of heights if a rise (m a metre) is too steep; empty if none is likely."""
        likely = [unit for unit in SMALLER_UNITS if rise * size_of(unit, "heights") <= STEEPEST]
        if self.height_unit or not likely:
            return ""
        says = " or ".join(f"height_unit = {unit!r}" for unit in likely)
        return f"; are they in {' or '.join(likely)}? {says} says so"

    @property
    def _surface(self) -> "_Surface":
        """Smoothed heights; a file that changes is read again."""
        stamp = self.file.stat().st_mtime_ns
        units = Units(self.place_unit, self.height_unit, self.spacing)
        return _smoothed(self.file, stamp, units, self.origin, self.smoothing)

    @property
    def sides(self) -> tuple[float, float]:
        """Spacing of the heights along x and y, m."""
        return self._surface.grid.sides

    def sample(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return height and slopes, see `Heights.sample`; NaN beyond the grid and beside missing heights."""
        surface = self._surface
        ev = surface.spline.ev
        out = np.stack([ev(x, y), ev(x, y, dx=1), ev(x, y, dy=1)], axis=-1)
        out[~surface.knows(x, y)] = np.nan
        return out

    def misfit(self, corners: np.ndarray, bounds: Bounds) -> str:
        """Describe why the grid does not cover a track, and a remedy; empty if it covers the track.

        `corners` (times, 4, 2), m, are those of a rectangle on the ground, such as the track. `bounds` are
        those of the terrain, m.
        """
        surface = self._surface
        low = corners.min(axis=(0, 1))
        high = corners.max(axis=(0, 1))
        ends = surface.ends
        wanted = f"{self.file.name} must have heights wherever the track comes, {_extent(low, high)}"
        if (low < ends[0]).any() or (high > ends[1]).any():
            remedy = self._remedy(np.array([low, high]), np.transpose(bounds))
            return f"{wanted}, and has them at {_extent(*ends)}; {remedy}"
        if (hole := surface.first_hole(corners)) is not None:
            return f"{wanted}; they are missing about x = {hole[0]:.4g} m, y = {hole[1]:.4g} m"
        return ""

    def _remedy(self, track: np.ndarray, terrain: np.ndarray) -> str:
        """Describe the shift or unit that brings the grid below a track, or say that none does.

        `track` and `terrain` are lowest and highest places: arrays (2, 2), m. The middle of the grid goes to
        that of the terrain if the grid then covers the track, else to that of the track.
        """
        surface = self._surface
        ends = surface.ends
        size = ends[1] - ends[0]
        wanted = track[1] - track[0]
        for place in (terrain, track):
            shift = np.round(0.5 * (place - ends).sum(axis=0), 2)
            if (ends[0] + shift <= track[0]).all() and (ends[1] + shift >= track[1]).all():
                x, y = (np.array(self.origin) + shift).tolist()
                return f"origin = [{x:.10g}, {y:.10g}] would bring it there"
        raw = ends - self.origin
        is_fine = max(self.sides) < FINEST
        if is_fine and np.abs(raw).max() <= MOST_DEGREES and raw[0].max() > 1.0:
            return f"its places from {raw[0][0]:.6g}, {raw[0][1]:.6g} look like degrees: {PROJECT}"
        sizes = {unit: size_of(unit, "places") * size for unit in GREATER_UNITS}
        large = {
            unit: f"with place_unit = {unit!r} it is {in_unit[0]:.4g} x {in_unit[1]:.4g} m large"
            for unit, in_unit in sizes.items()
            if (in_unit >= wanted).all()
        }
        if is_fine and self.place_unit is None and large:
            return f"are its places in {' or '.join(large)}? {'; '.join(large.values()).capitalize()}"
        return f"it is {size[0]:.4g} x {size[1]:.4g} m large, too small wherever it lies"


class _Surface(NamedTuple):
    """Smoothed heights of a grid, and the spline through them."""

    grid: HeightGrid
    known: np.ndarray  # (nx, ny): True where a height was measured
    spline: interpolate.RectBivariateSpline

    @property
    def ends(self) -> np.ndarray:
        """Lowest and highest place: array (2, 2), m."""
        return np.array([[self.grid.x[k], self.grid.y[k]] for k in (0, -1)])

    def knows(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return True for places (m) between four measured heights: array of their shape."""
        (x0, y0), (x1, y1) = self.ends
        inside = (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)
        if self.known.all():
            return inside
        whole = self.known[:-1, :-1] & self.known[1:, :-1] & self.known[:-1, 1:] & self.known[1:, 1:]
        (along, aside) = self.grid.sides
        (columns, rows) = whole.shape
        column = np.clip((x - x0) / along, 0, columns - 1).astype(int)
        row = np.clip((y - y0) / aside, 0, rows - 1).astype(int)
        return inside & whole[column, row]

    def first_hole(self, corners: np.ndarray) -> np.ndarray | None:
        """Return the first place (x, y), m, with missing heights in rectangles (times, 4, 2), or None."""
        if self.known.all():
            return None
        step = 0.5 * min(self.grid.sides)
        along = corners[:, 1] - corners[:, 0]
        aside = corners[:, 3] - corners[:, 0]
        counts = [2 + int(np.linalg.norm(side[0]) / step) for side in (along, aside)]
        share, other = (np.linspace(0.0, 1.0, count) for count in counts)
        for first, one_side, other_side in zip(corners[:, 0], along, aside, strict=True):
            places = first + share[:, None, None] * one_side + other[:, None] * other_side
            missing = places[~self.knows(places[..., 0], places[..., 1])]
            if len(missing):
                return np.asarray(missing[0])
        return None


@lru_cache(maxsize=4)
def _smoothed(
    file: Path, _stamp: int, units: Units, origin: tuple[float, float], smoothing: float
) -> _Surface:
    """Return the smoothed surface of a file for a `MeasuredGrid`; nearest heights replace missing ones."""
    grid = read_grid(file, units)
    z = grid.z
    known = np.isfinite(grid.z)
    sides = grid.sides
    if not known.all():
        z = z[
            tuple(ndimage.distance_transform_edt(~known, sides, return_distances=False, return_indices=True))
        ]
    z = ndimage.gaussian_filter(z, [smoothing / side for side in sides], mode="nearest")
    grid = HeightGrid(grid.x + origin[0], grid.y + origin[1], z)
    return _Surface(grid, known, interpolate.RectBivariateSpline(*grid))


def _extent(low: np.ndarray, high: np.ndarray) -> str:
    """Return the text of the rectangle between two places, m."""
    spans = [
        f"{least:.6g}..{most:.6g} m" if abs(least) < 1e3 else f"{least:.0f}..{most:.0f} m"
        for least, most in zip(low, high, strict=True)
    ]
    return f"x = {spans[0]}, y = {spans[1]}"
