"""Utilisation of pin, bush, roller, rail and chain: formulas that give a number and its limit.

The utilisation is number over limit with the factor of the load case on the load; at most 1 is allowed.
"""

from typing import NamedTuple

import numpy as np

from fem.fatigue import line_contact as hertz

SHARED = 1.5
"""Pull of the more loaded of two hinge joints of a shoe over half of the chain's (assumed)."""
IN_SHEAR = 0.6
"""Of the tensile strength, what a pin bears in shear (EN 1993-1-8, table 3.10)."""
GAMMA_M0 = 1.0
GAMMA_M2 = 1.25
"""Partial factors of EN 1993-1-8: M0 (remembered) and M2 (eurocode.us); M6,ser of contact in holes is 1."""
LIGHT = 0.591
"""Of EN 1993-1-8, eq. 3.15: Hertz's line contact of a pin in its hole."""


class PinnedHinge(NamedTuple):
    """PinnedHinge joint of two shoes with one pin: an inner lug between two outer ones, m."""

    diameter: float
    """Of the pin."""
    inner: float
    """Width of the inner lug, or length of the bush that bears on the pin."""
    outer: float
    """Width of each outer lug."""
    gap: float
    """Between an inner and an outer lug."""
    play: float = 0.0
    """Diameter of the hole over that of the pin."""


class PartStrength(NamedTuple):
    """Strength of a part, Pa."""

    tensile: float
    yield_strength: float


class PinStress(NamedTuple):
    """Stresses of a pin in two sections, Pa, and its moment, N m."""

    shear: float
    """Force of each section over its area."""
    bearing_inner: float
    """Force over diameter and width of the inner lug."""
    bearing_outer: float
    moment: float
    """In the middle of the pin."""
    bending: float
    """Moment over the elastic modulus of section."""


def pin_stress(force: float, hinge: PinnedHinge) -> PinStress:
    """Stresses of a pin that bears a force (N) in double shear.

    Shear F / 2 over pi d^2 / 4, bearing F / (d t) and F / (2 d t_outer), bending by
    M = F (b + 4 c + 2 a) / 8 with b inner, a outer width and c gap (EN 1993-1-8, figure 3.11, the formula
    remembered).
    """
    diameter, inner, outer, gap, _ = hinge
    area = 0.25 * np.pi * diameter**2
    moment = force * (inner + 4.0 * gap + 2.0 * outer) / 8.0
    return PinStress(
        0.5 * force / area,
        force / (diameter * inner),
        0.5 * force / (diameter * outer),
        moment,
        moment / (np.pi * diameter**3 / 32.0),
    )


class PinCheck(NamedTuple):
    """Parts of the resistance of a pin that are used."""

    shear: float
    bearing: float
    bending: float
    together: float
    """Squares of bending and shear."""


def pin_check(force: float, hinge: PinnedHinge, pin: PartStrength, lug: PartStrength) -> PinCheck:
    """Utilisation of a pin under a force (N) that has its load factor.

    F_v,Rd = 0.6 A f_up / gamma_M2 in each of two sections, F_b,Rd = 1.5 t d f_y / gamma_M0 with the lower
    yield strength of pin and lug, M_Rd = 1.5 W f_yp / gamma_M0, and (M / M_Rd)^2 + (F_v / F_v,Rd)^2 <= 1
    (EN 1993-1-8, table 3.10).
    """
    diameter, inner, outer, _, _ = hinge
    shear = 0.5 * force / (IN_SHEAR * 0.25 * np.pi * diameter**2 * pin.tensile / GAMMA_M2)
    width = min(inner, 2.0 * outer)
    weaker = min(pin.yield_strength, lug.yield_strength)
    bearing = force / (1.5 * width * diameter * weaker / GAMMA_M0)
    modulus = np.pi * diameter**3 / 32.0
    bending = pin_stress(force, hinge).moment / (1.5 * modulus * pin.yield_strength / GAMMA_M0)
    return PinCheck(shear, bearing, bending, float(bending**2 + shear**2))


def hole_contact(force: float, hinge: PinnedHinge, modulus: float) -> float:
    """Contact pressure (Pa) of a pin in a hole with play under service loads: EN 1993-1-8, eq. 3.15.

    0.591 sqrt(E F (d0 - d) / (d^2 t)), `modulus` E in Pa, of which 2.5 f_y / gamma_M6,ser is allowed for
    pins that are replaced.
    """
    width = min(hinge.inner, 2.0 * hinge.outer)
    return LIGHT * float(np.sqrt(modulus * force * hinge.play / (hinge.diameter**2 * width)))


def chain_strength(hinge: PinnedHinge, hinges: int, pin: PartStrength) -> float:
    """Tension (N) at which the pins of a link shear off: 0.6 f_u A in two sections a hinge (derived)."""
    return hinges * 2.0 * IN_SHEAR * pin.tensile * 0.25 * np.pi * hinge.diameter**2


class RollerTread(NamedTuple):
    """RollerTread of a roller on a rail."""

    radius: float
    """m."""
    width: float
    """That bears, m."""


class RollerContact(NamedTuple):
    """Line contact of a tread."""

    specific: float
    """K = F / (D b), Pa."""
    pressure: float
    """Greatest, by Hertz, Pa."""
    to_yield: float
    """Factor of the stresses until the rail flows below its surface."""
    to_shakedown: float
    """Factor until it flows in every pass."""


def roller_contact(
    force: float, tread: RollerTread, yield_strength: float, modulus: float = 210e9, poisson: float = 0.3
) -> RollerContact:
    """Contact of a tread with a force (N) on a rail of a yield strength (Pa), both of steel.

    p = sqrt(F E / (2 pi R b (1 - nu^2))), E of both (Hertz; BOStrab TR Sp appendix 4 and FEM 1.001 booklet 4
    have the same); stresses below it and shakedown by `fem.fatigue.line_contact` (Johnson).
    """
    plane = modulus / (2.0 * (1.0 - poisson**2))
    contact = hertz.line_contact(force / tread.width, tread.radius, plane)
    stress = hertz.path_stress(contact, yield_strength, poisson)
    specific = force / (2.0 * tread.radius * tread.width)
    return RollerContact(specific, float(contact.pressure), stress.to_yield, stress.to_shakedown)


def bending_of_shoe(force: float, width: float, rail: float) -> float:
    """Bending moment (N m) of a shoe at its middle on even ground: P (W / 4 - a).

    P the force (N) on each of two rails at `rail` a (m) beside the middle, W the shoe's `width` (m):
    `docs/check-cases.md`.
    """
    return force * (0.25 * width - rail)
