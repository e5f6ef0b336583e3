"""Map of ground of cells: what its memory holds as a run ends, and how deep shoes had pressed it at any time.

The memory is the ground's own and exact. At other times the map is that of the shoes' motion: how deep their
undersides have been, as stiff ones, at stored states.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

import numpy as np
import xarray as xr

from exudyn_crawler.ground.cells.law import CellLaw
from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.rotations import FloatArray, rotation_matrices
from exudyn_crawler.results.history.catalogue import variable
from exudyn_crawler.results.history.history import History

if TYPE_CHECKING:
    from exudyn_crawler.model.track_system import TrackSystem

MOST_STATES = 4000
"""Stored states whose undersides are looked at, evenly spread."""


def end_memory(system: "TrackSystem") -> xr.Dataset:
    """Cells that remember something, by column and row, as a history has them; nothing of other ground."""
    memory = system.memory()
    if not memory:
        return xr.Dataset()
    # cells are stored in the order in which their tiles were made, another one in a run that went on
    order = np.lexsort(memory["cells"].T[::-1])
    column, row = memory["cells"][order].T
    sinkage, pressure = memory["memory"][order, :2].T
    named = {"cell_column": column, "cell_row": row, "cell_sinkage": sinkage, "cell_pressure": pressure}
    return xr.Dataset({name: variable(name, values) for name, values in named.items()})


def ground_map(history: History, times: Sequence[float] = ()) -> xr.Dataset:
    """Map of the ground as a run on cells ends, over the rectangle that its shoes have touched.

    Parameters
    ----------
    history : History
    times : sequence of float
        s, at which the map has also how deep undersides had pressed the ground until then, as of
        `pressed_depths`, at the nearest stored times.

    Returns
    -------
    xarray.Dataset
        Dimensions x and y (m, global, middles of cells): height before any shoe came, greatest sinkage along
        the normal of a cell, and the rut, what stays of that where nothing presses; m. With times also
        `depth` (time, x, y), m, vertical.

    Raises
    ------
    ValueError
        If the case has no ground of cells.
    """
    case = history.case
    terrain, law = case.cell_terrain(), cast(CellLaw, case.cell_contact().law)
    cells = np.column_stack((history.cell_column, history.cell_row))
    first, last = cells.min(axis=0), cells.max(axis=0)
    x, y = ((np.arange(first[k], last[k] + 1) + 0.5) * terrain.cell for k in range(2))
    sinkage, pressure = history.cell_sinkage.values, history.cell_pressure.values
    constants = law.constants(min(case.shoe.length, case.shoe.width))
    pairs = zip(sinkage.tolist(), pressure.tolist(), strict=True)
    modulus = np.array([law.kernel.prepare(constants, z, p)[0] for z, p in pairs])
    springs_back = np.divide(pressure, modulus, out=sinkage.copy(), where=modulus > 0.0)
    rut = np.zeros_like(sinkage) if law.kernel.forgets else np.maximum(sinkage - springs_back, 0.0)
    maps = np.zeros((2, len(x), len(y)))
    maps[:, *(cells - first).T] = sinkage, rut
    fields = {
        "height": (terrain.surface(*np.meshgrid(x, y, indexing="ij")), "height before any shoe came"),
        "sinkage": (maps[0], "greatest sinkage along the normal of the ground"),
        "rut": (maps[1], "sinkage that stays where nothing presses"),
    }
    named = {"x": (x, "x of the cells' middles, global"), "y": (y, "y of the cells' middles, global")}
    ground = xr.Dataset(
        {name: (("x", "y"), one, {"units": "m", "long_name": text}) for name, (one, text) in fields.items()},
        coords={name: (name, one, {"units": "m", "long_name": text}) for name, (one, text) in named.items()},
        attrs={"title": f"{case.name}: ground at t = {history.duration:g} s", "end": history.duration},
    )
    if not len(times):
        return ground
    stored = history.time.values
    rows = np.unique([np.abs(stored - time).argmin() for time in times])
    depth = pressed_depths(history, rows, x, y, ground.height.values)
    kept = {"units": "m", "long_name": "how deep undersides had pressed the ground until then"}
    ground = ground.assign_coords(time=("time", stored[rows], {"units": "s"}))
    return ground.assign(depth=(("time", "x", "y"), depth.astype(np.float32), kept))


def pressed_depths(
    history: History, rows: np.ndarray, x: np.ndarray, y: np.ndarray, height: np.ndarray
) -> np.ndarray:
    """How deep undersides have been below the ground at some stored times: array (rows, x, y), m, vertical.

    Parameters
    ----------
    rows : int array (n,)
        Numbers of the stored times, increasing.
    x, y : array (nx,), array (ny,)
        Places, m, evenly spaced.
    height : array (nx, ny)
        Of the ground there, m.
    """
    step = -(-int(rows[-1] + 1) // MOST_STATES)
    looked = np.unique(np.concatenate((np.arange(0, rows[-1] + 1, step), rows)))
    states = history.dataset[["position", "angles"]].isel(time=looked).transpose("time", "shoe", "axis")
    position, turn = states.position.values, rotation_matrices(states.angles.values)
    footprint, grid = np.array(history.case.shoe.footprint), np.array((x[0], x[1], y[0], y[1]))
    depth, out = np.zeros(height.shape), np.zeros((len(rows), *height.shape))
    begin = 0
    for number, end in enumerate(np.searchsorted(looked, rows) + 1):
        _press_in(position[begin:end], turn[begin:end], footprint, grid, height, depth)
        out[number], begin = depth, end
    return out


@compiled
def _press_in(
    position: FloatArray,
    turn: FloatArray,
    footprint: FloatArray,
    grid: FloatArray,
    height: FloatArray,
    depth: FloatArray,
) -> None:
    """Deepen what undersides have pressed in, at places of which the first two along x and y are given."""
    x0, dx, y0, dy = grid[0], grid[1] - grid[0], grid[2], grid[3] - grid[2]
    for t in range(position.shape[0]):
        for s in range(position.shape[1]):
            r, R = position[t, s], turn[t, s]
            # middle of the underside, and half of its sides seen from above
            u, v = 0.5 * (footprint[0] + footprint[1]), 0.5 * (footprint[2] + footprint[3])
            half_x, half_y = 0.5 * (footprint[1] - footprint[0]), 0.5 * (footprint[3] - footprint[2])
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
