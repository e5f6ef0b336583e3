"""What a solver leaves behind that could not go on."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.model.state import StateLayout


class NewtonError(Exception):
    """Newton's method failed at the least step, or found no rest.

    Attributes
    ----------
    residual : array (equations,)
        Of the last iteration: forces (N), moments (N m) and modal forces, then what constraints are off.
    singular : bool
        Whether the equations had no solution.
    """

    def __init__(self, residual: NDArray, singular: bool) -> None:
        super().__init__("Newton's method failed")
        self.residual = residual
        self.singular = singular


def engine_failure(solver: Any, layout: StateLayout) -> NewtonError:
    """What Exudyn's static or dynamic solver left behind when it failed."""
    residual = np.array(solver.GetSystemResidual())
    if not solver.IsStaticSolver():
        # the solver multiplies the equations of motion by what makes accelerations of displacements
        residual[: layout.coordinate_count] /= solver.newmarkBeta * solver.it.currentStepSize**2
    return NewtonError(residual, bool(solver.conv.linearSolverFailed))
