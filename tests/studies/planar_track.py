"""The track in its middle plane on rigid even ground, by hand: minimal coordinates, no engine, no kernel.

Coordinates are the height of the front shoe's COM and the pitch of every shoe; the front shoe's x is given.
A positive pitch lowers a shoe's front. All shoes slide forward faster than friction changes with speed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from exudyn_crawler import Case
from exudyn_crawler.case import statics

STEP = 1e-6


def by_difference(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    """Central differences by every argument, a column each."""
    changes = STEP * np.eye(len(at))
    return np.column_stack([(function(at + e) - function(at - e)) / (2.0 * STEP) for e in changes])


@dataclass
class PlanarTrack:
    """Track of a case; `portion` is that of friction which acts."""

    case: Case
    portion: float = 1.0

    @property
    def count(self) -> int:
        """Number of shoes."""
        return self.case.track.shoe_count

    @cached_property
    def load(self) -> float:
        """Machine load on every shoe at t = 0, N."""
        return float(self.case.loads.loads(0.0)[0, 0])

    def places(self, y: np.ndarray) -> np.ndarray:
        """x, z and pitch of the shoes (shoes, 3), the front shoe's x being zero."""
        track, pitch = self.case.track, y[1:]
        ahead, behind, up = track.pin_ahead, track.pitch - track.pin_ahead, track.pin_height
        out = np.column_stack((np.zeros_like(pitch), np.full_like(pitch, y[0]), pitch))
        s, c = np.sin(pitch), np.cos(pitch)
        for k in range(self.count - 2, -1, -1):
            pin_x = out[k + 1, 0] - behind * c[k + 1] + up * s[k + 1]
            pin_z = out[k + 1, 1] + behind * s[k + 1] + up * c[k + 1]
            out[k, 0] = pin_x - ahead * c[k] - up * s[k]
            out[k, 1] = pin_z + ahead * s[k] - up * c[k]
        return out

    def directions(self, y: np.ndarray) -> np.ndarray:
        """Derivative of the places, flat, by the coordinates."""
        track, pitch = self.case.track, y[1:]
        ahead, behind, up = track.pin_ahead, track.pitch - track.pin_ahead, track.pin_height
        s, c = np.sin(pitch), np.cos(pitch)
        out = np.zeros((self.count, 3, len(y)))
        out[:, 1, 0] = 1.0
        for k in range(self.count):
            out[k, 2, 1 + k] = 1.0
            # the shoe itself moves about its front pin, all behind it with its rear pin
            out[: k + 1, :2, 1 + k] = ahead * s[k] - up * c[k], ahead * c[k] + up * s[k]
            out[:k, :2, 1 + k] += behind * s[k] + up * c[k], behind * c[k] - up * s[k]
        # the front shoe is led by its COM
        front = out[-1, :2, -1].copy()
        out[:, :2, -1] -= front
        return out.reshape(-1, len(y))

    def forces(self, y: np.ndarray, y_t: np.ndarray) -> np.ndarray:
        """Generalized forces of ground, weight and load."""
        directions = self.directions(y)
        rates = (directions @ y_t).reshape(-1, 3)
        wrenches = [self.wrench(place, rate) for place, rate in zip(self.places(y), rates, strict=True)]
        return directions.T @ np.ravel(wrenches)

    def balance(self, y: np.ndarray) -> np.ndarray:
        """Generalized forces while all shoes only slide."""
        return self.forces(y, np.zeros_like(y))

    def wrench(self, place: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Force along x and z and pitching moment about the COM of one shoe."""
        shoe, law = self.case.shoe, self.case.contact
        s, c = np.sin(place[2]), np.cos(place[2])
        half, below = 0.5 * shoe.length, -shoe.com_height
        ends = np.array([c * -half + s * below, c * half + s * below])
        depths = -(place[1] + np.array([s * half + c * below, -s * half + c * below]))
        assert depths.min() > 0.0, "the trapezoid has lifted off"
        mean, fall = depths.mean(), depths[1] - depths[0]
        length = ends[1] - ends[0]
        x = ends.mean() + length * fall / (12.0 * mean)
        depth = mean + fall**2 / (12.0 * mean)
        z = -0.5 * depth - place[1]
        sinking = -(rate[1] - rate[2] * x)
        normal = law.stiffness * depth**law.exponent + law.damping * sinking
        friction = -self.portion * law.dynamic_friction * normal
        lifting = normal - self.load - shoe.mass * self.case.gravity
        moment = z * friction - x * normal + s * shoe.load_point[2] * self.load
        return np.array([friction, lifting, moment])

    def steady(self) -> np.ndarray:
        """Coordinates of steady sliding, by Newton's method as friction grows to its value."""
        y = np.zeros(1 + self.count)
        y[0] = self.case.shoe.com_height - statics.settled_penetration(self.case)
        for portion in np.linspace(0.0, 1.0, 11):
            forces = PlanarTrack(self.case, portion).balance
            for _ in range(6):
                y = y - np.linalg.solve(by_difference(forces, y), forces(y))
        assert np.abs(self.balance(y)).max() < 1e-3
        return y

    def eigenvalues(self) -> np.ndarray:
        """About steady sliding, those with a positive imaginary part, 1/s."""
        y, shoe = self.steady(), self.case.shoe
        still, n = np.zeros_like(y), len(y)
        directions = self.directions(y)
        inertia = np.tile([shoe.mass, shoe.mass, shoe.inertia[1]], self.count)
        by_y = by_difference(self.balance, y)
        by_rate = by_difference(lambda y_t: self.forces(y, y_t), still)
        below = np.linalg.solve(directions.T @ (inertia[:, None] * directions), np.hstack((by_y, by_rate)))
        values = np.linalg.eigvals(np.vstack((np.eye(n, 2 * n, n), below)))
        return values[values.imag > 1e-6]
