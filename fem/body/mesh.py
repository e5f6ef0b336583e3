"""Tetrahedral meshes with named surfaces, and checks of them.

Node order within an element is that of meshio (`tetra`, `tetra10`), VTK, and the C3D10 of Abaqus and
CalculiX: the four corners, then the mid-points of the edges 01, 12, 02, 03, 13, 23. A face of the boundary
has its corners in outward sense, then the mid-points of its edges 01, 12, 20.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

TETRA_EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
"""Corners joined by each edge of a tetrahedron, in the order of its mid-side nodes."""

TETRA_FACES = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]])
"""Local nodes of the faces of a tetrahedron; corners in outward sense, then mid-side nodes."""


class MeshError(ValueError):
    """Error for a mesh that cannot be used; the message names the fault and its location."""


class MeshWarning(UserWarning):
    """Warning for a mesh that can be used although something in its file or its surfaces is doubtful."""


CUBIC_POINTS = np.vstack([np.full(4, 0.25), np.full((4, 4), 1.0 / 6.0) + np.eye(4) / 3.0])
"""Barycentric points of the five-point rule that is exact for cubic functions in a tetrahedron."""
CUBIC_WEIGHTS = np.array([-0.8, 0.45, 0.45, 0.45, 0.45]) / 6.0
"""Weights of the five-point rule; their sum is the volume of the unit tetrahedron."""
STIFFNESS_POINTS = np.full((4, 4), (5.0 - 5.0**0.5) / 20.0) + np.eye(4) / 5.0**0.5
"""Barycentric quadrature points of the stiffness of a 10-node tetrahedron in other programs."""


def jacobian_determinants(nodes: Floats, elements: Integers, points: Floats | None = None) -> Floats:
    """Return the Jacobian determinant of each element at each of its nodes, or at other points.

    Parameters
    ----------
    nodes : array (n, 3)
        Coordinates in m.
    elements : int array (m, 4 or 10)
        Node numbers.
    points : array (p, 4), optional
        Barycentric coordinates in place of those of the nodes.

    Returns
    -------
    array (m, 1) for tet4, (m, 10 or p) for tet10
        In m3: six times the volume of an element with straight edges.
    """
    slopes = np.vstack([-np.ones(3), np.eye(3)])
    if elements.shape[1] == 4:
        gradients = slopes[None]
    else:
        a, b = TETRA_EDGES.T
        if points is None:
            corners = np.eye(4)
            points = np.vstack([corners, (corners[a] + corners[b]) / 2])
        at_corners = (4 * points - 1)[:, :, None] * slopes
        at_edges = 4 * (points[:, a, None] * slopes[b] + points[:, b, None] * slopes[a])
        gradients = np.concatenate([at_corners, at_edges], axis=1)
    frames = np.einsum("pai,eac->epic", gradients, nodes[elements], optimize=True)
    with np.errstate(all="ignore"):  # coordinates of an invalid mesh may overflow
        return np.linalg.det(frames)


def listed(numbers: np.ndarray, count: int = 5) -> str:
    """Return the first of some numbers as text."""
    return ", ".join(str(number) for number in numbers[:count]) + (", ..." if len(numbers) > count else "")


def triangle_normals(corners: Floats) -> Floats:
    """Return right-hand normals (k, 3) of triangles; their lengths are twice the areas.

    `corners` (k, 3 or more, 3) belong to triangles, or to flat faces whose first three corners count.
    """
    first = corners[:, 0]
    return np.cross(corners[:, 1] - first, corners[:, 2] - first)


def sorted_rows(rows: Integers) -> tuple[Integers, NDArray[np.bool_]]:
    """Return the order (k,) that sorts rows (k, c) of numbers, and True for each row equal to its next.

    The last row has no next one. numpy's unique compares rows as bytes and takes four times as long.
    """
    order = np.lexsort(rows.T)
    return order, (rows[order[1:]] == rows[order[:-1]]).all(axis=1)


def boundary_faces(elements: Integers) -> Integers:
    """Find the boundary triangles of tetrahedra, (k, 3) or (k, 6), corners in outward sense."""
    local = TETRA_FACES[:, :3] if elements.shape[1] == 4 else TETRA_FACES
    faces = elements[:, local].reshape(-1, local.shape[1])
    order, same = sorted_rows(np.sort(faces[:, :3], axis=1))
    alone = np.ones(len(faces), dtype=bool)
    alone[1:] &= ~same
    alone[:-1] &= ~same
    return faces[np.sort(order[alone])]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Mesh of one connected body of tetrahedra of one kind.

    Parameters
    ----------
    nodes : array (n, 3)
        Coordinates in m, in body axes.
    elements : int array (m, 4 or 10)
        Node numbers from 0.
    surfaces : mapping of str to int array (k, 3 or 6)
        Named parts of the boundary as triangles of nodes; parts may overlap.
    notes : tuple of str
        Contents of its file that are not in the mesh.

    Raises
    ------
    MeshError
        If coordinates are not finite, elements are inverted, appear twice or refer to nodes that do not
        exist, nodes belong to no element, the elements form several bodies, or a surface is not part of
        the boundary.
    """

    nodes: Floats
    elements: Integers
    surfaces: Mapping[str, Integers]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        nodes = np.ascontiguousarray(self.nodes, dtype=np.float64)
        elements = np.ascontiguousarray(self.elements, dtype=np.int64)
        surfaces = {
            name: np.ascontiguousarray(faces, dtype=np.int64) for name, faces in self.surfaces.items()
        }
        for array in (nodes, elements, *surfaces.values()):
            array.setflags(write=False)
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "elements", elements)
        object.__setattr__(self, "surfaces", surfaces)
        self._check()

    def _check(self) -> None:
        nodes = self.nodes
        elements = self.elements
        if nodes.ndim != 2 or nodes.shape[1] != 3 or elements.ndim != 2:
            raise MeshError(
                f"nodes must be (n, 3) and elements (m, 4 or 10), got {nodes.shape} and {elements.shape}"
            )
        if elements.shape[1] not in (4, 10) or len(elements) == 0:
            raise MeshError(f"elements must be tetrahedra with 4 or 10 nodes, got {elements.shape}")
        bad = np.flatnonzero(~np.isfinite(nodes).all(axis=1))
        if len(bad):
            raise MeshError(f"nodes must be finite, got {len(bad)} that are not: {listed(bad)}")
        bad = np.flatnonzero(((elements < 0) | (elements >= len(nodes))).any(axis=1))
        if len(bad):
            raise MeshError(
                f"elements must refer to nodes in 0..{len(nodes) - 1}, "
                f"got {len(bad)} that do not: {listed(bad)}"
            )
        used = np.zeros(len(nodes), dtype=bool)
        used[elements.ravel()] = True
        if not used.all():
            loose = np.flatnonzero(~used)
            raise MeshError(f"nodes must belong to an element, got {len(loose)} loose ones: {listed(loose)}")
        self._check_shape()
        _, first, times = np.unique(
            np.sort(elements[:, :4], axis=1), axis=0, return_index=True, return_counts=True
        )
        if len(first) < len(elements):
            raise MeshError(
                f"elements must be different, got {(times > 1).sum()} of {len(first)} more than once: "
                f"{listed(np.sort(first[times > 1]))}"
            )
        self._check_connection()
        self._check_surfaces()

    def _check_shape(self) -> None:
        nodes = self.nodes
        bad = np.flatnonzero(~(jacobian_determinants(nodes, self.elements).min(axis=1) > 0.0))
        if len(bad) == 0:
            return
        straight = jacobian_determinants(nodes, self.elements[bad, :4]).min(axis=1)
        inside = jacobian_determinants(nodes, self.elements[bad], STIFFNESS_POINTS).min(axis=1)
        inverted = bad[~(np.minimum(straight, inside) > 0.0)]
        first = inverted[0] if len(inverted) else bad[0]
        where = f"the first is at {nodes[self.elements[first, :4]].mean(axis=0).round(4).tolist()}"
        if len(inverted):
            raise MeshError(
                f"elements must be neither inverted nor flat, got {len(inverted)} of {len(self.elements)} "
                f"that are: {listed(inverted)}; {where}"
            )
        raise MeshError(
            f"edges of elements must not be so curved that they fold, got {len(bad)} of {len(self.elements)} "
            f"elements that are inverted at a node, though not at their integration points: {listed(bad)}; "
            f"{where}; straighten their edges (fem.read_volume(file).straightened()), or mesh finer there, "
            "in gmsh with Mesh.HighOrderOptimize = 1"
        )

    def _check_connection(self) -> None:
        corners = self.elements[:, :4]
        count = len(self.nodes)
        links = coo_array(
            (
                np.ones(3 * len(corners), dtype=np.int8),
                (np.repeat(corners[:, 0], 3), corners[:, 1:].ravel()),
            ),
            shape=(count, count),
        )
        _, label = connected_components(links, directed=False)
        bodies = np.unique(label[corners[:, 0]], return_counts=True)[1]
        if len(bodies) > 1:
            raise MeshError(
                f"the mesh must be one body, got {len(bodies)} disconnected ones, of "
                f"{listed(np.sort(bodies)[::-1])} elements"
            )

    def _check_surfaces(self) -> None:
        width = self.boundary.shape[1]
        boundary = {tuple(face) for face in np.sort(self.boundary[:, :3], axis=1).tolist()}
        for name, faces in self.surfaces.items():
            if faces.ndim != 2 or faces.shape[1] != width or len(faces) == 0:
                raise MeshError(f"surface {name!r} must be (k, {width}) with k at least 1, got {faces.shape}")
            inside = [
                i
                for i, face in enumerate(np.sort(faces[:, :3], axis=1).tolist())
                if tuple(face) not in boundary
            ]
            if inside:
                raise MeshError(
                    f"surface {name!r} must lie on the boundary, got {len(inside)} of {len(faces)} "
                    f"triangles off it: {listed(np.array(inside))}"
                )

    @property
    def order(self) -> int:
        """Polynomial order of the elements: 1 (tet4) or 2 (tet10)."""
        return 1 if self.elements.shape[1] == 4 else 2

    @property
    def volume(self) -> float:
        """Volume in m3, exact also with curved edges, since the determinant is cubic."""
        determinants = jacobian_determinants(self.nodes, self.elements, CUBIC_POINTS)
        weights = CUBIC_WEIGHTS if self.order == 2 else [CUBIC_WEIGHTS.sum()]
        return float(np.sum(determinants @ weights))

    @cached_property
    def boundary(self) -> Integers:
        """Triangles of the whole boundary, (k, 3) or (k, 6), corners in outward sense."""
        return boundary_faces(self.elements)

    @cached_property
    def surface_nodes(self) -> Integers:
        """Numbers of all nodes on the boundary, ascending."""
        return np.unique(self.boundary)

    def surface(self, name: str) -> Integers:
        """Return the triangles of a named surface.

        Raises
        ------
        KeyError
            If the mesh has no such surface; the message lists those it has.
        """
        if name not in self.surfaces:
            raise KeyError(f"surface must be one of {sorted(self.surfaces)}, got {name!r}")
        return self.surfaces[name]

    def with_surfaces(self, more: Mapping[str, Integers]) -> Self:
        """Return the mesh with additional or replaced named surfaces, (k, 3 or 6) by name.

        Raises
        ------
        MeshError
            If one is not part of the boundary.
        """
        return type(self)(self.nodes, self.elements, {**self.surfaces, **more}, self.notes)

    def nodes_of(self, name: str) -> Integers:
        """Return the numbers of a named surface's nodes, ascending."""
        return np.unique(self.surface(name))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of coordinates, elements and named surfaces."""
        sha = hashlib.sha256()
        for array in (self.nodes, self.elements):
            sha.update(repr(array.shape).encode() + array.tobytes())
        for name in sorted(self.surfaces):
            sha.update(name.encode() + self.surfaces[name].tobytes())
        return sha.hexdigest()
