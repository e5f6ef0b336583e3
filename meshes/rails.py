"""Rails of a shoe's mesh: their outline, and the nodal weights of a force on them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fem.body.mesh import Floats, Integers, Mesh

LEVEL = 1e-3
"""Tolerance of level and equal rails, m."""
SUPPORT = 0.12
"""Distance before and behind a point within which nodes share a force, m."""
FEWEST_NODES = 6


class RailOutline(NamedTuple):
    """Two equal level rails in the axes of a shoe, m.

    x of their ends, y of the middles of the right and the left rail, their width, and z of their tops.
    """

    rear: float
    front: float
    right: float
    left: float
    width: float
    height: float


def rail_nodes(mesh: Mesh) -> tuple[Integers, Integers]:
    """Return the nodes of the right and of the left rail.

    Raises
    ------
    ValueError
        If the mesh has no surface "rails", or if it is not two bands beside each other.
    """
    if "rails" not in mesh.surfaces:
        raise ValueError(
            f"the mesh must have the surface 'rails' or 'roller path' for rollers, got only "
            f"{sorted(mesh.surfaces)}"
        )
    nodes = mesh.nodes_of("rails")
    nodes = nodes[np.argsort(mesh.nodes[nodes, 1])]
    y = mesh.nodes[nodes, 1]
    split = int(np.argmax(np.diff(y))) + 1
    if y[split] - y[split - 1] < 0.5 * (y[-1] - y[0]) / len(y) ** 0.5:
        raise ValueError("the mesh's surface 'rails' must be two bands, of a right and a left rail, got one")
    return nodes[:split], nodes[split:]


def rail_outline(mesh: Mesh) -> RailOutline:
    """Return the outline of the rails of a shoe's mesh.

    Raises
    ------
    ValueError
        For the causes of `rail_nodes`, or if the rails are not level or not equal.
    """
    boxes = []
    for nodes in rail_nodes(mesh):
        places = mesh.nodes[nodes]
        boxes.append((places.min(axis=0), places.max(axis=0)))
    (low, high), (left_low, left_high) = boxes
    sizes = np.array([np.delete(corner, 1) for corner in (low, high, left_low, left_high)])
    width = high[1] - low[1]
    uneven = np.ptp(sizes[:, 1]) > LEVEL or np.ptp(sizes[::2, 0]) > LEVEL or np.ptp(sizes[1::2, 0]) > LEVEL
    if uneven or abs(left_high[1] - left_low[1] - width) > LEVEL:
        raise ValueError(
            f"the mesh's rails must be level and equal within {LEVEL} m, got rails from {low.round(4)} to "
            f"{high.round(4)} and from {left_low.round(4)} to {left_high.round(4)} m"
        )
    return RailOutline(
        float(low[0]),
        float(high[0]),
        float(0.5 * (low[1] + high[1])),
        float(0.5 * (left_low[1] + left_high[1])),
        float(width),
        float(high[2]),
    )


def station_weights(mesh: Mesh, points: ArrayLike) -> Floats:
    """Return the nodal weights of a unit force at each of k points on the rails: array (k, n).

    Nodes of the point's rail within `SUPPORT` before and behind share the force by moving least squares
    (Lancaster and Salkauskas, Math. Comp. 37, 1981). Forces and moments of the weights are those of the
    force. The same weights applied to displacements give that of the point, exactly if the rail moves as a
    plane.

    Parameters
    ----------
    points : array (k, 2)
        x and y, m, in the shoe's axes.

    Raises
    ------
    ValueError
        For the causes of `rail_nodes`, or if too few nodes are near a point.
    """
    rails = rail_nodes(mesh)
    middles = [mesh.nodes[nodes, 1].mean() for nodes in rails]
    wanted = np.asarray(points, dtype=float)
    weights = np.zeros((len(wanted), len(mesh.nodes)))
    for row, (x, y) in zip(weights, wanted, strict=True):
        nodes = rails[int(np.argmin(np.abs(np.array(middles) - y)))]
        off = mesh.nodes[nodes, :2] - (x, y)
        near = np.clip(1.0 - np.abs(off[:, 0]) / SUPPORT, 0.0, None)
        if np.count_nonzero(near) < FEWEST_NODES:
            raise ValueError(
                f"the mesh's rails must have at least {FEWEST_NODES} nodes within {SUPPORT} m of any point, "
                f"got {np.count_nonzero(near)} at x = {x:.3g} m, y = {y:.3g} m"
            )
        plane = np.column_stack((np.ones(len(nodes)), off))
        moments = plane.T @ (near[:, None] * plane)
        row[nodes] = near * (plane @ np.linalg.solve(moments, np.array([1.0, 0.0, 0.0])))
    return weights
