"""Laws of contact: pure functions of numbers.

They are compiled, so that the contact of a whole track costs microseconds; Python can call them, too.
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import kernel


class Impact(NamedTuple):
    """Parameters of IMPACT: `stiffness` k (N/m**exponent), `exponent` e, `damping` c_max (N s/m).

    The damping rises with STEP from zero at the surface to c_max at `damping_depth` d (m).
    """

    stiffness: float
    exponent: float
    damping: float
    damping_depth: float


class Coulomb(NamedTuple):
    """Parameters of the friction curve: coefficients mu_s and mu_d, speeds V_st and V_d (m/s)."""

    static: float
    dynamic: float
    stiction_speed: float
    friction_speed: float


@kernel
def step(x: float, x0: float, h0: float, x1: float, h1: float) -> float:
    """Return the cubic step from `h0` at `x0` to `h1` at `x1`, constant outside (ADAMS/Solver STEP).

    Between the ends it is ``h0 + (h1 - h0) d**2 (3 - 2 d)`` with ``d = (x - x0) / (x1 - x0)``.
    """
    if x <= x0:
        return h0
    if x >= x1:
        return h1
    d = (x - x0) / (x1 - x0)
    return h0 + (h1 - h0) * d * d * (3.0 - 2.0 * d)


@kernel
def impact_force(law: Impact, penetration: float, penetration_rate: float) -> float:
    """Return the normal contact force (N) of the ADAMS IMPACT law (F-paper, contact section).

    The penetration is in m; the force is zero unless it is positive. Its rate (m/s) is positive while the
    bodies approach. The force is never negative: damping does not pull the bodies together.
    """
    if penetration <= 0.0:
        return 0.0
    if law.exponent == 2.0:
        elastic = law.stiffness * penetration * penetration
    else:
        elastic = law.stiffness * penetration**law.exponent
    damped = law.damping * penetration_rate * step(penetration, 0.0, 0.0, law.damping_depth, 1.0)
    return max(0.0, elastic + damped)


@kernel
def friction_per_slip(law: Coulomb, slip_speed: float) -> float:
    """Return the ADAMS Coulomb coefficient of friction divided by the slip speed (s/m; F-paper).

    The coefficient rises with STEP from zero to mu_s at V_st, falls to mu_d at V_d and stays there: there is
    no true sticking. ADAMS writes the rise as ``STEP(v, -V_st, -1, V_st, 1)``, an odd function of v. The
    friction force is this value times the normal force times the negative slip velocity, so that no direction
    has to be normalized. The limit at zero is ``1.5 mu_s / V_st``.
    """
    if slip_speed < law.stiction_speed:
        # STEP(v; -V_st, -1, V_st, 1) = r (3 - r**2) / 2 with r = v / V_st
        r = slip_speed / law.stiction_speed
        return law.static * 0.5 * (3.0 - r * r) / law.stiction_speed
    return step(slip_speed, law.stiction_speed, law.static, law.friction_speed, law.dynamic) / slip_speed


@kernel
def friction_torque(law: Coulomb, spin: float, area: float, friction_force: float) -> float:
    """Return the friction torque (N m) about the contact normal, against the relative spin (rad/s; F-paper).

    Its magnitude is ``T = (2/3) R F_T``: R is the radius of the circle with the contact area (m2), F_T the
    tangential force (N). The odd STEP of the friction curve gives the sign, here as a function of the rim
    speed ``R * spin``, so that the torque passes through zero smoothly.
    """
    radius = math.sqrt(area / math.pi)
    direction = step(radius * spin, -law.stiction_speed, -1.0, law.stiction_speed, 1.0)
    return -2.0 / 3.0 * radius * friction_force * direction
