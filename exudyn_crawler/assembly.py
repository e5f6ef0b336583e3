"""Contact of the whole track in the coordinates of a multibody system.

Turns the vector of generalized coordinates into places of shoes and units, and contact forces and their
derivatives back into generalized ones, for both formulations of the terrain. The coordinates are those
of the shoes (six each) followed by those of the terrain.
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray

from exudyn_crawler.contact import RESULT, RESULTS, contact_derivatives, contact_forces
from exudyn_crawler.overlap import overlap_workspace
from exudyn_crawler.parameters import Case
from exudyn_crawler.terrain import TerrainModes

UNIT_COORDINATES = 6
"""Coordinates of a unit in the constrained formulation: position and angles about x, y, z."""


class TerrainCoordinates(Protocol):
    """How a formulation of the terrain carries the units' motion."""

    @property
    def size(self) -> int:
        """Number of terrain coordinates."""
        ...

    def motion(self, q: NDArray, out: NDArray) -> None:
        """Write displacement (x, y, z) and tilt of the units, or their rates, into `out` (units, 4)."""
        ...

    def project(self, unit_forces: NDArray, units: NDArray, out: NDArray) -> None:
        """Write generalized terrain forces of the units' forces and moments (units, 6) into `out`."""
        ...

    def derivative(
        self, pairs: NDArray, blocks: NDArray, shoe_count: int
    ) -> NDArray:
        """Triplets (row, column, value) of pair blocks in all coordinates."""
        ...


@njit(cache=True)
def _put(triplets, n, row, column, value):
    triplets[n, 0] = row
    triplets[n, 1] = column
    triplets[n, 2] = value


@njit(cache=True)
def _modal_motion(heave, tilt, q, out):
    for u in range(heave.shape[0]):
        z = 0.0
        a = 0.0
        for k in range(heave.shape[1]):
            z += heave[u, k] * q[k]
            a += tilt[u, k] * q[k]
        out[u, 2] = z
        out[u, 3] = a


@njit(cache=True)
def _modal_project(heave, tilt, tilt_axis, unit_forces, out):
    out[:] = 0.0
    for u in range(heave.shape[0]):
        force, moment = unit_forces[u, 2], unit_forces[u, 3 + tilt_axis]
        if force != 0.0 or moment != 0.0:
            for k in range(heave.shape[1]):
                out[k] += heave[u, k] * force + tilt[u, k] * moment


@njit(cache=True)
def _modal_triplets(heave, tilt, pairs, blocks, shoe_count):
    """Dense blocks of every shoe with itself and with the modes, and of the modes."""
    modes = heave.shape[1]
    own = np.zeros((shoe_count, 6, 6))
    right = np.zeros((shoe_count, 6, modes))
    below = np.zeros((shoe_count, modes, 6))
    ground = np.zeros((modes, modes))
    for n in range(pairs.shape[0]):
        s, u = pairs[n, 0], pairs[n, 1]
        block = blocks[n]
        for r in range(6):
            for c in range(6):
                own[s, r, c] += block[r, c]
            for k in range(modes):
                right[s, r, k] += block[r, 6] * heave[u, k] + block[r, 7] * tilt[u, k]
                below[s, k, r] += block[6, r] * heave[u, k] + block[7, r] * tilt[u, k]
        for k in range(modes):
            force = block[6, 6] * heave[u, k] + block[6, 7] * tilt[u, k]
            moment = block[7, 6] * heave[u, k] + block[7, 7] * tilt[u, k]
            for r in range(modes):
                ground[r, k] += heave[u, r] * force + tilt[u, r] * moment
    triplets = np.empty((shoe_count * (36 + 12 * modes) + modes * modes, 3))
    first = 6 * shoe_count
    n = 0
    for s in range(shoe_count):
        for r in range(6):
            for c in range(6):
                _put(triplets, n, 6 * s + r, 6 * s + c, own[s, r, c])
                n += 1
            for k in range(modes):
                _put(triplets, n, 6 * s + r, first + k, right[s, r, k])
                _put(triplets, n + 1, first + k, 6 * s + r, below[s, k, r])
                n += 2
    for r in range(modes):
        for k in range(modes):
            _put(triplets, n, first + r, first + k, ground[r, k])
            n += 1
    return triplets


