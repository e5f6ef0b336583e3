"""Grid of terrain units: which of them lie under a shoe or a sphere."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Terrain
from exudyn_crawler.ground.frames import compiled


class Grid(NamedTuple):
    """Units in columns along x and rows along y, counted along y first; lengths in m.

    `x`, `y` is the corner of the first unit, `tilt_axis` what units tilt about: 0 for x, 1 for y.
    """

    columns: int
    rows: int
    length: float
    width: float
    height: float
    x: float
    y: float
    tilt_axis: int


class Cells(NamedTuple):
    """Rectangle of units: the first, and how many there are along x and along y."""

    first: int
    columns: int
    rows: int


def grid_of(terrain: Terrain) -> Grid:
    """Grid of a terrain."""
    return Grid(
        terrain.columns,
        terrain.rows,
        terrain.unit_length,
        terrain.unit_width,
        terrain.unit_height,
        *terrain.origin,
        terrain.tilt_axis,
    )


def units_below(grid: Grid, places: NDArray) -> NDArray:
    """Index of the unit below each place, or the one nearest to it: array of int, for (..., 2) m."""
    cells = np.floor((places - [grid.x, grid.y]) / [grid.length, grid.width]).astype(int)
    cells = np.clip(cells, 0, [grid.columns - 1, grid.rows - 1])
    return cells[..., 0] * grid.rows + cells[..., 1]


@compiled
def cells_about(grid: Grid, x: float, y: float, reach_x: float, reach_y: float) -> Cells:
    """Units that a rectangle about (x, y) with these half sides (m) meets, seen from above."""
    i0 = max(0, int(math.floor((x - grid.x - reach_x) / grid.length)))
    i1 = min(grid.columns - 1, int(math.floor((x - grid.x + reach_x) / grid.length)))
    j0 = max(0, int(math.floor((y - grid.y - reach_y) / grid.width)))
    j1 = min(grid.rows - 1, int(math.floor((y - grid.y + reach_y) / grid.width)))
    return Cells(i0 * grid.rows + j0, max(0, i1 - i0 + 1), max(0, j1 - j0 + 1))


@compiled
def cell(grid: Grid, cells: Cells, k: int) -> int:
    """Index of unit k of a rectangle of units."""
    return cells.first + (k // cells.rows) * grid.rows + k % cells.rows
