"""The terrain: the grid of its units, their joints, its independent coordinates, and how these carry units.

Neighbouring units are joined at the middle of their shared face: by spherical joints along a spanning
tree of the grid and by in-plane joints (equal height) everywhere else. With two of the three rotations
of every unit held at zero, all of them together say one thing: the joint point of a face has one height
(K-chapter; to second order in the tilt, which stays below 1e-2 rad). What that leaves free is carried
by `TerrainModes`.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg

from exudyn_crawler.case import Case, Terrain
from exudyn_crawler.ground.compiled import inner, kernel

REACH = 1.0
"""m round the track at t = 0 within which contact is expected."""


class Grid(NamedTuple):
    """Units in columns along x and rows along y, counted along y first; lengths in m.

    `x`, `y` is the corner of the first unit, `tilt_axis` what units tilt about: 0 for x, 1 for y.
    """

    columns: int
    rows: int
    length: float
    width: float
    height: float
    x: float
    y: float
    tilt_axis: int

    def units_below(self, places: np.ndarray) -> np.ndarray:
        """Index of the unit below each place, or the one nearest to it: array of int, for (..., 2) m."""
        cells = np.floor((places - [self.x, self.y]) / [self.length, self.width]).astype(int)
        cells = np.clip(cells, 0, [self.columns - 1, self.rows - 1])
        return cells[..., 0] * self.rows + cells[..., 1]


def grid_of(terrain: Terrain) -> Grid:
    """Grid of a terrain."""
    sides = (terrain.unit_length, terrain.unit_width, terrain.unit_height)
    return Grid(terrain.columns, terrain.rows, *sides, *terrain.origin, terrain.tilt_axis)


class TerrainJoint(NamedTuple):
    """Joint of two neighbouring units at the middle of their shared face."""

    first: int  # unit index (from 0)
    second: int
    axis: int  # direction from one to the other: 0 for x, 1 for y
    spherical: bool  # or in-plane


def terrain_joints(terrain: Terrain) -> list[TerrainJoint]:
    """All joints of the grid: spherical along a spanning tree, in-plane elsewhere.

    The tree has every joint along x, and those along y in the first column: for 10 x 5 units
    45 + 4 = 49 spherical and 36 in-plane joints, the numbers of the K-chapter.
    """
    joints = []
    for column in range(terrain.columns):
        for row in range(terrain.rows):
            unit = column * terrain.rows + row
            if column + 1 < terrain.columns:
                joints.append(TerrainJoint(unit, unit + terrain.rows, 0, True))
            if row + 1 < terrain.rows:
                joints.append(TerrainJoint(unit, unit + 1, 1, column == 0))
    return joints


@inner
def modal_motion(heave, tilt, q, out):
    """Write heave and tilt of units (units, 4) by the first of some coordinates, or their rates."""
    for u in range(heave.shape[0]):
        z = a = 0.0
        for k in range(heave.shape[1]):
            z += heave[u, k] * q[k]
            a += tilt[u, k] * q[k]
        out[u, 2] = z
        out[u, 3] = a


@kernel
def modal_motions(heave, tilt, states, out):
    """Write heave and tilt of units (times, units, 4) at states (times, coordinates), or their rates."""
    for t in range(states.shape[0]):
        modal_motion(heave, tilt, states[t], out[t])


@dataclass(frozen=True)
class TerrainModes:
    """Terrain carried by its independent coordinates, whose mass matrix is the identity."""

    heave: np.ndarray  # (units, coordinates): heave of each unit (m) per unit of a coordinate
    tilt: np.ndarray  # (units, coordinates): tilt of each unit (rad)
    stiffness: np.ndarray  # (coordinates, coordinates): of the supports, 1/s2
    damping: np.ndarray  # (coordinates, coordinates): of the supports, 1/s
    weight: np.ndarray  # (coordinates,): load of a unit acceleration of gravity along -z
    tilt_axis: int

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.heave.shape[1]

    def motion(self, q: np.ndarray) -> np.ndarray:
        """Displacement (x, y, z) and tilt of the units, or their rates: array (..., units, 4), m and rad.

        `q` (..., size) are coordinates, or their rates.
        """
        units = np.zeros((*q.shape[:-1], len(self.heave), 4))
        states = np.ascontiguousarray(q).reshape(-1, self.size)
        modal_motions(self.heave, self.tilt, states, units.reshape(-1, *units.shape[-2:]))
        return units

    def project(self, wrenches: np.ndarray) -> np.ndarray:
        """Generalized forces (size,) of forces and moments on the units (units, 6)."""
        return np.asarray(wrenches[:, 2] @ self.heave + wrenches[:, 3 + self.tilt_axis] @ self.tilt)

    def sunk_evenly(self, heave: float) -> np.ndarray:
        """Coordinates (size,) at which all units heave by the same (m) and none tilts.

        A combination of the modes, since the units meet at one height everywhere.
        """
        shapes = np.vstack((self.heave, self.tilt))
        return np.linalg.lstsq(shapes, np.repeat([heave, 0.0], len(self.heave)), rcond=None)[0]


@dataclass(frozen=True)
class UnitCoordinates:
    """Terrain whose units are rigid bodies with position and angles each; all but their tilt is held.

    Its methods are those of `TerrainModes`.
    """

    unit_count: int
    tilt_axis: int

    @property
    def size(self) -> int:
        """Number of coordinates: six a unit."""
        return 6 * self.unit_count

    def motion(self, q: np.ndarray) -> np.ndarray:
        """Displacement and tilt of the units, or their rates: array (..., units, 4)."""
        bodies = q.reshape(*q.shape[:-1], self.unit_count, 6)
        # a list as an index would give columns, for which kernels are compiled once more
        return np.take(bodies, [0, 1, 2, 3 + self.tilt_axis], axis=-1)

    def project(self, wrenches: np.ndarray) -> np.ndarray:
        """Generalized forces (size,); moments beside the tilt's only load what holds the units."""
        return wrenches.ravel()

    def sunk_evenly(self, heave: float) -> np.ndarray:
        """Coordinates (size,) at which all units heave by the same (m) and none tilts."""
        return np.tile([0.0, 0.0, heave, 0.0, 0.0, 0.0], self.unit_count)


