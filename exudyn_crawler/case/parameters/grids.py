"""Files of measured height grids: ESRI ASCII, NPY, NetCDF, and GeoTIFF if rasterio is installed.

A reader returns evenly spaced, rising coordinates and heights, all in m. It raises `ValueError`, with a
remedy, for missing or ambiguous information.
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.case.parameters.columns import MISSING, read_text
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.units import number_of

LEAST = 4  # least number of heights along each side, as for a cubic spline
CLIFF = 1000.0
"""Least distance (m) of an extreme height from all others at which it counts as a missing value."""
HIGHEST = 12e3  # m, greatest height above or below sea level; no ground on Earth is beyond
EVEN = 1e-6  # greatest deviation of coordinates from even spacing, fraction of the grid's extent
CLOSE = 1e-6  # relative tolerance of the declared value for missing heights, for rounding in float32
HEAD = ("ncols", "nrows", "cellsize", "dx", "dy", "nodata_value")
CORNERS = ("xllcorner", "yllcorner", "xllcenter", "yllcenter")
COMMA = re.compile(r"[+-]?\d*,\d+(?:e[+-]?\d+)?")
X_NAMES = ("x", "easting", "projection_x_coordinate")
Y_NAMES = ("y", "northing", "projection_y_coordinate")
DEGREES = ("lat", "latitude", "lon", "long", "longitude")


class HeightGrid(NamedTuple):
    """Heights at evenly spaced coordinates; NaN for a missing height."""

    x: np.ndarray  # (nx,), m
    y: np.ndarray  # (ny,), m
    z: np.ndarray  # (nx, ny), m

    @property
    def sides(self) -> tuple[float, float]:
        """Spacing along x and y, m."""
        return float(self.x[1] - self.x[0]), float(self.y[1] - self.y[0])


class Units(NamedTuple):
    """User's information that a file lacks: units (None: those of the file, or m) and a spacing, m."""

    place: str | None
    height: str | None
    spacing: float | None


def read_grid(path: Path, units: Units) -> HeightGrid:
    """Read a file of heights; raises `ValueError` or `OSError` for an unusable file."""
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise ValueError(f"its name must end with one of {', '.join(READERS)}")
    x, y, z = reader(path, units)
    if min(z.shape) < LEAST:
        raise ValueError(f"at least {LEAST} x {LEAST} heights are needed, got {z.shape[0]} x {z.shape[1]}")
    z = np.where(np.isfinite(z), z, np.nan)
    if np.isnan(z).all():
        raise ValueError("all of its heights are missing")
    _refuse_undeclared(z)
    if (farthest := np.nanmax(np.abs(z))) > HIGHEST:
        raise ValueError(
            f"its heights must be within {HIGHEST:g} m of sea level, got {fields.four_digits(farthest)} m; "
            "height_unit says another unit, such as 'mm'"
        )
    return HeightGrid(_even("x", x), _even("y", y), z)


def _refuse_undeclared(z: np.ndarray) -> None:
    """Raise `ValueError` for a height far from all others: a missing value that the file does not declare."""
    heights = np.unique(z[np.isfinite(z)])
    if len(heights) < 2:
        return
    for first, second in ((heights[0], heights[1]), (heights[-1], heights[-2])):
        if abs(first - second) > CLIFF:
            raise ValueError(
                f"{np.sum(z == first)} heights of {first:.6g} m, {abs(first - second):.4g} m off all others, "
                "look like missing ones (no-data) that the file does not declare: write NaN, or declare them "
                "(NODATA_value of an ASCII grid, _FillValue of NetCDF)"
            )


def _even(name: str, places: np.ndarray) -> np.ndarray:
    """Return evenly spaced coordinates (m) for rounded ones of a file; raises `ValueError` if not even."""
    rounding = 2.0 * np.finfo(places.dtype).eps * np.abs(places).max()
    exact = places.astype(float)
    if not np.isfinite(exact).all() or np.ptp(exact) <= rounding:
        raise ValueError(f"its positions along {name} must differ, got {exact[0]:.8g} to {exact[-1]:.8g} m")
    number = np.arange(len(exact))
    even = np.linspace(exact[0], exact[-1], len(exact))
    if rounding > EVEN * np.ptp(exact):
        slope, start = np.polyfit(number, exact, 1)
        even = start + slope * number
    if np.abs(even - exact).max() > max(EVEN * np.ptp(exact), rounding):
        steps = np.diff(exact)
        raise ValueError(f"its steps along {name} must be even, got {steps.min():.6g} to {steps.max():.6g} m")
    return even


def size_of(unit: str, name: str) -> float:
    """Return the size (m) of a unit of length; raises `ValueError`, with `name`, for any other unit."""
    if unit.lower().startswith("degree") or unit.lower() in ("deg", "°"):
        raise ValueError(f"its {name} are in degrees; {PROJECT}")
    size = number_of(f"1 {unit}", "m")
    if not isinstance(size, float):
        raise ValueError(f"{unit!r} must be a unit of length of its {name}, such as m, mm, km or ft")
    return size


