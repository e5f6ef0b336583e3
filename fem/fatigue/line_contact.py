"""Hertzian line contact of a roller on a level rail: pressure, stress below the surface, yield, shakedown.

Formulas: K. L. Johnson, Contact Mechanics (1985), sections 4.2(c) and 9.1. Both bodies are elastic half
spaces of the same constants, in plane strain. x is the rolling direction from the contact's middle, z the
depth. Melan's theorem gives the shakedown limit: below it plastic flow ceases after some passes.
"""

from typing import NamedTuple

import numpy as np

from fem.body.mesh import Floats

DEPTHS = np.linspace(0.0, 2.0, 41)
"""Depths of the evaluated stresses, multiples of the contact's half width."""
PLACES = np.linspace(-2.6, 2.6, 61)
"""Positions along the rolling direction, multiples of the half width; they hold the middle and the greatest
shear along the surface."""
BALL_STEPS = 200
"""Number of steps to the smallest ball around points: its radius is within 0.5 % and never too small."""


class LineContact(NamedTuple):
    """Contact of a roller and a rail.

    Attributes
    ----------
    pressure : float or array
        Greatest pressure, Pa.
    half_width : float or array
        Half width along the rolling direction, m.
    """

    pressure: Floats
    half_width: Floats


def line_contact(line_load: float | Floats, radius: float, plane_modulus: float) -> LineContact:
    """Return the contact under a force per width.

    Parameters
    ----------
    line_load : float or array
        N/m, not negative.
    radius : float
        Radius of the roller, m.
    plane_modulus : float
        E / (2 (1 - nu^2)) of two bodies of the same steel, Pa.
    """
    pressure = np.sqrt(line_load * plane_modulus / (np.pi * radius))
    return LineContact(pressure, 2.0 * np.sqrt(line_load * radius / (np.pi * plane_modulus)))


def greatest_line_load(force: float | Floats, moment: float | Floats, width: float) -> Floats:
    """Return the force per width (N/m) at the more loaded edge of a contact with linear load distribution.

    `force` (N) and `moment` (N m) act about the middle of the `width` (m). The other edge lifts if the
    eccentricity exceeds a sixth of the width; the rest of the contact then carries a triangular load.
    """
    force = np.asarray(force, dtype=float)
    arm = np.abs(np.divide(moment, force, out=np.zeros_like(force), where=force > 0.0))
    whole = force / width * (1.0 + 6.0 * arm / width)
    part = 2.0 / 3.0 * force / np.maximum(0.5 * width - arm, 1e-3 * width)
    return np.where(arm <= width / 6.0, whole, part)


def tilted_moment(force: float, tilt: float, width: float) -> float:
    """Return the moment (N m) of a steel contact under `force` (N), tilted by `tilt` (rad) over `width` (m).

    The force per width changes with the approach at the rate of Palmgren's law for rollers at the mean force:
    approach 3.84e-5 mm (force in N)^0.9 / (width in mm)^0.8 (Harris, Rolling Bearing Analysis, 4th ed.,
    6.54).
    """
    approach = 3.84e-8 * force**0.9 / (1e3 * width) ** 0.8
    slope = force / width / (0.9 * approach) * abs(tilt)
    if slope * width**2 <= 2.0 * force:
        return slope * width**3 / 12.0
    return force * (0.5 * width - np.sqrt(2.0 * force / slope) / 3.0)


def stress_below(x: float | Floats, z: float | Floats, poisson: float) -> Floats:
    """Return the stresses (..., 4) xx, yy, zz, xz, as multiples of the greatest pressure.

    `x` and `z` are multiples of the half width. The formulas are McEwen's; the shear has the sign of the
    rail's axes, z downward.
    """
    x, z = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(z, dtype=float))
    part = 1.0 - x**2 + z**2
    root = np.sqrt(part**2 + 4.0 * x**2 * z**2)
    m = np.sqrt(np.maximum(0.5 * (root + part), 0.0))
    n = np.sign(x) * np.sqrt(np.maximum(0.5 * (root - part), 0.0))
    whole = np.maximum(m**2 + n**2, 1e-300)
    xx = -m * (1.0 + (z**2 + n**2) / whole) + 2.0 * z
    zz = -m * (1.0 - (z**2 + n**2) / whole)
    xz = -n * (m**2 - z**2) / whole
    return np.stack((xx, poisson * (xx + zz), zz, xz), axis=-1)


