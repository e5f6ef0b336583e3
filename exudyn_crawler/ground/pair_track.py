"""Pairs of shoe and unit on a track: from its coordinates to contacts on frames, and back to forces."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.frames import Frame, Vector, Wrench, compiled, inlined, turned_back
from exudyn_crawler.ground.grid import Grid
from exudyn_crawler.ground.laws import named_law
from exudyn_crawler.ground.overlap import Overlap
from exudyn_crawler.ground.pairs import (
    Contact,
    Footprint,
    PairLaw,
    Patch,
    contact_point,
    pair_contact,
    wrench_on_shoe,
)
from exudyn_crawler.ground.rotations import Attitude, FloatArray, generalized_moment
from fem.patches import mean_rows

STATE = 13
"""Numbers that place a pair: six of the shoe, the unit's position and tilt, the patch's displacement."""


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


class PairForces(NamedTuple):
    """Forces of one pair, generalized for the shoe; on the patch in the shoe's axes."""

    shoe: Wrench
    unit: Wrench
    patch: Vector


@inlined
def named(places: tuple, track: tuple) -> tuple[Bodies, Track]:
    """Bodies and track of their values as plain tuples."""
    grid, footprint, flexible, (law, edge_width, whole_area) = track
    law = PairLaw(named_law(law), edge_width, whole_area)
    return Bodies(*places), Track(Grid(*grid), Footprint(*footprint), Flexible(*flexible), law)


@inlined
def gather(bodies: Bodies, s: int, u: int, state: FloatArray) -> None:
    """Write places and rates of a shoe and a unit into the rows of `state` (2, STATE), with no patch."""
    for k in range(6):
        state[0, k], state[1, k] = bodies.shoes[s, k], bodies.shoe_rates[s, k]
    for k in range(4):
        state[0, 6 + k], state[1, 6 + k] = bodies.units[u, k], bodies.unit_rates[u, k]
    for k in range(3):
        state[0, 10 + k] = state[1, 10 + k] = 0.0


@compiled
def patch_rectangle(
    part: Overlap, shoe: Frame, unit: Frame, track: Track
) -> tuple[float, float, float, float]:
    """Rectangle in the shoe's axes about an overlap: least and greatest x, least and greatest y, m.

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
    return middle[0] - hx, middle[0] + hx, middle[1] - hy, middle[1] + hy


@compiled
def patch_rows(rectangle: tuple[float, float, float, float], track: Track, rows: FloatArray) -> None:
    """Write the mean displacement (3, modes) of a rectangle of the underside by the modes."""
    flexible = track.flexible
    mean_rows(flexible.corner, flexible.cell, flexible.integral, rectangle, rows)


@inlined
def bend(bodies: Bodies, f: int, rows: FloatArray, state: FloatArray) -> None:
    """Write displacement and velocity of a flexible shoe's patch into `state`."""
    for c in range(3):
        displacement = 0.0
        velocity = 0.0
        for k in range(rows.shape[1]):
            displacement += rows[c, k] * bodies.modal[f, k]
            velocity += rows[c, k] * bodies.modal_rates[f, k]
        state[0, 10 + c], state[1, 10 + c] = displacement, velocity


@inlined
def contact_at(
    part: Overlap, shoe: Frame, unit: Frame, state: FloatArray, track: Track, ratio: float
) -> Contact:
    """Contact of a pair at a known overlap, with the patch of its state."""
    places, rates = state[0], state[1]
    patch = Patch((places[10], places[11], places[12]), (rates[10], rates[11], rates[12]))
    return pair_contact(part, shoe, unit, patch, 0.5 * track.grid.height, track.law, ratio)


@inlined
def forces_of(contact: Contact, shoe: Frame, unit: Frame, at: Attitude) -> PairForces:
    """Forces of a contact on the coordinates of its shoe, on its unit and on its patch."""
    on_shoe = wrench_on_shoe(contact, shoe.r)
    on_unit = wrench_on_shoe(contact, unit.r)
    force, moment = on_unit.force, on_unit.moment
    return PairForces(
        Wrench(on_shoe.force, generalized_moment(on_shoe.moment, at)),
        Wrench((-force[0], -force[1], -force[2]), (-moment[0], -moment[1], -moment[2])),
        turned_back(shoe.R, on_shoe.force),
    )
