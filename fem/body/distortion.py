"""Straight edges for quadratic tetrahedra that are folded at a node by their curved edges."""

import numpy as np

from fem.body.mesh import TETRA_EDGES, Floats, Integers, jacobian_determinants

LEAST_JACOBIAN_RATIO = 0.15
"""Ratio of an element's least to its greatest nodal Jacobian below which it gets straight edges."""


def straighten_distorted(nodes: Floats, elements: Integers) -> tuple[Floats, int]:
    """Straighten the edges of elements that a curved edge turns inside out.

    Parameters
    ----------
    nodes : array (n, 3)
        Coordinates in m.
    elements : int array (m, 10)
        Node numbers.

    Returns
    -------
    nodes : array (n, 3)
        Coordinates with the mid-side nodes moved.
    count : int
        Number of elements that were straightened.
    """
    nodes = nodes.copy()
    straightened = 0
    while True:
        determinant = jacobian_determinants(nodes, elements)
        bad = determinant.min(axis=1) < LEAST_JACOBIAN_RATIO * determinant.max(axis=1)
        middles = nodes[elements[:, TETRA_EDGES]].mean(axis=2)
        bent = np.linalg.norm(nodes[elements[:, 4:]] - middles, axis=2).max(axis=1)
        bad &= bent > 1e-9
        if not bad.any():
            return nodes, straightened
        nodes[elements[bad, 4:]] = middles[bad]
        straightened += int(bad.sum())
