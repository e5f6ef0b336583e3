"""Measured heights from files: ESRI ASCII grids, NPY, NetCDF, and GeoTIFF where rasterio is installed."""

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.ndimage import gaussian_filter

from exudyn_crawler.case.parameters.base import Errors, File, Parameters, Place, quantity

STEEPEST = 1.0
"""Rise over run beyond which heights are a wall, which cells do not know."""


class HeightGrid(NamedTuple):
    """Heights (nx, ny) at places (nx,) and (ny,) that rise evenly; m."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


class MeasuredGrid(Parameters):
    """Heights of a file, smoothed: a step between two of them has no slope of its own."""

    file: File = quantity("", "ESRI ASCII grid (.asc), NumPy array (.npy), NetCDF (.nc) or GeoTIFF (.tif)")
    smoothing: float = quantity(
        "m", "standard deviation of the Gaussian that smooths; about a cell", ge=0, le=100, default=0.1
    )
    spacing: float | None = quantity(
        "m", "of the places of an array (x, y) in an NPY file, which has none", gt=0, le=1e4, default=None
    )
    origin: tuple[Place, Place] = quantity(
        "m", "x and y of the first place of an NPY file; shift of those of other files", default=(0.0, 0.0)
    )

    def _errors(self) -> Errors:
        try:
            steepest = np.abs(np.concatenate([np.ravel(one) for one in self._slopes])).max()
        except (OSError, KeyError, ValueError) as error:
            yield f"file: {self.file} cannot be used: {' '.join(str(error).split())}"
            return
        if steepest > STEEPEST:
            yield (
                f"smoothing: heights of {self.file} must not rise by more than {STEEPEST:g} m a metre, since "
                f"cells know no walls, got {steepest:.3g} with smoothing = {self.smoothing:g} m"
            )

    @property
    def _heights(self) -> "_Heights":
        """Smoothed heights; a file that changes is read again."""
        stamp = self.file.stat().st_mtime_ns
        return _smoothed(self.file, stamp, self.spacing, self.origin, self.smoothing)

    @property
    def _slopes(self) -> tuple[np.ndarray, np.ndarray]:
        x, y, z = self._heights.grid
        return np.diff(z, axis=0) / (x[1] - x[0]), np.diff(z, axis=1) / (y[1] - y[0])

    def sample(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Height and slopes as of `Heights.sample`."""
        grid, ev = self._heights.grid, self._heights.spline.ev
        out = np.stack([ev(x, y), ev(x, y, dx=1), ev(x, y, dy=1)], axis=-1)
        out[(x < grid.x[0]) | (x > grid.x[-1]) | (y < grid.y[0]) | (y > grid.y[-1])] = np.nan
        return out


class _Heights(NamedTuple):
    """Smoothed heights, and what goes through them."""

    grid: HeightGrid
    spline: RectBivariateSpline


@lru_cache(maxsize=4)
def _smoothed(
    file: Path, _stamp: int, spacing: float | None, origin: tuple[float, float], smoothing: float
) -> _Heights:
    """Heights of a file as of `MeasuredGrid`."""
    if file.suffix.lower() not in READERS:
        raise ValueError(f"its name must end with one of {', '.join(READERS)}")
    grid = READERS[file.suffix.lower()](file, spacing)
    if min(grid.z.shape) < 4:
        raise ValueError(f"at least 4 x 4 heights are needed, got {grid.z.shape[0]} x {grid.z.shape[1]}")
    holes = np.argwhere(~np.isfinite(grid.z))
    if len(holes):
        x, y = grid.x[holes[0, 0]], grid.y[holes[0, 1]]
        raise ValueError(f"heights are missing at {len(holes)} places, the first at x = {x:g} m, y = {y:g} m")
    x, y = grid.x + origin[0], grid.y + origin[1]
    z = gaussian_filter(grid.z, [smoothing / (one[1] - one[0]) for one in (x, y)], mode="nearest")
    return _Heights(HeightGrid(x, y, z), RectBivariateSpline(x, y, z))


def _ascii(path: Path, _spacing: float | None) -> HeightGrid:
    words = path.read_text(encoding="ascii").lower().split()
    head: dict[str, float] = {}
    while len(words) > 1 and words[0][0].isalpha() and words[0] != "nan":
        name, value, *words = words
        head[name] = float(value)
    missing = [name for name in ("ncols", "nrows", "cellsize") if name not in head]
    if missing:
        raise ValueError(f"its head has no {' and no '.join(missing)}")
    columns, rows, side = int(head["ncols"]), int(head["nrows"]), head["cellsize"]
    if len(words) != columns * rows:
        raise ValueError(f"{columns} x {rows} heights are announced, got {len(words)}")
    z = np.array(words, dtype=float).reshape(rows, columns)[::-1].T
    z[z == head.get("nodata_value", -9999.0)] = np.nan
    x, y = (
        head[f"{axis}llcenter"] if f"{axis}llcenter" in head else head[f"{axis}llcorner"] + 0.5 * side
        for axis in "xy"
    )
    return HeightGrid(x + side * np.arange(columns), y + side * np.arange(rows), z)


def _npy(path: Path, spacing: float | None) -> HeightGrid:
    if spacing is None:
        raise ValueError("an NPY file needs a spacing")
    z = np.load(path, allow_pickle=False).astype(float)
    if z.ndim != 2:
        raise ValueError(f"its array must have 2 axes, got {z.ndim}")
    return HeightGrid(spacing * np.arange(z.shape[0]), spacing * np.arange(z.shape[1]), z)


def _netcdf(path: Path, _spacing: float | None) -> HeightGrid:
    import xarray

    with xarray.open_dataset(path) as data:
        fields = [one for one in data.data_vars.values() if set(one.dims) == {"x", "y"}]
        if len(fields) != 1:
            raise ValueError(f"it must have one variable over x and y, got {len(fields)}")
        field = fields[0].sortby(["x", "y"]).transpose("x", "y").astype(float)
        x, y = field["x"].values.astype(float), field["y"].values.astype(float)
        if any(np.ptp(np.diff(one)) > 1e-6 * np.ptp(one) for one in (x, y) if len(one) > 1):
            raise ValueError("the steps of x and of y must be even")
        return HeightGrid(x, y, field.values)


def _tiff(path: Path, _spacing: float | None) -> HeightGrid:
    try:
        import rasterio
    except ImportError:
        raise ValueError("GeoTIFF needs the package rasterio, which is not installed") from None
    with rasterio.open(path) as data:
        move = data.transform
        if move.b != 0.0 or move.d != 0.0 or move.a <= 0.0 or move.e >= 0.0:
            raise ValueError("its rows must run from north to south, its columns from west to east")
        z = data.read(1, masked=True).astype(float).filled(np.nan)
    x = move.c + move.a * (np.arange(z.shape[1]) + 0.5)
    y = move.f + move.e * (np.arange(z.shape[0]) + 0.5)
    return HeightGrid(x, y[::-1], z[::-1].T)


READERS: dict[str, Callable[[Path, float | None], HeightGrid]] = {
    ".asc": _ascii,
    ".npy": _npy,
    ".nc": _netcdf,
    ".tif": _tiff,
    ".tiff": _tiff,
}
"""Readers by the ending of a file's name."""
