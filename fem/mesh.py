"""Tetrahedral meshes with named surfaces: reading, checking, writing.

Node order within an element is meshio's (`tetra`, `tetra10`), which is also VTK's and that of the
C3D10 of Abaqus and CalculiX: the four corners, then the mid-points of the edges
01, 12, 02, 03, 13, 23. A face of the boundary has its corners in outward sense, then the
mid-points of its edges 01, 12, 20.
"""

from __future__ import annotations

import gzip
import hashlib
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import meshio
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

PHYSICAL = "gmsh:physical"
SOLID_TAG = 1
_TRIANGLE_OF = {"tetra": "triangle", "tetra10": "triangle6"}


class MeshError(ValueError):
    """A mesh that cannot be used; the message says what is wrong and where."""


def jacobian_determinants(nodes: Floats, elements: Integers) -> Floats:
    """Jacobian determinant of each element at each of its nodes.

    Parameters
    ----------
    nodes : (n, 3) coordinates in m.
    elements : (m, 4) or (m, 10) node numbers.

    Returns
    -------
    (m, 1) array for straight tet4, (m, 10) for tet10, in m3: six times the volume of an element
    with straight edges.
    """
    corners = np.eye(4)
    slopes = np.vstack([-np.ones(3), np.eye(3)])
    if elements.shape[1] == 4:
        gradients = slopes[None]
    else:
        a, b = TETRA_EDGES.T
        places = np.vstack([corners, (corners[a] + corners[b]) / 2])
        at_corners = (4 * places - 1)[:, :, None] * slopes
        at_edges = 4 * (places[:, a, None] * slopes[b] + places[:, b, None] * slopes[a])
        gradients = np.concatenate([at_corners, at_edges], axis=1)
    frames = np.einsum("pai,eac->epic", gradients, nodes[elements])
    return np.linalg.det(frames)


def _first(ids: NDArray, count: int = 5) -> str:
    listed = ", ".join(str(i) for i in ids[:count])
    return listed + (", ..." if len(ids) > count else "")


@dataclass(frozen=True, eq=False)
class Mesh:
    """One connected body of tetrahedra of one kind.

    Parameters
    ----------
    nodes : (n, 3) float array
        Coordinates in m, in body axes.
    elements : (m, 4) or (m, 10) int array
        Node numbers from 0.
    surfaces : mapping of str to (k, 3) or (k, 6) int array
        Named parts of the boundary as triangles of nodes; parts may overlap.

    Raises
    ------
    MeshError
        If coordinates are not finite, elements are inverted or refer to nodes that do not exist,
        nodes belong to no element, the elements make several bodies, or a surface is no part of
        the boundary.
    """

    nodes: Floats
    elements: Integers
    surfaces: Mapping[str, Integers]

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
        nodes, elements = self.nodes, self.elements
        if nodes.ndim != 2 or nodes.shape[1] != 3 or elements.ndim != 2:
            raise MeshError(
                f"nodes must be (n, 3) and elements (m, 4 or 10), not {nodes.shape} and {elements.shape}"
            )
        if elements.shape[1] not in (4, 10) or len(elements) == 0:
            raise MeshError(f"elements are {elements.shape}; tetrahedra with 4 or 10 nodes are needed")
        bad = np.flatnonzero(~np.isfinite(nodes).all(axis=1))
        if len(bad):
            raise MeshError(f"{len(bad)} nodes have coordinates that are not finite: {_first(bad)}")
        bad = np.flatnonzero(((elements < 0) | (elements >= len(nodes))).any(axis=1))
        if len(bad):
            raise MeshError(f"{len(bad)} elements refer to nodes outside 0..{len(nodes) - 1}: {_first(bad)}")
        used = np.zeros(len(nodes), dtype=bool)
        used[elements.ravel()] = True
        if not used.all():
            loose = np.flatnonzero(~used)
            raise MeshError(f"{len(loose)} loose nodes belong to no element: {_first(loose)}")
        bad = np.flatnonzero(jacobian_determinants(nodes, elements).min(axis=1) <= 0.0)
        if len(bad):
            raise MeshError(f"{len(bad)} of {len(elements)} elements are inverted or flat: {_first(bad)}")
        corners = elements[:, :4]
        links = coo_array(
            (
                np.ones(3 * len(corners), dtype=np.int8),
                (np.repeat(corners[:, 0], 3), corners[:, 1:].ravel()),
            ),
            shape=(len(nodes), len(nodes)),
        )
        _, label = connected_components(links, directed=False)
        bodies = np.unique(label[corners[:, 0]], return_counts=True)[1]
        if len(bodies) > 1:
            raise MeshError(
                f"the mesh holds {len(bodies)} disconnected bodies, of "
                f"{_first(np.sort(bodies)[::-1])} elements; one is needed"
            )
        self._check_surfaces()

    def _check_surfaces(self) -> None:
        width = self.boundary.shape[1]
        boundary = {tuple(face) for face in np.sort(self.boundary[:, :3], axis=1).tolist()}
        for name, faces in self.surfaces.items():
            if faces.ndim != 2 or faces.shape[1] != width or len(faces) == 0:
                raise MeshError(f"surface {name!r} is {faces.shape}; a non-empty (k, {width}) is needed")
            inside = [
                i
                for i, face in enumerate(np.sort(faces[:, :3], axis=1).tolist())
                if tuple(face) not in boundary
            ]
            if inside:
                raise MeshError(
                    f"surface {name!r}: {len(inside)} of {len(faces)} triangles are not on the "
                    f"boundary: {_first(np.array(inside))}"
                )

    @property
    def order(self) -> int:
        """Polynomial order of the elements: 1 (tet4) or 2 (tet10)."""
        return 1 if self.elements.shape[1] == 4 else 2

    @cached_property
    def boundary(self) -> Integers:
        """Triangles of the whole boundary, (k, 3) or (k, 6), corners in outward sense."""
        local = TETRA_FACES[:, : 3 * self.order]
        faces = self.elements[:, local].reshape(-1, local.shape[1])
        _, first, counts = np.unique(
            np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True
        )
        return faces[np.sort(first[counts == 1])]

    @cached_property
    def surface_nodes(self) -> Integers:
        """Numbers of all nodes on the boundary, ascending."""
        return np.unique(self.boundary)

    def surface(self, name: str) -> Integers:
        """Triangles of a named surface.

        Raises
        ------
        KeyError
            If the mesh has no such surface; the message lists those it has.
        """
        if name not in self.surfaces:
            raise KeyError(f"no surface {name!r} in the mesh; it has {sorted(self.surfaces)}")
        return self.surfaces[name]

    def nodes_of(self, name: str) -> Integers:
        """Numbers of the nodes of a named surface, ascending."""
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


