"""Overlap of a shoe's underside with the top of a terrain unit.

The overlap is the prism between the part of the underside that lies within the unit's outline and
below its top face, and that face. It is clipped exactly, for any position and tilt of the two.
"""

import numpy as np
from numba import njit

from exudyn_crawler.ground.rotations import FloatArray

VERTICES = 12
"""Room for the corners of a clipped rectangle: each of five cuts adds one at most."""

NO_OVERLAP = (0.0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0))


@njit(cache=True)
def _clip(source: FloatArray, count: int, target: FloatArray, axis: int, sign: float, limit: float) -> int:
    """Keep the part of a polygon with ``sign * coordinate <= limit``; rows are (xi, eta, depth)."""
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
    return kept


@njit(cache=True)
def overlap(
    corners: FloatArray, half_x: float, half_y: float, work: FloatArray
) -> tuple[float, float, float, float, tuple[float, float, float, float]]:
    """Clip the underside to a unit's top face and integrate the depth over what is left.

    Parameters
    ----------
    corners : array (4, 3)
        Corners of the underside in the unit's frame, in order round the rectangle: xi, eta
        measured from the unit's centre and depth below its top face (negative above it), m.
    half_x, half_y : float
        Half the unit's side lengths, m.
    work : array (2, VERTICES, 3)
        Scratch memory.

    Returns
    -------
    area : float
        m2, of the overlap seen along the unit's normal; zero where there is none.
    xi, eta : float
        m, centroid of the overlap volume in the unit's frame.
    depth : float
        m, depth of the underside at the centroid.
    bounds : tuple of float
        m, least and greatest xi, least and greatest eta of the overlap.

    Notes
    -----
    With the depth d linear over the polygon its value at the centroid of the volume is
    ``integral(d**2) / integral(d)``.
    """
    points, other = work[0], work[1]
    inside = True
    for k in range(4):
        for c in range(3):
            points[k, c] = corners[k, c]
        if abs(corners[k, 0]) > half_x or abs(corners[k, 1]) > half_y or corners[k, 2] <= 0.0:
            inside = False
    count = 4
    if not inside:
        for axis, sign, limit in (
            (0, 1.0, half_x),
            (0, -1.0, half_x),
            (1, 1.0, half_y),
            (1, -1.0, half_y),
            (2, -1.0, 0.0),
        ):
            count = _clip(points, count, other, axis, sign, limit)
            if count < 3:
                return NO_OVERLAP
            points, other = other, points

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

    low_xi = high_xi = points[0, 0]
    low_eta = high_eta = points[0, 1]
    for k in range(1, count):
        low_xi = min(low_xi, points[k, 0])
        high_xi = max(high_xi, points[k, 0])
        low_eta = min(low_eta, points[k, 1])
        high_eta = max(high_eta, points[k, 1])
    bounds = (low_xi, high_xi, low_eta, high_eta)
    return area, moment_xi / volume, moment_eta / volume, moment_depth / volume, bounds


def overlap_workspace() -> FloatArray:
    """Scratch memory for `overlap`."""
    return np.empty((2, VERTICES, 3))
