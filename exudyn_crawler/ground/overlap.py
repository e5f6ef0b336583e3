"""Overlap of a shoe's underside with the top of a terrain unit.

The overlap is the prism between the part of the underside that lies within the unit's outline and
below its top face, and that face. It is clipped exactly, for any position and tilt of the two. Where the
unit's outline cuts the underside, parts of the unit's side faces lie within the shoe.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground import columns
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.packed import FloatArray

VERTICES = 12
"""Largest number of corners of a clipped rectangle: each of five cuts adds one at most."""

COLUMNS = 4
"""Numbers of a corner: xi, eta in the unit's axes, depth below its top face, x in the shoe's frame; m."""


class Overlap(NamedTuple):
    """Overlap of an underside with a unit, in the unit's axes from its centre."""

    area: float  # m2, seen along the unit's normal; zero where there is none
    xi: float  # m, centroid of the overlap's volume
    eta: float
    depth: float  # m, of the underside below the top face at the centroid
    low_xi: float  # m, bounds
    high_xi: float
    low_eta: float
    high_eta: float
    volume: float  # m3
    # m2, area vector of the unit's side faces within the shoe. With `area` along z it is the integral of the
    # outward normal over all faces of the unit within the shoe, and the opposite of the volume's change by an
    # even displacement of the shoe
    side_x: float
    side_y: float
    reach: float  # m, greatest x of the overlap in the shoe's frame
    cut: int  # corners of the clipped polygon that `overlap` leaves in ``work[1]``; zero if unclipped


NO_OVERLAP = Overlap(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0)

ON_SIDE, ON_SURFACE = 1e-9, 1e-12
"""Distances (m) within which a corner of an overlap counts as on a unit's side, and on its top face."""


class GradientRows(NamedTuple):
    """First rows of the gradient of an overlap: derivative of each quantity by a displacement (m)."""

    area: columns.Number
    volume: columns.Number
    moment: columns.Pair  # of the volume: its integrals of xi and eta
    square: columns.Number  # integral of the depth's square
    side: columns.Pair  # `side_x` and `side_y` of `Overlap`
    width: columns.Pair  # in xi and eta
    reach: columns.Number


CHANGE = columns.columns_of(GradientRows)
GRADIENT = columns.width_of(GradientRows)
"""Number of rows of a gradient."""


@inner
def _clip(source: FloatArray, count: int, target: FloatArray, axis: int, sign: float, limit: float) -> int:
    """Write the part of a polygon with ``sign * coordinate <= limit``; rows as in `overlap`.

    Return the number of its corners, or zero if fewer than three are left.
    """
    corners = 0
    previous = count - 1
    distance_previous = limit - sign * source[previous, axis]
    for current in range(count):
        distance = limit - sign * source[current, axis]
        if (distance >= 0.0) != (distance_previous >= 0.0):
            t = distance_previous / (distance_previous - distance)
            for k in range(COLUMNS):
                target[corners, k] = source[previous, k] + t * (source[current, k] - source[previous, k])
            corners += 1
        if distance >= 0.0:
            for k in range(COLUMNS):
                target[corners, k] = source[current, k]
            corners += 1
        previous = current
        distance_previous = distance
    return corners if corners > 2 else 0


@inner
def _side(a: FloatArray, b: FloatArray, half_x: float, half_y: float) -> int:
    """Return the axis across the unit's side on which the edge of two corners lies; -1 for none."""
    for axis in range(2):
        half = half_x if axis == 0 else half_y
        if abs(abs(a[axis]) - half) < ON_SIDE and abs(a[axis] - b[axis]) < ON_SIDE:
            return axis
    return -1


@inner
def _along_side(a: FloatArray, b: FloatArray, axis: int) -> float:
    """Return the length of an edge on a side across an axis, with the sign of the side's outward normal."""
    return b[1] - a[1] if axis == 0 else a[0] - b[0]


