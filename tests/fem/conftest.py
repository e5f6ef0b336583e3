"""Small meshes that need no mesher, and the coarse shoe with its reductions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from skfem import Basis, ElementTetP2, MeshTet

import fem
import meshes

STEEL = fem.Material(200e9, 0.3, 7847.25)


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


@pytest.fixture(scope="session")
def shoe() -> fem.ElasticBody:
    return fem.ElasticBody(meshes.shoe_mesh("coarse"), STEEL)


def shoe_interfaces(body: fem.ElasticBody, spider: str = "rigid") -> list[fem.Interface]:
    return [
        fem.Interface(name, center, body.mesh.nodes_of(f"bore {name}"), spider)
        for name, center in meshes.JOINT_CENTERS.items()
    ]


@pytest.fixture(scope="session")
def partition(shoe: fem.ElasticBody) -> fem.Partition:
    return fem.Partition(shoe, shoe_interfaces(shoe))


@pytest.fixture(scope="session")
def reduced(shoe: fem.ElasticBody, partition: fem.Partition) -> fem.ReducedBody:
    return fem.craig_bampton(shoe, partition.interfaces, 76, partition=partition)


@pytest.fixture(scope="session")
def beam() -> fem.ElasticBody:
    """Steel beam of 0.6 x 0.1 x 0.1 m, with its ends as named surfaces."""
    mesh = box_mesh((6, 1, 1), (0.6, 0.1, 0.1))
    ends = {
        name: mesh.boundary[np.isclose(mesh.nodes[mesh.boundary][:, :, 0], x).all(axis=1)]
        for name, x in (("left", 0.0), ("right", 0.6))
    }
    return fem.ElasticBody(fem.Mesh(mesh.nodes, mesh.elements, ends), STEEL)


def beam_interfaces(body: fem.ElasticBody, spider: str = "rigid") -> list[fem.Interface]:
    return [
        fem.Interface(name, (x, 0.05, 0.05), body.mesh.nodes_of(name), spider)
        for name, x in (("left", 0.0), ("right", 0.6))
    ]
