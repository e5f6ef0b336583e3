"""Rotations by the successive angles about x, y, z that the shoes' coordinates hold.

``R = Rx(a) Ry(b) Rz(c)`` turns body components into global ones (Exudyn's `NodeRigidBodyRxyz`,
Tait-Bryan angles). The angles are singular at b = 90 degrees, which a shoe on the ground never nears.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@njit(cache=True)
def rotation_matrix(angles: FloatArray, out: FloatArray) -> None:
    """Write ``Rx(a) Ry(b) Rz(c)`` into `out` (3, 3)."""
    ca, sa = np.cos(angles[0]), np.sin(angles[0])
    cb, sb = np.cos(angles[1]), np.sin(angles[1])
    cc, sc = np.cos(angles[2]), np.sin(angles[2])
    out[0, 0] = cb * cc
    out[0, 1] = -cb * sc
    out[0, 2] = sb
    out[1, 0] = ca * sc + sa * sb * cc
    out[1, 1] = ca * cc - sa * sb * sc
    out[1, 2] = -sa * cb
    out[2, 0] = sa * sc - ca * sb * cc
    out[2, 1] = sa * cc + ca * sb * sc
    out[2, 2] = ca * cb


@njit(cache=True)
def rate_matrix(angles: FloatArray, out: FloatArray) -> None:
    """Write G (3, 3) with ``omega = G @ angle_rates`` in global components into `out`."""
    ca, sa = np.cos(angles[0]), np.sin(angles[0])
    cb, sb = np.cos(angles[1]), np.sin(angles[1])
    out[0, 0] = 1.0
    out[0, 1] = 0.0
    out[0, 2] = sb
    out[1, 0] = 0.0
    out[1, 1] = ca
    out[1, 2] = -sa * cb
    out[2, 0] = 0.0
    out[2, 1] = sa
    out[2, 2] = ca * cb


def angular_velocity(angles: FloatArray, rates: FloatArray) -> FloatArray:
    """Angular velocities in global components: array (..., 3), rad/s."""
    sa, ca = np.sin(angles[..., 0]), np.cos(angles[..., 0])
    sb, cb = np.sin(angles[..., 1]), np.cos(angles[..., 1])
    a, b, c = rates[..., 0], rates[..., 1], rates[..., 2]
    return np.stack((a + sb * c, ca * b - sa * cb * c, sa * b + ca * cb * c), axis=-1)


def angular_acceleration(angles: FloatArray, rates: FloatArray, accelerations: FloatArray) -> FloatArray:
    """Angular accelerations in global components: array (..., 3), rad/s2.

    `rates` and `accelerations` are the first and second derivatives of the angles.
    """
    sa, ca = np.sin(angles[..., 0]), np.cos(angles[..., 0])
    sb, cb = np.sin(angles[..., 1]), np.cos(angles[..., 1])
    a, b, c = rates[..., 0], rates[..., 1], rates[..., 2]
    convective = np.stack(
        (
            cb * b * c,
            -sa * a * b - ca * cb * a * c + sa * sb * b * c,
            ca * a * b - sa * cb * a * c - ca * sb * b * c,
        ),
        axis=-1,
    )
    return angular_velocity(angles, accelerations) + convective


def rotation_matrices(angles: FloatArray) -> FloatArray:
    """``Rx(a) Ry(b) Rz(c)`` of many angles (..., 3): array (..., 3, 3)."""
    flat = np.ascontiguousarray(angles).reshape(-1, 3)
    out = np.empty((len(flat), 3, 3))
    for one, matrix in zip(flat, out, strict=True):
        rotation_matrix(one, matrix)
    return out.reshape(*angles.shape[:-1], 3, 3)
