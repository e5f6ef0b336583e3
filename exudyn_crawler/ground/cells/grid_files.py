"""Measured heights from files: ESRI ASCII grids, NPY, NetCDF, and GeoTIFF where rasterio is installed."""

from collections.abc import Callable
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator
from scipy.interpolate import RectBivariateSpline
from scipy.ndimage import gaussian_filter

from exudyn_crawler.case.parameters.base import Parameters, Place, quantity

STEEPEST = 1.0
"""Rise over run beyond which heights are a wall, which cells do not know."""


class HeightGrid(NamedTuple):
    """Heights (nx, ny) at places (nx,) and (ny,) that rise evenly; m."""

    x: NDArray
    y: NDArray
    z: NDArray


class MeasuredGrid(Parameters):
    """Heights of a file, smoothed: a step between two of them has no slope of its own."""

    file: Path = quantity("", "ESRI ASCII grid (.asc), NumPy array (.npy), NetCDF (.nc) or GeoTIFF (.tif)")
    smoothing: float = quantity(
        "m", "standard deviation of the Gaussian that smooths; about a cell", ge=0, le=100, default=0.1
    )
    spacing: float | None = quantity(
        "m", "of the places of an array (x, y) in an NPY file, which has none", gt=0, le=1e4, default=None
    )
    origin: tuple[Place, Place] = quantity(
        "m",
        "x and y of the first place of an NPY file; shift of the places of other files",
        default=(0.0, 0.0),
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        self._spline  # noqa: B018 - a bad file is refused at once
        return self

    @cached_property
    def _spline(self) -> tuple[RectBivariateSpline, HeightGrid]:
        grid = read_grid(self.file, self.spacing)
        x, y = grid.x + self.origin[0], grid.y + self.origin[1]
        pitch = (x[1] - x[0], y[1] - y[0])
        z = gaussian_filter(grid.z, [self.smoothing / one for one in pitch], mode="nearest")
        steep = [np.abs(np.diff(z, axis=axis)) / one for axis, one in enumerate(pitch)]
        worst = max(float(one.max()) for one in steep)
        if worst > STEEPEST:
            raise ValueError(
                f"smoothing: heights of {self.file} must not rise by more than {STEEPEST:g} m a metre, since "
                f"cells know no walls, got {worst:.3g} with smoothing = {self.smoothing:g} m"
            )
        return RectBivariateSpline(x, y, z), HeightGrid(x, y, z)

    def sample(self, x: NDArray, y: NDArray) -> NDArray:
        """Height and slopes as of `Heights.sample`."""
        spline, grid = self._spline
        out = np.stack([spline.ev(x, y), spline.ev(x, y, dx=1), spline.ev(x, y, dy=1)], axis=-1)
        outside = (x < grid.x[0]) | (x > grid.x[-1]) | (y < grid.y[0]) | (y > grid.y[-1])
        out[outside] = np.nan
        return out


@lru_cache(maxsize=4)
def read_grid(path: Path, spacing: float | None = None) -> HeightGrid:
    """Heights of a file.

    Raises
    ------
    ValueError
        In one line, if the file cannot be read or has holes.
    """
    if path.suffix.lower() not in READERS:
        raise ValueError(f"file: must end with one of {', '.join(READERS)}, got {path}")
    try:
        grid = READERS[path.suffix.lower()](path, spacing)
    except (OSError, KeyError, ValueError) as error:
        raise ValueError(f"file: {path} cannot be read: {' '.join(str(error).split())}") from None
    if min(grid.z.shape) < 4:
        raise ValueError(
            f"file: {path} must have at least 4 x 4 heights, got {grid.z.shape[0]} x {grid.z.shape[1]}"
        )
    holes = np.argwhere(~np.isfinite(grid.z))
    if len(holes):
        i, j = holes[0]
        raise ValueError(
            f"file: {path} must have no holes, got {len(holes)}, the first at "
            f"x = {grid.x[i]:g} m, y = {grid.y[j]:g} m"
        )
    return grid


def _ascii(path: Path, _spacing: float | None) -> HeightGrid:
    head: dict[str, float] = {}
    numbers: list[float] = []
    for line in path.read_text(encoding="ascii").splitlines():
        words = line.split()
        if words and not numbers and words[0][0].isalpha() and words[0].lower() != "nan":
            head[words[0].lower()] = float(words[1])
        else:
            numbers.extend(map(float, words))
    missing = [name for name in ("ncols", "nrows", "cellsize") if name not in head]
    if missing:
        raise ValueError(f"the head has no {' and no '.join(missing)}")
    columns, rows, side = int(head["ncols"]), int(head["nrows"]), head["cellsize"]
    if len(numbers) != columns * rows:
        raise ValueError(f"{columns} x {rows} heights are announced, {len(numbers)} are there")
    z = np.array(numbers).reshape(rows, columns)[::-1].T.copy()
    z[z == head.get("nodata_value", -9999.0)] = np.nan
    first = [
        head[f"{axis}llcenter"] if f"{axis}llcenter" in head else head[f"{axis}llcorner"] + 0.5 * side
        for axis in "xy"
    ]
    return HeightGrid(first[0] + side * np.arange(columns), first[1] + side * np.arange(rows), z)


def _npy(path: Path, spacing: float | None) -> HeightGrid:
    if spacing is None:
        raise ValueError("an NPY file needs a spacing")
    z = np.load(path, allow_pickle=False).astype(float)
    if z.ndim != 2:
        raise ValueError(f"the array must have 2 axes, got {z.ndim}")
    return HeightGrid(spacing * np.arange(z.shape[0]), spacing * np.arange(z.shape[1]), z)


def _netcdf(path: Path, _spacing: float | None) -> HeightGrid:
    import xarray

    with xarray.open_dataset(path) as data:
        fields = [one for one in data.data_vars.values() if set(one.dims) == {"x", "y"}]
        if len(fields) != 1:
            raise ValueError(f"one variable over x and y is needed, got {len(fields)}")
        field = fields[0].sortby(["x", "y"]).transpose("x", "y")
        x, y = field["x"].values.astype(float), field["y"].values.astype(float)
        for axis, values in (("x", x), ("y", y)):
            steps = np.diff(values)
            if len(steps) and np.ptp(steps) > 1e-6 * abs(steps[0]):
                raise ValueError(f"{axis} must have even steps, got {steps.min():g} to {steps.max():g}")
        return HeightGrid(x, y, field.values.astype(float))


def _tiff(path: Path, _spacing: float | None) -> HeightGrid:
    try:
        import rasterio
    except ImportError:
        raise ValueError("GeoTIFF needs the package rasterio, which is not installed") from None
    with rasterio.open(path) as data:
        move = data.transform
        if move.b != 0.0 or move.d != 0.0:
            raise ValueError("a turned grid is not allowed")
        z = data.read(1, masked=True).astype(float).filled(np.nan)
        x = move.c + move.a * (np.arange(data.width) + 0.5)
        y = move.f + move.e * (np.arange(data.height) + 0.5)
    order_x, order_y = np.argsort(x), np.argsort(y)
    return HeightGrid(x[order_x], y[order_y], z[order_y][:, order_x].T.copy())


READERS: dict[str, Callable[[Path, float | None], HeightGrid]] = {
    ".asc": _ascii,
    ".npy": _npy,
    ".nc": _netcdf,
    ".tif": _tiff,
    ".tiff": _tiff,
}
"""Readers by the ending of a file's name."""
