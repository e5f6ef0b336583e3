"""Coulomb friction of MSC ADAMS: the curve over the slip speed, and the torque against spin."""

import math
from typing import NamedTuple

from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.laws.impact import step


class Coulomb(NamedTuple):
    """Parameters of the friction curve: coefficients mu_s and mu_d, speeds V_st and V_d (m/s)."""

    static: float
    dynamic: float
    stiction_speed: float
    friction_speed: float


@compiled
def friction_coefficient(law: Coulomb, slip_speed: float) -> float:
    """Coefficient of friction of the ADAMS Coulomb curve at a slip speed (F-paper).

    It rises with STEP from zero to mu_s at V_st, falls to mu_d at V_d and stays there: there is no true
    sticking. ADAMS writes the rise as ``STEP(v, -V_st, -1, V_st, 1)``, an odd function of v.

    Parameters
    ----------
    slip_speed : float
        m/s, magnitude of the slip velocity, not negative.
    """
    if slip_speed < law.stiction_speed:
        return law.static * step(slip_speed, -law.stiction_speed, -1.0, law.stiction_speed, 1.0)
    return step(slip_speed, law.stiction_speed, law.static, law.friction_speed, law.dynamic)


@compiled
def friction_per_slip(law: Coulomb, slip_speed: float) -> float:
    """Coefficient of friction over slip speed (s/m), finite at zero slip.

    The friction force is this times the normal force times the negative slip velocity, without
    a direction to divide by. The limit at zero is ``1.5 mu_s / V_st``.
    """
    if slip_speed < law.stiction_speed:
        # STEP(v; -V_st, -1, V_st, 1) = r (3 - r**2) / 2 with r = v / V_st
        r = slip_speed / law.stiction_speed
        return law.static * 0.5 * (3.0 - r * r) / law.stiction_speed
    return friction_coefficient(law, slip_speed) / slip_speed


@compiled
def friction_torque(law: Coulomb, spin: float, contact_radius: float, friction_force: float) -> float:
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
    """
    direction = step(contact_radius * spin, -law.stiction_speed, -1.0, law.stiction_speed, 1.0)
    return -2.0 / 3.0 * contact_radius * friction_force * direction


@compiled
def equal_area_radius(area: float) -> float:
    """Radius (m) of the circle with the area (m2)."""
    return math.sqrt(area / math.pi)