PROJECT = "heights are needed over places in m, such as those of a UTM zone (gdalwarp -t_srs EPSG:326nn)"
"""Advice for coordinates in degrees."""


def _ascii(path: Path, units: Units) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    _refuse_spacing(units)
    try:
        text = read_text(path)
    except ValueError:
        raise ValueError("it must be a text: an ESRI ASCII grid has a head and rows of numbers") from None
    words = text.lower().split()
    if "," in text and "." not in text:
        words = [word.replace(",", ".") if COMMA.fullmatch(word) else word for word in words]
    start = 0
    head: dict[str, str] = {}
    while start + 1 < len(words) and words[start][0].isalpha() and words[start] not in MISSING:
        head[words[start]] = words[start + 1]
        start += 2
    columns, rows, sides, corner = _head_values(head)
    if len(words) - start != columns * rows:
        raise ValueError(f"{columns} x {rows} heights are announced in its head, got {len(words) - start}")
    z = _ascii_heights(words[start:]).reshape(rows, columns)[::-1].T
    missing = _number("nodata_value", head.get("nodata_value", "-9999"), or_none=True)
    if missing is not None:
        z[np.isclose(z, missing, rtol=CLOSE, atol=0.0)] = np.nan
    size = 1.0 if units.place is None else size_of(units.place, "places")
    x, y = (size * (corner[k] + sides[k] * np.arange(count)) for k, count in enumerate((columns, rows)))
    return x, y, z * (1.0 if units.height is None else size_of(units.height, "heights"))


def _head_values(head: Mapping[str, str]) -> tuple[int, int, list[float], list[float]]:
    """Return columns, rows, spacing and first coordinates along x and y of a head."""
    if unknown := [name for name in head if name not in HEAD + CORNERS]:
        raise ValueError(f"its head has {unknown[0]!r}, but an ESRI ASCII grid has only {', '.join(HEAD)}")
    missing = [name for name in ("ncols", "nrows") if name not in head]
    has_sides = "cellsize" in head or ("dx" in head and "dy" in head)
    missing += [] if has_sides else ["cellsize"]
    missing += [
        f"{axis}llcorner" for axis in "xy" if not {f"{axis}llcorner", f"{axis}llcenter"} & head.keys()
    ]
    if missing:
        raise ValueError(f"its head has no {' and no '.join(missing)}")
    for axis in "xy":
        if {f"{axis}llcorner", f"{axis}llcenter"} <= head.keys():
            raise ValueError(f"its head must have {axis}llcorner or {axis}llcenter, got both")
    counts = [_number(name, head[name]) for name in ("ncols", "nrows")]
    for name, count in zip(("ncols", "nrows"), counts, strict=True):
        if count != int(count) or count < 1:
            raise ValueError(f"{name} must be a whole number, got {head[name]}")
    names = ["cellsize"] * 2 if "cellsize" in head else ["dx", "dy"]
    sides = [_number(name, head[name]) for name in names]
    for name, side in zip(names, sides, strict=True):
        if side <= 0.0:
            raise ValueError(f"{name} must be positive, got {head[name]}")
    corner = []
    for axis, side in zip("xy", sides, strict=True):
        if f"{axis}llcenter" in head:
            corner.append(_number(f"{axis}llcenter", head[f"{axis}llcenter"]))
        else:
            corner.append(_number(f"{axis}llcorner", head[f"{axis}llcorner"]) + 0.5 * side)
    return int(counts[0]), int(counts[1]), sides, corner


def _number(name: str, word: str, or_none: bool = False) -> Any:
    """Return the number of a head's word; with `or_none`, None for a word for a missing value."""
    if or_none and word in MISSING:
        return None
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{name} must be a number, got {word!r}")
    return value


def _ascii_heights(words: list[str]) -> np.ndarray:
    """Return the heights of words, NaN for missing values; raises `ValueError` for other texts."""
    words = ["nan" if word in MISSING else word for word in words]
    try:
        return np.array(words, dtype=float)
    except ValueError:
        pass
    for number, word in enumerate(words):
        try:
            float(word)
        except ValueError:
            comma = "; numbers have a point, not a comma" if "," in word else ""
            raise ValueError(f"height {number + 1} must be a number, got {word[:40]!r}{comma}") from None
    raise ValueError("its heights must be numbers")


def _refuse_spacing(units: Units) -> None:
    if units.spacing is not None:
        raise ValueError("spacing must be left out: the file has positions")


