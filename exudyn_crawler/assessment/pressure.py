"""Ground pressure of two tracks: by statics of two beams, and of one rigid plate on any ground.

Axes: see `assessment.forces`. Each track presses on a rectangle, without tension between track and ground.
The beams follow the statics of crane and rig guidance (triangle: eng-tips 185656). Further requirements of BR
470 (factors and platforms) are left out.
"""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from exudyn_crawler.assessment.forces import Floats, Numbers, Resultant

ALONG, ACROSS = 240, 12
"""Number of rectangles along and across each footprint in the sum of a plate's pressure."""
ITERATIONS = 60
"""Greatest number of Newton iterations to the rest position of a plate."""
CLOSE = 1e-10
"""Tolerance of the balance, fraction of the weight and of weight times length or gauge."""


class Footprints(NamedTuple):
    """Rectangles of both tracks on the ground, m."""

    gauge: float
    """Distance between the middles of the tracks."""
    length: float
    """Length on the ground."""
    width: float
    """Width of the shoes."""

    @property
    def area(self) -> float:
        """Area of both tracks, m2."""
        return 2.0 * self.length * self.width


class TrackPressure(NamedTuple):
    """Pressure under one track: arrays of the shape of its load; NaN and infinite if it tips."""

    greatest: Floats
    """Greatest pressure, Pa."""
    least: Floats
    """Least pressure, Pa; 0 if a part of the length is free."""
    mean: Floats
    """Mean pressure over the effective length, Pa."""
    length: Floats
    """Effective length, m."""
    even: Floats
    """Pressure of Meyerhof's even equivalent, ``load / (width (length - 2 |offset|))``, Pa."""


def track_loads(weight: Numbers, aside: Numbers, gauge: float) -> tuple[Floats, Floats]:
    """Return the loads of the left and the right track, N; one track bears all if the machine tips over it.

    P = V (1/2 +- y / B) (statics of a beam on two supports). The resultant acts at y (`aside`, m, to the
    left); B is the `gauge`, m.
    """
    share = np.clip(0.5 + np.asarray(aside) / gauge, 0.0, 1.0)
    return weight * share, weight * (1.0 - share)


def track_pressure(load: Numbers, ahead: Numbers, length: float, width: float) -> TrackPressure:
    """Return the pressure under a rigid track on linear ground without tension, for an eccentric load.

    Parameters
    ----------
    load : array
        N.
    ahead : array
        X of the load from the middle of the length, m.
    length, width : float
        Sides of the rectangle, m.

    Notes
    -----
    Up to an eccentricity e of a sixth of the length L, the pressure is a trapezoid, p = P / (b L) (1 +- 6 e /
    L). Beyond it is a triangle over ``L' = 3 (L / 2 - |e|)`` with p = 2 P / (b L') (Navier; no tension).
    Meyerhof's even pressure acts over ``L - 2 |e|`` (Meyerhof 1953, cited in FHWA GEC-6).
    """
    bears, away = np.broadcast_arrays(np.asarray(load, dtype=float), np.abs(np.asarray(ahead, dtype=float)))
    inside = away < 0.5 * length
    left = np.where(inside, 0.5 * length - away, np.nan)
    carries = np.minimum(length, 3.0 * left)
    whole = away <= length / 6.0
    middle = bears / (width * length)
    greatest = np.where(whole, middle * (1.0 + 6.0 * away / length), 2.0 * bears / (width * 3.0 * left))
    least = np.where(whole, middle * (1.0 - 6.0 * away / length), 0.0)
    return TrackPressure(
        np.where(inside, greatest, np.inf),
        np.where(inside, least, np.nan),
        np.where(inside, bears / (width * carries), np.inf),
        np.where(inside, carries, 0.0),
        np.where(inside, bears / (width * 2.0 * left), np.inf),
    )


def pressure_of_tracks(stands: Resultant, footprint: Footprints) -> tuple[TrackPressure, TrackPressure]:
    """Return the pressure under the left and the right track; both bear at one x (rigid frame)."""
    loads = track_loads(stands.weight, stands.aside, footprint.gauge)
    left, right = (track_pressure(load, stands.ahead, footprint.length, footprint.width) for load in loads)
    return left, right


class PlatePressure(NamedTuple):
    """Pressure under both tracks as one rigid plate."""

    greatest: float
    """Greatest pressure, Pa."""
    least: float
    """Least pressure, Pa."""
    x: Floats
    """X of the rectangles of the sum, (rectangles,), m."""
    y: Floats
    pressure: Floats
    """Pressure on the rectangles, Pa."""


Law = Callable[[Floats], tuple[Floats, Floats]]
"""Pressure (Pa) of the ground at depths (m), and its slope (Pa/m)."""


def linear_ground(stiffness: float) -> Law:
    """Return the law of Winkler ground: pressure over depth is `stiffness`, N/m3, without tension."""

    def law(depth: Floats) -> tuple[Floats, Floats]:
        pressed = depth > 0.0
        return stiffness * np.where(pressed, depth, 0.0), stiffness * pressed

    return law


