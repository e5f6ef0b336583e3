"""Meshes of Abaqus and CalculiX decks (.inp): tetrahedra, shells and named element faces.

Names are read as in these programs: blocks of one name are joined, sets may hold sets, and a surface is an
element set of shells or a ``*SURFACE`` of element faces. (meshio 5.3 keeps only the last block of a set, and
ends a block at its first comment.)
"""

import re
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from fem.body.mesh import TETRA_FACES, Integers, MeshError, boundary_faces, listed
from fem.files.deck_model import NODES_OF, Block, Deck, Place, deck_of, label, real
from fem.files.mesh_content import TETRAHEDRA, TRIANGLES, FileCells, FileContent

_WHOLE_SHELL = {"", "SPOS", "SNEG", "S1", "S2"}
"""Face names of a shell that mean the shell itself; others mean its edges."""
_FACES = {f"S{number}": number - 1 for number in (1, 2, 3, 4)}
"""Rows of `TETRA_FACES` for the faces of C3D4 and C3D10 (1-2-3, 1-4-2, 2-4-3, 3-4-1)."""
_FLAT = re.compile(r"(S|CPS|CPE|CPEG|CAX|M3D|SFM3D|R3D|DS)\d")
"""Pattern of element types that are faces."""
SHOWN_NAMES = 8


def read_deck(path: Path, text: str | None = None) -> FileContent:
    """Read the mesh of a deck.

    Parameters
    ----------
    path : Path
        Deck; its included files are searched beside it.
    text : str, optional
        Text of the deck, if already read.

    Raises
    ------
    MeshError
        If a line of the mesh cannot be read (the message names it), if keywords generate nodes or elements,
        or if several parts or instances have tetrahedra.
    """
    deck = deck_of(path, text)
    scope = _scope_of_solids(deck)
    keys = [key for key in deck.nodes if key[0] == scope]
    points = _placed(deck, scope, np.array([deck.nodes[key] for key in keys]).reshape(-1, 3))
    row_of = {number: row for row, (_, number) in enumerate(keys)}
    rows = [_rows(block, row_of) if _is_read(block, scope) else None for block in deck.blocks]
    named = _Named(deck, rows)
    cells = []
    for number, (block, nodes) in enumerate(zip(deck.blocks, rows, strict=True)):
        if nodes is not None:
            cells.append(FileCells(block.kind, nodes, named.groups(number)))
        else:
            cells.append(
                FileCells(block.kind or block.type, np.array(block.numbers, dtype=np.int64)[:, None], {})
            )
    faces = named.faces()
    return FileContent(points, cells, faces, named.unread, [*_notes(deck), *named.notes])


def _is_read(block: Block, scope: str) -> bool:
    return block.kind in NODES_OF and block.scope == scope


def _notes(deck: Deck) -> list[str]:
    names = list(dict.fromkeys(filter(None, deck.node_sets)))
    if not names:
        return []
    shown = ", ".join(map(repr, names[:SHOWN_NAMES])) + (", ..." if len(names) > SHOWN_NAMES else "")
    return [f"node sets do not say which faces are a surface, so that these are left out: {shown}"]


def _rows(block: Block, row_of: dict[int, int]) -> Integers:
    """Return the rows (m, k) of the nodes of a block."""
    missing = [node for nodes in block.nodes for node in nodes if node not in row_of]
    if missing:
        raise MeshError(
            f"nodes of elements of the type {block.type} must be in the deck, "
            f"which lacks {listed(np.unique(missing))}"
        )
    rows = [[row_of[node] for node in nodes] for nodes in block.nodes]
    return np.array(rows, dtype=np.int64).reshape(-1, NODES_OF[block.kind])


