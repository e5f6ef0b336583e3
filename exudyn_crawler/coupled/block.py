"""Equations of a machine in a coupled step: Newton's method in two halves, with a wrench between them.

`reduce` eliminates all unknowns but those of the last front, which has the car body: the place of the car
body is then a linear function of the wrench that the user's model exerts on it (`place_with`). `CoupledStep`
finds this wrench, and `advance` computes all unknowns with it. Both halves together are an iteration of
`model.newton`.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.coupled.commands import Commands
from exudyn_crawler.coupled.placement import Placement, Pose
from exudyn_crawler.coupled.rest import Rest
from exudyn_crawler.ground.rotations import angular_velocity, attitude, rotation_matrices
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model import elimination, equations, newton
from exudyn_crawler.model.compiled_system import KEEPS_MATRIX
from exudyn_crawler.model.diagnostics import NewtonError
from exudyn_crawler.model.inputs import Inputs

STATE, WRENCH = "state", "wrench"
"""Names of a stored track's arrays beside its commands and the memory of its ground."""


class Step(NamedTuple):
    """Step of generalized-alpha (Arnold and Bruels, Multibody System Dynamics 18, 2007, algorithm 1)."""

    start: float  # s
    size: float  # s
    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float

    @property
    def end(self) -> float:
        """Time of its end, s."""
        return self.start + self.size

    @property
    def weights(self) -> Weights:
        """Changes of rates and accelerations with the coordinates."""
        h = self.size
        return Weights(
            1.0,
            self.gamma / (h * self.beta),
            (1.0 - self.alpha_m) / ((1.0 - self.alpha_f) * self.beta * h * h),
            False,
            self.beta * h / self.gamma,
        )


