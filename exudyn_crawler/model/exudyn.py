"""The only import of Exudyn, and its integrator beside compiled equations.

This is its build with range checks. The one without saves 5 % of a run's time, but its last digits depend on
the processor's instruction set.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import exudyn as exu
import exudyn.itemInterface as items
import numpy as np
from exudyn.rigidBodyUtilities import EulerParameters2G, EulerParameters2RotationMatrix, RigidBodyInertia

exu.config.printToConsole = False

__all__ = ["EulerParameters2G", "EulerParameters2RotationMatrix", "RigidBodyInertia", "exu", "items"]


SLACK = 1e-6
"""Part of a step by which it may end beyond the time at which one has to end: rounding."""


def integrator(mbs: "exu.MainSystem", next_end: Callable[[float], float] | None = None) -> Any:
    """Exudyn's generalized-alpha solver; `next_end` gives the time (s) behind one at which a step has to end.

    Exudyn itself ends a step there only if none was shortened before.
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
    """Write size and end of a step as Exudyn does, but no farther than to the next end."""
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
    """Write coordinates, rates and accelerations (3, n) with which a step's search starts.

    By the generalized-alpha method (Arnold and Bruels, Multibody System Dynamics 18, 2007, algorithm 1). A
    step that failed has left Exudyn's algorithmic acceleration as it would be at the step's end, whatever its
    size; Exudyn itself would take it for that of the start when the step is tried again.
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
    """Exudyn's settings for a rest or a motion, in silence; residual (N, root mean square) that is enough."""
    settings = exu.SimulationSettings()
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    for solver in (settings.staticSolver, settings.timeIntegration):
        solver.verboseMode = 0
        solver.newton.absoluteTolerance = residual
        # the absolute tolerance alone decides: the first residual of a step is no measure
        solver.newton.relativeTolerance = 1e-16
        solver.newton.weightTolerancePerCoordinate = True
        solver.newton.maxIterations = iterations
    return settings


def generic_node(mbs: "exu.MainSystem", name: str, size: int) -> int:
    """Node of so many coordinates, all zero."""
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
    """Matrix as Exudyn takes it, without its zeros."""
    rows, columns = np.nonzero(values)
    matrix = exu.MatrixContainer()
    matrix.SetWithSparseMatrix(np.column_stack((rows, columns, values[rows, columns])), *values.shape)
    return matrix


def add_coordinates(mbs: "exu.MainSystem", name: str, size: int, **acting: object) -> int:
    """Object of so many coordinates with a mass of one for each, and what acts on them; gives their node."""
    node = generic_node(mbs, name, size)
    mass = sparse(np.eye(size))
    mbs.AddObject(items.ObjectGenericODE2(name=name, nodeNumbers=[node], massMatrix=mass, **acting))
    return node
