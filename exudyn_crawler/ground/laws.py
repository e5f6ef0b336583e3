"""Scalar laws of contact: STEP, IMPACT and the Coulomb friction curve of MSC ADAMS.

Pure functions of numbers, compiled by numba so that the contact of a whole track costs microseconds;
every function can be called from plain Python as well.
"""

import math

from numba import njit


@njit(cache=True, inline="always")
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


@njit(cache=True)
def impact_force(
    penetration: float,
    penetration_rate: float,
    stiffness: float,
    exponent: float,
    damping: float,
    damping_depth: float,
) -> float:
    """Normal contact force of the ADAMS IMPACT law (F-paper, contact section).

    Parameters
    ----------
    penetration : float
        m; no force unless positive.
    penetration_rate : float
        m/s, positive while the bodies approach.
    stiffness : float
        N/m**exponent.
    exponent : float
        1.
    damping : float
        N s/m, reached at `damping_depth`.
    damping_depth : float
        m; the damping grows with STEP from zero at the surface to this depth.

    Returns
    -------
    float
        N, never negative: damping does not pull the bodies together.
    """
    if penetration <= 0.0:
        return 0.0
    if exponent == 2.0:
        elastic = stiffness * penetration * penetration
    else:
        elastic = stiffness * penetration**exponent
    damped = damping * penetration_rate * step(penetration, 0.0, 0.0, damping_depth, 1.0)
    return max(0.0, elastic + damped)


@njit(cache=True)
def friction_coefficient(
    slip_speed: float, static: float, dynamic: float, stiction_speed: float, friction_speed: float
) -> float:
    """Coefficient of friction of the ADAMS Coulomb curve at a slip speed (F-paper).

    It rises with STEP from zero to `static` at `stiction_speed`, falls to `dynamic` at
    `friction_speed` and stays there: there is no true sticking. ADAMS writes the rise as
    ``STEP(v, -V_st, -1, V_st, 1)``, an odd function of v.

    Parameters
    ----------
    slip_speed : float
        m/s, magnitude of the slip velocity, not negative.
    static, dynamic : float
        Coefficients mu_s and mu_d.
    stiction_speed, friction_speed : float
        m/s, V_st and V_d.
    """
    if slip_speed < stiction_speed:
        return static * step(slip_speed, -stiction_speed, -1.0, stiction_speed, 1.0)
    return step(slip_speed, stiction_speed, static, friction_speed, dynamic)


@njit(cache=True)
def friction_per_slip(
    slip_speed: float, static: float, dynamic: float, stiction_speed: float, friction_speed: float
) -> float:
    """Coefficient of friction over slip speed (s/m), finite at zero slip.

    The friction force is this times the normal force times the negative slip velocity, without
    a direction to divide by. The limit at zero is ``1.5 mu_s / V_st``.
    """
    if slip_speed < stiction_speed:
        # STEP(v; -V_st, -1, V_st, 1) = r (3 - r**2) / 2 with r = v / V_st
        r = slip_speed / stiction_speed
        return static * 0.5 * (3.0 - r * r) / stiction_speed
    return friction_coefficient(slip_speed, static, dynamic, stiction_speed, friction_speed) / slip_speed


@njit(cache=True)
def friction_torque(
    spin: float, contact_radius: float, friction_force: float, stiction_speed: float
) -> float:
    """Friction torque about the contact normal, against the relative spin (F-paper).

    ``T = (2/3) R F_T``, turned with the spin by the same odd STEP of the rim speed ``R * spin``
    that turns the friction force with the slip, so that it passes through zero smoothly.

    Parameters
    ----------
    spin : float
        rad/s, relative angular velocity about the normal.
    contact_radius : float
        m, radius R of the circle with the area of contact.
    friction_force : float
        N, magnitude of the tangential force.
    stiction_speed : float
        m/s, V_st.
    """
    direction = step(contact_radius * spin, -stiction_speed, -1.0, stiction_speed, 1.0)
    return -2.0 / 3.0 * contact_radius * friction_force * direction


@njit(cache=True)
def equal_area_radius(area: float) -> float:
    """Radius (m) of the circle with the area (m2)."""
    return math.sqrt(area / math.pi)
