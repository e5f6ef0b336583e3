"""Which shoe or item a failed step or search for rest hangs on."""

from typing import Any

import numpy as np

from exudyn_crawler.model.system import System


def at_fault(system: System, solver: Any) -> str:
    """Name the equation that kept a solver from going on, such as "greatest residual at shoe 7 (z)".

    Residuals are compared as the solver does: forces (N), moments (N m) and modal forces as they are,
    constraints by what they are off (m, rad and their rates).

    Parameters
    ----------
    solver : exudyn.MainSolverStatic or exudyn.MainSolverImplicitSecondOrder
        After it failed.
    """
    singular = "the equations are singular, " if solver.conv.linearSolverFailed else ""
    residual = np.abs(solver.GetSystemResidual())
    if not np.isfinite(residual).all():
        # a single one makes all of them so in the next iteration
        return f"{singular}the residual is not finite"
    if not solver.IsStaticSolver():
        # the solver multiplies the equations of motion by what makes accelerations of displacements
        residual[: system.layout.coordinate_count] /= solver.newmarkBeta * solver.it.currentStepSize**2
    return f"{singular}greatest residual at {system.layout.equation(int(residual.argmax()))}"
