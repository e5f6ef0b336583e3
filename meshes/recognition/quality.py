"""Quality of a mesh: shapes of its elements, and walls that are one element thick."""

from typing import NamedTuple

import numpy as np

from fem.body.mesh import TETRA_EDGES, Floats, Integers, Mesh, jacobian_determinants
from meshes.recognition.triangles import Triangles

OPPOSED = 0.8
"""Cosine between an edge and the normals at its ends above which the edge goes through a wall."""


class MeshQuality(NamedTuple):
    """Quality of a mesh of tetrahedra.

    Attributes
    ----------
    least, mean : float
        Shape 6 sqrt(2) V / l^3 with the root mean square l of the edges: 1 for a regular tetrahedron.
    thinnest : float or None
        Thickness of the thinnest wall with a single element through it, m; None without such a wall.
    thin_share : float
        Fraction of the boundary's nodes on such walls.
    """

    least: float
    mean: float
    thinnest: float | None
    thin_share: float


def shapes(nodes: Floats, elements: Integers) -> Floats:
    """Return the shapes (m,) of tetrahedra (m, 4 or more) from corners among nodes (n, 3): 1 if regular."""
    corners = elements[:, :4]
    volumes = jacobian_determinants(nodes, corners)[:, 0] / 6.0
    ends = nodes[corners[:, TETRA_EDGES]]
    squares = ((ends[:, :, 1] - ends[:, :, 0]) ** 2).sum(axis=2).mean(axis=1)
    return np.asarray(6.0 * np.sqrt(2.0) * volumes / squares**1.5)


def mesh_quality(mesh: Mesh) -> MeshQuality:
    """Return the quality of a mesh from its corners."""
    shape = shapes(mesh.nodes, mesh.elements)
    walls, nodes = _walls(mesh)
    boundary = np.unique(mesh.boundary[:, :3])
    thinnest = float(walls.min()) if len(walls) else None
    return MeshQuality(float(shape.min()), float(shape.mean()), thinnest, len(nodes) / len(boundary))


def _walls(mesh: Mesh) -> tuple[Floats, np.ndarray]:
    """Return the lengths of inner edges through a wall, from boundary to boundary, and their nodes."""
    triangles = Triangles(mesh.nodes, mesh.boundary[:, :3])
    normals = np.zeros_like(mesh.nodes)
    for corner in range(3):
        np.add.at(normals, triangles.faces[:, corner], triangles.areas[:, None] * triangles.normals)
    sizes = np.linalg.norm(normals, axis=1)
    edges = np.unique(np.sort(mesh.elements[:, TETRA_EDGES].reshape(-1, 2), axis=1), axis=0)
    outer = np.unique(np.sort(triangles.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    count = len(mesh.nodes)
    edges = edges[(sizes[edges] > 0.0).all(axis=1)]
    inner = edges[~np.isin(edges @ (count, 1), outer @ (count, 1))]
    ways = mesh.nodes[inner[:, 1]] - mesh.nodes[inner[:, 0]]
    lengths = np.linalg.norm(ways, axis=1)
    first, second = (
        np.einsum("ec,ec->e", ways, normals[inner[:, end]]) / (lengths * sizes[inner[:, end]])
        for end in (0, 1)
    )
    through = (first < -OPPOSED) & (second > OPPOSED)
    return lengths[through], np.unique(inner[through])