TerrainCoordinates = TerrainModes | UnitCoordinates


def terrain_modes(terrain: Terrain) -> TerrainModes:
    """Vibration modes of a terrain whose neighbouring units meet at one height.

    Every shared face gives one equation between the heaves and tilts of two units; the modes span the
    null space of all of them, for 10 x 5 pitching units 10 + 5 and for 19 x 13 units 19 + 13.
    """
    count = terrain.unit_count
    joints = terrain_joints(terrain)
    equations = np.zeros((len(joints), 2 * count))  # columns: heaves, then tilts
    half = 0.5 * terrain.tilt_length
    # a positive pitch lowers the side at +x, a positive roll raises the side at +y
    rise = -half if terrain.tilt == "pitch" else half
    across = 0 if terrain.tilt == "pitch" else 1
    for equation, joint in zip(equations, joints, strict=True):
        equation[joint.first] = 1.0
        equation[joint.second] = -1.0
        if joint.axis == across:
            equation[count + joint.first] = equation[count + joint.second] = rise
    free = scipy.linalg.null_space(equations)

    mass = np.repeat([terrain.unit_mass, terrain.unit_inertia[terrain.tilt_axis]], count)
    support = np.repeat([terrain.heave_stiffness, terrain.tilt_stiffness], count)
    squares, shapes = scipy.linalg.eigh(free.T @ (support[:, None] * free), free.T @ (mass[:, None] * free))
    modes = free @ shapes
    return TerrainModes(
        heave=modes[:count],
        tilt=modes[count:],
        stiffness=np.diag(squares),
        damping=terrain.damping_time * np.diag(squares),
        weight=-terrain.unit_mass * modes[:count].sum(axis=0),
        tilt_axis=terrain.tilt_axis,
    )


def localized(modes: TerrainModes, units: np.ndarray) -> TerrainModes:
    """Same terrain in coordinates of which only the first few move these units (indices from 0).

    The units are those that the track can touch. An orthogonal change of coordinates, so the mass matrix
    stays the identity; it makes the derivatives of the contact forces sparse. The coordinates follow from the
    terrain and the units alone: many modes have one frequency and any mixture of them serves, but a stored
    state has to mean the same on another machine.
    """
    heaves, tilts = (np.linalg.norm(rows, axis=1).max() for rows in (modes.heave, modes.tilt))
    # this length makes tilts comparable with heaves; it is the terrain's, whatever its coordinates
    shapes = np.vstack((modes.heave, modes.tilt * (heaves / tilts)))
    near = shapes[np.concatenate((units, len(modes.heave) + units))]
    _, values, turned = np.linalg.svd(near, full_matrices=True)
    moving = int(np.sum(values > 1e-9 * values[0]))
    parts = ((near, turned[:moving]), (shapes, turned[moving:]))
    turned = np.vstack([_settled(rows @ part.T) @ part for rows, part in parts])
    return TerrainModes(
        heave=_clean(modes.heave @ turned.T),
        tilt=_clean(modes.tilt @ turned.T),
        stiffness=turned @ modes.stiffness @ turned.T,
        damping=turned @ modes.damping @ turned.T,
        weight=turned @ modes.weight,
        tilt_axis=modes.tilt_axis,
    )


def _settled(rows: np.ndarray) -> np.ndarray:
    """Directions (k, k), orthonormal, that rows (n, k) name one after the other, whatever axes these are in.

    Each is the first row whose rest beside the directions before it is large: of equally large ones rounding
    would choose.
    """
    rest = rows.copy()
    count = rows.shape[1]
    directions = np.empty((count, count))
    for direction in directions:
        lengths = np.linalg.norm(rest, axis=1)
        first = int(np.argmax(lengths > 0.9 * lengths.max()))
        direction[:] = rest[first] / lengths[first]
        rest -= np.outer(rest @ direction, direction)
    return directions


def _clean(shapes: np.ndarray) -> np.ndarray:
    """Shapes with what is only rounding set to zero, in the memory order that compiled code takes."""
    small = np.abs(shapes) < 1e-12 * np.abs(shapes).max()
    return np.ascontiguousarray(np.where(small, 0.0, shapes))


def units_near(terrain: Terrain, corners: np.ndarray, margin: float) -> np.ndarray:
    """Indices (from 0) of the units within `margin` (m) of the bounding rectangle of `corners`."""
    low = corners.min(axis=0) - margin
    high = corners.max(axis=0) + margin
    centers = terrain.centers[:, :2]
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
    near = np.all((centers + half > low) & (centers - half < high), axis=1)
    return np.flatnonzero(near)


def reduced_coordinates(case: Case) -> TerrainModes:
    """Independent coordinates of a case's terrain, of which the track moves as few as possible."""
    terrain = case.part(Terrain)
    return localized(terrain_modes(terrain), units_near(terrain, case.outline(0.0), REACH))


def terrain_coordinates(case: Case) -> TerrainCoordinates:
    """Coordinates of a case's terrain; Exudyn's contact of spheres needs the units as bodies."""
    if case.terrain_formulation == "constrained" or case.contact.model == "spheres":
        return UnitCoordinates(case.part(Terrain).unit_count, case.part(Terrain).tilt_axis)
    return reduced_coordinates(case)
