"""Sparse derivatives of the contact's forces: from blocks of pairs to triplets in all coordinates."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.rotations import FloatArray


class Shapes(NamedTuple):
    """Heave and tilt of the units by the terrain's coordinates.

    Attributes
    ----------
    heave, tilt : array (units, coordinates)
        m and rad per unit of a coordinate.
    reached : int
        Least number of leading coordinates to write; more are written where a contact moves them.
    """

    heave: FloatArray
    tilt: FloatArray
    reached: int


class PairBlocks(NamedTuple):
    """Derivatives of the contacts' forces, pair by pair.

    Attributes
    ----------
    pairs : array (contacts, 2)
        Shoe and unit of each block.
    values : array (contacts, >= 8, >= 8)
        Derivatives of (generalized force on the shoe, force in z and tilting moment on the unit, force on
        the patch of a flexible shoe in its axes) by (the shoe's coordinates, heave and tilt of the unit,
        displacement of the patch in the shoe's axes).
    rows : array (contacts, 3, modes)
        Mean displacement rows of flexible shoes' patches.
    """

    pairs: NDArray[np.int64]
    values: FloatArray
    rows: FloatArray


class Weights(NamedTuple):
    """Weights of the derivatives by places and by rates; whether friction over slip is kept as it is.

    Newton's method can cycle between the steep rise of the friction curve and its fall beyond; with this
    secant it converges more slowly, but does.
    """

    position: float
    velocity: float
    secant: bool = False

    def typed(self) -> tuple[float, float, bool]:
        """Same as compiled functions take it: other numbers would compile them anew."""
        return float(self.position), float(self.velocity), bool(self.secant)


class ModalBlocks(NamedTuple):
    """Derivatives of and by the modes of flexible shoes: with the shoe, the terrain and themselves."""

    right: FloatArray
    below: FloatArray
    ground_right: FloatArray
    ground_below: FloatArray
    own: FloatArray


@compiled
def _put(triplets, n, row, column, value):
    triplets[n, 0] = row
    triplets[n, 1] = column
    triplets[n, 2] = value


@compiled
def _moved(shapes, pairs):
    """Number of leading coordinates to write."""
    modes = shapes.reached
    for n in range(pairs.shape[0]):
        u = pairs[n, 1]
        for k in range(modes, shapes.heave.shape[1]):
            if shapes.heave[u, k] != 0.0 or shapes.tilt[u, k] != 0.0:
                modes = k + 1
    return modes


@compiled
def terrain_triplets(terrain: tuple, found: tuple, shoe_count: int) -> FloatArray:
    """Dense blocks of every shoe with itself and with the terrain's coordinates, and of these.

    `terrain` and `found` are `Shapes` and `PairBlocks` as plain tuples, here and below.
    """
    shapes, blocks = Shapes(*terrain), PairBlocks(*found)
    heave, tilt = shapes.heave, shapes.tilt
    modes = _moved(shapes, blocks.pairs)
    own = np.zeros((shoe_count, 6, 6))
    right = np.zeros((shoe_count, 6, modes))
    below = np.zeros((shoe_count, modes, 6))
    ground = np.zeros((modes, modes))
    for n in range(blocks.pairs.shape[0]):
        s, u = blocks.pairs[n, 0], blocks.pairs[n, 1]
        block = blocks.values[n]
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
    entry = np.int64(0)
    for s in range(shoe_count):
        for r in range(6):
            for c in range(6):
                _put(triplets, entry, 6 * s + r, 6 * s + c, own[s, r, c])
                entry += 1
            for k in range(modes):
                _put(triplets, entry, 6 * s + r, first + k, right[s, r, k])
                _put(triplets, entry + 1, first + k, 6 * s + r, below[s, k, r])
                entry += 2
    for r in range(modes):
        for k in range(modes):
            _put(triplets, entry, first + r, first + k, ground[r, k])
            entry += 1
    return triplets


@compiled
def _add_modal(sums, f, block, rows, heave, tilt):
    """Add a pair's block to those of its flexible shoe f; `heave`, `tilt` (coordinates,) are its unit's."""
    modes, terrain = rows.shape[1], sums.ground_right.shape[1]
    for m in range(modes):
        for r in range(6):
            for c in range(3):
                sums.right[f, r, m] += block[r, 8 + c] * rows[c, m]
                sums.below[f, m, r] += rows[c, m] * block[8 + c, r]
        force = moment = by_heave = by_tilt = 0.0
        for c in range(3):
            force += block[6, 8 + c] * rows[c, m]
            moment += block[7, 8 + c] * rows[c, m]
            by_heave += rows[c, m] * block[8 + c, 6]
            by_tilt += rows[c, m] * block[8 + c, 7]
        for k in range(terrain):
            sums.ground_right[f, k, m] += heave[k] * force + tilt[k] * moment
            sums.ground_below[f, m, k] += by_heave * heave[k] + by_tilt * tilt[k]
        x = y = z = 0.0
        for c in range(3):
            x += rows[c, m] * block[8 + c, 8]
            y += rows[c, m] * block[8 + c, 9]
            z += rows[c, m] * block[8 + c, 10]
        for k in range(modes):
            sums.own[f, m, k] += x * rows[0, k] + y * rows[1, k] + z * rows[2, k]


@compiled
def modal_triplets(terrain: tuple, found: tuple, row: NDArray[np.int64], first: int) -> FloatArray:
    """Blocks of every flexible shoe's modes with the shoe, the terrain and themselves.

    `row` holds, for every shoe, its row among the flexible ones or -1; `first` is their first coordinate.
    """
    shapes, blocks = Shapes(*terrain), PairBlocks(*found)
    reached = _moved(shapes, blocks.pairs)
    shoe_count, modes = row.shape[0], blocks.rows.shape[2]
    bodies = 0
    for s in range(shoe_count):
        bodies = max(bodies, row[s] + 1)
    sums = ModalBlocks(
        np.zeros((bodies, 6, modes)),
        np.zeros((bodies, modes, 6)),
        np.zeros((bodies, reached, modes)),
        np.zeros((bodies, modes, reached)),
        np.zeros((bodies, modes, modes)),
    )
    for n in range(blocks.pairs.shape[0]):
        f, u = row[blocks.pairs[n, 0]], blocks.pairs[n, 1]
        if f >= 0:
            _add_modal(sums, f, blocks.values[n], blocks.rows[n], shapes.heave[u], shapes.tilt[u])
    triplets = np.empty((bodies * modes * (12 + 2 * reached + modes), 3))
    entry = np.int64(0)
    for s in range(shoe_count):
        f = row[s]
        for m in range(modes if f >= 0 else 0):
            own = first + f * modes
            for r in range(6):
                _put(triplets, entry, 6 * s + r, own + m, sums.right[f, r, m])
                _put(triplets, entry + 1, own + m, 6 * s + r, sums.below[f, m, r])
                entry += 2
            for k in range(reached):
                _put(triplets, entry, 6 * shoe_count + k, own + m, sums.ground_right[f, k, m])
                _put(triplets, entry + 1, own + m, 6 * shoe_count + k, sums.ground_below[f, m, k])
                entry += 2
            for k in range(modes):
                _put(triplets, entry, own + m, own + k, sums.own[f, m, k])
                entry += 1
    return triplets


@compiled
def body_triplets(found: tuple, shoe_count: int, tilt_axis: int) -> FloatArray:
    """Triplets of the pairs, the units being bodies of six coordinates."""
    blocks = PairBlocks(*found)
    triplets = np.empty((64 * blocks.pairs.shape[0], 3))
    n = np.int64(0)
    for p in range(blocks.pairs.shape[0]):
        shoe = 6 * blocks.pairs[p, 0]
        unit = 6 * shoe_count + 6 * blocks.pairs[p, 1]
        for r in range(8):
            row = shoe + r if r < 6 else (unit + 2 if r == 6 else unit + 3 + tilt_axis)
            for c in range(8):
                column = shoe + c if c < 6 else (unit + 2 if c == 6 else unit + 3 + tilt_axis)
                _put(triplets, n, row, column, blocks.values[p, r, c])
                n += 1
    return triplets
