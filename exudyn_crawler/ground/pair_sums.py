"""Pair contact of a whole track in its coordinates: sums of forces, and derivatives pair by pair."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.frames import Frame, Vector, Wrench, compiled, norm, turned_back
from exudyn_crawler.ground.grid import Cells, Grid, cell, cells_about
from exudyn_crawler.ground.laws import drag_ratio, named_law
from exudyn_crawler.ground.overlap import Overlap
from exudyn_crawler.ground.pairs import (
    FROM_CURVE,
    Contact,
    Footprint,
    PairLaw,
    Patch,
    contact_point,
    keep,
    pair_contact,
    pair_overlap,
    wrench_on_shoe,
)
from exudyn_crawler.ground.rotations import (
    Attitude,
    FloatArray,
    attitude,
    generalized_moment,
    shoe_frame,
    tilted,
    unit_frame,
)
from exudyn_crawler.ground.triplets import PairBlocks, Weights
from fem.patches import mean_rows

PAIR_COORDINATES = 11
"""Coordinates that one pair's forces depend on: six of the shoe, heave and tilt of the unit, and three of
the displacement of a flexible shoe's patch in its own axes."""

STATE = 13
"""Numbers that place a pair: six of the shoe, the unit's position and tilt, the patch's displacement."""

MOVED = (0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12)
"""Which of them are the pair's coordinates: units keep their x and y."""

PATCH = 10
"""The first of them that leaves the overlap as it is."""

STEPS = (1e-7, 1e-6)
"""Steps of places (m, rad), far below the 0.1 mm of the damping law, and of rates (m/s, rad/s), far below
the 10 mm/s of the friction law."""


class Flexible(NamedTuple):
    """Integrated undersides of the flexible shoes (`fem.patches.Underside`).

    `row` holds, for every shoe, its row in the modal coordinates, or -1 where it is rigid.
    """

    corner: FloatArray
    cell: FloatArray
    integral: FloatArray
    row: NDArray[np.int64]


class Track(NamedTuple):
    """What stays as it is: units, underside of the shoes, flexible shoes and the law of every pair."""

    grid: Grid
    footprint: Footprint
    flexible: Flexible
    law: PairLaw


class Bodies(NamedTuple):
    """Places of all bodies, and their rates.

    Attributes
    ----------
    shoes, shoe_rates : array (shoes, 6)
        COM position (m) and angles about x, y, z (rad).
    units, unit_rates : array (units, 4)
        Centre position (m) and tilt (rad).
    modal, modal_rates : array (flexible shoes, modes)
        Modal coordinates.
    """

    shoes: FloatArray
    shoe_rates: FloatArray
    units: FloatArray
    unit_rates: FloatArray
    modal: FloatArray
    modal_rates: FloatArray


class Sums(NamedTuple):
    """Where the forces of all contacts are added up.

    Attributes
    ----------
    shoes : array (shoes, 6)
        Generalized forces on the shoes' coordinates (N, N m).
    units : array (units, 6)
        Force (N) and moment about the centre (N m) on each unit, global.
    modal : array (flexible shoes, modes)
        Modal forces.
    results : array (contacts, RESULTS)
        One row a contact, columns as in `pairs.RESULT`.
    """

    shoes: FloatArray
    units: FloatArray
    modal: FloatArray
    results: FloatArray


class PairForces(NamedTuple):
    """Forces of one pair, generalized for the shoe; on the patch in the shoe's axes."""

    shoe: Wrench
    unit: Wrench
    patch: Vector


@compiled
def _named(track: tuple) -> Track:
    """Track of its values as plain tuples."""
    grid, footprint, flexible, (law, edge_width, whole_area) = track
    law = PairLaw(named_law(law), edge_width, whole_area)
    return Track(Grid(*grid), Footprint(*footprint), Flexible(*flexible), law)


