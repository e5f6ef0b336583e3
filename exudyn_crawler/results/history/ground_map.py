"""Map of a ground of cells: its memory at the end of a run and at chosen times, and depths of undersides.

The memory is the ground's own and exact. At times not chosen before the run the map follows the shoes'
motion: the depths that their undersides, taken as rigid, have reached at stored states.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.terrain import CellContact, CellTerrain
from exudyn_crawler.ground import rotations
from exudyn_crawler.ground.compiled import kernel
from exudyn_crawler.results.history import History, catalogue

MOST_STATES = 4000
"""Greatest number of stored states whose undersides count, evenly spread."""
THEN = 5
"""Number of columns of a cell's record: time (s), column, row, greatest sinkage (m), pressure there (Pa)."""


def memory_now(memory: Mapping[str, np.ndarray], time: float) -> np.ndarray:
    """Return the cells in a ground's memory (`CellGround.state`) at a time (s): array (cells, THEN)."""
    count = len(memory["cells"])
    return np.column_stack((np.full(count, time), memory["cells"], memory["memory"][:, :2]))


def end_memory(memory: Mapping[str, np.ndarray], then: np.ndarray) -> xr.Dataset:
    """Return the cells with memory by column and row, as variables of a history; empty for other ground.

    `memory` is that at the end; `then` (cells of all times, THEN) holds the records at chosen times.
    """
    if not memory:
        return xr.Dataset()
    times, when = np.unique(then[:, 0], return_inverse=True)
    # cells are stored in the order in which their tiles were made, which differs in a continued run
    every = np.concatenate((memory["cells"], then[:, 1:3].astype(int)))
    cells, which = np.unique(every, axis=0, return_inverse=True)
    which = which.ravel()
    count = len(memory["cells"])
    pressed = np.zeros((2, len(cells)))
    before = np.zeros((2, len(times), len(cells)))
    pressed[:, which[:count]] = memory["memory"][:, :2].T
    before[:, when, which[count:]] = then[:, 3:].T
    named = {"cell_column": cells[:, 0], "cell_row": cells[:, 1]}
    named |= {"cell_sinkage": pressed[0], "cell_pressure": pressed[1]}
    if len(times):
        named |= {"ground_time": times, "cell_sinkage_then": before[0], "cell_pressure_then": before[1]}
    return xr.Dataset({name: catalogue.variable(name, values) for name, values in named.items()})


def ground_map(history: History, times: Sequence[float] = ()) -> xr.Dataset:
    """Return the map of the ground at the end of a run on cells, over the rectangle that its shoes touched.

    Dimensions are x and y (m, global, middles of cells). Variables in m: `height` before any shoe came,
    greatest `sinkage` along the normal of a cell, and `rut`, the sinkage that remains without load. With
    `times` (s) there are three more variables (time, x, y) at the nearest stored times. `depth` is vertical,
    see `pressed_depths`; `sinkage_then` and `rut_then` are the sinkage and rut at that time. These two are
    NaN at times without stored memory of the cells (`ground_times`). ValueError if the case
    has no ground of cells.
    """
    case = history.case
    terrain = case.part(CellTerrain)
    cells = np.column_stack((history.cell_column, history.cell_row))
    first = cells.min(axis=0)
    last = cells.max(axis=0)
    x, y = ((np.arange(first[k], last[k] + 1) + 0.5) * terrain.cell for k in range(2))
    place = tuple((cells - first).T)

    def mapped(sinkage: xr.DataArray, pressure: xr.DataArray) -> np.ndarray:
        maps = np.zeros((2, len(x), len(y)))
        maps[:, *place] = sinkage, ruts(case, sinkage.values, pressure.values)
        return maps

    at_end = mapped(history.cell_sinkage, history.cell_pressure)
    greatest = "greatest sinkage along the normal of the ground"
    stays = "sinkage that stays where nothing presses"
    height = terrain.surface(*np.meshgrid(x, y, indexing="ij"))
    dims = ("x", "y")
    ground = xr.Dataset(
        {
            "height": _metres(dims, height, "height before any shoe came"),
            "sinkage": _metres(dims, at_end[0], greatest),
            "rut": _metres(dims, at_end[1], stays),
        },
        coords={
            "x": _metres("x", x, "x of the cells' middles, global"),
            "y": _metres("y", y, "y of the cells' middles, global"),
        },
        attrs={"title": f"{case.name}: ground at t = {history.duration:g} s", "end": history.duration},
    )
    if not len(times):
        return ground
    stored = history.time.values
    rows = np.unique([np.abs(stored - time).argmin() for time in times])
    depth = pressed_depths(history, rows, x, y, height)
    then = np.full((2, *depth.shape), np.nan)
    if "ground_time" in history.dataset:
        ground_times = history.ground_time.values
        within = max(case.solver.step, case.solver.quiet_step)
        for row, time in enumerate(stored[rows]):
            nearest = int(np.abs(ground_times - time).argmin())
            if abs(ground_times[nearest] - time) <= within:
                now = history.dataset.isel(ground_time=nearest)
                then[:, row] = mapped(now.cell_sinkage_then, now.cell_pressure_then)
    over = ("time", *dims)
    single = np.float32
    ground = ground.assign_coords(time=("time", stored[rows], {"units": "s"}))
    return ground.assign(
        depth=_metres(over, depth.astype(single), "how deep undersides had pressed the ground until then"),
        sinkage_then=_metres(over, then[0].astype(single), f"{greatest} until then"),
        rut_then=_metres(over, then[1].astype(single), f"{stays}, of then"),
    )