def _npy(path: Path, units: Units) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    if units.spacing is None:
        raise ValueError("an NPY file needs a spacing")
    with path.open("rb") as file:
        if file.read(6) != b"\x93NUMPY":
            raise ValueError("it must be an NPY file of one array, as numpy.save writes it")
    # a memory map allocates nothing for a head that announces more than the file has
    try:
        z = np.lib.format.open_memmap(path, mode="r")
    except (ValueError, OverflowError) as error:
        raise ValueError(f"its head does not match its content: {error}") from None
    if z.dtype.kind not in "iuf":
        raise ValueError(f"its array must consist of numbers, got {z.dtype}")
    if z.ndim != 2:
        raise ValueError(f"its array must have 2 axes, got {z.ndim}")
    x, y = (units.spacing * np.arange(count) for count in z.shape)
    return x, y, z.astype(float) * (1.0 if units.height is None else size_of(units.height, "heights"))


def _netcdf(path: Path, units: Units) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    import xarray

    from fem.files.hdf5 import check_objects

    check_objects(path)
    try:
        opened = xarray.open_dataset(path, decode_times=False)
    except ValueError:
        raise ValueError("it must be a readable NetCDF file") from None
    with opened as data:
        maps = []
        for variable in data.squeeze().data_vars.values():
            axes = {_axis_of(data, str(dimension)): dimension for dimension in variable.dims}
            if variable.dtype.kind in "iuf" and set(axes) == {"x", "y"}:
                maps.append(variable.transpose(axes["x"], axes["y"]))
        if len(maps) != 1:
            has = [f"{name} over {' and '.join(map(str, data[name].dims))}" for name in data.data_vars]
            raise ValueError(f"it must have one variable over x and y, got {', '.join(has) or 'none'}")
        (field,) = maps
        if not field.size:
            raise ValueError(f"it has no heights: {' x '.join(map(str, field.shape))} of them")
        if str(field.attrs.get("positive", "")).lower() == "down":
            raise ValueError("it has depths, positive downward, but heights are needed: change their sign")
        places = [_netcdf_places(field, str(dimension), units) for dimension in field.dims]
        height = units.height or field.attrs.get("units") or "m"
        z = field.values.astype(float) * size_of(str(height).strip(), "heights")
    rising = [slice(None, None, -1 if along[0] > along[-1] else 1) for along in places]
    return places[0][rising[0]], places[1][rising[1]], z[rising[0], rising[1]]


def _axis_of(data: Any, dimension: str) -> str:
    """Return the axis of a dataset's dimension, "x" or "y", else the dimension's name.

    Raises `ValueError` for coordinates in degrees.
    """
    attributes = data[dimension].attrs if dimension in data.coords else {}
    names = {str(dimension).lower(), str(attributes.get("standard_name", "")).lower()}
    if names & set(DEGREES) or str(attributes.get("units", "")).lower().startswith("degree"):
        raise ValueError(f"its positions are in degrees ({dimension}); {PROJECT}")
    if names & set(X_NAMES):
        return "x"
    return "y" if names & set(Y_NAMES) else str(dimension)


def _netcdf_places(field: Any, dimension: str, units: Units) -> np.ndarray:
    """Return the coordinates of a field along a dimension, m, with the floating-point type of the file."""
    if dimension not in field.coords:
        if units.spacing is None:
            raise ValueError(f"it has no positions along {dimension}: give their spacing")
        return units.spacing * np.arange(field.sizes[dimension])
    _refuse_spacing(units)
    places = field[dimension]
    if places.dtype.kind not in "iuf":
        raise ValueError(f"its positions along {dimension} must be numbers, got {places.dtype}")
    unit = units.place or places.attrs.get("units") or "m"
    values = places.values if places.dtype.kind == "f" else places.values.astype(float)
    return np.asarray(values * values.dtype.type(size_of(str(unit).strip(), "places")))


def _tiff(path: Path, units: Units) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    try:
        import rasterio
    except ImportError:
        raise ValueError("GeoTIFF needs the package rasterio, which is not installed") from None
    _refuse_spacing(units)
    with rasterio.open(path) as data:
        move = data.transform
        system = data.crs
        if system is not None and system.is_geographic:
            raise ValueError(f"its positions are in degrees; {PROJECT}")
        if move.b != 0.0 or move.d != 0.0 or move.a <= 0.0 or move.e >= 0.0:
            raise ValueError("its rows must run from north to south, its columns from west to east")
        z = data.read(1, masked=True).astype(float).filled(np.nan)
        size = 1.0 if system is None or not system.is_projected else float(system.linear_units_factor[1])
        height = units.height or data.units[0] or "m"
    if units.place is not None:
        size = size_of(units.place, "places")
    x = size * (move.c + move.a * (np.arange(z.shape[1]) + 0.5))
    y = size * (move.f + move.e * (np.arange(z.shape[0]) + 0.5))
    return x, y[::-1], z[::-1].T * size_of(str(height).strip(), "heights")


READERS = {".asc": _ascii, ".npy": _npy, ".nc": _netcdf, ".tif": _tiff, ".tiff": _tiff}
"""Readers by the suffix of a file's name."""
