"""Rules of undercarriages: one value from others. Lengths in m, masses in kg, forces in N, angles in rad."""

import math
from collections.abc import Callable

import numpy as np

from exudyn_crawler.case.parameters.track import STEEL_DENSITY

WHEEL_WIDTH = 0.8  # width of a wheel over its radius (chosen here)


def pitch_by_mass(mass: float, factor: float) -> float:
    """Return the pitch of a machine from its mass: factor times the third root of the tonnes.

    Source: pitches from 171 mm at 12 t to 656 mm at 1410 t, three of them seen, lie within 15 % of 0.066.
    """
    return factor * (1e-3 * mass) ** (1.0 / 3.0)


def closing_pitch(shoes: int, lengths: Callable[[float], tuple[float, float]]) -> float:
    """Return the pitch of a chain of N shoes that closes about two equal circles: ``N p = 2 C + pi d``.

    `lengths` gives the length on ground C and the diameter d of the pins' circles at a pitch. Both are linear
    in the pitch, so that their values at two pitches give the solution.
    """
    excess = [shoes * pitch - loop_length(*lengths(pitch)) for pitch in (0.0, 1.0)]
    return excess[0] / (excess[0] - excess[1])


def pitch_of_ends(ends: float, gaps: float, depth: float, grouser: float) -> float:
    """Return the pitch at which sprocket, idler and shoes fill the crawler length beyond the ground, m.

    ``L - C = p / sin(pi / z) + 2 (depth p + grouser)``, depth in pitches.
    """
    return (ends - 2.0 * grouser) / (1.0 / math.sin(math.pi / gaps) + 2.0 * depth)


def pin_circle(pitch: float, gaps: float) -> float:
    """Return the diameter of the pins' circle of a sprocket, ``p / sin(pi / z)``.

    z is 10.5 for 21 teeth of a half-pitch sprocket (Case CX350B: 215.9 mm and 732.5 mm).
    """
    return pitch / math.sin(math.pi / gaps)


def gaps_of(pitch: float, diameter: float) -> float:
    """Return the gaps of a sprocket from the diameter of its pins' circle; the inverse of `pin_circle`."""
    return math.pi / math.asin(min(1.0, pitch / diameter))


def loop_length(on_ground: float, diameter: float) -> float:
    """Return the length of a chain about two equal circles: ``2 C + pi d``."""
    return 2.0 * on_ground + math.pi * diameter


def ground_length(on_ground: float, over_shoes: float, share: float) -> float:
    """Return the length in a printed ground pressure: C + share (L - C).

    Source: ISO 16754 has a share of 0.35 (remembered); sheets of excavators have 0.30 to 0.42, dozers 0.
    """
    return on_ground + share * (over_shoes - on_ground)


def ground_pressure(mass: float, width: float, length: float, gravity: float) -> float:
    """Return the mean pressure (Pa) below two tracks from their width and length."""
    return mass * gravity / (2.0 * width * length)


def clear_of(radius: float, other: float, height: float, play: float) -> float:
    """Return the distance along the track between wheel axes with a height difference and a clearance."""
    apart = radius + other + play
    return math.sqrt(max(0.0, apart**2 - height**2))


def box_inertia(mass: float, length: float, width: float, height: float) -> np.ndarray:
    """Return the moments of inertia of a box about its middle: array (3,), kg m2."""
    x, y, z = length**2, width**2, height**2
    return mass / 12.0 * np.array([y + z, x + z, x + y])


def ring_inertia(mass: float, radius: float) -> np.ndarray:
    """Return the moments of inertia of a wheel about x, y (its axis) and z, array (3,), kg m2.

    The wheel is between disc and ring: half of ``m r2`` about the axis, as a disc; 0.3 across, for a width of
    `WHEEL_WIDTH`.
    """
    return mass * radius**2 * np.array([0.3, 0.5, 0.3])


def solid_wheel(radius: float) -> float:
    """Return the mass (kg) of a wheel of solid steel, the greatest for its radius (m)."""
    return STEEL_DENSITY * math.pi * WHEEL_WIDTH * radius**3


def sprocket_torque(pull: float, radius: float, efficiency: float) -> float:
    """Return the torque of a sprocket for the pull of both tracks: 0.5 F r / eta."""
    return 0.5 * pull * radius / efficiency
