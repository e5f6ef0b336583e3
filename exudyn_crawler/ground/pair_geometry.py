"""What the contacts of a track are made of: where shoes and units are, and the volumes in which they overlap.

While a shoe reaches over a unit with more than the fingers at its rear it is one volume; where its fingers
alone do, each of them is one with a whole law of its own.
"""

from typing import NamedTuple

from exudyn_crawler.ground import pairs
from exudyn_crawler.ground.frames import Frame, Vector, compiled, inlined, turned_back, within
from exudyn_crawler.ground.laws import named_law, step
from exudyn_crawler.ground.overlap import Overlap
from exudyn_crawler.ground.rotations import (
    Attitude,
    FloatArray,
    IntArray,
    attitude,
    shoe_frame,
    tilted,
    unit_frame,
)
from exudyn_crawler.ground.terrain import Cells, Grid, cell, cells_about
from fem.patches import mean_rows


class Flexible(NamedTuple):
    """Integrated undersides of the flexible shoes (`fem.patches.Underside`).

    `row` holds, for every shoe, its row in the modal coordinates, or -1 where it is rigid.
    """

    corner: FloatArray
    cell: FloatArray
    integral: FloatArray
    row: IntArray


class Fingers(NamedTuple):
    """Fingers at the undersides' rear: length, and right and left side of each, (fingers, 2) y; m."""

    length: float
    sides: FloatArray


class ContactGeometry(NamedTuple):
    """What stays as it is: units, underside of the shoes, flexible shoes and the law of every contact."""

    grid: Grid
    footprint: pairs.Footprint
    flexible: Flexible
    law: pairs.PairLaw
    fingers: Fingers


class BodyStates(NamedTuple):
    """Places of all bodies, and their rates."""

    shoes: FloatArray  # (shoes, 6): COM position (m) and angles about x, y, z (rad)
    shoe_rates: FloatArray
    units: FloatArray  # (units, 4): centre position (m) and tilt (rad)
    unit_rates: FloatArray
    modal: FloatArray  # (flexible shoes, modes): modal coordinates
    modal_rates: FloatArray


@inlined
def named(places: tuple, geometry: tuple) -> tuple[BodyStates, ContactGeometry]:
    """BodyStates and track of their values as plain tuples."""
    grid, footprint, flexible, (law, edge_width, whole_area, area_normal, closest_points), fingers = geometry
    law = pairs.PairLaw(named_law(law), edge_width, whole_area, area_normal, closest_points)
    return BodyStates(*places), ContactGeometry(
        Grid(*grid), pairs.Footprint(*footprint), Flexible(*flexible), law, Fingers(*fingers)
    )


@compiled
def patch_rectangle(
    part: Overlap, shoe: Frame, unit: Frame, geometry: ContactGeometry
) -> tuple[float, float, float, float]:
    """Rectangle in the shoe's axes about an overlap: least and greatest x, least and greatest y, m.

    Seen from above: what the unit's tilt moves the overlap by is far less than a cell of the underside.
    """
    half_xi, half_eta = 0.5 * (part.high_xi - part.low_xi), 0.5 * (part.high_eta - part.low_eta)
    x = unit.r[0] + 0.5 * (part.low_xi + part.high_xi) - shoe.r[0]
    y = unit.r[1] + 0.5 * (part.low_eta + part.high_eta) - shoe.r[1]
    z = pairs.contact_point(part, unit, 0.5 * geometry.grid.height)[2] - shoe.r[2]
    middle = turned_back(shoe.R, (x, y, z))
    along_x, along_y = shoe.R[0], shoe.R[1]
    hx = abs(along_x[0]) * half_xi + abs(along_y[0]) * half_eta
    hy = abs(along_x[1]) * half_xi + abs(along_y[1]) * half_eta
    return middle[0] - hx, middle[0] + hx, middle[1] - hy, middle[1] + hy


@compiled
def patch_rows(
    rectangle: tuple[float, float, float, float], geometry: ContactGeometry, rows: FloatArray
) -> None:
    """Write the mean displacement (3, modes) of a rectangle of the underside by the modes."""
    flexible = geometry.flexible
    mean_rows(flexible.corner, flexible.cell, flexible.integral, rectangle, rows)