def law_of_sinkage(sinkage: Callable[[float], float], greatest: float, points: int = 400) -> Law:
    """Return the pressure law of a ground from its sinkage (m) under pressures (Pa) up to a `greatest` one.

    The curve is straight between its points and beyond the last point.
    """
    pressures = greatest * np.linspace(0.0, 1.0, points + 1) ** 2
    depths = np.array([0.0, *(sinkage(float(pressure)) for pressure in pressures[1:])])
    slopes = np.diff(pressures) / np.diff(depths)

    def law(depth: Floats) -> tuple[Floats, Floats]:
        piece = np.clip(np.searchsorted(depths, depth, side="right") - 1, 0, len(slopes) - 1)
        slope = slopes[piece]
        pressed = depth > 0.0
        return np.where(pressed, pressures[piece] + slope * (depth - depths[piece]), 0.0), slope * pressed

    return law


def plate_pressure(
    weight: float, ahead: float, aside: float, footprint: Footprints, law: Law | None = None
) -> PlatePressure:
    """Return the pressure of both tracks as one rigid plate on ground without tension.

    Parameters
    ----------
    weight : float
        N, into the ground, at `ahead` and `aside` of the middle, m.
    footprint : Footprints
        Footprints of both tracks.
    law : Law, optional
        Pressure law of the ground. None: linear; its stiffness then has no effect.

    Raises
    ------
    ValueError
        If the weight acts outside the rectangle about both footprints, so that the machine tips.

    Notes
    -----
    The depth is a plane d = d0 + d1 x + d2 y; Newton's method finds the plane with pressures that balance
    weight and moments. On linear ground that carries everywhere, the pressure is P / A + M c / I of both
    rectangles. Here I_y = 2 b L^3 / 12 and I_x = 2 (b L B^2 / 4 + L b^3 / 12) (eng-tips 135414).
    """
    gauge, length, width = footprint
    if abs(ahead) >= 0.5 * length or abs(aside) >= 0.5 * (gauge + width):
        raise ValueError(
            f"the machine tips: its weight acts beyond its tracks, at x = {ahead:.4g} m, y = {aside:.4g} m"
        )
    along = length * ((np.arange(ALONG) + 0.5) / ALONG - 0.5)
    across = width * ((np.arange(ACROSS) + 0.5) / ACROSS - 0.5)
    y = np.concatenate((across - 0.5 * gauge, across + 0.5 * gauge))
    x, y = (place.ravel() for place in np.meshgrid(along, y, indexing="ij"))
    plane = np.stack((np.ones_like(x), x / length, y / gauge))
    part = footprint.area / len(x)
    wanted = weight * np.array([1.0, ahead / length, aside / gauge])
    ground = law or linear_ground(weight / footprint.area)
    motion = np.array([_even_depth(ground, weight / footprint.area), 0.0, 0.0])
    for _ in range(ITERATIONS):
        pressure, slope = ground(plane.T @ motion)
        missing = wanted - part * (plane @ pressure)
        if np.abs(missing).max() <= CLOSE * weight:
            break
        motion = _stepped(ground, plane, motion, np.linalg.solve(part * (plane * slope) @ plane.T, missing))
    else:
        raise ValueError(f"no plane of depths carries {weight:.4g} N at x = {ahead:.4g} m, y = {aside:.4g} m")
    sides = product((-0.5, 0.5), (-0.5, 0.5), (-1.0, 1.0))
    corners = np.array(
        [[1.0, x_side, y_side * (1.0 + edge * width / gauge)] for x_side, y_side, edge in sides]
    )
    at_corners = ground(corners @ motion)[0]
    return PlatePressure(float(at_corners.max()), float(at_corners.min()), x, y, pressure)


def _even_depth(law: Law, pressure: float) -> float:
    """Return the depth (m) at which a ground has a pressure (Pa)."""

    def excess(depth: float) -> float:
        return float(law(np.array([depth]))[0][0]) - pressure

    high = 1e-6
    while excess(high) < 0.0:
        high *= 2.0
    return float(brentq(excess, 0.0, high))


def _stepped(law: Law, plane: Floats, motion: Floats, step: Floats) -> Floats:
    """Return the motion after the largest part of Newton's step that keeps enough ground below the plate."""
    share = 1.0
    while np.count_nonzero(law(plane.T @ (motion + share * step))[0]) < plane.shape[1] // 50:
        share *= 0.5
    return motion + share * step


def bearing_capacity(undrained_strength: float, footprint: Footprints) -> float:
    """Return the pressure (Pa) at which clay below one track fails: 5.14 c_u (1 + 0.2 b / L).

    `undrained_strength` is c_u, Pa. Prandtl, with Skempton's shape factor (remembered). Crawler cranes in
    tests reached up to 1.5 times this pressure (Liu, Chan and Gerbrandt, Canadian Geotechnical Journal,
    abstract).
    """
    short, long = sorted((footprint.width, footprint.length))
    return 5.14 * undrained_strength * (1.0 + 0.2 * short / long)


def mean_maximum_pressure(
    weight: float, rollers: int, link_area: float, width: float, pitch: float, diameter: float
) -> float:
    """Return the mean of the greatest pressures below the rollers of link tracks on soft ground, Pa.

    MMP = 1.26 W / (2 n A_l b sqrt(p D)) (Rowland 1972, remembered), in kN, m and kPa.

    Parameters
    ----------
    weight : float
        Weight of the machine, N.
    rollers : int
        Number of rollers of one track on the ground.
    link_area : float
        Area of a shoe over width times pitch.
    width, pitch, diameter : float
        Width of the shoe, pitch of the chain and diameter of a roller, m.
    """
    return 1.26 * weight / (2.0 * rollers * link_area * width * np.sqrt(pitch * diameter))
