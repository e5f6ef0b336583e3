"""Shoes on cells, moved by hand or by loads."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exudyn_crawler.case.parameters.heights import Heights
from exudyn_crawler.ground.cells.ground import CellGround
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.ground.cells.layouts import TRIAL

LENGTH, WIDTH, LOAD, MASS = 0.65, 3.505, 435e3, 4490.0
AREA = LENGTH * WIDTH
SAND = BekkerSoil.lete_sand()
ROCK = RockFloor.hard_floor()
BOTH_LAWS = pytest.mark.parametrize("law", [SAND, ROCK], ids=["sand", "rock"])
DOWN = np.array([0.0, 0.0, -LOAD, 0.0, 0.0, 0.0])


def turn(vector):
    """Rotation by a vector, rad."""
    return Rotation.from_rotvec(vector).as_matrix()


def frame(r, R=None, v=(0, 0, 0), omega=(0, 0, 0)):
    """Numbers of a frame: array (1, 18)."""
    return np.concatenate((r, np.ravel(np.eye(3) if R is None else R), v, omega)).astype(float)[None]


def ground(law, heights=None, cell=0.1, sides=(LENGTH, WIDTH), shoes=1, **parts):
    """Cells under shoes whose frames are in the middle of their undersides."""
    a, b = 0.5 * sides[0], 0.5 * sides[1]
    corners = [[-a, -b, 0], [a, -b, 0], [a, b, 0], [-a, b, 0]]
    return CellGround(law, heights or Heights(), cell, corners, shoes, **parts)


def step(cells, now, before):
    """Wrenches of an accepted step that ends at frames `now`."""
    cells.cover(now, before)
    wrenches = cells.press(now).copy()
    cells.commit()
    return wrenches


def points_of(cells):
    """Points (count, POINT) of the first shoe, with the numbers of one in a row."""
    return np.hstack(list(cells.shoes.points[0])).T[: cells.shoes.counts[0]]


class Shoe:
    """One shoe on cells of its own."""

    def __init__(self, law, r, R=None, **how):
        self.ground = ground(law, **how)
        self.r, self.R = np.array(r, float), np.eye(3) if R is None else R

    @property
    def tangent(self):
        """Of the last press."""
        return self.ground.shoes.tangent[0]

    @property
    def points(self):
        """Of the shoe (points, POINT)."""
        return points_of(self.ground)

    @property
    def force(self):
        """At the points."""
        return self.ground.shoes.force[0, : self.ground.shoes.counts[0]]

    @property
    def traction(self):
        """Normal one at the points."""
        return self.ground.shoes.trial[0, : self.ground.shoes.counts[0], TRIAL.traction]

    def cover(self, r=None, R=None):
        """Freeze the points for a step that ends here."""
        now = frame(self.r if r is None else r, self.R if R is None else R)
        self.ground.cover(now, frame(self.r, self.R))

    def press(self, r, R=None, v=(0, 0, 0), omega=(0, 0, 0), weights=(0.0, 0.0)):
        """Wrench at a frame."""
        return self.ground.press(frame(r, self.R if R is None else R, v, omega), weights)[0].copy()

    def accept(self, r, R=None):
        """Accept a step that ended here."""
        self.ground.commit()
        self.r, self.R = np.array(r, float), self.R if R is None else R

    def move(self, r, R=None):
        """Prescribed end of a step, accepted; the wrench."""
        self.cover(r, R)
        wrench = self.press(r, R)
        self.accept(r, R)
        return wrench

    def settle(self, load, steps=40, tolerance=1e-3):
        """Static equilibrium under a wrench, loaded in accepted steps; Newton's iterations."""
        total = 0
        for k in range(1, steps + 1):
            goal, r, R = np.asarray(load) * k / steps, self.r.copy(), self.R.copy()
            self.cover()
            for iteration in range(100):
                rest = self.press(r, R, weights=(1.0, 0.0)) + goal
                if np.abs(rest).max() < tolerance:
                    break
                total += 1
                change = np.linalg.solve(1e3 * np.eye(6) - self.tangent, rest)
                change *= min(1.0, 5e-3 * 0.9 ** max(0, iteration - 20) / np.abs(change).max())
                r, R = r + change[:3], turn(change[3:]) @ R
            else:
                raise AssertionError(f"no equilibrium: {rest}")
            self.accept(r, R)
        return total


class Driven(Shoe):
    """One free shoe in time: generalized-alpha, Newton's method with the kernel's tangents."""

    def __init__(self, law, r, R=None, h=2e-3, mass=MASS, rho=0.8, **how):
        super().__init__(law, r, R, **how)
        self.h, self.mass = h, mass
        self.inertia = mass / 12 * np.diag([WIDTH**2 + 0.3**2, LENGTH**2 + 0.3**2, LENGTH**2 + WIDTH**2])
        self.alpha_m, self.alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
        self.gamma = 0.5 + self.alpha_f - self.alpha_m
        self.beta = 0.25 * (self.gamma + 0.5) ** 2
        self.v, self.a, self.dv = np.zeros(6), np.zeros(6), np.zeros(6)
        self.iterations, self.time = [], 0.0

    def kinetic_energy(self):
        """Kinetic energy, J."""
        v, w = self.v[:3], self.v[3:]
        return 0.5 * self.mass * v @ v + 0.5 * w @ self.R @ self.inertia @ self.R.T @ w

    def step(self, load, servo=(0.0, 0.0), tolerance=1.0, most=25):
        """One step under a load at its end; `servo` (N s/m, m/s) drives along x."""
        h, beta, gamma, am, af = self.h, self.beta, self.gamma, self.alpha_m, self.alpha_f
        by_a, by_v = (1 - am) / (h * h * beta * (1 - af)), gamma / (h * beta)
        before = (af * self.dv - am * self.a) / (1 - am)
        d = h * self.v + h * h * ((0.5 - beta) * self.a + beta * before)
        v = self.v + h * ((1 - gamma) * self.a + gamma * before)
        dv = np.zeros(6)
        if h > 0.02:  # a long step starts where the last one ended: a predicted shoe would hang in the air
            d, v, dv = np.zeros(6), v - by_v * d, dv - by_a * d
        self.cover(self.r + d[:3], turn(d[3:]) @ self.R)
        iterations = 0
        for _ in range(most):
            r, R = self.r + d[:3], turn(d[3:]) @ self.R
            wrench = self.press(r, R, v[:3], v[3:], (1.0, by_v))
            J, w = R @ self.inertia @ R.T, v[3:]
            rest = np.r_[self.mass * dv[:3], J @ dv[3:] + np.cross(w, J @ w)] - wrench - load
            rest[0] -= servo[0] * (servo[1] - v[0])
            if np.abs(rest).max() < tolerance:
                break
            matrix = -self.tangent
            matrix[:3, :3] += by_a * self.mass * np.eye(3)
            matrix[3:, 3:] += by_a * J
            matrix[0, 0] += servo[0] * by_v
            change = np.linalg.solve(matrix, -rest)
            iterations += 1
            d, v, dv = d + change, v + by_v * change, dv + by_a * change
        else:
            raise AssertionError(f"Newton's method failed at {self.time:.3f} s: {rest}")
        self.iterations.append(iterations)
        self.accept(r, R)
        self.a, self.dv, self.v = before + (1 - af) / (1 - am) * dv, dv, v
        self.time += h