def _surfaces_of(raw: meshio.Mesh, kind: str) -> dict[str, Integers]:
    surfaces: dict[str, list[Integers]] = {}
    tags = raw.cell_data.get(PHYSICAL, [None] * len(raw.cells))
    names = {int(tag): name for name, (tag, dim) in raw.field_data.items() if dim == 2}
    for block, tag in zip(raw.cells, tags, strict=True):
        if block.type == kind and tag is not None:
            for value in np.unique(tag):
                name = names.get(int(value))
                if name is not None:
                    surfaces.setdefault(name, []).append(block.data[tag == value])
    if not surfaces:
        for name, per_block in raw.cell_sets.items():
            for block, chosen in zip(raw.cells, per_block, strict=True):
                if block.type == kind and chosen is not None and len(chosen):
                    surfaces.setdefault(name, []).append(block.data[chosen])
    return {name: np.concatenate(parts) for name, parts in surfaces.items()}


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh of tetrahedra from any format that meshio reads, also gzip-compressed (`.gz`).

    Named surfaces come from triangle cells with gmsh's physical names or, in other formats, from
    cell sets.

    Parameters
    ----------
    path : path of the file; lengths in m.

    Returns
    -------
    Mesh

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    MeshError
        If it is no mesh, holds no tetrahedra or several kinds of solid elements, or fails a check
        of `Mesh`.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no mesh file {path}")
    try:
        if path.suffix == ".gz":
            with tempfile.TemporaryDirectory() as folder:
                plain = Path(folder) / path.stem
                with gzip.open(path) as packed, plain.open("wb") as out:
                    shutil.copyfileobj(packed, out)
                raw = meshio.read(plain)
        else:
            raw = meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio's readers raise whatever they stumble on
        raise MeshError(f"{path} is no mesh that meshio can read: {error}") from error
    counts = {
        block.type: sum(len(b.data) for b in raw.cells if b.type == block.type)
        for block in raw.cells
        if block.dim == 3
    }
    if not set(counts) & set(_TRIANGLE_OF):
        held = ", ".join(f"{n} {kind}" for kind, n in counts.items()) or "no solid elements"
        raise MeshError(f"{path} has no tetrahedra (tetra or tetra10); it holds {held}")
    if len(counts) > 1:
        held = ", ".join(f"{n} {kind}" for kind, n in counts.items())
        raise MeshError(f"{path} mixes kinds of solid elements: {held}; one kind is needed")
    kind = next(iter(counts))
    elements = np.concatenate([b.data for b in raw.cells if b.type == kind]).astype(np.int64)
    nodes = np.asarray(raw.points, dtype=np.float64)
    try:
        return Mesh(nodes, elements, _surfaces_of(raw, _TRIANGLE_OF[kind]))
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def write_mesh(path: str | Path, mesh: Mesh) -> None:
    """Write a mesh with its named surfaces as a binary gmsh file, gzip-compressed if `.msh.gz`."""
    path = Path(path)
    kind = "tetra" if mesh.order == 1 else "tetra10"
    cells = [(kind, mesh.elements)]
    tags = [np.full(len(mesh.elements), SOLID_TAG)]
    field_data = {"solid": np.array([SOLID_TAG, 3])}
    for number, (name, faces) in enumerate(mesh.surfaces.items(), start=SOLID_TAG + 1):
        cells.append((_TRIANGLE_OF[kind], faces))
        tags.append(np.full(len(faces), number))
        field_data[name] = np.array([number, 2])
    raw = meshio.Mesh(
        mesh.nodes,
        cells,
        cell_data={PHYSICAL: tags, "gmsh:geometrical": tags},
        field_data=field_data,
    )
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / "plain.msh"
        meshio.write(plain, raw, file_format="gmsh22", binary=True)
        content = plain.read_bytes()
    path.write_bytes(gzip.compress(content, mtime=0) if path.suffix == ".gz" else content)
