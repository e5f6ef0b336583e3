"""Small meshes that need no mesher, and what holds them."""

from collections.abc import Callable

import numpy as np
from skfem import Basis, ElementTetP2, MeshTet

import fem
from fem.body.interfaces import Spider
from meshes import STEEL

DOWN = np.array([0.0, 0.0, -386.4e3])
"""N, the machine on a shoe."""
BACKWARD = {f"rear {side}": [-1.3e6, 0.0, 0.0] for side in ("left", "right")}
"""N, a chain's pull on a shoe's rear pins."""
ENDS = {"left": 0.0, "right": 0.6}
"""m, where along the beam they are."""


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


def tube(
    inner: float, outer: float, angle: float, graded: bool = False
) -> Callable[[np.ndarray], np.ndarray]:
    """Map a box of unit sides to a sector of a tube: x to radius, y to angle, z kept.

    A graded tube has its elements' sizes grow with the radius.
    """

    def mapping(p: np.ndarray) -> np.ndarray:
        r = inner * (outer / inner) ** p[:, 0] if graded else inner + (outer - inner) * p[:, 0]
        return np.column_stack([r * np.cos(angle * p[:, 1]), r * np.sin(angle * p[:, 1]), p[:, 2]])

    return mapping


def closed(mesh: fem.Mesh) -> fem.Mesh:
    """Mesh whose nodes at one place are one node, as where a ring of elements meets itself."""
    _, first, number = np.unique(mesh.nodes.round(9), axis=0, return_index=True, return_inverse=True)
    return fem.Mesh(mesh.nodes[first], number.ravel()[mesh.elements], {})


def beam_body(elements: int) -> fem.ElasticBody:
    """Steel beam of 0.6 x 0.1 x 0.1 m, with its ends as named surfaces."""
    mesh = box_mesh((elements, 1, 1), (0.6, 0.1, 0.1))
    x = mesh.nodes[mesh.boundary][:, :, 0]
    ends = {name: mesh.boundary[np.isclose(x, end).all(axis=1)] for name, end in ENDS.items()}
    return fem.ElasticBody(mesh.with_surfaces(ends), STEEL)


def beam_interfaces(body: fem.ElasticBody, spider: Spider = "rigid") -> list[fem.Interface]:
    nodes = body.mesh.nodes_of
    return [fem.Interface(name, np.array([x, 0.05, 0.05]), nodes(name), spider) for name, x in ENDS.items()]


def static_stress(
    partition: fem.Partition, forces: np.ndarray | None, centers: np.ndarray | None = None
) -> np.ndarray:
    """Stress (n, 6) of the full model under nodal forces (n, 3) and loads (i, 6) on its joint centres."""
    columns = [loads if loads is None else loads.reshape(-1, 1) for loads in (forces, centers)]
    return partition.body.stress(partition.static_response(*columns).reshape(-1, 3, 1))[:, :, 0]
