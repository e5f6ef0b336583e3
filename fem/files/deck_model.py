"""Nodes, elements, sets and surfaces of an Abaqus or CalculiX deck, as its keywords define them.

Separate blocks of one keyword are joined; references between sets and surfaces are not resolved yet.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from fem.body.mesh import MeshError
from fem.files.deck_lines import Keyword, keywords, label, unquoted

_KINDS = {
    "tetra": ("C3D4", "DC3D4", "AC3D4"),
    "tetra10": ("C3D10", "DC3D10", "AC3D10"),
    "triangle": ("S3", "STRI3", "CPS3", "CPE3", "CPEG3", "CAX3", "M3D3", "SFM3D3", "R3D3", "DS3"),
    "triangle6": ("S6", "STRI65", "CPS6", "CPE6", "CPEG6", "CAX6", "M3D6", "SFM3D6", "DS6"),
    "pyramid": ("C3D5",),
    "wedge": ("C3D6", "SC6"),
    "wedge15": ("C3D15",),
    "hexahedron": ("C3D8", "SC8"),
    "hexahedron20": ("C3D20",),
    "hexahedron27": ("C3D27",),
}
_KIND_OF = {base: kind for kind, bases in _KINDS.items() for base in bases}
NODES_OF = {"tetra": 4, "tetra10": 10, "triangle": 3, "triangle6": 6}
"""Number of nodes of each kind that is read; of other kinds only the element numbers are read."""
_MADE = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM")
"""Keywords that generate nodes and elements from others."""


class Place(NamedTuple):
    """Location of an element: its block, and its row in the block."""

    block: int
    row: int


@dataclass
class Set:
    """Named element set: element numbers and other sets, with their scopes."""

    name: str
    internal: bool = True
    numbers: list[tuple[str, int]] = field(default_factory=list)
    ranges: list[tuple[str, range]] = field(default_factory=list)
    names: list[tuple[str, str]] = field(default_factory=list)


@dataclass
class Surface:
    """Named surface: faces of elements, given by a set's name or a number in a scope."""

    name: str
    faces: list[tuple[str, str, str]] = field(default_factory=list)
    parts: list[tuple[str, str]] = field(default_factory=list)
    unread: str = ""


@dataclass
class Block:
    """Elements of one type: rows of their nodes, or none if the type is left out."""

    scope: str
    type: str
    kind: str
    numbers: list[int]
    nodes: list[list[int]]


@dataclass
class Deck:
    """Everything in a deck that belongs to its mesh; a scope is a part, or empty outside of parts."""

    scope: str = ""
    nodes: dict[tuple[str, int], tuple[float, float, float]] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)
    places: dict[tuple[str, int], Place] = field(default_factory=dict)
    sets: dict[tuple[str, str], Set] = field(default_factory=dict)
    surfaces: dict[tuple[str, str], Surface] = field(default_factory=dict)
    node_sets: list[str] = field(default_factory=list)
    instances: dict[str, tuple[str, Keyword]] = field(default_factory=dict)

    def set_named(self, name: str, scope: str) -> Set:
        """Return the set of a name; create it if there is none."""
        return self.sets.setdefault((scope, label(name)), Set(unquoted(name)))


def deck_of(path: Path, text: str | None = None) -> Deck:
    """Read everything in a deck that belongs to its mesh; see `deck.read_deck` for arguments and errors."""
    deck = Deck()
    for keyword in keywords(path, text):
        try:
            _take(deck, keyword)
        except MeshError:
            raise
        except (ValueError, IndexError) as error:
            raise MeshError(
                f"*{keyword.name} ({keyword.place}) must follow the syntax of Abaqus: {str(error)[:100]}"
            ) from error
    if not deck.nodes or not deck.blocks:
        raise MeshError("a deck must have *NODE and *ELEMENT")
    return deck


def _take(deck: Deck, keyword: Keyword) -> None:
    """Add a keyword's data to a deck."""
    name = keyword.name
    if name in _MADE:
        raise MeshError(
            f"nodes and elements must be written one by one, got *{name} ({keyword.place}); let the program "
            "write the whole mesh, as Abaqus/CAE does by Job, Write Input"
        )
    if name in ("PART", "INSTANCE"):
        _enter(deck, keyword)
    elif name in ("END PART", "END INSTANCE"):
        deck.scope = ""
    elif name == "NODE":
        _take_nodes(deck, keyword)
    elif name == "ELEMENT":
        _take_elements(deck, keyword)
    elif name == "ELSET":
        _take_set(deck, keyword)
    elif name == "SURFACE":
        _take_surface(deck, keyword)
    elif name == "NSET" and "INTERNAL" not in keyword.options:
        deck.node_sets.append(unquoted(keyword.options.get("NSET", "")))


def _enter(deck: Deck, keyword: Keyword) -> None:
    """Begin a part or an instance of it."""
    name = label(keyword.options.get("NAME", ""))
    if keyword.name == "INSTANCE":
        deck.instances[name] = (label(keyword.options.get("PART", "")) or name, keyword)
        name = deck.instances[name][0]
    deck.scope = name


def real(text: str) -> float:
    """Return the number in a field, possibly written by Fortran; 0 for an empty field."""
    return float(text.upper().replace("D", "E")) if text else 0.0


