"""Where a shoe and the units below it are, and the volumes in which they overlap.

While a shoe reaches over a unit with more than the fingers at its rear it is one volume; where its fingers
alone do, each of them is one with a whole law of its own.
"""

from typing import NamedTuple

from exudyn_crawler.ground.frames import Frame, Vector, inlined, within
from exudyn_crawler.ground.grid import Cells, Grid, cell, cells_about
from exudyn_crawler.ground.laws.impact import step
from exudyn_crawler.ground.pair_track import Bodies, Track
from exudyn_crawler.ground.pairs import Footprint, Volume, pair_overlap
from exudyn_crawler.ground.rotations import Attitude, FloatArray, attitude, shoe_frame, tilted, unit_frame

FINGER_BLEND, REACH_STEP = 0.02, 1e-7
"""m: of the reach in which the fingers' volumes take over from that of the whole underside, chosen here so
that the force has no jump; of the difference that gives its slope."""


class Standing(NamedTuple):
    """A shoe where it is, its row as of `pair_track.Flexible`, and the units that may lie under it."""

    row: int
    at: Attitude
    frame: Frame
    cells: Cells


class Outline(NamedTuple):
    """Outlines of undersides and units: without arrays, which would be counted wherever they are handed on.

    `footprint` and `finger_length` (m) are those of a shoe, `half` half the sides of a unit (m).
    """

    footprint: Footprint
    finger_length: float
    half: Vector


@inlined
def cells_below(shoe: Frame, footprint: Footprint, grid: Grid) -> Cells:
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
def standing(bodies: Bodies, track: Track, s: int) -> Standing:
    """Shoe s where it is."""
    at = attitude(bodies.shoes[s, 3], bodies.shoes[s, 4], bodies.shoes[s, 5])
    frame = shoe_frame(bodies.shoes[s], bodies.shoe_rates[s], at)
    return Standing(track.flexible.row[s], at, frame, cells_below(frame, track.footprint, track.grid))


@inlined
def below(bodies: Bodies, track: Track, shoe: Standing, k: int) -> tuple[int, Frame]:
    """Number and frame of the k-th unit that may lie under a shoe."""
    grid = track.grid
    u = cell(grid, shoe.cells, k)
    tilt = tilted(bodies.units[u, 3], grid.tilt_axis)
    return u, unit_frame(bodies.units[u], bodies.unit_rates[u], grid.tilt_axis, tilt)


@inlined
def outline_of(track: Track) -> Outline:
    """Outlines of undersides and units."""
    grid = track.grid
    return Outline(
        track.footprint, track.fingers.length, (0.5 * grid.length, 0.5 * grid.width, 0.5 * grid.height)
    )


@inlined
def share_of_whole(reach: float, outline: Outline) -> float:
    """Weight of the volume of a whole underside that reaches so far: the rest is its fingers'."""
    if outline.finger_length == 0.0:
        return 1.0
    ahead = reach - outline.footprint.low_x - outline.finger_length
    return step(ahead, -0.5 * FINGER_BLEND, 0.0, 0.5 * FINGER_BLEND, 1.0)


@inlined
def whole_volume(shoe: Frame, unit: Frame, outline: Outline, work: FloatArray) -> Volume:
    """Overlap of a whole underside with a unit."""
    part = pair_overlap(shoe, unit, outline.footprint, outline.half, work)
    return Volume(part, share_of_whole(part.reach, outline), outline.footprint, outline.half)


@inlined
def fading_of(whole: Volume, outline: Outline) -> float:
    """Slope of a whole underside's weight over its reach, 1/m."""
    if whole.weight == 0.0 or whole.weight == 1.0:
        return 0.0
    return (share_of_whole(whole.part.reach + REACH_STEP, outline) - whole.weight) / REACH_STEP


@within
def finger_volume(
    right: float, left: float, weight: float, shoe: Frame, unit: Frame, outline: Outline, work: FloatArray
) -> Volume:
    """Overlap of a finger between two sides (m) with a unit, beside a whole underside of this weight."""
    whole = outline.footprint
    own = Footprint(whole.low_x, whole.low_x + outline.finger_length, right, left, whole.z)
    return Volume(pair_overlap(shoe, unit, own, outline.half, work), 1.0 - weight, own, outline.half)
