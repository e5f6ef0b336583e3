"""Markers: points of bodies at which joints, loads and drives act, and a force's effect on the body."""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import (
    Vector,
    along,
    basis,
    cross,
    dot,
    norm,
    turned,
    turned_back,
    write_turned_rows,
)
from exudyn_crawler.ground.packed import FloatArray, Floats2, Floats3, Ints1
from exudyn_crawler.ground.rotations import Attitude
from exudyn_crawler.model.bodies import moved

SMALL = 1e-3
"""Rotation (rad) below which sine and cosine are computed by series."""

UNTURNED = (1.0, 0.5, 1.0 / 6.0)
"""Result of `_factors` without rotation."""

NOTHING = (0.0, 0.0, 0.0)


class Markers(NamedTuple):
    """Points of bodies at which joints, loads and drives act; k of them."""

    body: Ints1  # (k,): number of the body
    position: Floats2  # (k, 3): in the body's frame, m
    displacement: Floats3  # (k, 3, m): by the body's modes, in its frame; zero where it is rigid
    rotation: Floats3  # (k, 3, m): the same
    modes: Ints1  # (k,): number of modes that move it, none where its body is rigid


class End(NamedTuple):
    """Marker at the pose and deformation of its body."""

    lever: Vector  # from the frame's origin, m, global
    rotation: Vector  # vector to turn about, rad, the body's frame
    factors: Vector  # see `_factors`, of its length


@inner
def _factors(angle: float) -> tuple[float, float, float]:
    """Return ``sin a / a``, ``(1 - cos a) / a^2`` and ``(a - sin a) / a^3``."""
    if angle < SMALL:
        square = angle * angle
        return 1.0 - square / 6.0, 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    s = math.sin(angle) / angle
    return s, (1.0 - math.cos(angle)) / angle**2, (1.0 - s) / angle**2


@inner(merged=True)
def end_of(markers: Markers, k: int, attitude: Attitude, row: FloatArray) -> End:
    """Return marker k at the coordinates of its body and its modes (6 + m,)."""
    position = (markers.position[k, 0], markers.position[k, 1], markers.position[k, 2])
    if markers.modes[k] == 0:
        return End(turned(attitude.R, position), NOTHING, UNTURNED)
    rotation = moved(NOTHING, markers.rotation[k], row)
    lever = turned(attitude.R, moved(position, markers.displacement[k], row))
    return End(lever, rotation, _factors(norm(rotation)))


@inner(merged=True)
def axis_of(end: End, attitude: Attitude, k: int) -> Vector:
    """Return axis k of an end, global: ``R exp(rotation) e_k``."""
    t = end.rotation
    s, c, _ = end.factors
    once = cross(t, basis(k))
    return turned(attitude.R, along(along(basis(k), s, once), c, cross(t, once)))


@inner
def _by_rotation(end: End, moment: Vector) -> Vector:
    """Return the part of a moment (the shoe's frame) that is conjugate to an end's rotation vector.

    An end turns at ``T rotation'`` with ``T = 1 + (1 - cos a)/a^2 t~ + (a - sin a)/a^3 t~ t~``; the result is
    its transpose times the moment.
    """
    t = end.rotation
    _, c, d = end.factors
    once = cross(t, moment)
    return along(along(moment, -c, once), d, cross(t, once))


@inner(merged=True)
def _work(shapes: FloatArray, force: Vector, k: int) -> float:
    """Return the work of a force (the body's frame) along mode k of shapes (3, m)."""
    return force[0] * shapes[0, k] + force[1] * shapes[1, k] + force[2] * shapes[2, k]


@inner(merged=True)
def direction(
    markers: Markers,
    k: int,
    end: End,
    attitude: Attitude,
    force: Vector,
    moment: Vector,
    sign: float,
    out: FloatArray,
) -> None:
    """Write the generalized force (6 + m,) of a force and a moment (global) at marker k, times a sign.

    For a rigid body the last m entries are not written.
    """
    turning = turned(attitude.axes, along(moment, 1.0, cross(end.lever, force)))
    for c in range(3):
        out[c] = sign * force[c]
        out[3 + c] = sign * turning[c]
    if markers.modes[k] == 0:
        return
    shapes = markers.displacement[k]
    local = turned_back(attitude.R, force)
    for m in range(shapes.shape[1]):
        out[6 + m] = sign * _work(shapes, local, m)
    if dot(moment, moment) != 0.0:
        rotations = markers.rotation[k]
        local = _by_rotation(end, turned_back(attitude.R, moment))
        for m in range(rotations.shape[1]):
            out[6 + m] += sign * _work(rotations, local, m)


@inner(merged=True)
def write_point(
    attitude: Attitude, arm: Vector, shapes: FloatArray, modes: int, sign: float, jacobian: FloatArray
) -> None:
    """Write a point's Jacobian by the coordinates and modes of its body (3, 6 + m), times a sign.

    `arm` is the vector from the body's origin to the point, m, global. The first `modes` columns of `shapes`
    (3 or more, m), in the body's axes, move the point of a flexible body.
    """
    for c in range(3):
        by_angle = cross(attitude.axes[c], arm)
        for r in range(3):
            jacobian[r, c] = sign if r == c else 0.0
            jacobian[r, 3 + c] = sign * by_angle[r]
    if modes > 0:
        write_turned_rows(attitude.R, shapes, modes, sign, jacobian)
