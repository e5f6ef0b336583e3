"""Failure of a solver, with the residual of its last iteration."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.model.state import StateLayout


class NewtonError(Exception):
    """Newton's method failed at the least step, or found no equilibrium.

    Attributes
    ----------
    residual : array (equations,)
        Of the last iteration: forces (N), moments (N m) and modal forces, then the gaps of constraints.
    singular : bool
        Whether the equations had no solution.
    """

    def __init__(self, residual: NDArray, singular: bool) -> None:
        super().__init__("Newton's method failed")
        self.residual = residual
        self.singular = singular


def engine_failure(solver: Any, layout: StateLayout) -> NewtonError:
    """Failure of Exudyn's static or dynamic solver, with its residual."""
    residual = np.array(solver.GetSystemResidual())
    if not solver.IsStaticSolver():
        # the solver multiplies the equations of motion by the factor from displacements to accelerations
        residual[: layout.coordinate_count] /= solver.newmarkBeta * solver.it.currentStepSize**2
    return NewtonError(residual, bool(solver.conv.linearSolverFailed))
