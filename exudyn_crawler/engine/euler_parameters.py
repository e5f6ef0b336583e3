"""Conversion between a state's coordinates, with three angles a body, and Exudyn's, with Euler parameters.

Exudyn's `NodeRigidBodyEP` has the displacement of a body's origin and Euler parameters e; no attitude is
singular. Here ``omega = G(e) e'`` and ``G G^T = 4``. The rates of e are ``e' = G^T omega / 4`` and ``e'' =
G^T alpha / 4 - (e' . e') e`` (Nikravesh, Computer-Aided Analysis of Mechanical Systems, 1988, ch. 6).
"""

import numpy as np
from scipy.spatial.transform import Rotation

from exudyn_crawler.ground import rotations
from exudyn_crawler.model.exudyn import EulerParameters2G, EulerParameters2RotationMatrix

UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])
"""Reference Euler parameters of every body."""
SIZE = 7
"""Number of coordinates of a body: displacement and Euler parameters."""


class BodyCoordinates:
    """Coordinates of bodies in both forms, and forces on them; further coordinates are the same in both.

    Exudyn's begin with those of all bodies. In a state bodies may have their coordinates anywhere.
    `reference` (bodies, 6) has the positions (m) and angles (rad) at zero coordinates of a state,
    `coordinate` (bodies,) the number of every body's first coordinate in a state, and `size` is the number of
    the state's coordinates.
    """

    def __init__(self, reference: np.ndarray, coordinate: np.ndarray, size: int) -> None:
        self._reference = reference[:, 3:]
        self._turned = self._reference
        of_bodies = (coordinate[:, None] + np.arange(6)).ravel()
        # numbers of a state's coordinates, those of all bodies first
        self._order = np.concatenate((of_bodies, np.setdiff1d(np.arange(size), of_bodies)))

    def _split(self, values: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the first three numbers of every body, its others, and the numbers after the bodies."""
        count = size * len(self._reference)
        bodies = values[:count].reshape(-1, size)
        return bodies[:, :3], bodies[:, 3:], values[count:]

    def _split_state(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the same numbers of a state."""
        return self._split(values[self._order], 6)

    def _as_state(self, split: tuple[np.ndarray, np.ndarray, np.ndarray], turned: np.ndarray) -> np.ndarray:
        """Return numbers in the order of a state, with those of the bodies' rotation replaced."""
        out = np.empty(len(self._order))
        out[self._order] = _joined(split, turned)
        return out

    def _turn(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return G (3, 4, bodies), and angles (bodies, 3), at Exudyn's coordinates."""
        e = (self._split(q, SIZE)[1] + UNTURNED).T
        return EulerParameters2G(e), rotations.angles_of(EulerParameters2RotationMatrix(e).transpose(2, 0, 1))

    def of_state(self, q: np.ndarray, q_t: np.ndarray, q_tt: np.ndarray) -> list[np.ndarray]:
        """Return Exudyn's coordinates, rates and accelerations from those of a state."""
        split = [self._split_state(values) for values in (q, q_t, q_tt)]
        angles, rates, accelerations = (turned for _, turned, _ in split)
        angles = self._reference + angles
        self._turned = angles
        e = np.asarray(Rotation.from_matrix(rotations.rotation_matrices(angles)).as_quat(scalar_first=True))
        G = EulerParameters2G(e.T)
        e_t = 0.25 * np.einsum("ijn,ni->nj", G, rotations.angular_velocity(angles, rates))
        alpha = rotations.angular_acceleration(angles, rates, accelerations)
        e_tt = 0.25 * np.einsum("ijn,ni->nj", G, alpha) - np.sum(e_t**2, axis=1)[:, None] * e
        return [_joined(*parts) for parts in zip(split, (e - UNTURNED, e_t, e_tt), strict=True)]

    def to_state(self, q: np.ndarray, *rates: np.ndarray) -> list[np.ndarray]:
        """Return a state's coordinates, rates and, if given, accelerations from those of Exudyn.

        Angles have the whole turns nearest to the state that was read or set last.
        """
        split = [self._split(values, SIZE) for values in (q, *rates)]
        G, angles = self._turn(q)
        spin, *changes = (np.einsum("ijn,nj->ni", G, turned) for _, turned, _ in split[1:])
        self._turned = np.unwrap(np.stack((self._turned, angles)), axis=0)[1]
        turned = [self._turned - self._reference, rotations.angle_rates(angles, spin)]
        turned += [rotations.angle_accelerations(angles, turned[1], change) for change in changes]
        return [self._as_state(*parts) for parts in zip(split, turned, strict=True)]

    def forces_of_state(self, q: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Return the generalized forces on Exudyn's coordinates from those on a state's."""
        G, angles = self._turn(q)
        split = self._split_state(forces)
        return _joined(split, np.einsum("ijn,ni->nj", G, rotations.moments_of(angles, split[1])))

    def wrenches(self, q: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Return bodies' forces (N) and moments about origins (N m) from forces on Exudyn's coordinates.

        The array has six numbers a body, then the forces on the other coordinates.
        """
        G, _ = self._turn(q)
        split = self._split(forces, SIZE)
        return self._as_state(split, 0.25 * np.einsum("ijn,nj->ni", G, split[1]))

    def motions(self, q: np.ndarray) -> np.ndarray:
        """Return the factors from rates of Exudyn's coordinates to those of a state's: dense array."""
        G, angles = self._turn(q)
        bodies = len(angles)
        count = len(self._order)
        factors = np.zeros((count, count + bodies))
        by_parameters = rotations.angle_rates(
            np.repeat(angles[:, None], 4, axis=1), np.ascontiguousarray(G.transpose(2, 1, 0))
        )
        for b in range(bodies):
            rows = self._order[6 * b : 6 * b + 6]
            factors[rows[:3], SIZE * b + np.arange(3)] = 1.0
            factors[rows[3:, None], SIZE * b + np.arange(3, SIZE)] = by_parameters[b].T
        factors[self._order[6 * bodies :], np.arange(SIZE * bodies, count + bodies)] = 1.0
        return factors


def _joined(split: tuple[np.ndarray, np.ndarray, np.ndarray], turned: np.ndarray) -> np.ndarray:
    """Return coordinates with those of the bodies' rotation replaced."""
    return np.concatenate((np.hstack((split[0], turned)).ravel(), split[2]))
