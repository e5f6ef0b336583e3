"""Stress on the surface of one flexible shoe at many instants of a run."""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from exudyn_crawler.results.history.catalogue import QUANTITIES, variable
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.stress.stress_columns import stress_columns

AT_ONCE = 50
"""Instants whose fields are in memory together."""


def flat_triangles(faces: NDArray) -> NDArray:
    """Flat triangles through all nodes of faces (k, 6), corners first and then the middles of the sides.

    Returns
    -------
    int array (4 k, 3)
        In the sense of the faces.
    """
    quarters = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
    return np.stack([faces[:, list(quarter)] for quarter in quarters], axis=1).reshape(-1, 3)


def surface_stress(history: History, shoe: int, rows: ArrayLike) -> xr.Dataset:
    """Von Mises stress and elastic displacement of a shoe's surface.

    Parameters
    ----------
    shoe : int
        Number of a flexible shoe.
    rows : int array (instants,)
        Indices of stored instants.

    Returns
    -------
    xarray.Dataset
        `von_mises` (time, node), Pa; `displacement` (time, node, axis), m, in the shoe's frame;
        `node_position` (node, axis), m; `triangle` (face, corner), indices along node in outward sense.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history.
    """
    flexible = history.case.flexible
    if flexible is None or shoe not in flexible.shoes:
        there = [] if flexible is None else list(flexible.shoes)
        raise ValueError(f"shoe must be a flexible one of the history, of {there}, got {shoe}")
    columns = stress_columns(history, [shoe])
    shapes = columns.shapes
    used, corners = np.unique(flat_triangles(shapes.mesh.boundary), return_inverse=True)
    q = columns.coordinates[shoe][np.asarray(rows)]
    parts = [q[start : start + AT_ONCE] for start in range(0, len(q), AT_ONCE)]
    von_mises = np.concatenate([shapes.von_mises(part, used).astype("f4") for part in parts])
    bend = np.concatenate([shapes.displacement(part)[:, used].astype("f4") for part in parts])
    return xr.Dataset(
        {
            "von_mises": (("time", "node"), von_mises, QUANTITIES["frame_von_mises"].attributes),
            "displacement": (("time", "node", "axis"), bend, QUANTITIES["frame_displacement"].attributes),
            "node_position": variable("node_position", shapes.nodes[used]),
            "triangle": (("face", "corner"), corners.reshape(-1, 3)),
        },
        coords={"time": history.time.isel(time=np.asarray(rows)), "axis": ["x", "y", "z"]},
    )
