"""The only import of Exudyn, and its integrator for the compiled equations.

This build of Exudyn has range checks. The build without saves 5 % of a run's time, but its last digits depend
on the processor's instruction set.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import exudyn as exu
import exudyn.itemInterface as items
import numpy as np
from exudyn.graphics import FromPointsAndTrigs
from exudyn.rigidBodyUtilities import EulerParameters2G, EulerParameters2RotationMatrix, RigidBodyInertia

exu.config.printToConsole = False

__all__ = [
    "EulerParameters2G",
    "EulerParameters2RotationMatrix",
    "FromPointsAndTrigs",
    "RigidBodyInertia",
    "exu",
    "items",
]


SLACK = 1e-6
"""Allowed overrun of a required end by a step, fraction of the step: rounding."""


def integrator(mbs: "exu.MainSystem", next_end: Callable[[float], float] | None = None) -> Any:
    """Return Exudyn's generalized-alpha solver.

    `next_end` gives, for a time (s), the next time (s) at which a step has to end. Exudyn itself ends a step
    there only if none was shortened before.
    """
    # Exudyn's stub gives a solver's methods without self
    solver: Any = exu.MainSolverImplicitSecondOrder()
    if next_end is not None:
        solver.SetUserFunctionUpdateCurrentTime(mbs, partial(_begin_step, next_end))
    return solver


def _begin_step(
    next_end: Callable[[float], float],
    solver: Any,
    _mbs: "exu.MainSystem",
    _settings: "exu.SimulationSettings",
) -> None:
    """Write size and end of a step as Exudyn does, but at most up to the next end."""
    step = solver.it
    start = step.currentTime
    size = step.currentStepSize
    if start + size > step.endTime:
        size = step.endTime - start
    end = next_end(start)
    if start + size > end + SLACK * size:
        size = end - start
    step.currentStepSize = size
    step.currentTime = start + size


def predict(
    solver: Any,
    mbs: "exu.MainSystem",
    settings: "exu.SimulationSettings",
    state: np.ndarray,
) -> None:
    """Write the predicted coordinates, rates and accelerations (3, n) of a step.

    The method is generalized-alpha (Arnold and Bruels, Multibody System Dynamics 18, 2007, algorithm 1). A
    step that failed leaves Exudyn's algorithmic acceleration at the value of the step's end, whatever its
    size. Exudyn itself would take it for that of the start when the step is tried again.
    """
    data: Any = mbs.systemData
    h = solver.it.currentStepSize
    before = solver.GetStartOfStepStateAAlgorithmic()
    after = solver.GetAAlgorithmic()
    if (before == after).all():
        solver.ComputeNewtonUpdate(mbs, settings, True)
        state[0], state[1] = data.GetODE2Coordinates(), data.GetODE2Coordinates_t()
    else:
        beta = solver.newmarkBeta
        gamma = solver.newmarkGamma
        rate = data.GetODE2Coordinates_t()
        state[0] = data.GetODE2Coordinates() + h * rate + h * h * ((0.5 - beta) * before + beta * after)
        state[1] = rate + h * ((1.0 - gamma) * before + gamma * after)
    state[2] = 0.0


def newton_settings(residual: float, iterations: int) -> "exu.SimulationSettings":
    """Return Exudyn's silent settings for a rest or a motion; `residual` (N, root mean square) suffices."""
    settings = exu.SimulationSettings()
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    for solver in (settings.staticSolver, settings.timeIntegration):
        solver.verboseMode = 0
        solver.newton.absoluteTolerance = residual
        # the absolute tolerance alone decides: a step's first residual is no reference
        solver.newton.relativeTolerance = 1e-16
        solver.newton.weightTolerancePerCoordinate = True
        solver.newton.maxIterations = iterations
    return settings


def generic_node(mbs: "exu.MainSystem", name: str, size: int) -> int:
    """Add a node of `size` coordinates, all zero; return its number."""
    zeros = [0.0] * size
    return mbs.AddNode(
        items.NodeGenericODE2(
            name=name,
            referenceCoordinates=zeros,
            initialCoordinates=zeros,
            initialCoordinates_t=zeros,
            numberOfODE2Coordinates=size,
        )
    )


def sparse(values: np.ndarray) -> "exu.MatrixContainer":
    """Return a matrix in Exudyn's sparse form, without its zeros."""
    rows, columns = np.nonzero(values)
    matrix = exu.MatrixContainer()
    matrix.SetWithSparseMatrix(np.column_stack((rows, columns, values[rows, columns])), *values.shape)
    return matrix


def add_coordinates(mbs: "exu.MainSystem", name: str, size: int, **acting: object) -> int:
    """Add an object of `size` coordinates with unit masses, and the forces on it; return its node."""
    node = generic_node(mbs, name, size)
    mass = sparse(np.eye(size))
    mbs.AddObject(items.ObjectGenericODE2(name=name, nodeNumbers=[node], massMatrix=mass, **acting))
    return node