def _take_nodes(deck: Deck, keyword: Keyword) -> None:
    if keyword.options.get("SYSTEM", "R").upper() != "R":
        raise MeshError(
            f"nodes must have Cartesian coordinates, got *NODE in another system ({keyword.place})"
        )
    for number, *coordinates in keyword.rows():
        x, y, z = (real(text) for text in (*coordinates, "", "", "")[:3])
        key = (deck.scope, int(number))
        if deck.nodes.setdefault(key, (x, y, z)) != (x, y, z):
            raise MeshError(f"a node must have one position, got node {number} at two ({keyword.place})")
    if keyword.options.get("NSET"):
        deck.node_sets.append(unquoted(keyword.options["NSET"]))


def _kind(type_: str) -> str:
    """Return the kind of an element type, whatever its integration; empty for types left out."""
    match = re.fullmatch(r"(.*\d)[A-Z]*", type_)
    return _KIND_OF.get(match[1], "") if match else ""


def _take_elements(deck: Deck, keyword: Keyword) -> None:
    type_ = unquoted(keyword.options.get("TYPE", "")).upper()
    kind = _kind(type_)
    rows = _elements(keyword, NODES_OF[kind]) if kind in NODES_OF else _first_numbers(keyword)
    block = Block(deck.scope, type_ or "no type", kind, [], [])
    for number, *nodes in rows:
        place = deck.places.setdefault((deck.scope, number), Place(len(deck.blocks), len(block.numbers)))
        if place == (len(deck.blocks), len(block.numbers)):
            block.numbers.append(number)
            block.nodes.append(nodes)
            continue
        earlier = block if place.block == len(deck.blocks) else deck.blocks[place.block]
        if earlier.type != block.type or earlier.nodes[place.row] != nodes:
            raise MeshError(f"an element must be defined once, got element {number} twice ({keyword.place})")
    deck.blocks.append(block)
    if keyword.options.get("ELSET"):
        members = deck.set_named(keyword.options["ELSET"], deck.scope)
        members.internal = False
        members.numbers += [(deck.scope, row[0]) for row in rows]


def _elements(keyword: Keyword, count: int) -> list[list[int]]:
    """Return the numbers of elements and of their nodes; these may spread over several lines."""
    numbers = [int(text) for row in keyword.rows() for text in row if text]
    if len(numbers) % (count + 1):
        raise MeshError(
            f"*ELEMENT ({keyword.place}) must have {count} nodes for each element, "
            f"got {len(numbers)} numbers, which is no multiple of {count + 1}"
        )
    return [numbers[k : k + count + 1] for k in range(0, len(numbers), count + 1)]


def _first_numbers(keyword: Keyword) -> list[list[int]]:
    """Return the numbers of elements of a type that is left out; a comma continues one in the next line."""
    goes_on = False
    numbers = []
    for line in keyword.lines:
        if not goes_on:
            numbers.append([int(line.split(",")[0])])
        goes_on = line.endswith(",")
    return numbers


def _scope_of(deck: Deck, keyword: Keyword) -> str:
    """Return the scope of the elements that a set or a surface of the assembly names."""
    instance = keyword.options.get("INSTANCE")
    return deck.scope if instance is None else _part_of(deck, label(instance), keyword)


def _part_of(deck: Deck, instance: str, keyword: Keyword) -> str:
    if not deck.instances:
        return deck.scope  # an Abaqus deck without parts
    if instance not in deck.instances:
        raise MeshError(f"the deck must have the instance {instance!r} of *{keyword.name} ({keyword.place})")
    return deck.instances[instance][0]


def _reference(deck: Deck, text: str, scope: str) -> tuple[str, str]:
    """Return the scope and the name or number of a reference, possibly to an instance: `Part-1-1.top`."""
    instance, dot, name = unquoted(text).rpartition(".")
    if dot and label(instance) in deck.instances:
        return deck.instances[label(instance)][0], name
    return scope, unquoted(text)


def _named(keyword: Keyword, option: str) -> str:
    """Return the name of a set or a surface; raise `MeshError` if it has none."""
    name = keyword.options.get(option, "")
    if not name:
        raise MeshError(f"*{keyword.name} ({keyword.place}) must have a name, {option}=...")
    return name


def _take_set(deck: Deck, keyword: Keyword) -> None:
    members = deck.set_named(_named(keyword, "ELSET"), deck.scope)
    members.internal = members.internal and "INTERNAL" in keyword.options
    scope = _scope_of(deck, keyword)
    for row in keyword.rows():
        if "GENERATE" in keyword.options:
            first, last, *step = (int(text) for text in row if text)
            members.ranges.append((scope, range(first, last + 1, step[0] if step else 1)))
            continue
        for text in filter(None, row):
            where, name = _reference(deck, text, scope)
            if name.isdigit():
                members.numbers.append((where, int(name)))
            else:
                members.names.append((where, name))


def _take_surface(deck: Deck, keyword: Keyword) -> None:
    name = _named(keyword, "NAME")
    surface = deck.surfaces.setdefault((deck.scope, label(name)), Surface(unquoted(name)))
    combined = keyword.options.get("COMBINE", "UNION").upper()
    type_ = keyword.options.get("TYPE", "ELEMENT").upper()
    if combined != "UNION" or "CROP" in keyword.options or type_ not in ("ELEMENT", "NODE"):
        surface.unread = f"it must list faces of elements ({keyword.place})"
    elif type_ == "NODE":
        surface.unread = f"its nodes do not say which faces it has; let it list faces ({keyword.place})"
    elif "COMBINE" in keyword.options:
        surface.parts += [(deck.scope, text) for row in keyword.rows() for text in row if text]
    else:
        for row in keyword.rows():
            where, elements = _reference(deck, row[0], deck.scope)
            surface.faces.append((where, elements, row[1].upper() if len(row) > 1 else ""))
