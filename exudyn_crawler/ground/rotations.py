"""From the bodies' coordinates to frames, and from wrenches back to generalized forces.

The coordinates of a body are its position and the successive angles about x, y, z:
``R = Rx(a) Ry(b) Rz(c)`` turns body components into global ones (Exudyn's `NodeRigidBodyRxyz`,
Tait-Bryan angles). They are singular at b = 90 degrees, which a shoe on the ground never nears. This is the
only place that knows the angles: other coordinates, without that limit, would change this file alone.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.frames import Frame, Matrix, Vector, along, compiled, cross, dot, turned

FloatArray = NDArray[np.float64]


class Attitude(NamedTuple):
    """Rotation matrix of a body and the global axes that its three angles turn about."""

    R: Matrix
    axes: Matrix


@compiled
def attitude(a: float, b: float, c: float) -> Attitude:
    """Attitude at the angles a, b, c about x, y, z (rad).

    The first angle turns about the global x, the last about the body's own z.
    """
    ca, sa = math.cos(a), math.sin(a)
    cb, sb = math.cos(b), math.sin(b)
    cc, sc = math.cos(c), math.sin(c)
    R = (
        (cb * cc, -cb * sc, sb),
        (ca * sc + sa * sb * cc, ca * cc - sa * sb * sc, -sa * cb),
        (sa * sc - ca * sb * cc, sa * cc + ca * sb * sc, ca * cb),
    )
    return Attitude(R, ((1.0, 0.0, 0.0), (0.0, ca, sa), (sb, -sa * cb, ca * cb)))


@compiled
def tilted(angle: float, axis: int) -> Attitude:
    """Attitude of a unit at its one angle (rad), about x (axis 0) or y (axis 1)."""
    c, s = math.cos(angle), math.sin(angle)
    if axis == 1:
        R = ((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c))
        return Attitude(R, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (s, 0.0, c)))
    R = ((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c))
    return Attitude(R, ((1.0, 0.0, 0.0), (0.0, c, s), (0.0, -s, c)))


@compiled
def spin(at: Attitude, rates: Vector) -> Vector:
    """Angular velocity (rad/s, global) of the rates of the angles."""
    nothing = (0.0, 0.0, 0.0)
    return along(along(along(nothing, rates[0], at.axes[0]), rates[1], at.axes[1]), rates[2], at.axes[2])


@compiled
def spin_rate(at: Attitude, rates: Vector, accelerations: Vector) -> Vector:
    """Angular acceleration (rad/s2, global) of the angles' first and second derivatives.

    The axis of an angle turns with the angles that come before it.
    """
    nothing = (0.0, 0.0, 0.0)
    first = along(nothing, rates[0], at.axes[0])
    both = along(first, rates[1], at.axes[1])
    change = along(spin(at, accelerations), rates[1], cross(first, at.axes[1]))
    return along(change, rates[2], cross(both, at.axes[2]))


@compiled
def shoe_frame(q: FloatArray, q_t: FloatArray, at: Attitude) -> Frame:
    """Frame of a shoe at its six coordinates (position first) and their rates."""
    omega = spin(at, (q_t[3], q_t[4], q_t[5]))
    return Frame((q[0], q[1], q[2]), at.R, (q_t[0], q_t[1], q_t[2]), omega)


@compiled
def unit_frame(q: FloatArray, q_t: FloatArray, axis: int, at: Attitude) -> Frame:
    """Frame of a unit at its position and tilt (4) and their rates; `axis` is what it tilts about."""
    omega = (0.0, q_t[3], 0.0) if axis == 1 else (q_t[3], 0.0, 0.0)
    return Frame((q[0], q[1], q[2]), at.R, (q_t[0], q_t[1], q_t[2]), omega)


@compiled
def shoe_at(q: FloatArray, q_t: FloatArray) -> Frame:
    """`shoe_frame` at the shoe's own attitude."""
    return shoe_frame(q, q_t, attitude(q[3], q[4], q[5]))


@compiled
def unit_at(q: FloatArray, q_t: FloatArray, axis: int) -> Frame:
    """`unit_frame` at the unit's own tilt."""
    return unit_frame(q, q_t, axis, tilted(q[3], axis))


@compiled
def generalized_moment(moment: Vector, at: Attitude) -> Vector:
    """Generalized forces on a body's angles of a moment (N m): its parts along their axes."""
    return turned(at.axes, moment)


@compiled
def to_angles(block: FloatArray, moment: Vector, factor: float, at: Attitude) -> None:
    """Turn a derivative by rotations about global x, y, z into one by the angles, in place.

    Parameters
    ----------
    block : array (>= 6, >= 6)
        Derivatives of force and moment (first rows) and what follows them by displacement and rotation
        (first columns) and what follows them.
    moment : Vector
        Moment about the body's centre, N m: its parts along the axes change as these turn.
    factor : float
        Of the derivative by places.
    """
    for r in range(block.shape[0]):
        row = (block[r, 3], block[r, 4], block[r, 5])
        block[r, 3], block[r, 4], block[r, 5] = turned(at.axes, row)
    for c in range(block.shape[1]):
        change = (block[3, c], block[4, c], block[5, c])
        block[3, c], block[4, c], block[5, c] = turned(at.axes, change)
    (_, _, _), (_, ca, sa), (sb, across, up) = at.axes
    cb = -sa * across + ca * up
    block[4, 3] += factor * (ca * moment[2] - sa * moment[1])
    block[5, 3] += -factor * (up * moment[1] - across * moment[2])
    block[5, 4] += factor * dot((cb, sa * sb, -ca * sb), moment)


