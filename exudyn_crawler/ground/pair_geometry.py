"""Tables of the contacts of a track: bodies, units, and their overlap volumes.

A shoe that reaches over a unit with more than its rear fingers has one volume there. If only the fingers
reach over it, each finger has a volume with the whole law.
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground import laws, overlap, pairs, terrain
from exudyn_crawler.ground.compiled import inlined, inner, kernel
from exudyn_crawler.ground.frames import Frame, Vector, turned_back
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Floats4, Ints1

FINGER_BLEND, REACH_STEP = 0.02, 1e-7
"""FINGER_BLEND: range (m) of the reach in which the fingers' volumes replace that of the whole underside,
chosen here so that the force has no jump. REACH_STEP: difference (m) that gives the slope of this blend."""


class Outline(NamedTuple):
    """Outlines of units and undersides, without arrays: each call would count references to arrays."""

    grid: terrain.Grid
    footprint: pairs.Footprint
    finger_length: float  # m


class Flexible(NamedTuple):
    """Integrated undersides of the flexible shoes (`fem.body.rectangle_motion.Underside`)."""

    corner: Floats1
    cell: Floats1
    integral: Floats4
    row: Ints1  # (shoes,): row in the modal coordinates, -1 for a rigid shoe


class ContactGeometry(NamedTuple):
    """Constants of the contacts: outlines, the law of every contact, flexible shoes and fingers."""

    outline: Outline
    law: pairs.PairLaw
    flexible: Flexible
    fingers: Floats2  # (fingers, 2): y of the right and left side of each, at the undersides' rear, m


class BodyStates(NamedTuple):
    """Poses of all bodies, and their rates."""

    shoes: FloatArray  # (shoes, 6): COM position (m) and angles about x, y, z (rad)
    shoe_rates: FloatArray
    units: FloatArray  # (units, 4): centre position (m) and tilt (rad)
    unit_rates: FloatArray
    modal: FloatArray  # (flexible shoes, modes): modal coordinates
    modal_rates: FloatArray


class Cells(NamedTuple):
    """Rectangle of units: index of the first, and numbers of units along x and along y."""

    first: int
    columns: int
    rows: int


@inlined
def cells_below(shoe: Frame, outline: Outline) -> Cells:
    """Return the units that may lie under a shoe."""
    grid = outline.grid
    footprint = outline.footprint
    x = max(abs(footprint.low_x), abs(footprint.high_x))
    y = max(abs(footprint.low_y), abs(footprint.high_y))
    # pitch and tilt move the underside's corners by their height times the angle
    slack = 0.02 * grid.length
    across = shoe.R[0]
    side = shoe.R[1]
    reach_x = abs(across[0]) * x + abs(across[1]) * y + abs(across[2] * footprint.z) + slack
    reach_y = abs(side[0]) * x + abs(side[1]) * y + abs(side[2] * footprint.z) + slack
    i0 = max(0, math.floor((shoe.r[0] - grid.x - reach_x) / grid.length))
    i1 = min(grid.columns - 1, math.floor((shoe.r[0] - grid.x + reach_x) / grid.length))
    j0 = max(0, math.floor((shoe.r[1] - grid.y - reach_y) / grid.width))
    j1 = min(grid.rows - 1, math.floor((shoe.r[1] - grid.y + reach_y) / grid.width))
    return Cells(i0 * grid.rows + j0, max(0, i1 - i0 + 1), max(0, j1 - j0 + 1))


@inlined
def share_of_whole(reach: float, outline: Outline) -> float:
    """Return the weight of a whole underside's volume at a reach (m); the rest is that of its fingers."""
    if outline.finger_length == 0.0:
        return 1.0
    ahead = reach - outline.footprint.low_x - outline.finger_length
    return laws.step(ahead, -0.5 * FINGER_BLEND, 0.0, 0.5 * FINGER_BLEND, 1.0)


@inlined
def whole_volume(part: overlap.Overlap, half: Vector, outline: Outline) -> pairs.Volume:
    """Return the volume of a whole underside's overlap with a unit, `half` as in `pairs.Volume`."""
    weight = share_of_whole(part.reach, outline)
    fading = 0.0
    if weight != 0.0 and weight != 1.0:
        fading = (share_of_whole(part.reach + REACH_STEP, outline) - weight) / REACH_STEP
    return pairs.Volume(part, weight, outline.footprint, half, fading, pairs.WHOLE)


@inner
def finger_volume(
    finger: int,
    sides: Floats2,
    whole: pairs.Volume,
    shoe: Frame,
    unit: Frame,
    length: float,
    work: FloatArray,
) -> pairs.Volume:
    """Return the volume of a finger's overlap with a unit, beside that of the whole underside.

    `finger` is its number from 1, `sides` are those of all fingers, as in `ContactGeometry`, and `length` is
    the length of a finger, m.
    """
    low_x = whole.footprint.low_x
    z = whole.footprint.z
    right = sides[finger - 1, 0]
    left = sides[finger - 1, 1]
    footprint = pairs.Footprint(low_x, low_x + length, right, left, z)
    part = pairs.pair_overlap(shoe, unit, footprint, whole.half, work)
    return pairs.Volume(part, 1.0 - whole.weight, footprint, whole.half, -whole.fading, finger)


@kernel
def patch_rectangle(part: overlap.Overlap, shoe: Frame, unit: Frame, top: float) -> pairs.Rectangle:
    """Return the rectangle in the shoe's axes about an overlap, m; the unit's face is at `top`.

    It is seen from above: the unit's tilt moves the overlap by far less than a cell of the underside.
    """
    half_xi = 0.5 * (part.high_xi - part.low_xi)
    half_eta = 0.5 * (part.high_eta - part.low_eta)
    x = unit.r[0] + 0.5 * (part.low_xi + part.high_xi) - shoe.r[0]
    y = unit.r[1] + 0.5 * (part.low_eta + part.high_eta) - shoe.r[1]
    z = pairs.contact_point(part, unit, top)[2] - shoe.r[2]
    middle = turned_back(shoe.R, (x, y, z))
    along_x = shoe.R[0]
    along_y = shoe.R[1]
    hx = abs(along_x[0]) * half_xi + abs(along_y[0]) * half_eta
    hy = abs(along_x[1]) * half_xi + abs(along_y[1]) * half_eta
    return middle[0] - hx, middle[0] + hx, middle[1] - hy, middle[1] + hy
