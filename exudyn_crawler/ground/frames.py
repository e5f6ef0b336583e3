"""Frames of bodies and their vectors; nothing here knows coordinates.

Vectors are tuples of three numbers and matrices tuples of three rows, all in global components. Compiled code
keeps tuples in registers; arrays would be allocated and their references counted.
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.packed import FloatArray

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

FACING = 0.2
"""Cosine of a shoe's tilt below which its underside meets no ground: the shoe is on a tumbler, an idler or
the upper run."""


class Frame(NamedTuple):
    """Pose and motion of a rigid body: position r (m), rotation R, velocity v (m/s), omega (rad/s).

    The columns of R are the body's axes; all is in global components.
    """

    r: Vector
    R: Matrix
    v: Vector
    omega: Vector


@kernel
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def along(a: Vector, factor: float, b: Vector) -> Vector:
    """Return ``a + factor * b``."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@kernel
def scaled(factor: float, a: Vector) -> Vector:
    """Return ``factor * a``."""
    return factor * a[0], factor * a[1], factor * a[2]


@kernel
def basis(k: int) -> Vector:
    """Return the unit vector along axis k."""
    return 1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0


@kernel
def norm(a: Vector) -> float:
    """Return the length of a vector."""
    return math.sqrt(dot(a, a))


@kernel
def turned(R: Matrix, a: Vector) -> Vector:
    """Return ``R a``: the global components of a vector given in a body's frame."""
    return dot(R[0], a), dot(R[1], a), dot(R[2], a)


@kernel
def upward(R: Matrix) -> Vector:
    """Return the axis z of a body, global."""
    return R[0][2], R[1][2], R[2][2]


@kernel
def turned_back(R: Matrix, a: Vector) -> Vector:
    """Return ``R^T a``: the components of a global vector in a body's frame."""
    return (
        R[0][0] * a[0] + R[1][0] * a[1] + R[2][0] * a[2],
        R[0][1] * a[0] + R[1][1] * a[1] + R[2][1] * a[2],
        R[0][2] * a[0] + R[1][2] * a[1] + R[2][2] * a[2],
    )


@inner
def write_turned_rows(R: Matrix, rows: FloatArray, count: int, factor: float, out: FloatArray) -> None:
    """Write the first `count` columns of rows (3, m) in global components, times a factor.

    The rows are given in a body's axes; they are written behind six other columns.
    """
    for r in range(3):
        x, y, z = R[r]
        for k in range(count):
            out[r, 6 + k] = factor * (x * rows[0, k] + y * rows[1, k] + z * rows[2, k])


@kernel
def velocity_at(body: Frame, place: Vector) -> Vector:
    """Return the velocity (m/s) of a body's point at a location (m, global)."""
    return along(body.v, 1.0, cross(body.omega, along(place, -1.0, body.r)))
