"""Utilisation of pin, bush, roller, rail and chain: formulas for a number and its limit.

The utilisation is the number over its limit, with the factor of the load case on the load; at most 1 is
allowed.
"""

from typing import NamedTuple

import numpy as np

from fem.fatigue import line_contact as hertz

SHARED = 1.5
"""Pull of the more loaded of a shoe's two hinge joints over half of the chain's pull (assumed)."""
IN_SHEAR = 0.6
"""Shear strength of a pin, fraction of its tensile strength (EN 1993-1-8, table 3.10)."""
GAMMA_M0 = 1.0
GAMMA_M2 = 1.25
"""Partial factors of EN 1993-1-8: M0 (remembered) and M2 (eurocode.us); M6,ser of contact in holes is 1."""
LIGHT = 0.591
"""Factor of Hertz's line contact of a pin in its hole (EN 1993-1-8, eq. 3.15)."""


class PinnedHinge(NamedTuple):
    """Hinge joint of two shoes with one pin: an inner lug between two outer ones, m."""

    diameter: float
    """Diameter of the pin."""
    inner: float
    """Width of the inner lug, or length of the bush that bears on the pin."""
    outer: float
    """Width of each outer lug."""
    gap: float
    """Gap between an inner and an outer lug."""
    play: float = 0.0
    """Play: diameter of the hole less that of the pin."""

    @property
    def outer_governs(self) -> bool:
        """True if both outer lugs together are narrower than the inner one, and so bear more pressure."""
        return 2.0 * self.outer < self.inner

    @property
    def bearing_width(self) -> float:
        """Width (m) of the lugs with the greater pressure: of the inner lug, or of both outer ones."""
        return min(self.inner, 2.0 * self.outer)


class PartStrength(NamedTuple):
    """Strength of a part, Pa."""

    tensile: float
    yield_strength: float


class PinStress(NamedTuple):
    """Stresses or resistances of a pin, Pa."""

    shear: float
    """Force of each of two sections over its area."""
    bearing: float
    """Greatest force over diameter and width, of the inner lug or the outer ones."""
    bending: float
    """Moment in the middle of the pin over its elastic section modulus."""


def pin_moment(force: float, hinge: PinnedHinge) -> float:
    """Return the bending moment (N m) in the middle of a pin: M = F (b + 4 c + 2 a) / 8.

    b inner width, a outer width and c gap (EN 1993-1-8, figure 3.11; formula remembered).
    """
    return force * (hinge.inner + 4.0 * hinge.gap + 2.0 * hinge.outer) / 8.0


def pin_stress(force: float, hinge: PinnedHinge) -> PinStress:
    """Return the stresses of a pin under a force (N) in double shear.

    Shear F / 2 over pi d^2 / 4; bearing the greater of F / (d b) and F / (2 d a); bending M / (pi d^3 / 32).
    """
    diameter = hinge.diameter
    area = 0.25 * np.pi * diameter**2
    modulus = np.pi * diameter**3 / 32.0
    bearing = force / (diameter * hinge.bearing_width)
    return PinStress(0.5 * force / area, bearing, pin_moment(force, hinge) / modulus)


def pin_resistance(pin: PartStrength, lug: PartStrength) -> PinStress:
    """Return the resistances of a pin as stresses.

    Shear: 0.6 f_up / gamma_M2. Bearing: 1.5 f_y / gamma_M0 with the lower yield strength of pin and lug.
    Bending: 1.5 f_yp / gamma_M0 (EN 1993-1-8, table 3.10: F_v,Rd, F_b,Rd and M_Rd over area, width, modulus).
    """
    weaker = min(pin.yield_strength, lug.yield_strength)
    return PinStress(
        IN_SHEAR * pin.tensile / GAMMA_M2, 1.5 * weaker / GAMMA_M0, 1.5 * pin.yield_strength / GAMMA_M0
    )


def hole_contact(force: float, hinge: PinnedHinge, modulus: float) -> float:
    """Return the contact pressure (Pa) of a pin in a hole with play in service: EN 1993-1-8, eq. 3.15.

    The pressure is 0.591 sqrt(E F (d0 - d) / (d^2 t)), `modulus` E in Pa. The limit is 2.5 f_y / gamma_M6,ser
    for replaceable pins.
    """
    section = hinge.diameter**2 * hinge.bearing_width
    return LIGHT * float(np.sqrt(modulus * force * hinge.play / section))


def chain_strength(hinge: PinnedHinge, hinges: int, pin: PartStrength) -> float:
    """Return the tension (N) that shears off a link's pins: 0.6 f_u A in two sections a hinge (derived)."""
    return hinges * 2.0 * IN_SHEAR * pin.tensile * 0.25 * np.pi * hinge.diameter**2


class RollerTread(NamedTuple):
    """Tread of a roller on a rail."""

    radius: float
    """Radius, m."""
    width: float
    """Bearing width, m."""


class RollerContact(NamedTuple):
    """Line contact of a tread."""

    specific: float
    """Specific pressure K = F / (D b), Pa."""
    pressure: float
    """Greatest Hertz pressure, Pa."""
    to_yield: float
    """Factor on the stresses at which the rail yields below its surface."""
    to_shakedown: float
    """Factor at which the rail yields in every pass."""


def roller_contact(
    force: float, tread: RollerTread, yield_strength: float, modulus: float = 210e9, poisson: float = 0.3
) -> RollerContact:
    """Return the contact of a tread under a force (N) on a rail with a yield strength (Pa), both of steel.

    p = sqrt(F E / (2 pi R b (1 - nu^2))), with one E for both (Hertz). BOStrab TR Sp appendix 4 and FEM 1.001
    booklet 4 have the same formula. Stresses below the contact and shakedown are those of
    `fem.fatigue.line_contact` (Johnson).
    """
    plane = modulus / (2.0 * (1.0 - poisson**2))
    contact = hertz.line_contact(force / tread.width, tread.radius, plane)
    stress = hertz.path_stress(contact, yield_strength, poisson)
    specific = force / (2.0 * tread.radius * tread.width)
    return RollerContact(specific, float(contact.pressure), stress.to_yield, stress.to_shakedown)


def bending_of_shoe(force: float, width: float, rail: float) -> float:
    """Return the bending moment (N m) of a shoe at its middle on even ground: P (W / 4 - a).

    P is the force (N) on each of two rails at a = `rail` (m) from the middle, W the shoe's `width` (m):
    `docs/check-cases.md`.
    """
    return force * (0.25 * width - rail)