@dataclass(frozen=True)
class ReducedCoordinates:
    """Terrain carried by its vibration modes."""

    modes: TerrainModes
    tilt_axis: int

    @property
    def size(self) -> int:
        """Number of modes."""
        return self.modes.heave.shape[1]

    def motion(self, q: NDArray, out: NDArray) -> None:
        """Heave and tilt of the units; the modes hold no other motion."""
        _modal_motion(self.modes.heave, self.modes.tilt, q, out)

    def project(self, unit_forces: NDArray, units: NDArray, out: NDArray) -> None:
        """Modal forces."""
        _modal_project(self.modes.heave, self.modes.tilt, self.tilt_axis, unit_forces, out)

    def derivative(self, pairs: NDArray, blocks: NDArray, shoe_count: int) -> NDArray:
        """Triplets in a pattern that never changes, so that factorizations can reuse it."""
        return _modal_triplets(self.modes.heave, self.modes.tilt, pairs, blocks, shoe_count)


@njit(cache=True)
def _body_project(unit_forces, units, tilt_axis, out):
    for u in range(units.shape[0]):
        angle = units[u, 3]
        fx, fy, fz = unit_forces[u, 0], unit_forces[u, 1], unit_forces[u, 2]
        mx, my, mz = unit_forces[u, 3], unit_forces[u, 4], unit_forces[u, 5]
        n = 6 * u
        out[n], out[n + 1], out[n + 2], out[n + 3] = fx, fy, fz, mx
        # columns 2 and 3 of the rate matrix at a pure pitch or roll by `angle`
        if tilt_axis == 1:
            out[n + 4] = my
            out[n + 5] = np.sin(angle) * mx + np.cos(angle) * mz
        else:
            out[n + 4] = np.cos(angle) * my + np.sin(angle) * mz
            out[n + 5] = -np.sin(angle) * my + np.cos(angle) * mz


@njit(cache=True)
def _body_triplets(pairs, blocks, shoe_count, tilt_axis):
    triplets = np.empty((64 * pairs.shape[0], 3))
    n = 0
    for p in range(pairs.shape[0]):
        shoe = 6 * pairs[p, 0]
        unit = 6 * shoe_count + 6 * pairs[p, 1]
        for r in range(8):
            row = shoe + r if r < 6 else (unit + 2 if r == 6 else unit + 3 + tilt_axis)
            for c in range(8):
                column = shoe + c if c < 6 else (unit + 2 if c == 6 else unit + 3 + tilt_axis)
                _put(triplets, n, row, column, blocks[p, r, c])
                n += 1
    return triplets


@dataclass(frozen=True)
class ConstrainedCoordinates:
    """Terrain carried by rigid bodies with six coordinates each."""

    unit_count: int
    tilt_axis: int

    @property
    def size(self) -> int:
        """Six coordinates a unit."""
        return UNIT_COORDINATES * self.unit_count

    def motion(self, q: NDArray, out: NDArray) -> None:
        """Displacement and the one angle that the units keep."""
        bodies = q.reshape(self.unit_count, UNIT_COORDINATES)
        out[:, :3] = bodies[:, :3]
        out[:, 3] = bodies[:, 3 + self.tilt_axis]

    def project(self, unit_forces: NDArray, units: NDArray, out: NDArray) -> None:
        """Forces and generalized moments of the bodies."""
        _body_project(unit_forces, units, self.tilt_axis, out)

    def derivative(self, pairs: NDArray, blocks: NDArray, shoe_count: int) -> NDArray:
        """Triplets of the pairs; their small dependence on the units' x and y is left out."""
        return _body_triplets(pairs, blocks, shoe_count, self.tilt_axis)


