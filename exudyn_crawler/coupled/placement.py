"""Placement of a case's frame of reference in that of a user's model, and poses in both."""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import kernel
from exudyn_crawler.ground.packed import FloatArray
from exudyn_crawler.ground.rotations import attitude


class Pose(NamedTuple):
    """Position (3,), m, and rotation matrix (3, 3) of a body."""

    position: np.ndarray
    axes: np.ndarray


class Placement:
    """Frame of a case in a user's model: a position and a heading.

    `position` (3,) is that of the case's origin, m; `heading` is the direction of its x axis, rad, positive
    to the left. `turn` (3, 3) turns vectors of the case's frame into the user's, `of_wrench` (6, 6) forces
    with moments.
    """

    def __init__(self, position: np.ndarray, heading: float) -> None:
        self.position = position
        c, s = math.cos(heading), math.sin(heading)
        self.turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        self.of_wrench = np.kron(np.eye(2), self.turn)

    def pose(self, pose: Pose) -> Pose:
        """Return a pose in the case's frame as one in the user's."""
        return Pose(self.position + self.turn @ pose.position, self.turn @ pose.axes)


@kernel
def write_gap(
    user: FloatArray, own: FloatArray, position: FloatArray, turn: FloatArray, out: FloatArray
) -> None:
    """Write the gap (6,) from a body of a case to one of the user's model, in the user's frame, m and rad.

    `user` (7,) are position and Euler parameters, `own` (6,) position and angles in the case's frame;
    `position` and `turn` are those of the case's `Placement`. The rotation is that of small gaps.
    """
    a, b, c, d = user[3], user[4], user[5], user[6]
    axes = (
        (a * a + b * b - c * c - d * d, 2.0 * (b * c - a * d), 2.0 * (b * d + a * c)),
        (2.0 * (b * c + a * d), a * a - b * b + c * c - d * d, 2.0 * (c * d - a * b)),
        (2.0 * (b * d - a * c), 2.0 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    R = attitude(own[3], own[4], own[5]).R
    for k in range(6):
        out[k] = 0.0
    for i in range(3):
        out[i] = user[i] - position[i]
        for j in range(3):
            out[i] -= turn[i, j] * own[j]
    # half of the vector of the antisymmetric part of the rotation from one to the other
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        for m in range(3):
            other_i = turn[i, 0] * R[0][m] + turn[i, 1] * R[1][m] + turn[i, 2] * R[2][m]
            other_j = turn[j, 0] * R[0][m] + turn[j, 1] * R[1][m] + turn[j, 2] * R[2][m]
            out[3 + k] += 0.5 * (axes[j][m] * other_i - axes[i][m] * other_j)
