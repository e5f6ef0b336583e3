"""A user's model in a coupled step: Exudyn forms its residual and matrix, this module solves and corrects.

The model is loaded by wrenches on its car bodies (`residual`, `correct`), and says how far these are from the
places of the tracks' car bodies (`gaps`). `CoupledStep` makes Newton's method of both. Exudyn multiplies the
equations of motion by ``beta h^2``, so that the unknowns of its algebraic equations are the multipliers times
that factor.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from exudyn_crawler.coupled.block import Step
from exudyn_crawler.coupled.placement import Placement, write_gap
from exudyn_crawler.model.exudyn import exu, integrator, predict

NOW = exu.ConfigurationType.Current
INITIAL = exu.ConfigurationType.Initial
START = exu.ConfigurationType.StartOfStep


class CarItems(NamedTuple):
    """Exudyn's items of a car body."""

    body: int
    node: int
    marker: int
    force: int  # load
    torque: int  # load
    placement: Placement


class UserModel:
    """Equations of a user's model with the car bodies of tracks, in the steps of an Exudyn solver.

    Attributes `jacobians` and `residuals` count how often Exudyn has formed them.
    """

    def __init__(self, mbs: "exu.MainSystem", cars: Sequence[CarItems]) -> None:
        self.mbs = mbs
        self._cars = cars
        self._data: Any = mbs.systemData
        self._rows = [np.array(self._data.GetObjectLTGODE2(car.body)) for car in cars]
        self._references = [
            np.array(
                mbs.GetNodeOutput(
                    car.node, exu.OutputVariableType.Coordinates, exu.ConfigurationType.Reference
                )
            )
            for car in cars
        ]
        self._size = self._data.ODE2Size()
        self._second_order = slice(0, self._size)
        self._first_order = slice(self._size, self._size + self._data.ODE1Size())
        self._algebraic = slice(self._first_order.stop, self._first_order.stop + self._data.AEsize())
        self.jacobians = self.residuals = 0
        self._factors: Any = None
        self._factored: tuple[float, ...] = ()
        self.answers = np.zeros((0, 0))
        self._found: tuple[float, float] | None = None  # the last residual, until a change
        # size of this and of the last step, accelerations and multipliers at their starts
        self._start = self._before = (0.0, np.zeros(0), np.zeros(0))

    def begin(self, solver: Any, settings: "exu.SimulationSettings", step: Step) -> None:
        """Predict a step: accelerations and multipliers change as in the last step of its size."""
        self._solver = solver
        self._settings = settings
        self._weights = step.weights
        self._scale = step.beta * step.size**2
        self._half = 0.5 * step.size
        self._found = None
        state = np.zeros((3, self._size))
        predict(solver, self.mbs, settings, state)
        second = np.array(self._data.GetODE2Coordinates_tt(START))
        multipliers = np.array(self._data.GetAECoordinates(START))
        self._start = step.size, second, multipliers
        size, second_before, multipliers_before = self._before
        if size == step.size:
            second = 2.0 * second - second_before
            self._data.GetAECoordinates(NOW, False)[:] = 2.0 * multipliers - multipliers_before
        state += np.multiply.outer(self._weights[:3], second / self._weights.acceleration)
        self._data.GetODE2Coordinates(NOW, False)[:] = state[0]
        self._data.GetODE2Coordinates_t(NOW, False)[:] = state[1]
        self._data.GetODE2Coordinates_tt(NOW, False)[:] = state[2]
        # the trapezoidal rule integrates coordinates of first order; here with their last rates
        rates = np.array(self._data.GetODE1Coordinates_t(START))
        self._data.GetODE1Coordinates(NOW, False)[:] = (
            self._data.GetODE1Coordinates(START) + step.size * rates
        )
        self._data.GetODE1Coordinates_t(NOW, False)[:] = rates

    def resume(self) -> None:
        """Go on with a solved step after a change of Exudyn's data coordinates."""
        self._found = None

    def accept(self) -> None:
        """Make the solved step the last one."""
        self._before = self._start

    def residual(self, wrenches: np.ndarray) -> tuple[float, float]:
        """Form the equations with the wrenches on the car bodies (6 cars,), in the user's frame.

        Return the root mean square of the equations of motion, N, and the greatest error of the others: gaps
        of constraints, m and rad, and relative errors of coordinates of first order. Both stay until the next
        correction.
        """
        if self._found is None:
            self._load(wrenches)
            self._solver.ComputeNewtonResidual(self.mbs, self._settings)
            self.residuals += 1
            self._residual = np.array(self._solver.GetSystemResidual())
            forces = self._residual[self._second_order]
            norm = math.sqrt(forces @ forces / self._size) / self._scale
            gap = float(np.abs(self._residual[self._algebraic]).max(initial=0.0))
            self._found = norm, max(gap, self._rate_error())
        return self._found

    def _rate_error(self) -> float:
        """Return the greatest error of coordinates of first order in a step, fraction of the greatest one."""
        if self._first_order.start == self._first_order.stop:
            return 0.0
        values = np.abs(self._data.GetODE1Coordinates(NOW, False))
        rates = np.abs(self._data.GetODE1Coordinates_t(NOW, False))
        greatest = float((values + self._half * rates).max())
        error = self._half * float(np.abs(self._residual[self._first_order]).max())
        return error / greatest if greatest > 0.0 else error

    def _load(self, wrenches: np.ndarray) -> None:
        for k, car in enumerate(self._cars):
            self.mbs.SetLoadParameter(car.force, "loadVector", wrenches[6 * k : 6 * k + 3])
            self.mbs.SetLoadParameter(car.torque, "loadVector", wrenches[6 * k + 3 : 6 * k + 6])

    @property
    def is_factored(self) -> bool:
        """True if the factors are those of a step of this size."""
        return self._factored == tuple(self._weights)

    def factor(self) -> None:
        """Form and factor the matrix at the last residual, and solve for unit wrenches on the car bodies.

        Raises `numpy.linalg.LinAlgError` if it is singular.
        """
        self._solver.ComputeNewtonJacobian(self.mbs, self._settings)
        self.jacobians += 1
        try:
            self._factors = splu(csc_array(np.array(self._solver.GetSystemJacobian())))
        except RuntimeError as error:
            raise np.linalg.LinAlgError(str(error)) from error
        self._factored = tuple(self._weights)
        self._turnings = [self._turning(k) for k in range(len(self._cars))]
        unit = np.zeros((len(self._residual), 6 * len(self._cars)))
        for k, turning in enumerate(self._turnings):
            unit[self._rows[k], 6 * k : 6 * k + 6] = self._scale * turning.T
        self._by_wrench = self._factors.solve(unit)
        self.answers = self.turned(self._by_wrench)

    def _turning(self, car: int) -> np.ndarray:
        """Return the change of a car body's pose by its coordinates: array (6, 7)."""
        a, b, c, d = (self._references[car] + self._data.GetODE2Coordinates(NOW, False)[self._rows[car]])[3:]
        turning = np.zeros((6, 7))
        turning[:3, :3] = np.eye(3)
        turning[3:, 3:] = 2.0 * np.array([[-b, a, -d, c], [-c, d, a, -b], [-d, -c, b, a]])
        return turning

    def accelerations(self, wrenches: np.ndarray, settings: "exu.SimulationSettings") -> np.ndarray:
        """Compute the initial accelerations with wrenches on the car bodies, see `residual`.

        Return those of the car bodies, linear and angular, in the user's frame: array (6 cars,).
        """
        self._load(wrenches)
        solver: Any = integrator(self.mbs)
        solver.InitializeSolver(self.mbs, settings)
        solver.FinalizeSolver(self.mbs, settings)
        second = np.array(self._data.GetODE2Coordinates_tt(NOW))
        self._turnings = [self._turning(k) for k in range(len(self._cars))]
        return self.turned(second)

    def keep(self) -> None:
        """Make the present state the initial one."""
        for get in (
            self._data.GetODE2Coordinates,
            self._data.GetODE2Coordinates_t,
            self._data.GetODE2Coordinates_tt,
            self._data.GetODE1Coordinates,
            self._data.GetODE1Coordinates_t,
            self._data.GetAECoordinates,
            self._data.GetDataCoordinates,
        ):
            get(INITIAL, False)[:] = get(NOW, False)

    def turned(self, change: np.ndarray) -> np.ndarray:
        """Return the changes of all car bodies' poses (6 cars, ...) by a change of the unknowns."""
        return np.concatenate(
            [turning @ change[rows] for turning, rows in zip(self._turnings, self._rows, strict=True)]
        )

    def solve(self) -> np.ndarray:
        """Return the correction of all unknowns for the last residual, without a change of wrenches."""
        return np.asarray(self._factors.solve(self._residual))

    def correct(self, change: np.ndarray, wrenches: np.ndarray) -> None:
        """Subtract a correction of `solve`, and add the answer to a change of all wrenches (6 cars,)."""
        self._found = None
        change = change - self._by_wrench @ wrenches
        by = self._weights
        coordinates = change[self._second_order]
        values = change[self._first_order]
        self._data.GetODE2Coordinates(NOW, False)[:] -= coordinates
        self._data.GetODE2Coordinates_t(NOW, False)[:] -= by.velocity * coordinates
        self._data.GetODE2Coordinates_tt(NOW, False)[:] -= by.acceleration * coordinates
        self._data.GetODE1Coordinates(NOW, False)[:] -= values
        self._data.GetODE1Coordinates_t(NOW, False)[:] -= values / self._half
        self._data.GetAECoordinates(NOW, False)[:] -= change[self._algebraic] / self._scale

    def gaps(self, places: Sequence[np.ndarray]) -> np.ndarray:
        """Return the gaps from car bodies at places (6,) in their cases to the user's: array (6 cars,)."""
        q = self._data.GetODE2Coordinates(NOW, False)
        out = np.empty((len(places), 6))
        for k, (car, place) in enumerate(zip(self._cars, places, strict=True)):
            at = car.placement
            write_gap(self._references[k] + q[self._rows[k]], place, at.position, at.turn, out[k])
        return out.ravel()