@compiled
def _cells(shoe: Frame, footprint: Footprint, grid: Grid) -> Cells:
    """Units that may lie under a shoe."""
    x = max(abs(footprint.low_x), abs(footprint.high_x))
    y = max(abs(footprint.low_y), abs(footprint.high_y))
    # pitch and tilt move the underside's corners by their height times the angle
    slack = 0.02 * grid.length
    across, side = shoe.R[0], shoe.R[1]
    reach_x = abs(across[0]) * x + abs(across[1]) * y + abs(across[2] * footprint.z) + slack
    reach_y = abs(side[0]) * x + abs(side[1]) * y + abs(side[2] * footprint.z) + slack
    return cells_about(grid, shoe.r[0], shoe.r[1], reach_x, reach_y)


@compiled
def _gather(bodies: Bodies, s: int, u: int, state: FloatArray) -> None:
    """Write places and rates of a shoe and a unit into the rows of `state` (2, STATE), with no patch."""
    for k in range(6):
        state[0, k], state[1, k] = bodies.shoes[s, k], bodies.shoe_rates[s, k]
    for k in range(4):
        state[0, 6 + k], state[1, 6 + k] = bodies.units[u, k], bodies.unit_rates[u, k]
    for k in range(3):
        state[0, 10 + k] = state[1, 10 + k] = 0.0


@compiled
def _patch_rows(part: Overlap, shoe: Frame, unit: Frame, track: Track, rows: FloatArray) -> None:
    """Write mean displacement rows (3, modes) of the rectangle in the shoe's axes about an overlap.

    Seen from above: what the unit's tilt moves the overlap by is far less than a cell of the underside.
    """
    half_xi, half_eta = 0.5 * (part.high_xi - part.low_xi), 0.5 * (part.high_eta - part.low_eta)
    x = unit.r[0] + 0.5 * (part.low_xi + part.high_xi) - shoe.r[0]
    y = unit.r[1] + 0.5 * (part.low_eta + part.high_eta) - shoe.r[1]
    z = contact_point(part, unit, 0.5 * track.grid.height)[2] - shoe.r[2]
    middle = turned_back(shoe.R, (x, y, z))
    along_x, along_y = shoe.R[0], shoe.R[1]
    hx = abs(along_x[0]) * half_xi + abs(along_y[0]) * half_eta
    hy = abs(along_x[1]) * half_xi + abs(along_y[1]) * half_eta
    rectangle = (middle[0] - hx, middle[0] + hx, middle[1] - hy, middle[1] + hy)
    flexible = track.flexible
    mean_rows(flexible.corner, flexible.cell, flexible.integral, rectangle, rows)


@compiled
def _bend(bodies: Bodies, f: int, rows: FloatArray, state: FloatArray) -> None:
    """Write displacement and velocity of a flexible shoe's patch into `state`."""
    for c in range(3):
        displacement = 0.0
        velocity = 0.0
        for k in range(rows.shape[1]):
            displacement += rows[c, k] * bodies.modal[f, k]
            velocity += rows[c, k] * bodies.modal_rates[f, k]
        state[0, 10 + c], state[1, 10 + c] = displacement, velocity


@compiled
def _contact(
    part: Overlap, shoe: Frame, unit: Frame, state: FloatArray, track: Track, ratio: float
) -> Contact:
    """Contact of a pair at a known overlap, with the patch of its state."""
    places, rates = state[0], state[1]
    patch = Patch((places[10], places[11], places[12]), (rates[10], rates[11], rates[12]))
    return pair_contact(part, shoe, unit, patch, 0.5 * track.grid.height, track.law, ratio)


@compiled
def _forces(contact: Contact, shoe: Frame, unit: Frame, at: Attitude) -> PairForces:
    """Forces of a contact on the coordinates of its shoe, on its unit and on its patch."""
    on_shoe = wrench_on_shoe(contact, shoe.r)
    on_unit = wrench_on_shoe(contact, unit.r)
    force, moment = on_unit.force, on_unit.moment
    return PairForces(
        Wrench(on_shoe.force, generalized_moment(on_shoe.moment, at)),
        Wrench((-force[0], -force[1], -force[2]), (-moment[0], -moment[1], -moment[2])),
        turned_back(shoe.R, on_shoe.force),
    )


