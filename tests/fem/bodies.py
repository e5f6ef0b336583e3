"""Small meshes that need no mesher, and what holds them."""

from collections.abc import Callable

import numpy as np
from skfem import Basis, ElementTetP2, MeshTet

import fem


def box_mesh(
    counts: tuple[int, int, int],
    size: tuple[float, float, float],
    mapping: Callable[[np.ndarray], np.ndarray] | None = None,
    order: int = 2,
) -> fem.Mesh:
    """Structured mesh of a box (n, 3), optionally mapped; mid-side nodes follow the mapping."""
    grid = MeshTet.init_tensor(*(np.linspace(0, s, n + 1) for s, n in zip(size, counts, strict=True)))
    if order == 1:
        points, elements = grid.p.T, grid.t.T
    else:
        basis = Basis(grid, ElementTetP2())
        points, elements = basis.doflocs.T, basis.element_dofs.T
    points = points if mapping is None else mapping(points)
    a, b, c, d = (points[elements[:, i]] for i in range(4))
    flipped = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0
    swap = [1, 0, 2, 3] if order == 1 else [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]
    elements = np.where(flipped[:, None], elements[:, swap], elements)
    return fem.Mesh(points, elements, {})


def beam_interfaces(body: fem.ElasticBody, spider: str = "rigid") -> list[fem.Interface]:
    return [
        fem.Interface(name, (x, 0.05, 0.05), body.mesh.nodes_of(name), spider)
        for name, x in (("left", 0.0), ("right", 0.6))
    ]
