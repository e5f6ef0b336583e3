"""Diagnosis of a failed step or a failed search for a rest by Newton's method."""

import numpy as np

from exudyn_crawler.errors import EquilibriumError
from exudyn_crawler.model.equations import STIFFNESS
from exudyn_crawler.model.state import StateLayout
from exudyn_crawler.model.track_system import TrackSystem


class NewtonError(Exception):
    """Failure of Newton's method at the least step, or in the search for an equilibrium.

    `residual` (equations,) is that of the last iteration: forces (N), moments (N m) and modal forces, then
    the gaps of constraints; `singular` is true if the equations had no solution. A known `cause` replaces
    both.
    """

    def __init__(self, residual: np.ndarray, singular: bool, cause: str = "") -> None:
        super().__init__(cause or "Newton's method failed")
        self.residual = residual
        self.singular = singular
        self.cause = cause

    def fault(self, layout: StateLayout) -> str:
        """Return the cause, or the equation that failed, such as "greatest residual at shoe 7 (z)".

        Residuals are compared as they are: forces in N, moments in N m, modal forces, and the gaps of
        constraints in m, rad and their rates.
        """
        if self.cause:
            return self.cause
        singular = "the equations are singular, " if self.singular else ""
        residual = np.abs(self.residual)
        if not np.isfinite(residual).all():
            # a single number makes all of them so in the next iteration
            return f"{singular}the residual is not finite"
        return f"{singular}greatest residual at {layout.equation(int(residual.argmax()))}"


def in_units(layout: StateLayout, residual: np.ndarray) -> np.ndarray:
    """Return the residual of `equations.residual` with gaps in m and rad; absent equations are zero."""
    equations = np.zeros(layout.equation_count)
    equations[: len(residual)] = residual
    equations[layout.coordinate_count :] /= STIFFNESS
    return equations


def no_rest(system: TrackSystem, failed: NewtonError) -> EquilibriumError:
    """Return the error of a failed search for rest: the fault and, if the ground must hold, the reason."""
    slides = ""
    if system.sticks and system.case.terrain.is_even and failed.singular:
        slides = "; the ground's shear may be too weak to hold the shoes: compare contact.law with the slope"
    fault = failed.cause or f"Newton's method failed, {failed.fault(system.layout)}{slides}"
    return EquilibriumError(f"no static equilibrium of case {system.case.name!r} was found: {fault}")
