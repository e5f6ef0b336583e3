"""The engine: the only import of Exudyn; its integrator beside compiled equations.

This is its build with range checks. The one without saves 5 % of a run's time, but its last digits depend on
the processor's instruction set.
"""

from typing import Any

import exudyn as exu
import exudyn.itemInterface as items
import numpy as np

exu.config.printToConsole = False

__all__ = ["exu", "items"]


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
    before, after = solver.GetStartOfStepStateAAlgorithmic(), solver.GetAAlgorithmic()
    if np.array_equal(before, after):
        solver.ComputeNewtonUpdate(mbs, settings, True)
        state[0], state[1] = data.GetODE2Coordinates(), data.GetODE2Coordinates_t()
    else:
        beta, gamma, rate = solver.newmarkBeta, solver.newmarkGamma, data.GetODE2Coordinates_t()
        state[0] = data.GetODE2Coordinates() + h * rate + h * h * ((0.5 - beta) * before + beta * after)
        state[1] = rate + h * ((1.0 - gamma) * before + gamma * after)
    state[2] = 0.0


def coordinates_only(container: "exu.SystemContainer", size: int) -> "exu.MainSystem":
    """System of one object that has so many coordinates and a mass for each."""
    mbs = container.AddSystem()
    zeros = [0.0] * size
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=zeros,
            initialCoordinates=zeros,
            initialCoordinates_t=zeros,
            numberOfODE2Coordinates=size,
        )
    )
    index = np.arange(size)
    mass = exu.MatrixContainer()
    mass.SetWithSparseMatrix(np.column_stack((index, index, np.ones(size))), size, size)
    mbs.AddObject(items.ObjectGenericODE2(name="track", nodeNumbers=[node], massMatrix=mass))
    mbs.Assemble()
    return mbs