class TrackBlock:
    """State and equations of a track whose car body a user's model loads.

    `wrench` (6,) are force and moment of the user's model on the car body about its origin, N and N m, in the
    case's frame. `response` (6, 6) is the change, per unit of it, of what the factored matrix solves for: in
    a step the car body's coordinates, after `accelerate` its accelerations. `turning` (6, 6) is the change of
    its pose by its coordinates. `iterations` and `matrices` count those of all accepted steps; `has_moved` is
    true after the first one.
    """

    def __init__(self, rest: Rest, placement: Placement) -> None:
        self.system = rest.system
        self.placement = placement
        self.iterations = self.matrices = 0
        self.has_moved = False
        tables = self.system.tables
        first = int(tables.bodies.coordinate[rest.frame])
        self._frame = slice(first, first + 6)
        self._reference = tables.bodies.reference[rest.frame]
        fronts = tables.fronts
        self._last_front = len(fronts.pivots) - 1
        self._own = np.array(fronts.rows(self._last_front))  # unknowns of the last front
        self._keeps_matrix = self.system.case.terrain.model in KEEPS_MATRIX[self.system.case.gear.kind]
        self._change = np.zeros_like(self.system.scratch[0])
        self.wrench = rest.wrench.copy()
        self.commands = Commands(self.system)
        self._take_over()

    def _take_over(self) -> None:
        """Start from the state of the system."""
        self.state = self._accepted = self.system.motion
        self.multipliers = self._accepted_multipliers = self.system.multipliers.copy()
        self._accepted_wrench = self.wrench
        self._before = 0.0, self.wrench  # size of the last step, and the wrench at its start
        self._algorithmic = self.state[2].copy()
        self._factored: Weights | None = None  # weights of the factored matrix that the next step begins with

    def accelerate(self, time: float, wrench: np.ndarray) -> np.ndarray:
        """Compute the initial accelerations with a wrench (6,) of the user's model.

        Return those of the car body, linear and angular, in the case's frame: array (6,). `response` is then
        that of the accelerations.
        """
        self.wrench = wrench
        self.system.accelerate(self._loaded(self.commands.applied(self.system.inputs(time))))
        self._take_over()
        self._write_answers()
        # the car body hardly turns at rest: the products of its rates are left out
        return np.asarray(self.turning @ self.state[2, self._frame])

    def restart(self) -> None:
        """Start from the last accepted state, as a process that read it from a file would."""
        self.restore(self.stored())

    def stored(self) -> dict[str, np.ndarray]:
        """Return the last accepted state as arrays by name."""
        own = {STATE: self.system.state(), WRENCH: self._accepted_wrench.copy()}
        memory = {name: np.array(values) for name, values in self.system.memory().items()}
        return own | self.commands.stored() | memory

    def restore(self, stored: Mapping[str, np.ndarray]) -> None:
        """Start from a stored state."""
        memory = {name: stored[name] for name in self.system.memory()}
        row = stored[STATE]
        self.system.set_state(row, memory)
        data: Any = self.system.mbs.systemData
        data.SetTime(float(self.system.layout.part(row, "time")))
        self.wrench = stored[WRENCH].copy()
        self.commands.restore(stored)
        self.has_moved = True
        self._take_over()

    def begin(self, step: Step) -> bool:
        """Predict a step from the last accepted one; return False if a shoe leaves the map."""
        h = step.size
        q, q_t, q_tt = self._accepted
        before = self._algorithmic
        after = self._after = (step.alpha_f * q_tt - step.alpha_m * before) / (1.0 - step.alpha_m)
        weights = self._weights = step.weights
        self.state = np.zeros_like(self._accepted)
        self.state[0] = q + h * q_t + h * h * ((0.5 - step.beta) * before + step.beta * after)
        self.state[1] = q_t + h * ((1.0 - step.gamma) * before + step.gamma * after)
        self.multipliers = self._accepted_multipliers.copy()
        size, wrench_before = self._before
        # the wrench changes as in the last step of this size
        self.wrench = 2.0 * self._accepted_wrench - wrench_before if size == h else self._accepted_wrench
        factored = self._factored == weights
        if factored or self.system.cells is not None:
            # as `CompiledSystem` begins a step
            self.state += np.multiply.outer(weights[:3], q_tt / weights.acceleration)
        self._inputs = self.commands.applied(self.system.inputs(step.end))
        return self._search(factored)

    def resume(self) -> bool:
        """Go on with a solved step after a change of the user's model; return as `begin` does."""
        return self._search(True)

    def _search(self, factored: bool) -> bool:
        """Begin Newton's method at the state, as `newton.step` does."""
        self._stage = newton.FACTORED if factored else newton.DERIVED
        self._count = self._made = self._age = 0
        try:
            self.system.cover(self.state)
        except NewtonError:
            return False
        self._last = self._norm(self._undifferentiated if factored else self._weights)
        return True

    @property
    def _undifferentiated(self) -> Weights:
        return Weights(0.0, 0.0, 0.0, False, self._weights.level)

    def _loaded(self, inputs: Inputs) -> Inputs:
        """Add the wrench of the user's model to loads and drive."""
        loads = inputs.loads.copy()
        loads[self.system.layout.shoes] += self.wrench
        return inputs._replace(loads=loads)

    def _norm(self, weights: Weights) -> float:
        """Compute the residual at the state; return its root mean square, N."""
        out = self.system.scratch[0]
        inputs = self._loaded(self._inputs)
        equations.residual(self.system.block, self.state, self.multipliers, inputs, weights, out)
        return math.sqrt(out @ out / len(out))

    def reduce(self) -> bool:
        """Eliminate the track from the right-hand side of an iteration; return True if its matrix is new."""
        out, values = self.system.scratch
        fronts = self.system.tables.fronts
        if self._stage == newton.STALE:
            self._norm(self._weights._replace(secant=self._made >= newton.TANGENTS))
        is_new = self._stage != newton.FACTORED
        if is_new:
            equations.matrix(self.system.block, self._weights, values)
            elimination.eliminate(fronts, values)
            self._made += 1
            self._age = 0
            self._write_answers()
        self._change[:] = out
        elimination.reduce(fronts, values, self._change, 0)
        return is_new

    def _write_answers(self) -> None:
        """Solve the last front of the factored matrix for unit wrenches."""
        values = self.system.scratch[1]
        first = self._frame.start
        self.turning = np.eye(6)
        self.turning[3:, 3:] = np.transpose(attitude(*self._angles(self.state[0, self._frame])).axes)
        answers = np.zeros((6, len(self._change)))
        answers[:, first : first + 6] = self.turning
        for answer in answers:
            elimination.reduce(self.system.tables.fronts, values, answer, self._last_front)
        self._answers = answers[:, self._own].T.copy()
        self.response = answers[:, self._frame].T.copy()

    def _angles(self, coordinates: np.ndarray) -> np.ndarray:
        return np.asarray(coordinates[3:] + self._reference[3:])

    def place_with(self, wrench: np.ndarray) -> np.ndarray:
        """Return position (m) and angles (rad) of the car body after the iteration, for a wrench (6,)."""
        change = self._change[self._frame] - self.response @ (wrench - self.wrench)
        return np.asarray(self.state[0, self._frame] - change + self._reference)

    @property
    def pose(self) -> Pose:
        """Pose of the car body, in the case's frame."""
        place = self.state[0, self._frame] + self._reference
        return Pose(place[:3], rotation_matrices(place[None, 3:])[0])

    @property
    def velocity(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocity (m/s) and angular velocity (rad/s) of the car body, in the case's frame."""
        rates = self.state[1, self._frame]
        return rates[:3], angular_velocity(self._angles(self.state[0, self._frame]), rates[3:])

    def advance(self, wrench: np.ndarray) -> bool | None:
        """Complete an iteration with a wrench (6,) on the car body.

        Return True if the residual is small enough, False if the search is given up, else None.
        """
        system = self.system
        solver = system.case.solver
        self._change[self._own] -= self._answers @ (wrench - self.wrench)
        self.wrench = wrench
        elimination.complete(system.tables.fronts, system.scratch[1], self._change)
        newton.subtract(system.block, self._change, self._weights, self.state, self.multipliers)
        self._count += 1
        self._age += 1
        last, self._last = self._last, self._norm(self._undifferentiated)
        self._stage = newton.FACTORED
        limit = solver.residual if self._made > 0 else newton.CLOSER * solver.residual
        if self._last <= limit:
            return True
        if not self._last < newton.DIVERGED or self._count >= solver.maximum_iterations:
            return False
        search = system.tables.search
        if newton.is_stale(search, self._made, self._age, self._last, last, limit):
            self._stage = newton.STALE
        return None

    def accept(self, step: Step) -> None:
        """Make the solved step the last one."""
        self._algorithmic = self._after + (1.0 - step.alpha_f) / (1.0 - step.alpha_m) * self.state[2]
        self._before = step.size, self._accepted_wrench
        self._accepted = self.state
        self._accepted_multipliers = self.multipliers
        self._accepted_wrench = self.wrench
        self._factored = self._weights if self._keeps_matrix and self._count == 1 else None
        self.iterations += self._count
        self.matrices += self._made
        self.has_moved = True
        self.system.accept(step.end, self.state, self.multipliers)
