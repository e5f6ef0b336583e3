"""Between the coordinates of a state, with three angles a body, and Exudyn's, with four Euler parameters.

Exudyn's `NodeRigidBodyEP` has the displacement of a body's origin and Euler parameters e; no attitude is
singular. With ``omega = G(e) e'`` and ``G G^T = 4`` go ``e' = G^T omega / 4`` and
``e'' = G^T alpha / 4 - (e' . e') e`` (Nikravesh, Computer-Aided Analysis of Mechanical Systems, 1988, ch. 6).
"""

import numpy as np
from scipy.spatial.transform import Rotation

from exudyn_crawler.ground import rotations

UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])
"""Euler parameters of reference of every body."""
SIGNS = np.array([-1.0, 1.0, 1.0, 1.0])
SIZE = 7
"""Coordinates of a body: displacement and Euler parameters."""


def rate_matrix(e: np.ndarray) -> np.ndarray:
    """G of Euler parameters (..., 4), which makes global angular velocities of their rates: (..., 3, 4)."""
    e0, e1, e2, e3 = np.moveaxis(e, -1, 0)
    rows = ((-e1, e0, -e3, e2), (-e2, e3, e0, -e1), (-e3, -e2, e1, e0))
    return 2.0 * np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def matrices_of(e: np.ndarray) -> np.ndarray:
    """Rotation matrices of Euler parameters (..., 4) of any norm: array (..., 3, 3).

    ``R = G Gb^T / 4`` with Gb, which makes angular velocities in body components (Nikravesh, ch. 6).
    """
    # forces that are no numbers bring parameters to zero, which scipy refuses
    of_body = rate_matrix(e * -SIGNS) * SIGNS
    products = np.einsum("...ij,...kj->...ik", rate_matrix(e), of_body)
    return np.asarray(0.25 * products / np.sum(e**2, axis=-1)[..., None, None])


class BodyCoordinates:
    """Coordinates of bodies in both forms, and forces on them; others follow theirs, the same in both.

    `reference` (bodies, 6) are positions (m) and angles (rad) where the coordinates of a state are zero.
    """

    def __init__(self, reference: np.ndarray) -> None:
        self._reference = reference
        self._turned = reference[:, 3:].copy()

    def _split(self, values: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """First three numbers of every body, its others, and what follows the bodies."""
        count = size * len(self._reference)
        bodies = values[:count].reshape(-1, size)
        return bodies[:, :3], bodies[:, 3:], values[count:]

    def _turn(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """G (bodies, 3, 4), and angles (bodies, 3), at Exudyn's coordinates."""
        e = self._split(q, SIZE)[1] + UNTURNED
        return rate_matrix(e), rotations.angles_of(matrices_of(e))

    def of_state(self, q: np.ndarray, q_t: np.ndarray, q_tt: np.ndarray) -> list[np.ndarray]:
        """Exudyn's coordinates, rates and accelerations of a state's."""
        split = [self._split(values, 6) for values in (q, q_t, q_tt)]
        angles, rates, accelerations = (turned for _, turned, _ in split)
        self._turned = angles = self._reference[:, 3:] + angles
        e = np.asarray(Rotation.from_matrix(rotations.rotation_matrices(angles)).as_quat(scalar_first=True))
        G = rate_matrix(e)
        e_t = 0.25 * np.einsum("nij,ni->nj", G, rotations.angular_velocity(angles, rates))
        alpha = rotations.angular_acceleration(angles, rates, accelerations)
        e_tt = 0.25 * np.einsum("nij,ni->nj", G, alpha) - np.sum(e_t**2, axis=1)[:, None] * e
        return [_joined(*one) for one in zip(split, (e - UNTURNED, e_t, e_tt), strict=True)]

    def to_state(self, q: np.ndarray, *rates: np.ndarray) -> list[np.ndarray]:
        """A state's coordinates, rates and, where these are given, accelerations of Exudyn's.

        Whole turns are those next to the state that was read or set last.
        """
        split = [self._split(values, SIZE) for values in (q, *rates)]
        G, angles = self._turn(q)
        spins = [np.einsum("nij,nj->ni", G, turned) for _, turned, _ in split[1:]]
        turned = [rotations.angle_rates(angles, spins[0])]
        if len(spins) > 1:
            turned.append(rotations.angle_accelerations(angles, turned[0], spins[1]))
        turns = 2.0 * np.pi
        self._turned = angles + turns * np.round((self._turned - angles) / turns)
        turned.insert(0, self._turned - self._reference[:, 3:])
        return [_joined(*one) for one in zip(split, turned, strict=True)]

    def forces_of_state(self, q: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Generalized forces on Exudyn's coordinates of those on a state's."""
        (G, angles), split = self._turn(q), self._split(forces, 6)
        return _joined(split, np.einsum("nij,ni->nj", G, rotations.moments_of(angles, split[1])))

    def wrenches(self, q: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Forces (N) and moments about the origins (N m) of forces on Exudyn's coordinates: (bodies, 6)."""
        pushes, turning, _ = self._split(forces, SIZE)
        return np.hstack((pushes, 0.25 * np.einsum("nij,nj->ni", self._turn(q)[0], turning)))

    def forces_to_state(self, q: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Generalized forces on a state's coordinates of those on Exudyn's."""
        turning = rotations.moments_on_angles(self._turn(q)[1], self.wrenches(q, forces)[:, 3:])
        return _joined(self._split(forces, SIZE), turning)


def _joined(split: tuple[np.ndarray, np.ndarray, np.ndarray], turned: np.ndarray) -> np.ndarray:
    """Coordinates of which those that turn the bodies are replaced."""
    return np.concatenate((np.hstack((split[0], turned)).ravel(), split[2]))
