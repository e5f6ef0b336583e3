"""Laws of contact: pure functions of numbers.

They are compiled, so that the contact of a whole track costs microseconds; plain Python can call them, too.
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import kernel


class Impact(NamedTuple):
    """Parameters of IMPACT: `stiffness` k (N/m**exponent), `exponent` e, `damping` c_max (N s/m).

    The damping grows with STEP from zero at the surface to all of it at `damping_depth` d (m).
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
    """Cubic step from `h0` at `x0` to `h1` at `x1`, constant outside (ADAMS/Solver STEP).

    Between the two ends ``h0 + (h1 - h0) d**2 (3 - 2 d)`` with ``d = (x - x0) / (x1 - x0)``.
    """
    if x <= x0:
        return h0
    if x >= x1:
        return h1
    d = (x - x0) / (x1 - x0)
    return h0 + (h1 - h0) * d * d * (3.0 - 2.0 * d)


@kernel
def impact_force(law: Impact, penetration: float, penetration_rate: float) -> float:
    """Normal contact force (N) of the ADAMS IMPACT law (F-paper, contact section).

    Of a penetration (m), without which there is none, and its rate (m/s), positive while the bodies approach.
    Never negative: damping does not pull the bodies together.
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
    """Coefficient of friction of the ADAMS Coulomb curve over the slip speed (s/m; F-paper).

    The coefficient rises with STEP from zero to mu_s at V_st, falls to mu_d at V_d and stays there: there is
    no true sticking. ADAMS writes the rise as ``STEP(v, -V_st, -1, V_st, 1)``, an odd function of v. The
    friction force is this times the normal force times the negative slip velocity, without a direction to
    divide by. The limit at zero is ``1.5 mu_s / V_st``.
    """
    if slip_speed < law.stiction_speed:
        # STEP(v; -V_st, -1, V_st, 1) = r (3 - r**2) / 2 with r = v / V_st
        r = slip_speed / law.stiction_speed
        return law.static * 0.5 * (3.0 - r * r) / law.stiction_speed
    return step(slip_speed, law.stiction_speed, law.static, law.friction_speed, law.dynamic) / slip_speed


@kernel
def friction_torque(law: Coulomb, spin: float, area: float, friction_force: float) -> float:
    """Friction torque (N m) about the contact normal, against the relative spin (rad/s; F-paper).

    ``T = (2/3) R F_T`` of the radius R of the circle with the area of contact (m2) and the tangential force
    (N), turned with the spin by the same odd STEP of the rim speed ``R * spin`` that turns the friction force
    with the slip, so that it passes through zero smoothly.
    """
    radius = math.sqrt(area / math.pi)
    direction = step(radius * spin, -law.stiction_speed, -1.0, law.stiction_speed, 1.0)
    return -2.0 / 3.0 * radius * friction_force * direction
