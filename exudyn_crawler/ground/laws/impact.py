"""STEP and the IMPACT normal force of MSC ADAMS."""

from typing import NamedTuple

from exudyn_crawler.ground.frames import compiled


class Impact(NamedTuple):
    """Parameters of IMPACT: `stiffness` k (N/m**exponent), `exponent` e, `damping` c_max (N s/m).

    The damping grows with STEP from zero at the surface to all of it at `damping_depth` d (m).
    """

    stiffness: float
    exponent: float
    damping: float
    damping_depth: float


@compiled
def step(x: float, x0: float, h0: float, x1: float, h1: float) -> float:
    """Cubic step from `h0` at `x0` to `h1` at `x1`, constant outside (ADAMS/Solver STEP).

    Between the two ends ``h0 + (h1 - h0) d**2 (3 - 2 d)`` with ``d = (x - x0) / (x1 - x0)``.
    """
    if x <= x0:
        return h0
    if x >= x1:
        return h1
    d = (x - x0) / (x1 - x0)
    return h0 + (h1 - h0) * d * d * (3.0 - 2.0 * d)


@compiled
def impact_force(law: Impact, penetration: float, penetration_rate: float) -> float:
    """Normal contact force of the ADAMS IMPACT law (F-paper, contact section).

    Parameters
    ----------
    penetration : float
        m; no force unless positive.
    penetration_rate : float
        m/s, positive while the bodies approach.

    Returns
    -------
    float
        N, never negative: damping does not pull the bodies together.
    """
    if penetration <= 0.0:
        return 0.0
    if law.exponent == 2.0:
        elastic = law.stiffness * penetration * penetration
    else:
        elastic = law.stiffness * penetration**law.exponent
    damped = law.damping * penetration_rate * step(penetration, 0.0, 0.0, law.damping_depth, 1.0)
    return max(0.0, elastic + damped)
