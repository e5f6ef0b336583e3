"""What the contacts of a track are made of: units, undersides, law, and the places of all bodies."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.frames import Frame, compiled, inlined, turned_back
from exudyn_crawler.ground.grid import Grid
from exudyn_crawler.ground.laws import named_law
from exudyn_crawler.ground.overlap import Overlap
from exudyn_crawler.ground.pairs import (
    Footprint,
    PairLaw,
    contact_point,
)
from exudyn_crawler.ground.rotations import FloatArray
from fem.patches import mean_rows


class Flexible(NamedTuple):
    """Integrated undersides of the flexible shoes (`fem.patches.Underside`).

    `row` holds, for every shoe, its row in the modal coordinates, or -1 where it is rigid.
    """

    corner: FloatArray
    cell: FloatArray
    integral: FloatArray
    row: NDArray[np.int64]


class Fingers(NamedTuple):
    """Fingers at the undersides' rear: length, and right and left side of each, (fingers, 2) y; m."""

    length: float
    sides: FloatArray


class Track(NamedTuple):
    """What stays as it is: units, underside of the shoes, flexible shoes and the law of every contact."""

    grid: Grid
    footprint: Footprint
    flexible: Flexible
    law: PairLaw
    fingers: Fingers


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


@inlined
def named(places: tuple, track: tuple) -> tuple[Bodies, Track]:
    """Bodies and track of their values as plain tuples."""
    grid, footprint, flexible, (law, edge_width, whole_area, area_normal, closest_points), fingers = track
    law = PairLaw(named_law(law), edge_width, whole_area, area_normal, closest_points)
    return Bodies(*places), Track(
        Grid(*grid), Footprint(*footprint), Flexible(*flexible), law, Fingers(*fingers)
    )


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
