"""Which shoe or item a failed step or search for rest hangs on."""

import numpy as np

from exudyn_crawler.model.failure import NewtonError
from exudyn_crawler.model.state import StateLayout


def at_fault(layout: StateLayout, failed: NewtonError) -> str:
    """Name the equation that kept a solver from going on, such as "greatest residual at shoe 7 (z)".

    Residuals are compared as they are: forces in N, moments in N m, modal forces, and what constraints are
    off in m, rad and their rates.
    """
    singular = "the equations are singular, " if failed.singular else ""
    residual = np.abs(failed.residual)
    if not np.isfinite(residual).all():
        # a single one makes all of them so in the next iteration
        return f"{singular}the residual is not finite"
    return f"{singular}greatest residual at {layout.equation(int(residual.argmax()))}"