def angular_velocity(angles: FloatArray, rates: FloatArray) -> FloatArray:
    """Angular velocities (rad/s, global) of angles and their rates: array (..., 3)."""
    return np.asarray(np.einsum("...kj,...k->...j", _axes(angles), rates), dtype=np.float64)


def angular_acceleration(angles: FloatArray, rates: FloatArray, accelerations: FloatArray) -> FloatArray:
    """Angular accelerations (rad/s2, global) of angles and their two derivatives: array (..., 3)."""
    return angular_velocity(angles, accelerations) + _turning_of_axes(angles, rates)


def angles_of(axes: FloatArray) -> FloatArray:
    """Angles (rad) of rotation matrices (..., 3, 3): array (..., 3)."""
    about_x = np.arctan2(-axes[..., 1, 2], axes[..., 2, 2])
    about_y = np.arcsin(np.clip(axes[..., 0, 2], -1.0, 1.0))
    about_z = np.arctan2(-axes[..., 0, 1], axes[..., 0, 0])
    return np.stack((about_x, about_y, about_z), axis=-1)


def angle_rates(angles: FloatArray, omega: FloatArray) -> FloatArray:
    """Rates of angles (rad/s) that make an angular velocity (rad/s, global): array (..., 3)."""
    turned = np.swapaxes(_axes(angles), -1, -2)
    return np.asarray(np.linalg.solve(turned, omega[..., None])[..., 0], dtype=np.float64)


def angle_accelerations(angles: FloatArray, rates: FloatArray, alpha: FloatArray) -> FloatArray:
    """Second derivatives of angles (rad/s2) that make an angular acceleration (rad/s2, global)."""
    return angle_rates(angles, alpha - _turning_of_axes(angles, rates))


def moments_of(angles: FloatArray, generalized: FloatArray) -> FloatArray:
    """Moments (N m, global) that have these generalized forces on the angles: array (bodies, 3)."""
    return np.asarray(np.linalg.solve(_axes(angles), generalized[..., None])[..., 0], dtype=np.float64)


def moments_on_angles(angles: FloatArray, moments: FloatArray) -> FloatArray:
    """Generalized forces on the angles of moments (N m, global): array (bodies, 3)."""
    return np.asarray(np.einsum("...kj,...j->...k", _axes(angles), moments), dtype=np.float64)


def _axes(angles: FloatArray) -> FloatArray:
    """Global axes that angles (..., 3) turn about: array (..., 3, 3), an axis a row."""
    flat = np.ascontiguousarray(angles).reshape(-1, 3)
    out = np.empty((len(flat), 3, 3))
    _all_axes(flat, out)
    return out.reshape(*angles.shape[:-1], 3, 3)


def _turning_of_axes(angles: FloatArray, rates: FloatArray) -> FloatArray:
    """Part of the angular acceleration (rad/s2, global) that the rates make alone: array (..., 3)."""
    flat = np.ascontiguousarray(angles).reshape(-1, 3)
    out = np.empty_like(flat)
    _all_turning(flat, np.ascontiguousarray(rates).reshape(-1, 3), out)
    return out.reshape(angles.shape)


def rotation_matrices(angles: FloatArray) -> FloatArray:
    """``Rx(a) Ry(b) Rz(c)`` of many angles (..., 3): array (..., 3, 3)."""
    flat = np.ascontiguousarray(angles).reshape(-1, 3)
    out = np.empty((len(flat), 3, 3))
    _rotation_matrices(flat, out)
    return out.reshape(*angles.shape[:-1], 3, 3)


@compiled
def _rotation_matrices(angles, out):
    for n in range(angles.shape[0]):
        R = attitude(angles[n, 0], angles[n, 1], angles[n, 2]).R
        for r in range(3):
            for c in range(3):
                out[n, r, c] = R[r][c]


@compiled
def _all_axes(angles, out):
    for n in range(angles.shape[0]):
        axes = attitude(angles[n, 0], angles[n, 1], angles[n, 2]).axes
        for r in range(3):
            for c in range(3):
                out[n, r, c] = axes[r][c]


@compiled
def _all_turning(angles, rates, out):
    still = (0.0, 0.0, 0.0)
    for n in range(angles.shape[0]):
        at = attitude(angles[n, 0], angles[n, 1], angles[n, 2])
        change = spin_rate(at, (rates[n, 0], rates[n, 1], rates[n, 2]), still)
        for r in range(3):
            out[n, r] = change[r]
