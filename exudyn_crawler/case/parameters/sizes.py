"""Checks of sizes: pins within their shoe, inertias for mass and extent, wheels without overlap."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case.parameters import base, track
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors

ROUNDING = 1e-9  # m, tolerance of places at a bound; also a relative one of inertias
DENSEST = 8000.0  # kg/m3, density of steel, the greatest of any part
COMPONENTS = ("Ixx", "Iyy", "Izz")


class Round(NamedTuple):
    """Wheel seen along its axis."""

    name: str
    x: float  # of its axis, m
    z: float
    radius: float


def pin_errors(shoe: track.Shoe, chain: track.Track) -> Errors:
    """Yield an error for each pin beyond the sides of its shoe or below its underside."""
    _, _, low, high, underside = shoe.footprint + np.array([0.0, 0.0, *2 * [chain.first_com[1]], 0.0])
    for name in ("spherical_y", "parallel_y"):
        place = getattr(chain, name)
        if not low - ROUNDING <= place <= high + ROUNDING:
            width = f"the shoe's width of {shoe.width:.4g} m, from {low:.4g} to {high:.4g} m"
            yield f"track.{name} must lie within {width}, got {place:g}"
    if chain.pin_height <= underside:
        above = f"above the shoe's underside at {underside:.4g} m"
        yield f"track.pin_height must be {above}, got {chain.pin_height:g}"


def wide_inertia(name: str, mass: float, inertia: base.Six, reach: Sequence[float]) -> Iterator[str]:
    """Yield a warning for each moment of inertia above that of the whole mass (kg) at the body's corners.

    `reach` is the body's extent from its COM along its axes, m.
    """
    squares = np.square(reach)
    for component, value, most in zip(COMPONENTS, inertia, mass * (squares.sum() - squares), strict=False):
        if value > most * (1.0 + ROUNDING):
            extent = " x ".join(f"{2.0 * distance:.3g}" for distance in reach)
            whole = fields.quantity_text(mass, "kg")
            corners = f"more than the {most:.4g} of {whole} at the corners of {extent} m"
            size = f"{component} is {fields.four_digits(value)} kg m2"
            yield f"{name}.inertia: {size}, {corners}; it may be that of another size"


def shoe_reach(shoe: track.Shoe, chain: track.Track) -> tuple[float, float, float]:
    """Return the extent of a shoe from its COM along its axes, m; up and down it is at most the pitch."""
    rear, front, right, left, _ = np.abs(shoe.footprint)
    along = max(rear, front, chain.pin_ahead, chain.pitch - chain.pin_ahead)
    return along, max(right, left), max(chain.pitch, shoe.com_height)


def thin_inertia(name: str, mass: float, inertia: base.Six) -> Iterator[str]:
    """Yield a warning if the inertia is below that of a solid steel ball, the least for a mass (kg)."""
    radius = (0.75 * mass / (math.pi * DENSEST)) ** (1.0 / 3.0)
    least = 1.2 * mass * radius**2
    trace = sum(inertia[:3])
    if trace < least:
        moments = f"Ixx + Iyy + Izz is {trace:.4g} kg m2 with {fields.quantity_text(mass, 'kg')}"
        ball = f"less than the {least:.4g} of a ball of steel, which has the least"
        yield f"{name}.inertia: {moments}, {ball}; it may be that of another size"


def far_inertia(name: str, mass: float, inertia: base.Six, length: float) -> Iterator[str]:
    """Yield a warning if a radius of gyration exceeds `length` (m)."""
    radius = math.sqrt(np.linalg.eigvalsh(base.inertia_tensor(inertia))[-1] / mass)
    if radius > length:
        whole = fields.quantity_text(mass, "kg")
        gives = f"it gives a radius of gyration of {radius:.3g} m with {whole}, more than {length:.3g} m"
        yield f"{name}.inertia: {gives}; it may be that of another size"


def overlap_errors(wheels: Sequence[Round], tolerance: float = 1e-6) -> Errors:
    """Yield an error for each overlap of wheels of different groups: rollers, carriers, tumbler and idler."""
    for k, wheel in enumerate(wheels):
        for other in wheels[k + 1 :]:
            if wheel.name.split()[0] == other.name.split()[0]:
                continue
            apart = math.hypot(wheel.x - other.x, wheel.z - other.z)
            inside = wheel.radius + other.radius - apart
            if inside > tolerance:
                are = f"axes {apart:.4g} m apart, radii {wheel.radius:.4g} and {other.radius:.4g} m"
                by = f"they do by {1e3 * inside:.3g} mm"
                yield f"{wheel.name} and {other.name} must not overlap, {by}: {are}"
