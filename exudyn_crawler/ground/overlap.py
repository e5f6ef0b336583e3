"""Overlap of a shoe's underside with the top of a terrain unit.

The overlap is the prism between the part of the underside that lies within the unit's outline and
below its top face, and that face. It is clipped exactly, for any position and tilt of the two.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.frames import compiled, within
from exudyn_crawler.ground.rotations import FloatArray

VERTICES = 12
"""Room for the corners of a clipped rectangle: each of five cuts adds one at most."""


class Overlap(NamedTuple):
    """Overlap of an underside with a unit, in the unit's axes from its centre.

    Attributes
    ----------
    area : float
        m2, seen along the unit's normal; zero where there is none.
    xi, eta : float
        m, centroid of the overlap's volume.
    depth : float
        m, depth of the underside below the top face at the centroid.
    low_xi, high_xi, low_eta, high_eta : float
        m, bounds.
    volume : float
        m3.
    """

    area: float
    xi: float
    eta: float
    depth: float
    low_xi: float
    high_xi: float
    low_eta: float
    high_eta: float
    volume: float


NO_OVERLAP = Overlap(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@within
def _clip(source: FloatArray, count: int, target: FloatArray, axis: int, sign: float, limit: float) -> int:
    """Keep the part of a polygon with ``sign * coordinate <= limit``; rows are (xi, eta, depth).

    Gives the number of its corners, zero where fewer than three are left.
    """
    kept = 0
    previous = count - 1
    distance_previous = limit - sign * source[previous, axis]
    for current in range(count):
        distance = limit - sign * source[current, axis]
        if (distance >= 0.0) != (distance_previous >= 0.0):
            t = distance_previous / (distance_previous - distance)
            for k in range(3):
                target[kept, k] = source[previous, k] + t * (source[current, k] - source[previous, k])
            kept += 1
        if distance >= 0.0:
            for k in range(3):
                target[kept, k] = source[current, k]
            kept += 1
        previous = current
        distance_previous = distance
    return kept if kept > 2 else 0


@within
def _integrated(points: FloatArray, count: int) -> Overlap:
    """Integrals of the depth over a polygon of (xi, eta, depth), a fan of triangles."""
    area = 0.0
    volume = 0.0
    moment_xi = 0.0
    moment_eta = 0.0
    moment_depth = 0.0
    xi0, eta0, d0 = points[0, 0], points[0, 1], points[0, 2]
    for k in range(1, count - 1):
        xi1, eta1, d1 = points[k, 0], points[k, 1], points[k, 2]
        xi2, eta2, d2 = points[k + 1, 0], points[k + 1, 1], points[k + 1, 2]
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
    for k in range(1, count):
        low_xi, high_xi = min(low_xi, points[k, 0]), max(high_xi, points[k, 0])
        low_eta, high_eta = min(low_eta, points[k, 1]), max(high_eta, points[k, 1])
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
    )


@compiled
def overlap(work: FloatArray, half_x: float, half_y: float) -> Overlap:
    """Clip the underside to a unit's top face and integrate the depth over what is left.

    Parameters
    ----------
    work : array (2, VERTICES, 3)
        The first four rows of ``work[0]`` are the corners of the underside in order round the rectangle,
        clockwise from outside: xi, eta in the unit's axes from its centre and depth below its top face
        (negative above it), m. Overwritten.
    half_x, half_y : float
        Half the unit's side lengths, m.

    Notes
    -----
    With the depth d linear over the polygon its value at the centroid of the volume is
    ``integral(d**2) / integral(d)``. An underside that looks up overlaps with nothing.
    """
    points, other = work[0], work[1]
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
    return _integrated(points, count)


def overlap_workspace() -> FloatArray:
    """Scratch memory for `overlap`."""
    return np.zeros((2, VERTICES, 3))
