"""Meshes of gmsh files (.msh, versions 2.2 and 4.1, text and binary) with all groups of every cell.

Format: gmsh's reference manual, "MSH file format". A cell may be in several physical groups; version 2.2 has
a copy for each. (meshio 5.3 reads only the first group, and confuses a surface and a volume of one name.)
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from meshio.gmsh import gmsh_to_meshio_type

from fem.body.mesh import Floats, Integers, MeshError
from fem.files.gmsh_sections import SAVE_AGAIN, Scanner
from fem.files.mesh_content import TETRAHEDRA, FileCells, FileContent

_NAME = re.compile(r'\s*(\d+)\s+(-?\d+)\s+"(.*)"\s*$')
_GMSH_TETRA10 = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
"""Order of gmsh's tetrahedron nodes in meshio."""
_LINEAR = {
    "vertex": 1,
    "line": 2,
    "triangle": 3,
    "quad": 4,
    "tetra": 4,
    "pyramid": 5,
    "wedge": 6,
    "hexahedron": 8,
}
"""Number of nodes of the kinds without a number in their meshio name."""
SURFACE = 2
VOLUME = 3


class Entity(NamedTuple):
    """Geometric entity of cells: its dimension and its number."""

    dimension: int
    number: int


@dataclass
class Msh:
    """Content of a file: names of groups, groups of entities (version 4.1 only), nodes and cells."""

    names: dict[tuple[int, int], str] = field(default_factory=dict)
    groups: dict[Entity, list[int]] = field(default_factory=dict)
    tags: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    points: Floats = field(default_factory=lambda: np.empty((0, 3)))
    cells: list[tuple[int, Integers, dict[int, Integers]]] = field(default_factory=list)
    """Gmsh's type number, tags of nodes (m, k), and the rows of each group."""


def read_gmsh(content: bytes) -> FileContent:
    """Read the content of a gmsh file.

    Raises
    ------
    MeshError
        If the file has another version, is partitioned, ends early or refers to missing nodes.
    """
    msh = Msh()
    scanner = Scanner(content)
    for section in iter(scanner.next_section, ""):
        if section == "PhysicalNames":
            msh.names = _names(scanner.rest_of_section().decode(errors="replace"))
        elif section == "Entities" and scanner.version == "4.1":
            _read_entities(scanner, msh)
        elif section == "PartitionedEntities":
            raise MeshError("it must not be partitioned; save it whole (gmsh: unpartition the mesh)")
        elif section in ("Nodes", "ParametricNodes"):
            if scanner.version == "4.1":
                _read_nodes(scanner, msh)
            else:
                _read_old_nodes(scanner, msh, section)
        elif section == "Elements":
            if scanner.version == "4.1":
                _read_elements(scanner, msh)
            elif scanner.is_text:
                _read_old_text(scanner, msh)
            else:
                _read_old_elements(scanner, msh)
        scanner.leave_section(section)
    if not msh.cells:
        raise MeshError("it holds no gmsh mesh: $Elements section not found or empty")
    return _file_content(msh)


def _names(text: str) -> dict[tuple[int, int], str]:
    """Return the names of groups by dimension and number."""
    matches = [match for match in map(_NAME.match, text.splitlines()) if match]
    return {(int(match[1]), abs(int(match[2]))): match[3] for match in matches}


def _read_entities(scanner: Scanner, msh: Msh) -> None:
    for dimension, count in enumerate(scanner.sizes(4)):
        for _ in range(count):
            (number,) = scanner.integers(1).tolist()
            scanner.reals(3 if dimension == 0 else 6)  # bounding box
            groups = scanner.integers(int(scanner.sizes(1)[0]))
            # a group that reverses the entity has a negative number
            msh.groups[Entity(dimension, number)] = np.unique(np.abs(groups)).tolist()
            if dimension:
                scanner.integers(int(scanner.sizes(1)[0]))  # bounding entities


def _read_nodes(scanner: Scanner, msh: Msh) -> None:
    blocks, _, _, _ = scanner.sizes(4).tolist()
    tags = [msh.tags]
    points = [msh.points]
    for _ in range(blocks):
        dimension, _, parametric = scanner.integers(3).tolist()
        (count,) = scanner.sizes(1).tolist()
        tags.append(scanner.sizes(count))
        width = 3 + (dimension if parametric else 0)
        points.append(scanner.reals(count * width).reshape(count, width)[:, :3])
    msh.tags = np.concatenate(tags)
    msh.points = np.concatenate(points)


def _read_elements(scanner: Scanner, msh: Msh) -> None:
    blocks, _, _, _ = scanner.sizes(4).tolist()
    for _ in range(blocks):
        dimension, number, type_ = scanner.integers(3).tolist()
        (count,) = scanner.sizes(1).tolist()
        width = 1 + _node_count(type_)
        nodes = scanner.sizes(count * width).reshape(count, width)[:, 1:]
        rows = np.arange(count)
        groups = msh.groups.get(Entity(dimension, number), [])
        msh.cells.append((type_, nodes, dict.fromkeys(groups, rows)))


def _node_count(type_: int) -> int:
    if type_ not in gmsh_to_meshio_type:
        raise MeshError(f"its elements must have types of gmsh's documentation, got type {type_}")
    kind = gmsh_to_meshio_type[type_]
    base = kind.rstrip("0123456789")
    return int(kind[len(base) :] or _LINEAR[base])