@compiled
def pair_forces(places: tuple, model: tuple, out: tuple, work: FloatArray) -> int:
    """Add up the forces of all contacts between the shoes and the terrain's units.

    Parameters
    ----------
    places, model, out : tuple
        `Bodies`, `Track` and `Sums` as plain tuples; what is in `out` is overwritten.
    work : array (2, VERTICES, 3)
        Scratch memory as of `overlap_workspace`.

    Returns
    -------
    int
        Number of contacts; more than ``Sums.results`` has rows where some did not fit in.
    """
    bodies, track, sums = Bodies(*places), _named(model), Sums(*out)
    sums.shoes.fill(0.0)
    sums.units.fill(0.0)
    sums.modal.fill(0.0)
    state = np.empty((2, STATE))
    rows = np.empty((3, bodies.modal.shape[1]))
    grid = track.grid
    half = (0.5 * grid.length, 0.5 * grid.width, 0.5 * grid.height)
    count = 0
    for s in range(bodies.shoes.shape[0]):
        f = track.flexible.row[s]
        at = attitude(bodies.shoes[s, 3], bodies.shoes[s, 4], bodies.shoes[s, 5])
        shoe = shoe_frame(bodies.shoes[s], bodies.shoe_rates[s], at)
        cells = _cells(shoe, track.footprint, grid)
        for k in range(cells.columns * cells.rows):
            u = cell(grid, cells, k)
            tilt = tilted(bodies.units[u, 3], grid.tilt_axis)
            unit = unit_frame(bodies.units[u], bodies.unit_rates[u], grid.tilt_axis, tilt)
            part = pair_overlap(shoe, unit, track.footprint, half, work)
            if part.area <= 0.0:
                continue
            _gather(bodies, s, u, state)
            if f >= 0:
                _patch_rows(part, shoe, unit, track, rows)
                _bend(bodies, f, rows, state)
            contact = _contact(part, shoe, unit, state, track, FROM_CURVE)
            forces = _forces(contact, shoe, unit, at)
            if count < sums.results.shape[0]:
                keep(contact, s, u, sums.results[count])
            count += 1
            for c in range(3):
                sums.shoes[s, c] += forces.shoe.force[c]
                sums.shoes[s, 3 + c] += forces.shoe.moment[c]
                sums.units[u, c] += forces.unit.force[c]
                sums.units[u, 3 + c] += forces.unit.moment[c]
            if f >= 0:
                for m in range(rows.shape[1]):
                    for c in range(3):
                        sums.modal[f, m] += rows[c, m] * forces.patch[c]
    return count


@compiled
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


@compiled
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
    contact = _contact(part, shoe, unit, state, track, FROM_CURVE)
    base = _forces(contact, shoe, unit, base_at)
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
        contact = _contact(moved_part, shoe, unit, state, track, ratio)
        moved = _forces(contact, shoe, unit, at)
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
    bodies, track, weights, blocks = Bodies(*places), _named(model), Weights(*factors), PairBlocks(*out)
    state = np.empty((2, STATE))
    grid = track.grid
    half = (0.5 * grid.length, 0.5 * grid.width, 0.5 * grid.height)
    count = 0
    for s in range(bodies.shoes.shape[0]):
        f = track.flexible.row[s]
        at = attitude(bodies.shoes[s, 3], bodies.shoes[s, 4], bodies.shoes[s, 5])
        shoe = shoe_frame(bodies.shoes[s], bodies.shoe_rates[s], at)
        cells = _cells(shoe, track.footprint, grid)
        for k in range(cells.columns * cells.rows):
            u = cell(grid, cells, k)
            tilt = tilted(bodies.units[u, 3], grid.tilt_axis)
            unit = unit_frame(bodies.units[u], bodies.unit_rates[u], grid.tilt_axis, tilt)
            part = pair_overlap(shoe, unit, track.footprint, half, work)
            if part.area <= 0.0 or count >= blocks.values.shape[0]:
                continue
            _gather(bodies, s, u, state)
            coordinates = 8
            if f >= 0:
                _patch_rows(part, shoe, unit, track, blocks.rows[count])
                _bend(bodies, f, blocks.rows[count], state)
                coordinates = PAIR_COORDINATES
            _block(part, state, coordinates, track, weights, blocks.values[count], work)
            blocks.pairs[count, 0], blocks.pairs[count, 1] = s, u
            count += 1
    return count