class PathStress(NamedTuple):
    """Stress below a contact, Pa, with its depth (m), and load factors to yield and to shakedown."""

    shear: float
    depth: float
    to_yield: float
    to_shakedown: float

    @property
    def verdict(self) -> str:
        """Response of a path to repeated contacts: "elastic", "shakes down" or "ratchets"."""
        if self.to_yield >= 1.0:
            return "elastic"
        return "shakes down" if self.to_shakedown >= 1.0 else "ratchets"

    def of_strength(self, times: float) -> "PathStress":
        """Return the result for a yield strength `times` as high."""
        return self._replace(to_yield=times * self.to_yield, to_shakedown=times * self.to_shakedown)


def path_stress(
    contact: LineContact, yield_strength: float, poisson: float, beside: Floats | None = None
) -> PathStress:
    """Find the greatest shear below a contact and the load factors to yield and to ratchetting.

    Parameters
    ----------
    contact : LineContact
        Contact under one force per width.
    yield_strength : float
        Von Mises yield strength, Pa.
    poisson : float
        Poisson's ratio.
    beside : array (k, 3), optional
        Stress of the structure xx, yy, xy (Pa) within the surface, constant over the contact's depth. The
        first row is with the roller above, the others are stresses at other times.

    Notes
    -----
    Residual stresses xx and yy may have any values at a depth. The stresses there shake down if all of them,
    over positions and times, lie in a ball of deviators (Melan). Its radius is k = yield / sqrt(3).
    """
    size = float(contact.pressure)
    k = yield_strength / np.sqrt(3.0)
    xx, yy, zz, xz = np.moveaxis(size * stress_below(PLACES, DEPTHS[:, None], poisson), -1, 0)
    others = np.zeros((1, 3)) if beside is None else np.atleast_2d(beside)
    here = _deviators(xx + others[0, 0], yy + others[0, 1], zz, np.full_like(xx, others[0, 2]), xz)
    # without the roller: unloaded, or loaded as at other times
    away = np.concatenate((np.zeros((1, 3)), others[1:]))
    none = np.zeros(len(away))
    rest = _deviators(away[:, 0], away[:, 1], none, away[:, 2], none)
    shear = np.hypot(0.5 * (xx - zz), xz)
    row = int(shear.max(axis=1).argmax())
    points = np.concatenate((here, np.broadcast_to(rest, (len(DEPTHS), *rest.shape))), axis=1)
    return PathStress(
        float(shear.max()),
        float(DEPTHS[row] * contact.half_width),
        float(k / np.linalg.norm(here, axis=-1).max()),
        float(k / _ball_radius(points).max()),
    )


def _deviators(xx: Floats, yy: Floats, zz: Floats, xy: Floats, xz: Floats) -> Floats:
    """Return points (..., 4) whose distance from zero is the von Mises stress over sqrt(3).

    Residual stresses xx and yy shift the first two coordinates.
    """
    first = 0.5 * (xx - yy)
    second = (xx + yy - 2.0 * zz) / np.sqrt(12.0)
    return np.stack((first, second, xy, xz), axis=-1)


def _ball_radius(points: Floats) -> Floats:
    """Return radii (d,) of the smallest balls around points (d, p, 4); the centres end with two zeros.

    The centre moves towards the farthest point in ever smaller steps (Badoiu and Clarkson, 2003).
    """
    center = np.zeros((len(points), 1, points.shape[2]))
    radius = np.full(len(points), np.inf)
    rows = np.arange(len(points))
    for step in range(1, BALL_STEPS + 1):
        away = points - center
        lengths = np.linalg.norm(away, axis=-1)
        farthest = lengths.argmax(axis=1)
        radius = np.minimum(radius, lengths[rows, farthest])
        center[:, 0, :2] += away[rows, farthest, :2] / (step + 1)
    return radius
