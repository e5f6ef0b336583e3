"""Tetrahedra of maker files: separate bodies, mid-side nodes, centroid."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fem.body.mesh import CUBIC_POINTS, CUBIC_WEIGHTS, TETRA_EDGES, Floats, Integers, jacobian_determinants

OPPOSITE = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))
"""Corners of the face opposite to each corner."""


def bodies(elements: Integers, count: int) -> list[Integers]:
    """Return the element numbers of each connected body among `count` nodes, the largest first."""
    corners = elements[:, :4]
    ends = np.repeat(corners[:, 0], 3), corners[:, 1:].ravel()
    links = coo_array((np.ones(len(ends[0]), dtype=np.int8), ends), shape=(count, count))
    label = connected_components(links, directed=False)[1][corners[:, 0]]
    order = np.argsort(label, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    return sorted(parts, key=len, reverse=True)


def renumbered(nodes: Floats, elements: Integers) -> tuple[Floats, Integers, Integers]:
    """Return the nodes of these elements, the elements, and the new number of every old node or -1."""
    used = np.unique(elements)
    number = np.full(len(nodes), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    return nodes[used], number[elements], number


def peeled(elements: Integers, flat: np.ndarray) -> Integers:
    """Return elements (m, 4) without those that are `flat` (booleans (m,)) and have two boundary faces.

    Such an element joins four corners of one plane; without it the boundary has the other diagonal.
    """
    chosen = np.ones(len(elements), dtype=bool)
    while True:
        remaining = np.flatnonzero(chosen)
        faces = np.sort(elements[remaining][:, OPPOSITE].reshape(-1, 3), axis=1)
        _, number, counts = np.unique(faces, axis=0, return_inverse=True, return_counts=True)
        outer = (counts[number.ravel()] == 1).reshape(-1, 4).sum(axis=1)
        lids = remaining[flat[remaining] & (outer == 2)]
        if not len(lids):
            return elements[chosen]
        chosen[lids] = False


def with_middles(nodes: Floats, elements: Integers) -> tuple[Floats, Integers]:
    """Return tetrahedra of 10 nodes with straight edges, made from those of 4."""
    ends = np.sort(elements[:, TETRA_EDGES].reshape(-1, 2), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    middles = nodes[edges].mean(axis=1)
    return np.concatenate((nodes, middles)), np.hstack((elements, len(nodes) + number.reshape(-1, 6)))


def centroid(nodes: Floats, elements: Integers) -> Floats:
    """Return the centroid of tetrahedra with straight or curved edges: array (3,)."""
    points = CUBIC_POINTS
    if elements.shape[1] == 4:
        shapes = points
    else:
        a, b = TETRA_EDGES.T
        shapes = np.hstack((points * (2.0 * points - 1.0), 4.0 * points[:, a] * points[:, b]))
    determinants = np.broadcast_to(
        jacobian_determinants(nodes, elements, points), (len(elements), len(points))
    )
    middle = nodes.mean(axis=0)
    places = np.einsum("pa,eac->epc", shapes, nodes[elements] - middle)
    moments = np.einsum("p,ep,epc->c", CUBIC_WEIGHTS, determinants, places)
    return np.asarray(middle + moments / (determinants @ CUBIC_WEIGHTS).sum())
