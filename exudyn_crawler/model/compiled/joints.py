"""Constraints between shoes, and what drives the front one: what they are off, and their directions.

A constraint is a force and a moment on a shoe, or opposite ones on two: its direction in the shoe's
coordinates turns the rates of these into the rate of the constraint, and its multiplier into generalized
forces.
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.frames import Vector, along, basis, cross, dot, turned, turned_back
from exudyn_crawler.ground.rotations import Attitude, FloatArray
from exudyn_crawler.model.compiled.bodies import moved
from exudyn_crawler.model.compiled.elimination import IntArray, solving_within

ROWS = 5
"""Equations of a pin: its place, and its axis y across the axes x and z of the shoe in front."""

SMALL = 1e-3
"""rad, rotation below which sine and cosine are taken as series."""


class Pins(NamedTuple):
    """Pins between shoes; the two ends of each are those of the rear and of the front shoe.

    Attributes
    ----------
    shoes : array (pins, 2)
        Shoe at each end.
    places : array (pins, 2, 3)
        In the shoe's frame, m.
    shifts, turns : array (pins, 2, 3, m)
        Displacement and rotation of an end by the modes of its shoe, zero where that is rigid.
    """

    shoes: IntArray
    places: FloatArray
    shifts: FloatArray
    turns: FloatArray


class End(NamedTuple):
    """An end of a pin as its shoe carries it.

    `lever` (m, global) from the frame's origin; `rotation` (rad, the shoe's frame) is a vector to turn about.
    """

    lever: Vector
    rotation: Vector


@solving_within
def end_of(place: FloatArray, shifts: FloatArray, turns: FloatArray, at: Attitude, own: FloatArray) -> End:
    """End of a pin at the coordinates of its shoe and its modes (6 + m,)."""
    lever = turned(at.R, moved((place[0], place[1], place[2]), shifts, own))
    return End(lever, moved((0.0, 0.0, 0.0), turns, own))


@solving_within
def _factors(angle: float) -> tuple[float, float, float]:
    """``sin a / a``, ``(1 - cos a) / a^2`` and ``(a - sin a) / a^3``."""
    if angle < SMALL:
        square = angle * angle
        return 1.0 - square / 6.0, 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    s = math.sin(angle) / angle
    return s, (1.0 - math.cos(angle)) / angle**2, (1.0 - s) / angle**2


@solving_within
def axis_of(end: End, at: Attitude, k: int) -> Vector:
    """Axis k of an end, global: ``R exp(rotation) e_k``."""
    t = end.rotation
    s, c, _ = _factors(math.sqrt(dot(t, t)))
    once = cross(t, basis(k))
    return turned(at.R, along(along(basis(k), s, once), c, cross(t, once)))


@solving_within
def _by_rotation(end: End, moment: Vector) -> Vector:
    """Part of a moment (the shoe's frame) that the rates of an end's rotation vector feel.

    An end turns at ``T rotation'`` with ``T = 1 + (1 - cos a)/a^2 t~ + (a - sin a)/a^3 t~ t~``; this is its
    transpose times the moment.
    """
    t = end.rotation
    _, c, d = _factors(math.sqrt(dot(t, t)))
    once = cross(t, moment)
    return along(along(moment, -c, once), d, cross(t, once))


@solving_within
def direction(
    force: Vector,
    moment: Vector,
    end: End,
    shapes: tuple[FloatArray, FloatArray],
    at: Attitude,
    sign: float,
    out: FloatArray,
) -> None:
    """Write the direction (6 + m,) of a force and a moment (global) at an end, times a sign.

    `shapes` are displacement and rotation of the end by the modes, (3, m) each.
    """
    turning = turned(at.axes, along(moment, 1.0, cross(end.lever, force)))
    for k in range(3):
        out[k] = sign * force[k]
        out[3 + k] = sign * turning[k]
    push, twist = turned_back(at.R, force), _by_rotation(end, turned_back(at.R, moment))
    shifts, turns = shapes
    for k in range(shifts.shape[1]):
        work = 0.0
        for c in range(3):
            work += push[c] * shifts[c, k] + twist[c] * turns[c, k]
        out[6 + k] = sign * work


@solving_within
def pin(
    shapes: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    ends: tuple[End, End],
    attitudes: tuple[Attitude, Attitude],
    apart: Vector,
    off: FloatArray,
    directions: FloatArray,
) -> None:
    """Write what a pin is off (ROWS,) and its directions (2, ROWS, 6 + m).

    Parameters
    ----------
    shapes : tuple of array (3, m)
        Displacement and rotation of the rear shoe's end by its modes, then of the front shoe's.
    ends, attitudes : tuple
        Of rear and front shoe.
    apart : Vector
        From the rear frame's origin to the front one's, m, global.
    """
    rear, front = ends
    gap = along(along(apart, 1.0, front.lever), -1.0, rear.lever)
    across = axis_of(rear, attitudes[0], 1)
    for r in range(ROWS):
        force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if r < 3:
            force = basis(r)
            off[r] = gap[r]
        else:
            axis = axis_of(front, attitudes[1], 0 if r == 3 else 2)
            off[r] = dot(across, axis)
            moment = cross(axis, across)
        direction(force, moment, rear, (shapes[0], shapes[1]), attitudes[0], -1.0, directions[0, r])
        direction(force, moment, front, (shapes[2], shapes[3]), attitudes[1], 1.0, directions[1, r])
