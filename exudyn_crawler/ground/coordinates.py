"""How the terrain's and the flexible shoes' coordinates carry the contact: motion, forces, derivatives.

The coordinates are those of the shoes (six each), then the terrain's, then the flexible shoes' modes.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray

from exudyn_crawler.ground.terrain import TerrainModes

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

    def derivative(self, pairs: NDArray, blocks: NDArray, shoe_count: int) -> NDArray:
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
def _moved(heave, tilt, reached, pairs):
    """Number of leading coordinates to write: `reached`, or more where a contact moves more."""
    modes = reached
    for n in range(pairs.shape[0]):
        u = pairs[n, 1]
        for k in range(modes, heave.shape[1]):
            if heave[u, k] != 0.0 or tilt[u, k] != 0.0:
                modes = k + 1
    return modes


@njit(cache=True)
def _modal_triplets(heave, tilt, reached, pairs, blocks, shoe_count):
    """Dense blocks of every shoe with itself and with the coordinates, and of the coordinates.

    `reached` is the least number of leading coordinates to write; more are written where a contact
    moves them.
    """
    modes = _moved(heave, tilt, reached, pairs)
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
    """Terrain carried by its independent coordinates.

    `reached` of them, the first ones, move the units that the track is expected to touch.
    """

    modes: TerrainModes
    tilt_axis: int
    reached: int

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.modes.size

    def motion(self, q: NDArray, out: NDArray) -> None:
        """Heave and tilt of the units; there is no other motion."""
        _modal_motion(self.modes.heave, self.modes.tilt, q, out)

    def project(self, unit_forces: NDArray, units: NDArray, out: NDArray) -> None:
        """Generalized forces."""
        _modal_project(self.modes.heave, self.modes.tilt, self.tilt_axis, unit_forces, out)

    def derivative(self, pairs: NDArray, blocks: NDArray, shoe_count: int) -> NDArray:
        """Triplets in a pattern that rarely changes, so that factorizations can reuse it."""
        return _modal_triplets(self.modes.heave, self.modes.tilt, self.reached, pairs, blocks, shoe_count)


@njit(cache=True)
def flexible_triplets(heave, tilt, reached, pairs, blocks, patch_rows, flexible_row, first_modal):
    """Blocks of every flexible shoe's modes with the shoe, the terrain and themselves."""
    terrain = _moved(heave, tilt, reached, pairs)
    shoe_count = flexible_row.shape[0]
    bodies = 0
    for s in range(shoe_count):
        bodies = max(bodies, flexible_row[s] + 1)
    modes = patch_rows.shape[2]
    right = np.zeros((bodies, 6, modes))
    below = np.zeros((bodies, modes, 6))
    ground_right = np.zeros((bodies, terrain, modes))
    ground_below = np.zeros((bodies, modes, terrain))
    own = np.zeros((bodies, modes, modes))
    of_patch = np.zeros((3, modes))
    for n in range(pairs.shape[0]):
        s, u = pairs[n, 0], pairs[n, 1]
        f = flexible_row[s]
        if f < 0:
            continue
        block, rows = blocks[n], patch_rows[n]
        for m in range(modes):
            for r in range(6):
                for c in range(3):
                    right[f, r, m] += block[r, 8 + c] * rows[c, m]
                    below[f, m, r] += rows[c, m] * block[8 + c, r]
            force_by = 0.0
            moment_by = 0.0
            by_heave = 0.0
            by_tilt = 0.0
            for c in range(3):
                force_by += block[6, 8 + c] * rows[c, m]
                moment_by += block[7, 8 + c] * rows[c, m]
                by_heave += rows[c, m] * block[8 + c, 6]
                by_tilt += rows[c, m] * block[8 + c, 7]
                of_patch[c, m] = 0.0
                for d in range(3):
                    of_patch[c, m] += block[8 + c, 8 + d] * rows[d, m]
            for k in range(terrain):
                ground_right[f, k, m] += heave[u, k] * force_by + tilt[u, k] * moment_by
                ground_below[f, m, k] += by_heave * heave[u, k] + by_tilt * tilt[u, k]
        for m in range(modes):
            for k in range(modes):
                own[f, m, k] += (
                    rows[0, m] * of_patch[0, k] + rows[1, m] * of_patch[1, k] + rows[2, m] * of_patch[2, k]
                )
    triplets = np.empty((bodies * modes * (12 + 2 * terrain + modes), 3))
    first_terrain = 6 * shoe_count
    n = 0
    for s in range(shoe_count):
        f = flexible_row[s]
        if f < 0:
            continue
        first = first_modal + f * modes
        for m in range(modes):
            for r in range(6):
                _put(triplets, n, 6 * s + r, first + m, right[f, r, m])
                _put(triplets, n + 1, first + m, 6 * s + r, below[f, m, r])
                n += 2
            for k in range(terrain):
                _put(triplets, n, first_terrain + k, first + m, ground_right[f, k, m])
                _put(triplets, n + 1, first + m, first_terrain + k, ground_below[f, m, k])
                n += 2
            for k in range(modes):
                _put(triplets, n, first + m, first + k, own[f, m, k])
                n += 1
    return triplets


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
