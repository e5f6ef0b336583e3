"""Conversion of coordinates of bodies to frames, and of wrenches to generalized forces.

The coordinates of a body are its position and the angles roll about x, pitch about y and yaw about z:
``R = Rz(yaw) Rx(roll) Ry(pitch)`` turns body components into global ones. Yaw and pitch are unlimited. The
middle angle, roll, is singular at 90 degrees; no shoe, sprocket or frame comes near it. This module alone
knows the sequence.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import kernel
from exudyn_crawler.ground.frames import Frame, Matrix, Vector, along, cross
from exudyn_crawler.ground.packed import FloatArray


class Attitude(NamedTuple):
    """Rotation matrix of a body, and the global axes of its roll, pitch and yaw."""

    R: Matrix
    axes: Matrix


@kernel
def attitude(roll: float, pitch: float, yaw: float) -> Attitude:
    """Return the attitude at angles about x, y and z (rad).

    Yaw turns about the global z, roll about x after yaw, pitch about the body's own y.
    """
    cosines = math.cos(roll), math.cos(pitch), math.cos(yaw)
    return attitude_by(cosines, (math.sin(roll), math.sin(pitch), math.sin(yaw)))


@kernel
def attitude_by(cosines: Vector, sines: Vector) -> Attitude:
    """Return the attitude for the cosines and the sines of its angles."""
    (ca, cb, cc) = cosines
    (sa, sb, sc) = sines
    R = (
        (cb * cc - sb * sc * sa, -sc * ca, sb * cc + cb * sc * sa),
        (cb * sc + sb * cc * sa, cc * ca, sb * sc - cb * cc * sa),
        (-sb * ca, sa, cb * ca),
    )
    return Attitude(R, ((cc, sc, 0.0), (-sc * ca, cc * ca, sa), (0.0, 0.0, 1.0)))


@kernel
def spin(attitude: Attitude, rates: Vector) -> Vector:
    """Return the angular velocity (rad/s, global) for the rates of the angles."""
    nothing = (0.0, 0.0, 0.0)
    return along(
        along(along(nothing, rates[0], attitude.axes[0]), rates[1], attitude.axes[1]),
        rates[2],
        attitude.axes[2],
    )


@kernel
def spin_rate(attitude: Attitude, rates: Vector, accelerations: Vector) -> Vector:
    """Return the angular acceleration (rad/s2, global) for the angles' first and second derivatives.

    Yaw turns the axis of roll; yaw and roll turn the axis of pitch.
    """
    by_yaw = along((0.0, 0.0, 0.0), rates[2], attitude.axes[2])
    by_yaw_roll = along(by_yaw, rates[0], attitude.axes[0])
    change = along(spin(attitude, accelerations), rates[0], cross(by_yaw, attitude.axes[0]))
    return along(change, rates[1], cross(by_yaw_roll, attitude.axes[1]))


@kernel
def shoe_frame(q: FloatArray, q_t: FloatArray, attitude: Attitude) -> Frame:
    """Return the frame of a shoe at its six coordinates (position first) and their rates."""
    omega = spin(attitude, (q_t[3], q_t[4], q_t[5]))
    return Frame((q[0], q[1], q[2]), attitude.R, (q_t[0], q_t[1], q_t[2]), omega)


@kernel
def unit_frame(q: FloatArray, q_t: FloatArray, axis: int) -> Frame:
    """Return the frame of a unit at its position and tilt (4) and their rates.

    The unit tilts about `axis` 0 (x) or 1 (y).
    """
    c = math.cos(q[3])
    s = math.sin(q[3])
    R = ((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c))
    omega = (q_t[3], 0.0, 0.0)
    if axis == 1:
        R = ((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c))
        omega = (0.0, q_t[3], 0.0)
    return Frame((q[0], q[1], q[2]), R, (q_t[0], q_t[1], q_t[2]), omega)


def rotation_matrices(angles: FloatArray) -> FloatArray:
    """Return the rotation matrices of angles (..., 3): array (..., 3, 3)."""
    return _of_each(_write_rotations, (3, 3), angles)


def angles_of(axes: FloatArray) -> FloatArray:
    """Return angles (rad) of rotation matrices (..., 3, 3), pitch and yaw within a turn: array (..., 3)."""
    roll = np.arcsin(np.clip(axes[..., 2, 1], -1.0, 1.0))
    pitch = np.arctan2(-axes[..., 2, 0], axes[..., 2, 2])
    yaw = np.arctan2(-axes[..., 0, 1], axes[..., 1, 1])
    return np.stack((roll, pitch, yaw), axis=-1)


def angular_velocity(angles: FloatArray, rates: FloatArray) -> FloatArray:
    """Return the angular velocities (rad/s, global) for angles and their rates: array (..., 3)."""
    return np.asarray(np.einsum("...kj,...k->...j", _axes(angles), rates))


def angle_rates(angles: FloatArray, omega: FloatArray) -> FloatArray:
    """Return the rates of angles (rad/s) for an angular velocity (rad/s, global): array (..., 3)."""
    turned = np.swapaxes(_axes(angles), -1, -2)
    return np.asarray(np.linalg.solve(turned, omega[..., None])[..., 0], dtype=np.float64)


def angular_acceleration(angles: FloatArray, rates: FloatArray, accelerations: FloatArray) -> FloatArray:
    """Return angular accelerations (rad/s2, global) for angles and their two derivatives: array (..., 3)."""
    return angular_velocity(angles, accelerations) + _of_each(_write_turning, (3,), angles, rates)


def angle_accelerations(angles: FloatArray, rates: FloatArray, alpha: FloatArray) -> FloatArray:
    """Return the second derivatives of angles (rad/s2) for an angular acceleration (rad/s2, global)."""
    return angle_rates(angles, alpha - _of_each(_write_turning, (3,), angles, rates))


def moments_of(angles: FloatArray, generalized: FloatArray) -> FloatArray:
    """Return the moments (N m, global) for generalized forces on the angles: array (bodies, 3)."""
    return np.asarray(np.linalg.solve(_axes(angles), generalized[..., None])[..., 0], dtype=np.float64)


def moments_on_angles(angles: FloatArray, moments: FloatArray) -> FloatArray:
    """Return the generalized forces on the angles of moments (N m, global): array (bodies, 3)."""
    return np.asarray(np.einsum("...kj,...j->...k", _axes(angles), moments))


def _axes(angles: FloatArray) -> FloatArray:
    """Return the global axes of rotation of angles (..., 3): array (..., 3, 3), one axis in each row."""
    return _of_each(_write_axes, (3, 3), angles)


def _of_each(write: Callable, shape: tuple[int, ...], *vectors: FloatArray) -> FloatArray:
    """Apply a compiled function to all rows of vectors (..., 3): array (..., *shape)."""
    flat = [np.ascontiguousarray(vector).reshape(-1, 3) for vector in vectors]
    out = np.empty((len(flat[0]), *shape))
    write(*flat, out)
    return out.reshape(*vectors[0].shape[:-1], *shape)


@kernel
def _write_rotations(angles, out):
    for n in range(angles.shape[0]):
        R = attitude(angles[n, 0], angles[n, 1], angles[n, 2]).R
        for r in range(3):
            out[n, r, 0], out[n, r, 1], out[n, r, 2] = R[r]


@kernel
def _write_axes(angles, out):
    for n in range(angles.shape[0]):
        axes = attitude(angles[n, 0], angles[n, 1], angles[n, 2]).axes
        for r in range(3):
            out[n, r, 0], out[n, r, 1], out[n, r, 2] = axes[r]


@kernel
def _write_turning(angles, rates, out):
    """Write the part of the angular accelerations (rad/s2, global) that depends on the rates alone."""
    for n in range(angles.shape[0]):
        orientation = attitude(angles[n, 0], angles[n, 1], angles[n, 2])
        out[n, 0], out[n, 1], out[n, 2] = spin_rate(
            orientation, (rates[n, 0], rates[n, 1], rates[n, 2]), (0.0, 0.0, 0.0)
        )
