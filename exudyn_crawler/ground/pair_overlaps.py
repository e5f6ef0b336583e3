"""Where a shoe and the units below it are, and their overlaps: how both walks over all pairs begin."""

from typing import NamedTuple

from exudyn_crawler.ground.frames import Frame, inlined
from exudyn_crawler.ground.grid import Cells, Grid, cell, cells_about
from exudyn_crawler.ground.overlap import Overlap
from exudyn_crawler.ground.pair_track import Bodies, Track
from exudyn_crawler.ground.pairs import Footprint, pair_overlap
from exudyn_crawler.ground.rotations import Attitude, FloatArray, attitude, shoe_frame, tilted, unit_frame


class Standing(NamedTuple):
    """A shoe where it is, its row as of `pair_track.Flexible`, and the units that may lie under it."""

    row: int
    at: Attitude
    frame: Frame
    cells: Cells


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
def below(
    bodies: Bodies, track: Track, shoe: Standing, k: int, work: FloatArray
) -> tuple[int, Frame, Overlap]:
    """Number and frame of the k-th unit that may lie under a shoe, and their overlap.

    No named tuple: that one, handed on to other functions, costs a quarter of the forces' time.
    """
    grid = track.grid
    u = cell(grid, shoe.cells, k)
    tilt = tilted(bodies.units[u, 3], grid.tilt_axis)
    unit = unit_frame(bodies.units[u], bodies.unit_rates[u], grid.tilt_axis, tilt)
    half = (0.5 * grid.length, 0.5 * grid.width, 0.5 * grid.height)
    return u, unit, pair_overlap(shoe.frame, unit, track.footprint, half, work)
