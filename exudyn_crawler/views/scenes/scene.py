"""Description of a scene in space: solids with their poses over time, colours, and arrows.

Pictures, films, ParaView and the 3D views of pages all draw it. The first dimension of values over time is
`times`; its length is 1 for constant values.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

FLAT = "none"  # edges of faces without shade and without lines between them
HIDDEN, SIDES = 0.002, 32
"""Depth (m) by which a face must lie before a point to hide it; sides of the prism of a disc."""
BOX = np.array([[x, y, z] for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float)
BOX_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
"""Corners of a hexahedron in VTK's order, from -1 to 1, and its faces in outward sense."""


@dataclass(frozen=True)
class View:
    """Parallel projection: unit vectors (3,) rightward and upward in the picture, and its origin (3,), m."""

    right: np.ndarray
    up: np.ndarray
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @classmethod
    def seen_from(cls, azimuth: float, elevation: float) -> Self:
        """Return the view of a viewer at an azimuth about z from +x and at an elevation, degrees."""
        around, above = np.radians([azimuth, elevation])
        right = np.array([-np.sin(around), np.cos(around), 0.0])
        toward = np.array([np.cos(above) * np.cos(around), np.cos(above) * np.sin(around), np.sin(above)])
        return cls(right, np.cross(toward, right))

    def on(self, body: "Placement") -> Self:
        """Return this view fixed to a body: the body keeps its place in the picture wherever it moves."""
        return replace(self, right=body.turn @ self.right, up=body.turn @ self.up, origin=body.origin)

    @property
    def toward(self) -> np.ndarray:
        """Unit vector from the scene to the viewer."""
        return np.cross(self.right, self.up)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return points (..., 3) as right, up and toward the viewer: array of the same shape, m."""
        return (points - self.origin) @ np.column_stack((self.right, self.up, self.toward))


class Placement(NamedTuple):
    """Pose of a body: `origin` (3,), m, and `turn` (3, 3), whose columns are its axes, both global."""

    origin: np.ndarray
    turn: np.ndarray

    def place(self, points: np.ndarray) -> np.ndarray:
        """Return points (..., 3) in the body's axes as global ones."""
        return points @ self.turn.T + self.origin


@dataclass(frozen=True)
class Colouring:
    """Values on a solid, (times, copies, points) or (times, copies), and their colours.

    A missing value is NaN. `title` is that of the colour bar, with the unit; `name` tells several colourings
    of a solid apart. `colours` are a colour map of matplotlib between `low` and `high`, or a colour for each
    whole number from 0; `words` explain these colours. Values in `decades` are powers of ten; a page calls
    values from `high` on "beyond" it.
    """

    title: str
    values: np.ndarray
    low: float
    high: float
    colours: str | tuple[str, ...]
    words: tuple[str, ...] = ()
    name: str = ""
    decades: bool = False


@dataclass(frozen=True)
class Solid:
    """Shape with one pose or several copies; a copy with a NaN origin is absent.

    `faces` are arrays (m, k) of the corners of convex faces in outward sense; curved faces are cut into
    triangles. A solid with eight points is a box. With `edges`, or `FLAT` ones, there is no shade.
    """

    name: str
    points: np.ndarray  # (n, 3), m, in the body's axes
    faces: tuple[np.ndarray, ...]
    colour: str
    origin: np.ndarray = field(default_factory=lambda: np.zeros((1, 1, 3)))  # (times, copies, 3), m
    turn: np.ndarray = field(default_factory=lambda: np.eye(3)[None, None])  # (times, copies, 3, 3), axes
    opacity: float = 1.0
    edges: str = ""  # colour of the edges of faces with more than three corners
    labels: tuple[str, ...] = ()  # of each copy
    notes: tuple[str, ...] = ()  # beside the name at each time
    lift: np.ndarray | None = None  # (times, copies), m upward, added to the origin
    bend: np.ndarray | None = None  # (times, copies, n, 3): displacement in the body's axes, m ...
    larger: float = 1.0  # ... and its magnification
    colourings: tuple[Colouring, ...] = ()  # the first is drawn; a page offers all
    nodes: np.ndarray | None = None  # (n,): numbers of the points in a mesh

    @cached_property
    def triangles(self) -> np.ndarray:
        """Faces cut into triangles: int array (m, 3)."""
        return triangulated(self.faces)

    @property
    def values(self) -> np.ndarray:
        """Values (n,) of the drawn colouring at the only time; zeros if there is none."""
        return self.colourings[0].values.ravel() if self.colourings else np.zeros(len(self.points))

    def at(self, time: int = 0) -> "Solid":
        """Return all copies at a time, by its index, as one solid in global axes."""
        origin = at_time(self.origin, time)
        turn = at_time(self.turn, time)
        if self.lift is not None:
            origin = origin + upward(at_time(self.lift, time))
        there = np.flatnonzero(np.isfinite(origin).all(axis=1))
        shape = np.broadcast_to(self.points, (len(there), *self.points.shape))
        if self.bend is not None:
            shape = shape + self.larger * at_time(self.bend, time)[there]
        placed = np.einsum("cij,cnj->cni", turn[there], shape) + origin[there, None]
        starts = len(self.points) * np.arange(len(there))[:, None, None]
        faces = tuple((group + starts).reshape(-1, group.shape[1]) for group in self.faces)
        shown = []
        for colouring in self.colourings[:1]:
            values = at_time(colouring.values, time)[there].reshape(len(there), -1)
            shown.append(
                replace(colouring, values=np.broadcast_to(values, placed.shape[:2]).reshape(1, 1, -1))
            )
        merged = Solid(self.name, placed.reshape(-1, 3), faces, self.colour)
        return replace(merged, opacity=self.opacity, edges=self.edges, colourings=tuple(shown))

    def shows(self, point: int, view: View) -> bool:
        """Return True for a point that is visible, without a face of the solid before it."""
        projected = view.project(self.points)
        triangles = self.triangles
        here = projected[point]
        others = projected[triangles[(triangles != point).all(axis=1)]]
        around = (others.min(axis=1) <= here) & (others.max(axis=1) >= here)
        others = others[around[:, :2].all(axis=1)]
        origin = others[:, 0, :2]
        sides = np.stack((others[:, 1, :2] - origin, others[:, 2, :2] - origin), axis=-1)
        shares = np.linalg.pinv(sides) @ (here[:2] - origin)[:, :, None]
        u, v = shares[:, 0, 0], shares[:, 1, 0]
        depth = others[:, 0, 2] * (1.0 - u - v) + others[:, 1, 2] * u + others[:, 2, 2] * v
        covers = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
        return not bool((covers & (depth > here[2] + HIDDEN)).any())