@inner
def _integrated(points: FloatArray, count: int, cut: bool, half_x: float, half_y: float) -> Overlap:
    """Return integrals of the depth over a polygon, a fan of triangles, and over its edges if it is `cut`."""
    area = 0.0
    volume = 0.0
    moment_xi = 0.0
    moment_eta = 0.0
    moment_depth = 0.0
    xi0 = points[0, 0]
    eta0 = points[0, 1]
    d0 = points[0, 2]
    for k in range(1, count - 1):
        xi1 = points[k, 0]
        eta1 = points[k, 1]
        d1 = points[k, 2]
        xi2 = points[k + 1, 0]
        eta2 = points[k + 1, 1]
        d2 = points[k + 1, 2]
        triangle = 0.5 * ((xi1 - xi0) * (eta2 - eta0) - (xi2 - xi0) * (eta1 - eta0))
        total = d0 + d1 + d2
        area += triangle
        volume += triangle * total / 3.0
        moment_xi += triangle * ((xi0 + xi1 + xi2) * total + xi0 * d0 + xi1 * d1 + xi2 * d2) / 12.0
        moment_eta += triangle * ((eta0 + eta1 + eta2) * total + eta0 * d0 + eta1 * d1 + eta2 * d2) / 12.0
        moment_depth += triangle * (total * total + d0 * d0 + d1 * d1 + d2 * d2) / 12.0
    if area <= 0.0 or volume <= 0.0:
        return NO_OVERLAP
    low_xi = high_xi = xi0
    low_eta = high_eta = eta0
    reach = points[0, 3]
    side_x = side_y = 0.0
    for k in range(count):
        low_xi = min(low_xi, points[k, 0])
        high_xi = max(high_xi, points[k, 0])
        low_eta = min(low_eta, points[k, 1])
        high_eta = max(high_eta, points[k, 1])
        reach = max(reach, points[k, 3])
        if cut:
            a, b = points[k], points[(k + 1) % count]
            axis = _side(a, b, half_x, half_y)
            if axis >= 0:
                face = 0.5 * (a[2] + b[2]) * _along_side(a, b, axis)
                side_x = side_x + face * (axis == 0)
                side_y = side_y + face * (axis == 1)
    return Overlap(
        area,
        moment_xi / volume,
        moment_eta / volume,
        moment_depth / volume,
        low_xi,
        high_xi,
        low_eta,
        high_eta,
        volume,
        side_x,
        side_y,
        reach,
        count if cut else 0,
    )


@kernel
def overlap(work: FloatArray, half_x: float, half_y: float) -> Overlap:
    """Clip the underside to a unit's top face and integrate the depth over the clipped polygon.

    `work` (2, VERTICES, COLUMNS) is overwritten. The first four rows of ``work[0]`` are the corners of the
    underside in order round the rectangle, clockwise from outside: xi, eta in the unit's axes from its
    centre, depth below its top face (negative above it) and x in the shoe's frame, m. `half_x` and `half_y`
    are half the unit's side lengths, m.

    The depth d is linear over the polygon. Its value at the centroid of the volume is therefore
    ``integral(d**2) / integral(d)``. An underside that faces upwards overlaps with nothing.
    """
    points = work[0]
    other = work[1]
    inside = True
    for k in range(4):
        if abs(points[k, 0]) > half_x or abs(points[k, 1]) > half_y or points[k, 2] <= 0.0:
            inside = False
    count = np.int64(4)
    for cut in range(0 if inside else 5):  # both sides across x, both across y, the top face
        axis = cut // 2
        limit = half_x if axis == 0 else (half_y if axis == 1 else 0.0)
        sign = -1.0 if cut % 2 == 1 or axis == 2 else 1.0
        count = _clip(points, count, other, axis, sign, limit)
        if count == 0:
            return NO_OVERLAP
        points, other = other, points
    return _integrated(points, count, not inside, half_x, half_y)


