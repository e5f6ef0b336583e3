"""Geometry of a closed chain: the belt about its wheels, and pins on it at a distance of a pitch.

All places are in the plane of the chain, x along the travel and z up, in m. The chain runs forward below, up
round the front wheel, back above, and down round the rear one. The inside of the loop is on its left. The
pins are on the belt, which consists of arcs on the pins' circles and of common tangents of these circles.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from scipy.optimize import brentq

CLOSED = 1e-9  # m, greatest distance of an assembled chain's ends; rounding alone is left
FIRST_PIN = 0.5  # place of the first pin on the belt, see `point_at`
TINY = 1e-12  # m or rad, least length of a piece as a divisor
ROUNDING = 1e-9  # tolerance of a place on the belt, fraction of a piece
MARCH = 0.25  # step along the belt in the search for the next pin, fraction of a pitch

Point = tuple[float, float]
Circle = tuple[float, float, float]  # x and z of its centre, and its radius


class MisfitError(ValueError):
    """Error for a chain that does not close round its wheels."""


class WithinError(MisfitError):
    """Error for a wheel within the chain about the others.

    Attributes
    ----------
    number : int
        Number of the wheel among the circles of the belt, from 0.
    depth, height : float
        Distance of the wheel from the chain, m, and the height of its axis (z, m) at which they touch.
    """

    def __init__(self, number: int, depth: float, height: float) -> None:
        super().__init__(f"wheel {number} lies {depth:.4g} m within the chain about the others")
        self.number = number
        self.depth = depth
        self.height = height


class Piece(NamedTuple):
    """Piece of a belt: an arc about a point, or a line that may sag as a parabola."""

    x: float  # m, centre of the arc, or start of the line
    z: float
    radius: float  # m, zero for a line
    begin: float  # rad, start angle of an arc; x of a line's end, m
    end: float  # rad, end angle of an arc; z of a line's end, m
    sag: float = 0.0  # m, depth of a line's middle

    def at(self, t: float) -> Point:
        """Return the point at a fraction t of the piece, from 0 to 1."""
        if self.radius > 0.0:
            angle = self.begin + t * (self.end - self.begin)
            return self.x + self.radius * math.cos(angle), self.z + self.radius * math.sin(angle)
        z = self.z + t * (self.end - self.z) - 4.0 * self.sag * t * (1.0 - t)
        return self.x + t * (self.begin - self.x), z

    def share_ahead(self, t: float, chord: float) -> float:
        """Return the fraction at a chord (m) ahead of a fraction t, above 1 if beyond; NaN with a sag."""
        if self.sag != 0.0:
            return math.nan
        if self.radius == 0.0:
            return t + chord / max(self.length, TINY)
        if chord > 2.0 * self.radius:
            return math.inf
        return t + 2.0 * math.asin(0.5 * chord / self.radius) / max(self.end - self.begin, TINY)

    @property
    def length(self) -> float:
        """Length, m; of a sagging line to the second order in the sag."""
        if self.radius > 0.0:
            return self.radius * (self.end - self.begin)
        span = math.hypot(self.begin - self.x, self.end - self.z)
        return span * (1.0 + 8.0 / 3.0 * (self.sag / span) ** 2)


def tangent_angle(first: Circle, second: Circle) -> float:
    """Return the direction (rad) of the outward normal of the tangent from the first circle to the second.

    Raises `MisfitError` if one circle is inside the other.
    """
    x0, z0, r0 = first
    x1, z1, r1 = second
    apart = math.hypot(x1 - x0, z1 - z0)
    if abs(r0 - r1) >= apart:
        raise MisfitError(f"wheels at x = {x0:.4g} m and {x1:.4g} m overlap")
    return math.atan2(z1 - z0, x1 - x0) - math.acos((r0 - r1) / apart)


def _within(circles: Sequence[Circle], number: int) -> WithinError:
    """Return the error for a circle within the belt about its two neighbours."""
    before, this, after = (circles[(number + k) % len(circles)] for k in (-1, 0, 1))
    angle = tangent_angle(before, after)
    apart = (before[0] - this[0]) * math.cos(angle) + (before[1] - this[1]) * math.sin(angle)
    depth = apart + before[2] - this[2]
    return WithinError(number, depth, this[1] + depth / math.sin(angle))


def belt(circles: Sequence[Circle], sag: float = 0.0) -> list[Piece]:
    """Return the belt about circles (x, z, radius) in their order round the loop: arc, line, next arc, ...

    The last line, which ends at the first circle, has the sag. Raises `WithinError` for a circle within the
    belt about the others, and `MisfitError` for a circle inside its neighbour.
    """
    following = [*circles[1:], circles[0]]
    pieces = list[Piece]()
    tangents = [tangent_angle(*pair) for pair in zip(circles, following, strict=True)]
    for k, (x, z, r) in enumerate(circles):
        first = tangents[k - 1]
        last = tangents[k]
        last += 2.0 * math.pi * math.ceil((first - last) / (2.0 * math.pi) - 1e-9)
        if last - first > 1.5 * math.pi:
            raise _within(circles, k)
        x1, z1, r1 = circles[(k + 1) % len(circles)]
        c = math.cos(last)
        s = math.sin(last)
        pieces.append(Piece(x, z, r, first, last))
        sags = sag if k == len(circles) - 1 else 0.0
        pieces.append(Piece(x + r * c, z + r * s, 0.0, x1 + r1 * c, z1 + r1 * s, sags))
    return pieces


def point_at(pieces: Sequence[Piece], u: float) -> Point:
    """Return the point of a belt at the place u: its whole part is the piece, the rest the fraction of it.

    A place beyond the last piece goes round the belt again.
    """
    k = math.floor(u)
    return pieces[k % len(pieces)].at(u - k)


def pins_along(pieces: Sequence[Piece], pitch: float, count: int) -> list[float]:
    """Return the places (see `point_at`) of count + 1 pins, each a pitch from the one before."""
    pins = [FIRST_PIN]
    steps = [MARCH * pitch / max(piece.length, TINY) for piece in pieces]
    for _ in range(count):
        number = math.floor(pins[-1])
        share = pieces[number % len(pieces)].share_ahead(pins[-1] - number, pitch)
        if share <= 1.0:
            pins.append(number + share)
            continue
        x, z = point_at(pieces, pins[-1])

        def beyond(u: float, x: float = x, z: float = z) -> float:
            there = point_at(pieces, u)
            return math.hypot(there[0] - x, there[1] - z) - pitch

        # the tolerance keeps a pin at the end of the piece if rounding decides
        low = pins[-1] if math.isnan(share) else max(pins[-1], number + 1.0 - ROUNDING)
        while True:
            k = math.floor(low + 1e-13)
            high = min(k + 1.0, low + steps[k % len(pieces)] + 1e-9)
            if beyond(high) >= 0.0:
                break
            low = high
        pins.append(float(brentq(beyond, low, high, xtol=1e-16, rtol=1e-15)))
    return pins


def surplus(pieces: Sequence[Piece], pitch: float, count: int) -> float:
    """Return the surplus length along the belt, m, of a chain with `count` links; negative if too short."""
    last = pins_along(pieces, pitch, count)[-1]
    end = FIRST_PIN + len(pieces)
    low = min(last, end)
    high = max(last, end)
    total = 0.0
    u = low
    while u < high:
        k = math.floor(u + 1e-15)
        to = min(high, k + 1.0)
        total = total + pieces[k % len(pieces)].length * (to - u)
        u = to
    return math.copysign(total, last - end)


def closed_chain(
    shape: Callable[[float], list[Piece]], pitch: float, count: int, bounds: tuple[float, float], what: str
) -> float:
    """Return the value (m) of a belt's `shape` at which a chain of `count` links closes on the belt.

    `what` names the value in errors. Raises `MisfitError` if the value is beyond its bounds; the error gives
    the missing or surplus length and the number of shoes that fits.
    """

    def left_over(value: float, links: int = count) -> float:
        return surplus(shape(value), pitch, links)

    least = left_over(bounds[0])
    greatest = left_over(bounds[1])
    if least < 0.0 or greatest > 0.0:
        length, value = (-least, bounds[0]) if least < 0.0 else (greatest, bounds[1])
        change = math.ceil(length / pitch) if least < 0.0 else -math.ceil(length / pitch)
        how = "short" if least < 0.0 else "long"
        other = count + change
        advice = f"no number of shoes fits between {bounds[0]:.4g} and {bounds[1]:.4g} m"
        if left_over(bounds[0], other) >= 0.0 >= left_over(bounds[1], other):
            advice = f"{other} shoes fit"
        chain = f"a chain of {count} shoes of {pitch:.4g} m"
        raise MisfitError(f"{chain} is too {how} by {length:.4f} m with {what} {value:.4g} m: {advice}")
    return float(brentq(left_over, *bounds, xtol=1e-16, rtol=1e-15))
