"""Content of a mesh file of any format: blocks of cells with their groups, and the volume mesh in it.

Groups of one name are joined, and a face may have several names. A surface is read whole or not at all; the
notes tell why one is left out.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Self

import numpy as np
from scipy.spatial import cKDTree

from fem.body.distortion import straighten_distorted
from fem.body.mesh import (
    TETRA_FACES,
    Floats,
    Integers,
    Mesh,
    MeshError,
    boundary_faces,
    jacobian_determinants,
    listed,
)

TRIANGLES = ("triangle", "triangle6")
TETRAHEDRA = ("tetra", "tetra10")
OTHER_SOLIDS = ("hexahedron", "wedge", "pyramid", "polyhedron", "tetra")
"""Prefixes of the names of solid cells; tetrahedra of 4 or 10 nodes are the supported ones."""
SAME_PLACE = 1e-6
"""Distance below which a shell's node and a solid's node are the same, fraction of the body's size."""
LARGEST_FILE = 1 << 30
"""Greatest size of an unpacked mesh file, bytes: a hundred times that of the finest ready mesh."""
LARGEST_PLACE = 1e12
"""Limit of coordinates, in any unit."""
TURNED = np.array([1, 0, 2, 3, 4, 6, 5, 8, 7, 9])
"""Order of local nodes that reverses the sense of a tetrahedron."""


class FileCells(NamedTuple):
    """Cells of one kind.

    Attributes
    ----------
    kind : str
        Name in meshio: "tetra10", "triangle6".
    nodes : int array (m, k)
        Rows of the nodes' coordinates.
    groups : mapping of str to int array
        Rows of the cells of each named group.
    """

    kind: str
    nodes: Integers
    groups: Mapping[str, Integers]


@dataclass
class FileContent:
    """Everything that a reader finds in a mesh file.

    Attributes
    ----------
    points : array (n, 3)
        Coordinates in the file's unit.
    cells : list of FileCells
    faces : dict of str to list of int array (k, 3)
        Corners of named faces of solid cells.
    unread : dict of str to str
        Reasons by name of the surfaces that cannot be read in full.
    notes : list of str
        Contents of the file beside its mesh.
    """

    points: Floats
    cells: list[FileCells]
    faces: dict[str, list[Integers]] = field(default_factory=dict)
    unread: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class VolumeMesh:
    """Volume mesh of a file with its named surfaces and bodies, before any check of `Mesh`.

    Attributes
    ----------
    nodes : array (n, 3)
        Nodes of the tetrahedra alone, in the file's unit and axes.
    elements : int array (m, 4 or 10)
        Nodes of each element; all have a positive volume.
    surfaces : dict of str to int array (k, 3 or 6)
        Named parts of the boundary.
    cell_sets : dict of str to int array
        Numbers of the elements of named bodies.
    unread : dict of str to str
        Reasons by name of the surfaces that are left out, since they cannot be read in full.
    notes : tuple of str
        Other contents of the file that are left out.
    """

    nodes: Floats
    elements: Integers
    surfaces: dict[str, Integers]
    cell_sets: dict[str, Integers]
    unread: dict[str, str]
    notes: tuple[str, ...]

    def mesh(self) -> Mesh:
        """Return the checked mesh of one body; lengths are taken as m. Raise `MeshError` if a check fails."""
        left_out = [f"surface {name!r} is left out: {reason}" for name, reason in self.unread.items()]
        return Mesh(self.nodes, self.elements, self.surfaces, (*left_out, *self.notes))

    def straightened(self) -> Self:
        """Return the volume mesh with straight edges where curved ones fold an element, or nearly do."""
        if self.elements.shape[1] == 4:
            return self
        nodes, count = straighten_distorted(self.nodes, self.elements)
        return replace(self, nodes=nodes, notes=(*self.notes, f"{count} elements have straight edges"))