FINGER_BLEND, REACH_STEP = 0.02, 1e-7
"""m: of the reach in which the fingers' volumes take over from that of the whole underside, chosen here so
that the force has no jump; of the difference that gives its slope."""


class Standing(NamedTuple):
    """A shoe where it is, its row as of `Flexible`, and the units that may lie under it."""

    row: int
    at: Attitude
    frame: Frame
    cells: Cells


class Outline(NamedTuple):
    """Outlines of undersides and units: without arrays, which would be counted wherever they are handed on.

    `footprint` and `finger_length` (m) are those of a shoe, `half` half the sides of a unit (m).
    """

    footprint: pairs.Footprint
    finger_length: float
    half: Vector


@inlined
def cells_below(shoe: Frame, footprint: pairs.Footprint, grid: Grid) -> Cells:
    """Units that may lie under a shoe."""
    x = max(abs(footprint.low_x), abs(footprint.high_x))
    y = max(abs(footprint.low_y), abs(footprint.high_y))
    # pitch and tilt move the underside's corners by their height times the angle
    slack = 0.02 * grid.length
    across, side = shoe.R[0], shoe.R[1]
    reach_x = abs(across[0]) * x + abs(across[1]) * y + abs(across[2] * footprint.z) + slack
    reach_y = abs(side[0]) * x + abs(side[1]) * y + abs(side[2] * footprint.z) + slack
    return cells_about(grid, shoe.r[0], shoe.r[1], reach_x, reach_y)


@inlined
def standing(bodies: BodyStates, geometry: ContactGeometry, s: int) -> Standing:
    """Shoe s where it is."""
    at = attitude(bodies.shoes[s, 3], bodies.shoes[s, 4], bodies.shoes[s, 5])
    frame = shoe_frame(bodies.shoes[s], bodies.shoe_rates[s], at)
    return Standing(
        geometry.flexible.row[s], at, frame, cells_below(frame, geometry.footprint, geometry.grid)
    )


@inlined
def below(bodies: BodyStates, geometry: ContactGeometry, shoe: Standing, k: int) -> tuple[int, Frame]:
    """Number and frame of the k-th unit that may lie under a shoe."""
    grid = geometry.grid
    u = cell(grid, shoe.cells, k)
    tilt = tilted(bodies.units[u, 3], grid.tilt_axis)
    return u, unit_frame(bodies.units[u], bodies.unit_rates[u], grid.tilt_axis, tilt)


@inlined
def outline_of(geometry: ContactGeometry) -> Outline:
    """Outlines of undersides and units."""
    grid = geometry.grid
    return Outline(
        geometry.footprint, geometry.fingers.length, (0.5 * grid.length, 0.5 * grid.width, 0.5 * grid.height)
    )


@inlined
def share_of_whole(reach: float, outline: Outline) -> float:
    """Weight of the volume of a whole underside that reaches so far: the rest is its fingers'."""
    if outline.finger_length == 0.0:
        return 1.0
    ahead = reach - outline.footprint.low_x - outline.finger_length
    return step(ahead, -0.5 * FINGER_BLEND, 0.0, 0.5 * FINGER_BLEND, 1.0)


@inlined
def whole_volume(shoe: Frame, unit: Frame, outline: Outline, work: FloatArray) -> pairs.Volume:
    """Overlap of a whole underside with a unit."""
    part = pairs.pair_overlap(shoe, unit, outline.footprint, outline.half, work)
    return pairs.Volume(part, share_of_whole(part.reach, outline), outline.footprint, outline.half)


@inlined
def fading_of(whole: pairs.Volume, outline: Outline) -> float:
    """Slope of a whole underside's weight over its reach, 1/m."""
    if whole.weight == 0.0 or whole.weight == 1.0:
        return 0.0
    return (share_of_whole(whole.part.reach + REACH_STEP, outline) - whole.weight) / REACH_STEP


@within
def finger_volume(
    right: float, left: float, weight: float, shoe: Frame, unit: Frame, outline: Outline, work: FloatArray
) -> pairs.Volume:
    """Overlap of a finger between two sides (m) with a unit, beside a whole underside of this weight."""
    whole = outline.footprint
    own = pairs.Footprint(whole.low_x, whole.low_x + outline.finger_length, right, left, whole.z)
    return pairs.Volume(
        pairs.pair_overlap(shoe, unit, own, outline.half, work), 1.0 - weight, own, outline.half
    )
