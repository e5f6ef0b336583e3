"""Layout of a state: the meaning of the numbers of a row.

A row holds the time; the coordinates, their first and their second rates; the Lagrange multipliers, joint by
joint; and the values of the ground's contact that do not follow from these. Each body has six coordinates
(displacement of its origin from t = 0, then the angles about x, y, z): those of the shoes come first, then
the terrain's, the flexible shoes' modes and other bodies.
"""

import json
from dataclasses import asdict, dataclass
from functools import cached_property
from math import prod

import numpy as np

VERSION = 8
"""Version of the layout's text and of the case beside it; another version is an error."""

RATES = ("", " rate", " acceleration")
"""Suffixes of the names of coordinates, of their first and of their second rates."""

BODY_COORDINATES = ("x", "y", "z", "rotation about x", "rotation about y", "rotation about z")

BEARING, MOTOR = "bearing of the {}", "motor of the {}"
"""Names of the joints between a frame and a tumbler or an idler: bearing or slide, and motor against spin."""


def pin_name(side: str, link: int) -> str:
    """Return the name of the joint at one pin, "right" or "left", of a link (numbers from 1)."""
    return f"{side} pin of link {link}"


def friction_name(pin: str) -> str:
    """Return the name of the friction of a joint at a pin, by the joint's name."""
    return f"friction of {pin.replace(' of link ', ', link ')}"


@dataclass(frozen=True)
class StateLayout:
    """Parts of a state by name.

    The parts are "time"; "shoes" (shoes, 6), "terrain" (coordinates,), "modes" (flexible shoes, modes) and
    other bodies by their names (6,), together "coordinates", each also followed by " rate" and
    " acceleration"; every joint with multipliers, such as "right pin of link 1", "drive" and "turn", together
    "multipliers"; "contact" (shoes, contact).
    """

    shoes: int
    terrain: int  # number of the terrain's coordinates
    terrain_bodies: bool = False  # True if these are six for each unit
    flexible_shoes: tuple[int, ...] = ()  # their numbers
    modes: int = 0  # of each flexible shoe
    multipliers: tuple[tuple[str, int], ...] = ()  # items and their numbers of Lagrange multipliers
    # number of values of a shoe's contact that do not follow from the rest: with the engine's contact its
    # force and moment
    contact: int = 0
    bodies: tuple[str, ...] = ()  # names of the bodies beside the shoes

    @cached_property
    def _parts(self) -> dict[str, tuple[int, tuple[int, ...]]]:
        """First index and shape of every part and of the groups of parts."""
        shapes = {"shoes": (self.shoes, 6), "terrain": (self.terrain,)}
        shapes |= {"modes": (len(self.flexible_shoes), self.modes), **dict.fromkeys(self.bodies, (6,))}
        parts: dict[str, tuple[int, tuple[int, ...]]] = {"time": (0, ())}
        first = 1
        for rate in RATES:
            start = first
            for name, shape in shapes.items():
                parts[name + rate] = (first, shape)
                first += prod(shape)
            parts[f"coordinates{rate}"] = (start, (first - start,))
        start = first
        for name, size in self.multipliers:
            parts[name] = (first, (size,))
            first += size
        parts["multipliers"] = (start, (first - start,))
        parts["contact"] = (first, (self.shoes, self.contact))
        return parts

    @property
    def coordinate_count(self) -> int:
        """Number of coordinates."""
        return self._parts["coordinates"][1][0]

    @property
    def equation_count(self) -> int:
        """Number of equations: one for each coordinate and each multiplier."""
        return self.coordinate_count + sum(size for _, size in self.multipliers)

    @cached_property
    def size(self) -> int:
        """Length of a row."""
        first, shape = self._parts["contact"]
        return first + prod(shape)

    def part(self, rows: np.ndarray, name: str) -> np.ndarray:
        """Return a view of a part of rows (..., size): array (..., shape of the part).

        Raises `ValueError` if there is no such part or the rows have another length.
        """
        if rows.shape[-1] != self.size:
            raise ValueError(f"rows of a state must have {self.size} numbers, got {rows.shape[-1]}")
        first, shape = self._place(name)
        return rows[..., first : first + prod(shape)].reshape((*rows.shape[:-1], *shape))

    def _place(self, name: str) -> tuple[int, tuple[int, ...]]:
        if name not in self._parts:
            raise ValueError(f"a state has no part {name!r}; it has {sorted(self._parts)}")
        return self._parts[name]

    def first_multiplier(self, name: str) -> int:
        """Return the index of an item's first multiplier among all; raise `ValueError` if it has none."""
        return self._place(name)[0] - self._place("multipliers")[0]

    def has(self, name: str) -> bool:
        """Return True if there is a part of this name."""
        return name in self._parts

    def equation(self, row: int) -> str:
        """Return the coordinate of an equation, or, behind all coordinates, the item of the multiplier."""
        shoes = [f"shoe {number + 1}" for number in range(self.shoes)]
        units = [f"unit {number + 1}" for number in range(self.terrain // 6)]
        shoes, units, others = (
            [f"{name} ({coordinate})" for name in names for coordinate in BODY_COORDINATES]
            for names in (shoes, units, self.bodies)
        )
        terrain = [f"terrain (coordinate {number + 1})" for number in range(self.terrain)]
        modes = [f"modes of shoe {s} (mode {k + 1})" for s in self.flexible_shoes for k in range(self.modes)]
        multipliers = [name for name, size in self.multipliers for _ in range(size)]
        return [*shoes, *(units if self.terrain_bodies else terrain), *modes, *others, *multipliers][row]

    def to_json(self) -> str:
        """Return the layout as text, with its version."""
        return json.dumps({"version": VERSION} | asdict(self))