def volume_mesh(content: FileContent) -> VolumeMesh:
    """Find the tetrahedra of a file, and its named surfaces on their boundary.

    Raises
    ------
    MeshError
        If the file has no tetrahedra, other solids beside them or several orders of them, or if elements are
        turned inside out.
    """
    kind = _kind_of_solids(content.cells)
    solids = [block for block in content.cells if block.kind == kind]
    elements = np.concatenate([block.nodes for block in solids]).astype(np.int64)
    _check_numbers(elements, len(content.points))
    for block in content.cells:
        if block.kind in TRIANGLES:
            _check_numbers(block.nodes, len(content.points))
    notes = list(content.notes)
    used = np.unique(elements)
    wild = used[~(np.abs(content.points[used]) < LARGEST_PLACE).all(axis=1)]
    if len(wild):
        raise MeshError(
            f"coordinates must be finite and less than {LARGEST_PLACE:g}, got {len(wild)} nodes with others, "
            f"such as {content.points[wild[0]].tolist()}"
        )
    elements, turned = _turned_outside(content.points, elements)
    if turned:
        notes.append(f"{turned} of {len(elements)} elements are numbered in the other sense and were turned")
    number = np.full(len(content.points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    loose = len(content.points) - len(used)
    surfaces, unread = _surfaces(content, number, content.points[used], boundary_faces(number[elements]))
    if loose:
        notes.append(f"{loose} nodes belong to no solid element and are left out")
    notes += _left_out(content.cells)
    return VolumeMesh(
        np.ascontiguousarray(content.points[used], dtype=np.float64),
        number[elements],
        surfaces,
        _cell_sets(solids),
        unread,
        tuple(notes),
    )


def _kind_of_solids(cells: Iterable[FileCells]) -> str:
    counts: Counter[str] = Counter()
    for block in cells:
        if block.kind.startswith(OTHER_SOLIDS):
            counts[block.kind] += len(block.nodes)
    counts = +counts
    held = ", ".join(f"{number} {kind}" for kind, number in counts.items()) or "no solid elements"
    if not set(counts) & set(TETRAHEDRA):
        raise MeshError(f"it must hold tetrahedra of 4 or 10 nodes, got {held}")
    if len(counts) > 1:
        raise MeshError(f"it must hold one kind of solid elements, got {held}")
    return next(iter(counts))


def _check_numbers(elements: Integers, count: int) -> None:
    bad = np.flatnonzero(((elements < 0) | (elements >= count)).any(axis=1))
    if len(bad):
        raise MeshError(
            f"elements must refer to nodes of the file, got {len(bad)} that do not: {listed(bad)}"
        )


def _turned_outside(points: Floats, elements: Integers) -> tuple[Integers, int]:
    """Reverse the numbering of elements with negative volume; return the elements and the number reversed.

    Programs differ in the sense of an element's nodes. An element that is turned inside out between its
    neighbours has a negative volume, too. After its numbering is reversed, it shares faces of the same sense
    with its neighbours.
    """
    turned = jacobian_determinants(points, elements[:, :4])[:, 0] < 0.0
    if not turned.any():
        return elements, 0
    order = TURNED[: elements.shape[1]]
    elements = np.where(turned[:, None], elements[:, order], elements)
    wrong = np.flatnonzero(turned & _shares_a_sense(elements))
    if len(wrong):
        place = points[elements[wrong[0], :4]].mean(axis=0)
        raise MeshError(
            f"elements must not be inverted, got {len(wrong)} of {len(elements)} that their neighbours turn "
            f"inside out: {listed(wrong)}; the first is at {place.round(4).tolist()}"
        )
    return elements, int(turned.sum())


def _shares_a_sense(elements: Integers) -> np.ndarray:
    """Return True for elements (m,) that share a face with the same sense of corners with another one."""
    faces = elements[:, TETRA_FACES[:, :3]].reshape(-1, 3)
    order = np.argsort(faces, axis=1)
    ordered = np.take_along_axis(faces, order, axis=1)
    # permutations of three corners that keep the sense are cyclic shifts of 0, 1, 2
    even = (order[:, 1] - order[:, 0]) % 3 == 1
    _, place, counts = np.unique(
        np.column_stack((ordered, even)), axis=0, return_inverse=True, return_counts=True
    )
    shared: np.ndarray = (counts[place.ravel()] > 1).reshape(-1, 4)
    return np.asarray(shared.any(axis=1))


def _surfaces(
    content: FileContent, number: Integers, nodes: Floats, boundary: Integers
) -> tuple[dict[str, Integers], dict[str, str]]:
    """Return the named surfaces as faces of the boundary, and the reasons by name of those left out."""
    number = _with_nodes_at_the_same_place(content, number, nodes)
    place = {face: row for row, face in enumerate(map(tuple, np.sort(boundary[:, :3], axis=1).tolist()))}
    surfaces: dict[str, Integers] = {}
    unread = dict(content.unread)
    for name, parts in _named_faces(content).items():
        faces: dict[tuple[int, ...], Integers] = {}
        off = 0
        for part in parts:
            rows = number[part]
            for face, corners in zip(rows, map(tuple, np.sort(rows[:, :3], axis=1).tolist()), strict=True):
                row = place.get(corners)
                if row is None:
                    off += 1
                elif corners not in faces:
                    whole = set(face.tolist()) == set(boundary[row].tolist())
                    faces[corners] = face if whole else boundary[row]
        if off and faces:
            unread[name] = (
                f"{off} of its {off + len(faces)} faces are no faces of the boundary of the solid elements; "
                "name outer faces alone, and merge the nodes of shells with those of the solids"
            )
        elif faces and name not in unread:
            surfaces[name] = np.array(list(faces.values()), dtype=np.int64)
    return surfaces, unread


def _named_faces(content: FileContent) -> dict[str, list[Integers]]:
    named: dict[str, list[Integers]] = {}
    for block in content.cells:
        if block.kind in TRIANGLES:
            for name, rows in block.groups.items():
                named.setdefault(name, []).append(block.nodes[rows])
    for name, parts in content.faces.items():
        named.setdefault(name, []).extend(parts)
    return named


def _with_nodes_at_the_same_place(content: FileContent, number: Integers, nodes: Floats) -> Integers:
    """Return the node numbers of solids, also for nodes of shells that coincide with them."""
    shells = [block.nodes.ravel() for block in content.cells if block.kind in TRIANGLES and block.groups]
    if not shells:
        return number
    alone = np.unique(np.concatenate(shells))
    alone = alone[number[alone] < 0]
    alone = alone[np.isfinite(content.points[alone]).all(axis=1)]
    if len(alone) == 0 or not np.isfinite(nodes).all():
        return number
    reach = SAME_PLACE * float(np.ptp(nodes, axis=0).max())
    distance, nearest = cKDTree(nodes).query(content.points[alone], distance_upper_bound=reach)
    number = number.copy()
    number[alone[np.isfinite(distance)]] = nearest[np.isfinite(distance)]
    return number


def _cell_sets(solids: list[FileCells]) -> dict[str, Integers]:
    sets: dict[str, list[Integers]] = {}
    first = 0
    for block in solids:
        for name, rows in block.groups.items():
            sets.setdefault(name, []).append(first + np.asarray(rows, dtype=np.int64))
        first += len(block.nodes)
    return {name: np.unique(np.concatenate(parts)) for name, parts in sets.items()}


def _left_out(cells: list[FileCells]) -> list[str]:
    """Return notes on cells that are neither tetrahedra nor triangles."""
    counts: Counter[str] = Counter()
    for block in cells:
        if block.kind not in (*TRIANGLES, *TETRAHEDRA):
            counts[block.kind] += len(block.nodes)
    return [f"{number} elements of the kind {kind} are left out" for kind, number in counts.items() if number]