def _scope_of_solids(deck: Deck) -> str:
    """Return the part with the solid elements; raise `MeshError` for several parts or instances of it."""
    scopes = list(dict.fromkeys(block.scope for block in deck.blocks if block.kind in TETRAHEDRA))
    if len(scopes) > 1:
        raise MeshError(
            f"a deck must hold one part with tetrahedra, got {', '.join(map(repr, scopes))}; "
            "write the body alone"
        )
    if not scopes:
        return ""
    instances = [name for name, (part, _) in deck.instances.items() if part == scopes[0]]
    if len(instances) > 1:
        raise MeshError(
            f"a deck must hold one instance of the body, got {', '.join(map(repr, instances))}; "
            "write one alone"
        )
    return scopes[0]


def _placed(deck: Deck, scope: str, points: np.ndarray) -> np.ndarray:
    """Return the nodes (n, 3) of a part as placed by its instance: moved first, then turned about an axis."""
    for part, keyword in deck.instances.values():
        rows = [[real(text) for text in row] for row in keyword.rows()]
        if part == scope and rows:
            points = points + np.array((rows[0] + [0.0] * 3)[:3])
            if len(rows) > 1:
                start = np.array(rows[1][:3])
                axis = np.array(rows[1][3:6]) - start
                turn = Rotation.from_rotvec(np.radians(rows[1][6]) * axis / np.linalg.norm(axis))
                points = turn.apply(points - start) + start
    return points


