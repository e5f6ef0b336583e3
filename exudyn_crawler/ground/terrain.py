"""Terrain: the grid of its units, their joints, its independent coordinates and the motion of the units.

Neighbouring units are joined at the middle of their shared face: by spherical joints along a spanning tree of
the grid, and by in-plane joints (equal height) everywhere else. Two of the three rotations of every unit are
held at zero. All joints together then give one condition: the joint point of a face has one height
(K-chapter; to second order in the tilt, which stays below 1e-2 rad). `TerrainModes` carries the remaining
freedoms.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.linalg
from threadpoolctl import threadpool_limits

from exudyn_crawler.case import Case, Terrain
from exudyn_crawler.ground.compiled import inner, kernel

REACH = 1.0
"""Distance (m) round the track at t = 0 within which contact is expected."""


class Grid(NamedTuple):
    """Units in columns along x and rows along y, counted along y first; lengths in m.

    `x`, `y` is the corner of the first unit; `tilt_axis` is the axis of tilt: 0 for x, 1 for y.
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
        """Return the index of the unit below each point (..., 2), m, or of the nearest unit: array of int."""
        cells = np.floor((places - [self.x, self.y]) / [self.length, self.width]).astype(int)
        cells = np.clip(cells, 0, [self.columns - 1, self.rows - 1])
        return cells[..., 0] * self.rows + cells[..., 1]


def grid_of(terrain: Terrain) -> Grid:
    """Return the grid of a terrain."""
    sides = (terrain.unit_length, terrain.unit_width, terrain.unit_height)
    return Grid(terrain.columns, terrain.rows, *sides, *terrain.origin, terrain.tilt_axis)


class TerrainJoint(NamedTuple):
    """Joint of two neighbouring units at the middle of their shared face."""

    first: int  # unit index (from 0)
    second: int
    axis: int  # direction from one to the other: 0 for x, 1 for y
    spherical: bool  # or in-plane


def terrain_joints(terrain: Terrain) -> list[TerrainJoint]:
    """Return all joints of the grid: spherical along a spanning tree, in-plane elsewhere.

    The tree has every joint along x, and the joints along y in the first column. For 10 x 5 units these are
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
    """Write heave and tilt of units (units, 4) at coordinates, or their rates.

    Only the first coordinates count, as many as `heave` has columns.
    """
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
    """Terrain in its independent coordinates; their mass matrix is the identity."""

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
        """Return displacement (x, y, z) and tilt of the units, or their rates: (..., units, 4), m and rad.

        `q` (..., size) are coordinates, or their rates.
        """
        units = np.zeros((*q.shape[:-1], len(self.heave), 4))
        states = np.ascontiguousarray(q).reshape(-1, self.size)
        modal_motions(self.heave, self.tilt, states, units.reshape(-1, *units.shape[-2:]))
        return units

    def project(self, wrenches: np.ndarray) -> np.ndarray:
        """Return the generalized forces (size,) of forces and moments on the units (units, 6)."""
        return np.asarray(wrenches[:, 2] @ self.heave + wrenches[:, 3 + self.tilt_axis] @ self.tilt)

    def sunk_evenly(self, heave: float) -> np.ndarray:
        """Return coordinates (size,) at which all units heave by the same (m) and none tilts.

        The modes can combine to this motion, because the units meet at one height everywhere.
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
        """Number of coordinates: six for each unit."""
        return 6 * self.unit_count

    def motion(self, q: np.ndarray) -> np.ndarray:
        """Return displacement and tilt of the units, or their rates: array (..., units, 4)."""
        bodies = q.reshape(*q.shape[:-1], self.unit_count, 6)
        # a list as an index would give columns, for which kernels are compiled once more
        return np.take(bodies, [0, 1, 2, 3 + self.tilt_axis], axis=-1)

    def project(self, wrenches: np.ndarray) -> np.ndarray:
        """Return the generalized forces (size,); moments other than the tilt's load only the units' holds."""
        return wrenches.ravel()

    def sunk_evenly(self, heave: float) -> np.ndarray:
        """Return coordinates (size,) at which all units heave by the same (m) and none tilts."""
        return np.tile([0.0, 0.0, heave, 0.0, 0.0, 0.0], self.unit_count)


TerrainCoordinates = TerrainModes | UnitCoordinates


@lru_cache(maxsize=4)
@threadpool_limits.wrap(limits=1, user_api="blas")
def terrain_modes(terrain: Terrain) -> TerrainModes:
    """Return the vibration modes of a terrain whose neighbouring units meet at one height.

    Every shared face gives one equation between the heaves and tilts of two units. The modes span the null
    space of all equations: 10 + 5 modes for 10 x 5 pitching units, 19 + 13 for 19 x 13 units. They are kept:
    every system of a start needs them, and hundreds of units take a tenth of a second. One thread finds
    them, in a run or before it, so that they have the same bits.
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
    """Return the terrain in coordinates whose first few alone move these units (indices from 0).

    The units are those that the track can touch. The change of coordinates is orthogonal, so that the mass
    matrix stays the identity. It makes the derivatives of the contact forces sparse. The coordinates follow
    from the terrain and the units alone. Many modes have one frequency and any mixture of them serves, but a
    stored state must mean the same on another machine.
    """
    heaves, tilts = (np.linalg.norm(rows, axis=1).max() for rows in (modes.heave, modes.tilt))
    # this length makes tilts comparable with heaves; it does not depend on the terrain's coordinates
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
    """Return orthonormal directions (k, k) given by rows (n, k) in their order.

    They do not depend on the axes of the rows. Each direction is the first row with a large remainder
    orthogonal to the directions before it. Among equally large rows rounding would choose.
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
    """Return shapes with rounding errors set to zero, in the memory order that compiled code takes."""
    small = np.abs(shapes) < 1e-12 * np.abs(shapes).max()
    return np.ascontiguousarray(np.where(small, 0.0, shapes))


def units_near(terrain: Terrain, corners: np.ndarray, margin: float) -> np.ndarray:
    """Return the indices (from 0) of the units within `margin` (m) of the bounding rectangle of `corners`."""
    low = corners.min(axis=0) - margin
    high = corners.max(axis=0) + margin
    centers = terrain.centers[:, :2]
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
    near = np.all((centers + half > low) & (centers - half < high), axis=1)
    return np.flatnonzero(near)


def reduced_coordinates(case: Case) -> TerrainModes:
    """Return a case's terrain in independent coordinates; the track moves as few of them as possible."""
    terrain = case.part(Terrain)
    return localized(terrain_modes(terrain), units_near(terrain, case.outline(0.0), REACH))


def terrain_coordinates(case: Case) -> TerrainCoordinates:
    """Return the coordinates of a case's terrain; Exudyn's contact of spheres needs the units as bodies."""
    if case.terrain_formulation == "constrained" or case.contact.model == "spheres":
        return UnitCoordinates(case.part(Terrain).unit_count, case.part(Terrain).tilt_axis)
    return reduced_coordinates(case)
