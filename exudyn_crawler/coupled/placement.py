"""Placement of a case's frame of reference in that of a user's model."""

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np


class Placement:
    """Frame of a case in a user's model: a position and a heading.

    `position` (3,) is that of the case's origin, m; `heading` is that of its x axis, rad, positive to the
    left.
    """

    def __init__(self, position: np.ndarray, heading: float) -> None:
        self.position = position
        c, s = math.cos(heading), math.sin(heading)
        self.turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    @cached_property
    def of_wrench(self) -> np.ndarray:
        """Matrix (6, 6) that turns force and moment of the case's frame into those of the user's."""
        return np.kron(np.eye(2), self.turn)

    def pose(self, pose: "Pose") -> "Pose":
        """Return a pose in the case's frame as one in the user's."""
        return Pose(self.position + self.turn @ pose.position, self.turn @ pose.axes)

    def own_pose(self, pose: "Pose") -> "Pose":
        """Return a pose in the user's frame as one in the case's."""
        return Pose(self.turn.T @ (pose.position - self.position), self.turn.T @ pose.axes)


class Pose(NamedTuple):
    """Position (3,), m, and rotation matrix (3, 3) of a body."""

    position: np.ndarray
    axes: np.ndarray

    def gap(self, other: "Pose") -> np.ndarray:
        """Return the displacement (m) and the small rotation (rad) from another pose to this one: (6,)."""
        turn = self.axes @ other.axes.T
        spin = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        return np.concatenate((self.position - other.position, spin))
