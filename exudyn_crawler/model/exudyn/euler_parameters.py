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
    of_body = rate_matrix(e * -SIGNS) * SIGNS
    products = np.einsum("...ij,...kj->...ik", rate_matrix(e), of_body)
    return np.asarray(0.25 * products / np.sum(e**2, axis=-1)[..., None, None])


class BodyCoordinates:
    """Coordinates of bodies in both forms; others follow theirs, the same in both.

    `reference` (bodies, 6) are positions (m) and angles (rad) where the coordinates of a state are zero.
    """

    def __init__(self, reference: np.ndarray) -> None:
        self._reference = reference
        self._turned = reference[:, 3:].copy()

    def _split(self, values: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates of bodies (bodies, size), and the rest."""
        count = size * len(self._reference)
        return values[:count].reshape(-1, size), values[count:]

    def _parameters(self, q: np.ndarray) -> np.ndarray:
        return self._split(q, SIZE)[0][:, 3:] + UNTURNED

    def motion(self, q: np.ndarray, q_t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions and angles (bodies, 6) of Exudyn's coordinates, and their rates."""
        bodies, rates = self._split(q, SIZE)[0], self._split(q_t, SIZE)[0]
        e = bodies[:, 3:] + UNTURNED
        angles = rotations.angles_of(matrices_of(e))
        omega = np.einsum("nij,nj->ni", rate_matrix(e), rates[:, 3:])
        places = np.hstack((self._reference[:, :3] + bodies[:, :3], angles))
        return places, np.hstack((rates[:, :3], rotations.angle_rates(angles, omega)))

    def of_state(self, q: np.ndarray, q_t: np.ndarray, q_tt: np.ndarray) -> list[np.ndarray]:
        """Exudyn's coordinates, rates and accelerations of a state's."""
        bodies, rates, accelerations = (self._split(values, 6)[0] for values in (q, q_t, q_tt))
        angles = self._reference[:, 3:] + bodies[:, 3:]
        self._turned = angles
        e = np.asarray(Rotation.from_matrix(rotations.rotation_matrices(angles)).as_quat(scalar_first=True))
        back = 0.25 * rate_matrix(e)
        e_t = np.einsum("nij,ni->nj", back, rotations.angular_velocity(angles, rates[:, 3:]))
        alpha = rotations.angular_acceleration(angles, rates[:, 3:], accelerations[:, 3:])
        e_tt = np.einsum("nij,ni->nj", back, alpha) - np.sum(e_t**2, axis=1)[:, None] * e
        return [
            np.concatenate((np.hstack((own[:, :3], turned)).ravel(), self._split(values, 6)[1]))
            for own, turned, values in (
                (bodies, e - UNTURNED, q),
                (rates, e_t, q_t),
                (accelerations, e_tt, q_tt),
            )
        ]

    def to_state(self, q: np.ndarray, q_t: np.ndarray, q_tt: np.ndarray) -> list[np.ndarray]:
        """A state's coordinates, rates and accelerations of Exudyn's.

        Whole turns are those next to the state that was read or set last.
        """
        rates, accelerations = self._split(q_t, SIZE)[0], self._split(q_tt, SIZE)[0]
        e = self._parameters(q)
        G = rate_matrix(e)
        angles = rotations.angles_of(matrices_of(e))
        omega, alpha = (np.einsum("nij,nj->ni", G, values[:, 3:]) for values in (rates, accelerations))
        angles_t = rotations.angle_rates(angles, omega)
        angles_tt = rotations.angle_accelerations(angles, angles_t, alpha)
        turns = 2.0 * np.pi
        self._turned = angles + turns * np.round((self._turned - angles) / turns)
        own = (self._turned - self._reference[:, 3:], angles_t, angles_tt)
        return [
            np.concatenate((np.hstack((body[:, :3], turned)).ravel(), rest))
            for turned, (body, rest) in zip(
                own, (self._split(values, SIZE) for values in (q, q_t, q_tt)), strict=True
            )
        ]

    def generalized(self, q: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
        """Forces on Exudyn's coordinates of the bodies of wrenches (bodies, 6) about their origins."""
        turning = np.einsum("nij,ni->nj", rate_matrix(self._parameters(q)), wrenches[:, 3:])
        return np.hstack((wrenches[:, :3], turning)).ravel()

    def wrenches(self, q: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Forces (N) and moments about the origins (N m) of forces on Exudyn's coordinates: (bodies, 6)."""
        own = self._split(forces, SIZE)[0]
        moments = 0.25 * np.einsum("nij,nj->ni", rate_matrix(self._parameters(q)), own[:, 3:])
        return np.hstack((own[:, :3], moments))

    def forces_to_state(self, q: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Generalized forces on a state's coordinates of those on Exudyn's."""
        wrenches = self.wrenches(q, forces)
        angles = rotations.angles_of(matrices_of(self._parameters(q)))
        wrenches[:, 3:] = rotations.moments_on_angles(angles, wrenches[:, 3:])
        return np.concatenate((wrenches.ravel(), self._split(forces, SIZE)[1]))