@dataclass
class TrackContact:
    """Contact forces of a case as functions of its generalized coordinates."""

    case: Case
    coordinates: TerrainCoordinates
    _buffers: dict[str, NDArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Lay out the memory that every evaluation reuses."""
        shoes, units = self.case.track.shoe_count, self.case.terrain.unit_count
        terrain = self.case.terrain
        self.shoe_reference = np.zeros((shoes, 6))
        self.shoe_reference[:, :3] = self.case.track.com_positions(self.case.shoe.com_height)
        self.unit_reference = np.zeros((units, 4))
        self.unit_reference[:, :3] = terrain.centers
        self.grid = np.array(
            [
                terrain.columns,
                terrain.rows,
                terrain.unit_length,
                terrain.unit_width,
                terrain.unit_height,
            ]
        )
        self.footprint = self.case.shoe.footprint
        self.law = self.case.contact.as_array
        # units that a shoe's outline can meet at once, at any yaw
        diagonal = float(np.hypot(self.case.shoe.length, self.case.shoe.width))
        reach = (int(diagonal / terrain.unit_length) + 2) * (int(diagonal / terrain.unit_width) + 2)
        contacts = shoes * min(reach, units)
        self._buffers = {
            "displacements": np.zeros((units, 4)),
            "unit_rates": np.zeros((units, 4)),
            "shoe_forces": np.zeros((shoes, 6)),
            "unit_forces": np.zeros((units, 6)),
            "results": np.zeros((contacts, RESULTS)),
            "pairs": np.zeros((contacts, 2), dtype=np.int64),
            "blocks": np.zeros((contacts, 8, 8)),
            "work": overlap_workspace(),
        }

    @property
    def size(self) -> int:
        """Number of generalized coordinates: six a shoe, then the terrain's."""
        return self.shoe_reference.size + self.coordinates.size

    def _places(self, q: NDArray, q_t: NDArray) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        split = self.shoe_reference.size
        shoes = self.shoe_reference + q[:split].reshape(-1, 6)
        shoe_rates = q_t[:split].reshape(-1, 6)
        displacements, unit_rates = self._buffers["displacements"], self._buffers["unit_rates"]
        self.coordinates.motion(q[split:], displacements)
        self.coordinates.motion(q_t[split:], unit_rates)
        return shoes, shoe_rates, self.unit_reference + displacements, unit_rates

    def _evaluate(self, q: NDArray, q_t: NDArray) -> tuple[int, NDArray]:
        shoes, shoe_rates, units, unit_rates = self._places(q, q_t)
        b = self._buffers
        count = contact_forces(
            shoes,
            shoe_rates,
            units,
            unit_rates,
            self.case.terrain.tilt_axis,
            self.grid,
            self.footprint,
            self.law,
            b["shoe_forces"],
            b["unit_forces"],
            b["results"],
            b["work"],
        )
        return count, units

    def forces(self, q: NDArray, q_t: NDArray) -> NDArray:
        """Generalized contact forces: array (size,)."""
        _, units = self._evaluate(q, q_t)
        generalized = np.empty(self.size)
        split = self.shoe_reference.size
        generalized[:split] = self._buffers["shoe_forces"].ravel()
        self.coordinates.project(self._buffers["unit_forces"], units, generalized[split:])
        return generalized

    def derivatives(
        self, q: NDArray, q_t: NDArray, position_factor: float, velocity_factor: float
    ) -> NDArray:
        """Triplets (row, column, value) of the weighted sum of both derivatives of the forces.

        ``position_factor * d(forces)/dq + velocity_factor * d(forces)/dq_t``, array (entries, 3).
        """
        shoes, shoe_rates, units, unit_rates = self._places(q, q_t)
        b = self._buffers
        count = contact_derivatives(
            shoes,
            shoe_rates,
            units,
            unit_rates,
            self.case.terrain.tilt_axis,
            self.grid,
            self.footprint,
            self.law,
            position_factor,
            velocity_factor,
            b["pairs"],
            b["blocks"],
            b["work"],
        )
        return self.coordinates.derivative(b["pairs"][:count], b["blocks"][:count], len(shoes))

    def results(self, q: NDArray, q_t: NDArray) -> NDArray:
        """Contacts at a state: array (contacts, RESULTS), columns as in `contact.RESULT`."""
        count, _ = self._evaluate(q, q_t)
        return self._buffers["results"][:count].copy()

    def unit_motion(self, q: NDArray) -> NDArray:
        """Displacement (m) and tilt (rad) of the units from where their springs are free: (units, 4)."""
        out = np.zeros_like(self.unit_reference)
        self.coordinates.motion(q[self.shoe_reference.size :], out)
        return out


__all__ = [
    "RESULT",
    "ConstrainedCoordinates",
    "ReducedCoordinates",
    "TerrainCoordinates",
    "TrackContact",
]