@dataclass(frozen=True)
class Arrows:
    """Forces of one kind: `heads` (times, arrows, 3), the points of application, m, and `forces` there, N.

    An arrow with a NaN head is absent. `scale` is the drawn length of 1 N (m). `solid` is the name of the
    solid that the arrows belong to where solids are drawn apart. Pages draw each arrow again `through` m
    beyond its head along the force, because a solid hides one of the two.
    """

    name: str
    colour: str
    heads: np.ndarray
    forces: np.ndarray
    scale: float
    solid: str = ""
    through: float = 0.0

    def at(self, time: int = 0) -> np.ndarray:
        """Return tail and head of each present arrow at a time, by its index: array (arrows, 2, 3), m."""
        heads = self.heads[time]
        forces = self.scale * self.forces[time]
        there = np.isfinite(heads).all(axis=1) & forces.any(axis=1)
        return np.stack((heads[there] - forces[there], heads[there]), axis=1)


class Scene(NamedTuple):
    """Solids and arrows at some times, each with a title; pictures show the first time."""

    titles: tuple[str, ...]
    solids: tuple[Solid, ...]
    arrows: tuple[Arrows, ...] = ()


def at_time(values: np.ndarray, time: int) -> np.ndarray:
    """Return the row of values (times, ...) at a time, by its index; constant values have one row."""
    return values[min(time, len(values) - 1)]


def triangulated(faces: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return convex faces, arrays (m, k) of corners, as triangles (m, 3); triangles stay as given."""
    if len(faces) == 1 and faces[0].shape[1] == 3:
        return faces[0]
    return np.concatenate([group[:, [0, k, k + 1]] for group in faces for k in range(1, group.shape[1] - 1)])


def box(low: np.typing.ArrayLike, high: np.typing.ArrayLike) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Return corners (8, 3) of a box between two corners, m, and its faces."""
    middle = 0.5 * np.add(low, high)
    half = 0.5 * np.subtract(high, low)
    return middle + half * BOX, (BOX_FACES,)


def disc(radius: float, width: float, sides: int = SIDES) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Return points (2 sides, 3) of a disc about the y axis, m, and its faces: rim and both flat sides."""
    around = 2.0 * np.pi * np.arange(sides) / sides
    rim = radius * np.column_stack((np.sin(around), np.zeros(sides), np.cos(around)))
    half = np.array([0.0, 0.5 * width, 0.0])
    right = np.arange(sides)
    after = np.roll(right, -1)
    faces = triangulated((np.column_stack((right, after, after + sides, right + sides)),))
    return np.concatenate((rim - half, rim + half)), (faces, np.stack((right[::-1], right + sides)))


def star(outline: np.ndarray, width: float) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Return points (2 n + 2, 3) of a prism about the y axis, m, and its faces.

    Its outline (n, 2), x and z in m, is clockwise seen from the right; every point of it is visible from the
    axis.
    """
    n = len(outline)
    half = np.array([0.0, 0.5 * width, 0.0])
    flat = np.column_stack((outline[:, 0], np.zeros(n), outline[:, 1]))
    right = np.arange(n)
    after = np.roll(np.arange(n), -1)
    rim = np.column_stack((right, after, after + n, right + n))
    middle = np.full(n, 2 * n)
    ends = [(middle, after, right), (middle + 1, right + n, after + n)]
    faces = rim, np.concatenate([np.column_stack(end) for end in ends])
    return np.concatenate((flat - half, flat + half, [-half, half])), faces


def carried(
    origin: np.ndarray, turn: np.ndarray, places: np.ndarray, spin: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return origins (times, bodies * n, 3), m, and axes of parts at points (n, 3), m, of bodies.

    `origin` (times, bodies, 3) and `turn` (times, bodies, 3, 3) are those of the bodies. The parts have the
    axes of their bodies, or `spin` if given.
    """
    points = origin[:, :, None] + np.einsum("tbij,nj->tbni", turn, places)
    return points.reshape(len(points), -1, 3), np.repeat(turn if spin is None else spin, len(places), axis=1)


def upward(heights: np.ndarray) -> np.ndarray:
    """Return upward vectors (..., 3) with heights (...)."""
    return heights[..., None] * np.array([0.0, 0.0, 1.0])
