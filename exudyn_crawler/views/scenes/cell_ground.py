"""Ground of cells as a surface of heights, lowered where shoes have been."""

import math
from functools import lru_cache

import numpy as np
import xarray as xr

from exudyn_crawler.case import CellTerrain
from exudyn_crawler.results.history.ground_map import pressed_depths
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes.scene import FLAT, Colouring, Solid, upward

SPACING, MOST_POINTS = 0.25, 4000
"""m between the points of a surface; of larger ones there are so many."""
HEIGHT = "height of the ground in mm"


@lru_cache(maxsize=4)
def _heights(terrain: CellTerrain, bounds: tuple[float, float, float, float]) -> tuple[np.ndarray, ...]:
    """Evenly spaced x and y (m) between bounds, and heights (x, y), m; those not measured are the least."""
    x0, x1, y0, y1 = bounds
    spacing = max(SPACING, math.sqrt((x1 - x0) * (y1 - y0) / MOST_POINTS))
    x, y = (np.linspace(a, b, max(2, math.ceil((b - a) / spacing) + 1)) for a, b in ((x0, x1), (y0, y1)))
    height = terrain.surface(*np.meshgrid(x, y, indexing="ij"))
    return x, y, np.nan_to_num(height, nan=np.nanmin(height))


def grid_of(terrain: CellTerrain, x: tuple[float, float], y: tuple[float, float]) -> tuple[np.ndarray, ...]:
    """Same within the field, for the least and greatest x and y (m) of what is shown."""
    (left, right), (low, high) = terrain.bounds
    return _heights(terrain, (max(x[0], left), min(x[1], right), max(y[0], low), min(y[1], high)))


def with_ground(
    history: History, dataset: xr.Dataset, rows: np.ndarray, grid: tuple[np.ndarray, ...]
) -> xr.Dataset:
    """Instants of a history, its stored times of numbers `rows`, with the ground's height and depth, m.

    The depth is how far undersides have been below the height until then.
    """
    x, y, height = grid
    depth = pressed_depths(history, rows, x, y, height)
    return dataset.assign_coords(ground_x=x, ground_y=y).assign(
        ground_height=(("ground_x", "ground_y"), height),
        ground_depth=(("time", "ground_x", "ground_y"), depth),
    )


def surface(dataset: xr.Dataset) -> Solid:
    """Ground of instants as of `with_ground`, coloured by its height in mm."""
    x, y = dataset.ground_x.values, dataset.ground_y.values
    height = dataset.ground_height.transpose("ground_x", "ground_y").values
    depth = dataset.ground_depth.transpose("time", "ground_x", "ground_y").values
    depth = depth.reshape(len(depth), -1)
    places = np.meshgrid(x, y, indexing="ij")
    points = np.column_stack([one.ravel() for one in (*places, height)])
    number = np.arange(height.size).reshape(height.shape)
    faces = np.stack((number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]), axis=-1)
    now = (points[:, 2] - depth) / style.MILLI
    colouring = Colouring(HEIGHT, now[:, None], now.min(), now.max(), style.HEAVE_MAP)
    return Solid(
        "ground",
        points,
        (faces.reshape(-1, 4),),
        style.GROUND,
        opacity=0.6,
        edges=FLAT,
        bend=upward(-depth[:, None]),
        colourings=(colouring,),
    )


def section(dataset: xr.Dataset, y: float, deep: float, at_rest: bool = False) -> Solid:
    """Ground of one instant cut along a y (m), strip by strip, down to `deep` m below its points.

    `at_rest` is before any shoe came.
    """
    line = dataset.isel(time=0).sel(ground_y=y, method="nearest")
    x, top = line.ground_x.values, line.ground_height.values - (0.0 if at_rest else line.ground_depth.values)
    bottom = line.ground_height.values - deep
    ends = np.stack((x[:-1], x[1:], x[1:], x[:-1]), axis=1)
    heights = np.stack((bottom[:-1], bottom[1:], top[1:], top[:-1]), axis=1)
    points = np.stack((ends, np.full_like(ends, y), heights), axis=-1)
    faces = (np.arange(ends.size).reshape(-1, 4),)
    return Solid("ground", points.reshape(-1, 3), faces, style.GROUND, edges=style.GROUND)