def _read_old_nodes(scanner: Scanner, msh: Msh, section: str) -> None:
    count = int(scanner.line())
    if scanner.is_text:
        # parameters on curves and surfaces may follow the coordinates
        lines = [line.split()[:4] for line in scanner.rest_of_section().splitlines() if line.strip()]
        if len(lines) != count:
            raise MeshError(f"it must have {count} nodes, as it says, got {len(lines)}")
        numbers = np.array(lines, dtype=np.float64).reshape(-1, 4)
        msh.tags = numbers[:, 0].astype(np.int64)
        msh.points = numbers[:, 1:]
    elif section == "ParametricNodes":
        raise MeshError(
            f"its nodes must have no parameters; save it without (Mesh.SaveParametric = 0), or {SAVE_AGAIN}"
        )
    else:
        tags, *coordinates = scanner.rows(count, ["i4", "f8", "f8", "f8"])
        msh.tags = tags.astype(np.int64)
        msh.points = np.column_stack(coordinates).astype(np.float64)


def _read_old_text(scanner: Scanner, msh: Msh) -> None:
    count = int(scanner.line())
    lines = [line for line in scanner.rest_of_section().splitlines() if line.strip()]
    if len(lines) != count:
        raise MeshError(f"it must have {count} elements, as it says, got {len(lines)}")
    records: dict[int, tuple[list[list[int]], list[int]]] = {}
    for line in lines:
        _, type_, tags, *numbers = map(int, line.split())
        nodes, groups = records.setdefault(type_, ([], []))
        nodes.append(numbers[tags:])
        groups.append(numbers[0] if tags else 0)
    for type_, (nodes, groups) in records.items():
        if {len(row) for row in nodes} != {_node_count(type_)}:
            raise MeshError(f"its elements of type {type_} must have {_node_count(type_)} nodes")
        _add_old(msh, type_, np.array(nodes, dtype=np.int64), np.array(groups))


def _read_old_elements(scanner: Scanner, msh: Msh) -> None:
    left = int(scanner.line())
    records: dict[int, tuple[list[Integers], list[Integers]]] = {}
    while left > 0:
        type_, count, tags = scanner.integers(3).tolist()
        if count < 1 or tags < 0:
            raise MeshError(f"its blocks must have elements, got one of {count} with {tags} tags")
        width = 1 + tags + _node_count(type_)
        numbers = scanner.integers(count * width).reshape(count, width)
        nodes, groups = records.setdefault(type_, ([], []))
        nodes.append(numbers[:, 1 + tags :])
        groups.append(numbers[:, 1] if tags else np.zeros(count, dtype=np.int64))
        left -= count
    for type_, (nodes, groups) in records.items():
        _add_old(msh, type_, np.concatenate(nodes), np.concatenate(groups))


def _add_old(msh: Msh, type_: int, nodes: Integers, groups: Integers) -> None:
    """Add cells of a type; version 2.2 has a copy of a cell for each of its groups."""
    if gmsh_to_meshio_type[type_] in TETRAHEDRA:
        _, first, copy = np.unique(nodes, axis=0, return_index=True, return_inverse=True)
        order = np.argsort(first)
        row = np.argsort(order)[copy.ravel()]
        nodes = nodes[first[order]]
    else:
        row = np.arange(len(nodes))
    groups = np.abs(groups)
    msh.cells.append(
        (type_, nodes, {int(group): row[groups == group] for group in np.unique(groups) if group})
    )


def _file_content(msh: Msh) -> FileContent:
    order = np.argsort(msh.tags, kind="stable")
    tags = msh.tags[order]
    if (tags[1:] == tags[:-1]).any():
        raise MeshError("its nodes must have different numbers, got two with the same")
    cells = []
    unnamed: dict[int, set[int]] = {SURFACE: set(), VOLUME: set()}
    for type_, nodes, rows_of in msh.cells:
        kind = gmsh_to_meshio_type[type_]
        dimension = VOLUME if kind.startswith(("tetra", "hexa", "wedge", "pyramid")) else SURFACE
        if kind.startswith(("vertex", "line")):
            continue
        named: dict[str, list[Integers]] = {}
        for group, rows in rows_of.items():
            if (dimension, group) in msh.names:
                named.setdefault(msh.names[dimension, group], []).append(rows)
            else:
                unnamed[dimension].add(group)
        cells.append(FileCells(kind, _rows(nodes, kind, tags, order), _joined(named)))
    notes = []
    if unnamed[SURFACE]:
        notes.append(
            "physical surfaces without a name are left out, "
            f"of the numbers {', '.join(map(str, sorted(unnamed[SURFACE])))}"
        )
    held = {name for block in cells for name in block.groups}
    empty = [name for (dimension, _), name in msh.names.items() if dimension == SURFACE and name not in held]
    if empty:
        notes.append(
            f"no elements are in the physical surfaces {', '.join(map(repr, empty))}: "
            "gmsh's Mesh.SaveAll leaves groups out in version 2.2; save without it, or in version 4.1"
        )
    if not unnamed[SURFACE] and not any(dimension == SURFACE for dimension, _ in msh.names):
        notes.append("no face is in a physical surface; name them in gmsh (Physical Surface)")
    return FileContent(msh.points, cells, notes=notes)


def _joined(named: Mapping[str, list[Integers]]) -> dict[str, Integers]:
    return {name: np.unique(np.concatenate(parts)) for name, parts in named.items()}


def _rows(nodes: Integers, kind: str, tags: Integers, order: Integers) -> Integers:
    """Return the rows of nodes by their tags, in meshio's order of a cell's nodes."""
    place = np.minimum(np.searchsorted(tags, nodes), len(tags) - 1) if len(tags) else np.zeros_like(nodes)
    known = tags[place] == nodes if len(tags) else np.zeros(nodes.shape, dtype=bool)
    if not known.all():
        missing = np.unique(nodes[~known])
        raise MeshError(
            f"its elements must refer to its nodes, got {len(missing)} others, such as {missing[0]}"
        )
    rows = order[place]
    return rows[:, _GMSH_TETRA10] if kind == "tetra10" else rows
