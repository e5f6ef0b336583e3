"""Derivatives of the pairs' forces, one block a pair, by differences."""

import numpy as np

from exudyn_crawler.ground.frames import compiled, inlined, norm, within
from exudyn_crawler.ground.laws import drag_ratio
from exudyn_crawler.ground.overlap import Overlap
from exudyn_crawler.ground.pair_overlaps import below, standing
from exudyn_crawler.ground.pair_track import (
    STATE,
    PairForces,
    Track,
    bend,
    contact_at,
    forces_of,
    gather,
    named,
    patch_rectangle,
    patch_rows,
)
from exudyn_crawler.ground.pairs import FROM_CURVE, pair_overlap
from exudyn_crawler.ground.rotations import FloatArray, attitude, shoe_frame, tilted, unit_frame
from exudyn_crawler.ground.triplets import PairBlocks, Weights

PAIR_COORDINATES = 11
"""Coordinates that one pair's forces depend on: six of the shoe, heave and tilt of the unit, and three of
the displacement of a flexible shoe's patch in its own axes."""

MOVED = (0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12)
"""Which of them are the pair's coordinates: units keep their x and y."""

PATCH = 10
"""The first of them that leaves the overlap as it is."""

STEPS = (1e-7, 1e-6)
"""Steps of places (m, rad), far below the 0.1 mm of the damping law, and of rates (m/s, rad/s), far below
the 10 mm/s of the friction law."""


@inlined
def _add_difference(
    moved: PairForces, base: PairForces, factor: float, axis: int, column: FloatArray
) -> None:
    """Add weighted force differences to a column of a pair's block; `axis` is the units'."""
    for k in range(3):
        column[k] += factor * (moved.shoe.force[k] - base.shoe.force[k])
        column[3 + k] += factor * (moved.shoe.moment[k] - base.shoe.moment[k])
        column[8 + k] += factor * (moved.patch[k] - base.patch[k])
    column[6] += factor * (moved.unit.force[2] - base.unit.force[2])
    column[7] += factor * (moved.unit.moment[axis] - base.unit.moment[axis])


@within
def _block(
    part: Overlap,
    state: FloatArray,
    coordinates: int,
    track: Track,
    weights: Weights,
    block: FloatArray,
    work: FloatArray,
) -> None:
    """Write the derivatives of one pair by its first `coordinates`, moving one number at a time."""
    grid = track.grid
    half = (0.5 * grid.length, 0.5 * grid.width, 0.5 * grid.height)
    axis = grid.tilt_axis
    base_at, base_tilt = attitude(state[0, 3], state[0, 4], state[0, 5]), tilted(state[0, 9], axis)
    shoe = shoe_frame(state[0], state[1], base_at)
    unit = unit_frame(state[0, 6:], state[1, 6:], axis, base_tilt)
    contact = contact_at(part, shoe, unit, state, track, FROM_CURVE)
    base = forces_of(contact, shoe, unit, base_at)
    ratio = drag_ratio(track.law.law, norm(contact.slip_velocity)) if weights.secant else FROM_CURVE
    block.fill(0.0)
    for n in range(2 * coordinates):
        row, c = n // coordinates, n % coordinates
        weight = weights.position if row == 0 else weights.velocity
        old = state[row, MOVED[c]]
        state[row, MOVED[c]] = old + STEPS[row]
        at, tilt, moved_part = base_at, base_tilt, part
        if row == 0 and MOVED[c] < PATCH:
            at, tilt = attitude(state[0, 3], state[0, 4], state[0, 5]), tilted(state[0, 9], axis)
        shoe = shoe_frame(state[0], state[1], at)
        unit = unit_frame(state[0, 6:], state[1, 6:], axis, tilt)
        if row == 0 and MOVED[c] < PATCH:
            moved_part = pair_overlap(shoe, unit, track.footprint, half, work)
        # where nothing overlaps any more the law has no share and gives no force
        contact = contact_at(moved_part, shoe, unit, state, track, ratio)
        moved = forces_of(contact, shoe, unit, at)
        state[row, MOVED[c]] = old
        _add_difference(moved, base, weight / STEPS[row], axis, block[:, c])


@compiled
def pair_derivatives(places: tuple, model: tuple, factors: tuple, out: tuple, work: FloatArray) -> int:
    """Derivatives of the contact forces, one block a pair.

    `factors` and `out` are `Weights` and `PairBlocks` as plain tuples, the others as for `pair_forces`. A
    block is ``Weights.position`` times the derivative by the pair's coordinates plus ``Weights.velocity``
    times the one by their rates.

    Returns
    -------
    int
        Number of contacts.

    Notes
    -----
    One-sided differences: exact derivatives of the clipping would take as many lines as the
    clipping, and the error of 1e-6 relative costs Newton's method nothing.
    """
    bodies, track = named(places, model)
    weights, blocks = Weights(*factors), PairBlocks(*out)
    state = np.empty((2, STATE))
    count = 0
    for s in range(bodies.shoes.shape[0]):
        shoe = standing(bodies, track, s)
        coordinates = 8 if shoe.row < 0 else PAIR_COORDINATES
        for k in range(shoe.cells.columns * shoe.cells.rows):
            u, unit, part = below(bodies, track, shoe, k, work)
            if part.area <= 0.0 or count >= blocks.values.shape[0]:
                continue
            gather(bodies, s, u, state)
            if shoe.row >= 0:
                patch_rows(patch_rectangle(part, shoe.frame, unit, track), track, blocks.rows[count])
                bend(bodies, shoe.row, blocks.rows[count], state)
            _block(part, state, coordinates, track, weights, blocks.values[count], work)
            blocks.pairs[count, 0], blocks.pairs[count, 1] = s, u
            count += 1
    return count