class _Named:
    """Sets and surfaces of a deck, resolved to blocks and rows of elements.

    Parameters
    ----------
    deck : Deck
    rows : list of int array (m, k)
        Rows of the nodes of each block; None for a block that is left out.
    """

    def __init__(self, deck: Deck, rows: list[Integers | None]) -> None:
        self.deck = deck
        self.rows = rows
        self.unread: dict[str, str] = {}
        self.notes: list[str] = []
        self._names: dict[str, str] = {}
        self._members: dict[tuple[str, str], tuple[list[Place], str]] = {}
        self._groups: dict[int, dict[str, list[int]]] = {}
        for key, members in deck.sets.items():
            places, reason = self._places(key)
            name = self._name(key[1], members.name)
            if reason and any(deck.blocks[place.block].kind in TRIANGLES for place in places):
                self.unread[name] = reason
            if members.internal:
                continue
            for place in places:
                self._groups.setdefault(place.block, {}).setdefault(name, []).append(place.row)

    def groups(self, block: int) -> dict[str, Integers]:
        """Return the rows of each set's elements in a block."""
        return {name: np.unique(rows) for name, rows in self._groups.get(block, {}).items()}

    def faces(self) -> dict[str, list[Integers]]:
        """Return the face corners (k, 3) of each surface; incomplete surfaces join `unread`."""
        faces: dict[str, list[Integers]] = {}
        for key, surface in self.deck.surfaces.items():
            name = self._name(key[1], surface.name)
            corners, reason = self._corners(key, ())
            if reason and (corners or name in self._shells()):
                self.unread[name] = reason
            elif reason:
                self.notes.append(f"surface {name!r} is left out: {reason}")
            if corners:
                faces.setdefault(name, []).append(np.array(corners, dtype=np.int64))
        return faces

    def _shells(self) -> set[str]:
        """Return the names of the sets that hold shells."""
        blocks = self.deck.blocks
        return {
            name for block, sets in self._groups.items() if blocks[block].kind in TRIANGLES for name in sets
        }

    def _name(self, key: str, name: str) -> str:
        """Return a name in its first spelling in the deck."""
        return self._names.setdefault(key, name)

    def _places(
        self, key: tuple[str, str], above: tuple[tuple[str, str], ...] = ()
    ) -> tuple[list[Place], str]:
        """Return the places of a set's elements, and the reason if the set is incomplete."""
        if key in self._members:
            return self._members[key]
        if key not in self.deck.sets:
            return [], f"it names the set {key[1]!r}, which the deck does not have"
        if key in above:
            return [], f"the set {self.deck.sets[key].name!r} holds itself"
        members = self.deck.sets[key]
        known = self.deck.places
        places: dict[Place, None] = {}
        for scope, numbers in members.ranges:
            places |= dict.fromkeys(known[scope, number] for number in self._present(scope, numbers))
        missing = [number for scope, number in members.numbers if (scope, number) not in known]
        places |= dict.fromkeys(known[entry] for entry in members.numbers if entry in known)
        reason = ""
        if missing:
            reason = f"it lists elements that the deck does not have: {listed(np.array(missing))}"
        for scope, name in members.names:
            more, why = self._places((scope, label(name)), (*above, key))
            places |= dict.fromkeys(more)
            reason = reason or why
        odd = {self.deck.blocks[place.block].type for place in places if self._is_other_face(place)}
        if odd and not reason:
            reason = f"it has elements of the type {', '.join(sorted(odd))}; mesh it with triangles"
        self._members[key] = (list(places), reason)
        return self._members[key]

    def _present(self, scope: str, numbers: range) -> list[int]:
        """Return the numbers of a range that elements have; the range may reach far beyond them."""
        known = self.deck.places
        if len(numbers) <= len(known):
            return [number for number in numbers if (scope, number) in known]
        return [number for where, number in known if where == scope and number in numbers]

    def _is_other_face(self, place: Place) -> bool:
        """Return True for an element that is a face but not a triangle."""
        block = self.deck.blocks[place.block]
        return not block.kind and _FLAT.match(block.type) is not None

    def _corners(
        self, key: tuple[str, str], above: tuple[tuple[str, str], ...]
    ) -> tuple[list[tuple[int, ...]], str]:
        """Return the face corners of a surface, and the reason if the surface is incomplete."""
        if key not in self.deck.surfaces or key in above:
            return [], f"it names the surface {key[1]!r}, which the deck does not have"
        surface = self.deck.surfaces[key]
        corners: list[tuple[int, ...]] = []
        reason = surface.unread
        for scope, elements, face in surface.faces:
            more, why = self._faces_of(scope, elements, face)
            corners += more
            reason = reason or why
        for scope, name in surface.parts:
            more, why = self._corners((scope, label(name)), (*above, key))
            corners += more
            reason = reason or why
        return corners, reason

    def _faces_of(self, scope: str, elements: str, face: str) -> tuple[list[tuple[int, ...]], str]:
        """Return the corners of one face of each given element, or of their free faces if none is named."""
        reason = ""
        if elements.isdigit():
            place = self.deck.places.get((scope, int(elements)))
            places = [] if place is None else [place]
            if place is None:
                reason = f"it has a face of the element {elements}, which the deck does not have"
        else:
            places, reason = self._places((scope, label(elements)))
        corners: list[tuple[int, ...]] = []
        for place in places:
            rows = self.rows[place.block]
            kind = self.deck.blocks[place.block].kind
            if rows is not None and kind in TETRAHEDRA and face in _FACES:
                corners.append(tuple(rows[place.row][TETRA_FACES[_FACES[face], :3]].tolist()))
            elif rows is not None and kind in TETRAHEDRA and not face:
                sides = rows[place.row][TETRA_FACES[:, :3]].tolist()
                corners += [tuple(side) for side in sides if tuple(sorted(side)) in self._free]
            elif rows is not None and kind in TRIANGLES and face in _WHOLE_SHELL:
                corners.append(tuple(rows[place.row][:3].tolist()))
            else:
                type_ = self.deck.blocks[place.block].type
                reason = reason or f"it has the face {face or 'of no name'} of an element of the type {type_}"
        return corners, reason

    @cached_property
    def _free(self) -> set[tuple[int, ...]]:
        """Corners, ascending, of free faces of solids."""
        solids = [
            rows
            for rows, block in zip(self.rows, self.deck.blocks, strict=True)
            if rows is not None and block.kind in TETRAHEDRA
        ]
        corners = np.concatenate([rows[:, :4] for rows in solids])
        return set(map(tuple, np.sort(boundary_faces(corners), axis=1).tolist()))
