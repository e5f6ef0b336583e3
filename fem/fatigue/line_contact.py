"""Line contact of a roller on a level rail by Hertz: pressure, stress below the surface, yield, shakedown.

Formulas: K. L. Johnson, Contact Mechanics (1985), sections 4.2(c) and 9.1; both bodies are elastic half
spaces of the same constants, in plane strain. x is the way of rolling from the contact's middle, z the depth.
Melan's theorem gives the load up to which plastic flow ceases after some passes.
"""

from typing import NamedTuple

import numpy as np

from fem.body.mesh import Floats

DEPTHS = np.linspace(0.0, 2.0, 41)
"""Over half widths of the contact, where stresses are looked at."""
PLACES = np.linspace(-2.6, 2.6, 61)
"""Same along the way of rolling, with the middle and where the shear along the surface is greatest."""
BALL_STEPS = 200
"""Steps to the smallest ball about points: its radius is good to half a per cent, and not too small."""


class LineContact(NamedTuple):
    """Contact of a roller and a rail.

    Attributes
    ----------
    pressure : float or array
        Greatest, Pa.
    half_width : float or array
        Along the way of rolling, m.
    """

    pressure: Floats
    half_width: Floats


def line_contact(line_load: float | Floats, radius: float, plane_modulus: float) -> LineContact:
    """Contact under a force per width.

    Parameters
    ----------
    line_load : float or array
        N/m, not negative.
    radius : float
        Of the roller, m.
    plane_modulus : float
        E / (2 (1 - nu^2)) of two bodies of the same steel, Pa.
    """
    pressure = np.sqrt(line_load * plane_modulus / (np.pi * radius))
    return LineContact(pressure, 2.0 * np.sqrt(line_load * radius / (np.pi * plane_modulus)))


def greatest_line_load(force: float | Floats, moment: float | Floats, width: float) -> Floats:
    """Force per width (N/m) at the more loaded edge of a contact whose force per width changes evenly.

    `force` (N) and `moment` (N m) about the middle of the `width` (m); beyond a sixth of the width the other
    edge lifts, and what is left of the contact carries a triangle.
    """
    force = np.asarray(force, dtype=float)
    arm = np.abs(np.divide(moment, force, out=np.zeros_like(force), where=force > 0.0))
    whole = force / width * (1.0 + 6.0 * arm / width)
    part = 2.0 / 3.0 * force / np.maximum(0.5 * width - arm, 1e-3 * width)
    return np.where(arm <= width / 6.0, whole, part)


def tilted_moment(force: float, tilt: float, width: float) -> float:
    """Moment (N m) of a contact of steel under a force (N), tilted by `tilt` (rad) across its `width` (m).

    The force per width changes with the approach as Palmgren's rollers do about the mean force: approach
    3.84e-5 mm (force in N)^0.9 / (width in mm)^0.8 (Harris, Rolling Bearing Analysis, 4th ed., 6.54).
    """
    approach = 3.84e-8 * force**0.9 / (1e3 * width) ** 0.8
    slope = force / width / (0.9 * approach) * abs(tilt)
    if slope * width**2 <= 2.0 * force:
        return slope * width**3 / 12.0
    return force * (0.5 * width - np.sqrt(2.0 * force / slope) / 3.0)


def stress_below(x: float | Floats, z: float | Floats, poisson: float) -> Floats:
    """Stresses (..., 4) xx, yy, zz, xz over the greatest pressure, at places over the half width.

    McEwen's form; the shear has the sign of the rail's axes, z downward.
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
    """Stress below a contact, Pa, with its depth (m), and factors of the load up to yield and shakedown."""

    shear: float
    depth: float
    to_yield: float
    to_shakedown: float

    @property
    def verdict(self) -> str:
        """Say what a path does under such contacts."""
        if self.to_yield >= 1.0:
            return "elastic"
        return "shakes down" if self.to_shakedown >= 1.0 else "ratchets"

    def of_strength(self, times: float) -> "PathStress":
        """Same for a yield strength so many times as high."""
        return self._replace(to_yield=times * self.to_yield, to_shakedown=times * self.to_shakedown)


def path_stress(
    contact: LineContact, yield_strength: float, poisson: float, beside: Floats | None = None
) -> PathStress:
    """Greatest shear below a contact, and by what its stresses may grow until yield and until ratchetting.

    Parameters
    ----------
    contact : LineContact
        Of one force per width.
    yield_strength : float
        Pa; von Mises.
    poisson : float
        Poisson's ratio.
    beside : array (k, 3), optional
        Stress of the structure xx, yy, xy (Pa) within the surface, the same over the contact's depth: first
        that with the roller above it, then others that come at other times.

    Notes
    -----
    Residual stresses xx and yy may be any at a depth. Then stresses shake down if all of them, over places
    and times, lie in a ball of radius k = yield / sqrt(3) in the space of deviators (Melan).
    """
    size = float(contact.pressure)
    k = yield_strength / np.sqrt(3.0)
    xx, yy, zz, xz = np.moveaxis(size * stress_below(PLACES, DEPTHS[:, None], poisson), -1, 0)
    others = np.zeros((1, 3)) if beside is None else np.atleast_2d(beside)
    here = _deviators(xx + others[0, 0], yy + others[0, 1], zz, np.full_like(xx, others[0, 2]), xz)
    # without the roller, unloaded or as at other times
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
    """Points (..., 4) whose distance from zero is the von Mises stress over sqrt(3).

    The first two can be moved by residual stresses xx and yy.
    """
    first = 0.5 * (xx - yy)
    second = (xx + yy - 2.0 * zz) / np.sqrt(12.0)
    return np.stack((first, second, xy, xz), axis=-1)


def _ball_radius(points: Floats) -> Floats:
    """Radii (d,) of the smallest balls about points (d, p, 4) whose centres have no last two coordinates.

    The centre goes to the farthest point by ever smaller steps (Badoiu and Clarkson, 2003).
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