@inner
def _corner_speed(
    corner: FloatArray, beyond: FloatArray, axis: int, direction: int, half_x: float, half_y: float
) -> float:
    """Return the speed of a corner along the unit's side for a unit speed of the shoe.

    `corner` is the end of an edge on the side, `beyond` the other end of the next edge; `axis` and
    `direction` are those of the side's normal and of the displacement: 0 for xi, 1 for eta.
    """
    along_it = beyond[1 - axis] - corner[1 - axis]
    apart = beyond[axis] - corner[axis]
    if _side(corner, beyond, half_x, half_y) >= 0 or apart == 0.0:
        return 0.0
    # the next edge is the shoe's and moves with it
    return 1.0 if direction != axis else -along_it / apart


@kernel
def write_gradient(
    points: FloatArray,
    count: int,
    part: Overlap,
    half_x: float,
    half_y: float,
    slope_xi: float,
    slope_eta: float,
    out: FloatArray,
) -> None:
    """Write the gradient (GRADIENT, 3) of a clipped overlap by motions of the shoe along the unit's axes.

    `points` and `count` are its polygon, as `overlap` leaves it; the slopes are those of the depth over xi
    and eta.

    In the shoe's frame the underside is fixed and the unit's outline moves the other way. An integral of the
    depth therefore changes on the edges that lie on the unit's sides, and by the depth's own change as the
    shoe rises. The effect of slanted ends on the widths is left out; it matters for slivers alone.
    """
    out.fill(0.0)
    steep = (slope_xi * slope_xi + slope_eta * slope_eta) ** 0.5
    first_xi = first_eta = 0.0
    for k in range(count):
        a, b = points[k], points[(k + 1) % count]
        twice = a[0] * b[1] - b[0] * a[1]
        first_xi += (a[0] + b[0]) * twice / 6.0
        first_eta += (a[1] + b[1]) * twice / 6.0
        axis = _side(a, b, half_x, half_y)
        if axis < 0:
            if abs(a[2]) < ON_SURFACE and abs(b[2]) < ON_SURFACE and steep > 0.0:
                out[CHANGE.area, 2] -= ((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5 / steep
            continue
        length = _along_side(a, b, axis)
        out[CHANGE.area, axis] -= length
        out[CHANGE.volume, axis] -= 0.5 * length * (a[2] + b[2])
        for c in range(2):
            moment = length * (a[c] * (2.0 * a[2] + b[2]) + b[c] * (a[2] + 2.0 * b[2])) / 6.0
            out[CHANGE.moment + c, axis] -= moment
        out[CHANGE.square, axis] -= length * (a[2] * a[2] + a[2] * b[2] + b[2] * b[2]) / 3.0
        out[CHANGE.side + axis, 2] -= length
        before = points[(k + count - 1) % count]
        after = points[(k + 2) % count]
        sign = 1.0 if axis == 0 else -1.0
        for direction in range(2):
            ends = b[2] * _corner_speed(b, after, axis, direction, half_x, half_y)
            ends -= a[2] * _corner_speed(a, before, axis, direction, half_x, half_y)
            slope = slope_xi if direction == 0 else slope_eta
            out[CHANGE.side + axis, direction] += sign * ends - slope * length
        for corner, beyond in ((a, before), (b, after)):
            if (
                corner[3] == part.reach
                and _side(corner, beyond, half_x, half_y) < 0
                and beyond[axis] != corner[axis]
            ):
                out[CHANGE.reach, axis] = -(beyond[3] - corner[3]) / (beyond[axis] - corner[axis])
        # what lies across the side is the shoe's, unless both sides cut it
        out[CHANGE.width + axis, axis] -= 1.0 if length > 0.0 else -1.0
    out[CHANGE.moment, 0] += part.volume
    out[CHANGE.moment + 1, 1] += part.volume
    out[CHANGE.volume, 2] = -part.area
    out[CHANGE.moment, 2] = -first_xi
    out[CHANGE.moment + 1, 2] = -first_eta
    out[CHANGE.square, 2] = -2.0 * part.volume


def overlap_workspace() -> FloatArray:
    """Return scratch memory for `overlap`."""
    return np.zeros((2, VERTICES, COLUMNS))