def _metres(dims: str | tuple[str, ...], values: np.ndarray, meaning: str) -> tuple[Any, ...]:
    """Return a variable in m."""
    return dims, values, {"units": "m", "long_name": meaning}


def ruts(case: Case, sinkage: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """Return the sinkages (m) that remain after unloading from greatest sinkages (m) at pressures (Pa)."""
    law: Any = case.part(CellContact).law
    if law.kernel.forgets:
        return np.zeros_like(sinkage)
    constants = law.constants(case.shoe.ground_breadth)
    pairs = zip(sinkage.tolist(), pressure.tolist(), strict=True)
    modulus = np.array([law.kernel.prepare(constants, z, p)[0] for z, p in pairs])
    springs_back = np.divide(pressure, modulus, out=sinkage.copy(), where=modulus > 0.0)
    return np.maximum(sinkage - springs_back, 0.0)


def pressed_depths(
    history: History, rows: np.ndarray, x: np.ndarray, y: np.ndarray, height: np.ndarray
) -> np.ndarray:
    """Return the greatest vertical depth of undersides below ground until stored times: (rows, nx, ny), m.

    The indices of the times, `rows` (n,), increase. `x` (nx,) and `y` (ny,) are evenly spaced coordinates, m;
    `height` (nx, ny) is that of the ground there, m.
    """
    step = -(-int(rows[-1] + 1) // MOST_STATES)
    looked = np.unique(np.concatenate((np.arange(0, rows[-1] + 1, step), rows)))
    states = history.dataset[["position", "angles"]].isel(time=looked).transpose("time", "shoe", "axis")
    position = states.position.values
    turn = rotations.rotation_matrices(states.angles.values)
    footprint = np.array(history.case.shoe.footprint)
    grid = np.array((x[0], x[1], y[0], y[1]))
    depth = np.zeros(height.shape)
    out = np.zeros((len(rows), *height.shape))
    begin = 0
    for number, end in enumerate(np.searchsorted(looked, rows) + 1):
        _press_in(position[begin:end], turn[begin:end], footprint, grid, height, depth)
        out[number] = depth
        begin = end
    return out


@kernel
def _press_in(
    position: rotations.FloatArray,
    turn: rotations.FloatArray,
    footprint: rotations.FloatArray,
    grid: rotations.FloatArray,
    height: rotations.FloatArray,
    depth: rotations.FloatArray,
) -> None:
    """Update the greatest depth of undersides; `grid` has the first two coordinates along x and along y."""
    x0 = grid[0]
    dx = grid[1] - grid[0]
    y0 = grid[2]
    dy = grid[3] - grid[2]
    for t in range(position.shape[0]):
        for s in range(position.shape[1]):
            r = position[t, s]
            R = turn[t, s]
            # middle of the underside, and half of its sides seen from above
            u, v = 0.5 * (footprint[0] + footprint[1]), 0.5 * (footprint[2] + footprint[3])
            half_x = 0.5 * (footprint[1] - footprint[0])
            half_y = 0.5 * (footprint[3] - footprint[2])
            middle_x = r[0] + R[0, 0] * u + R[0, 1] * v + R[0, 2] * footprint[4]
            middle_y = r[1] + R[1, 0] * u + R[1, 1] * v + R[1, 2] * footprint[4]
            middle_z = r[2] + R[2, 0] * u + R[2, 1] * v + R[2, 2] * footprint[4]
            reach_x = abs(R[0, 0]) * half_x + abs(R[0, 1]) * half_y
            reach_y = abs(R[1, 0]) * half_x + abs(R[1, 1]) * half_y
            i0 = max(0, int(np.ceil((middle_x - reach_x - x0) / dx)))
            i1 = min(height.shape[0] - 1, int(np.floor((middle_x + reach_x - x0) / dx)))
            j0 = max(0, int(np.ceil((middle_y - reach_y - y0) / dy)))
            j1 = min(height.shape[1] - 1, int(np.floor((middle_y + reach_y - y0) / dy)))
            for i in range(i0, i1 + 1):
                for j in range(j0, j1 + 1):
                    x, y = x0 + i * dx - middle_x, y0 + j * dy - middle_y
                    z = -(R[0, 2] * x + R[1, 2] * y) / R[2, 2]
                    along = R[0, 0] * x + R[1, 0] * y + R[2, 0] * z
                    across = R[0, 1] * x + R[1, 1] * y + R[2, 1] * z
                    if abs(along) <= half_x and abs(across) <= half_y:
                        depth[i, j] = max(depth[i, j], height[i, j] - middle_z - z)
