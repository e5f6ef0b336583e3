"""Geometry of a closed chain: the belt about its wheels, and pins on it that are a pitch apart.

Everything lies in the plane of the chain, x along the travel and z up, in m. The chain runs forward below, up
round the front wheel, back above and down round the rear one, so that the loop's inside is on its left. The
pins lie on the belt: common tangents of circles through the pins, and arcs on these.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from scipy.optimize import brentq

CLOSED = 1e-9  # m, by which the ends of an assembled chain may be apart; what is reached is rounding
FIRST_PIN = 0.5  # its place on the belt, see `point_at`
TINY = 1e-12  # m or rad, least length of a piece that is divided by
ROUNDING = 1e-9  # share of a piece
MARCH = 0.25  # of a pitch, steps along the belt in which the next pin is sought

Point = tuple[float, float]
Circle = tuple[float, float, float]  # x and z of its centre, and its radius


class MisfitError(ValueError):
    """The chain does not close round its wheels."""


class WithinError(MisfitError):
    """A wheel lies within the chain about the others.

    Attributes
    ----------
    number : int
        Its number among the circles of the belt, from 0.
    depth, height : float
        How far it is from touching the chain, m, and the height of its axis at which it touches it.
    """

    def __init__(self, number: int, depth: float, height: float) -> None:
        super().__init__(f"wheel {number} lies {depth:.4g} m within the chain about the others")
        self.number = number
        self.depth = depth
        self.height = height


class Piece(NamedTuple):
    """Piece of a belt: an arc about a place, or a line that may sag as a parabola."""

    x: float  # centre of the arc, or begin of the line
    z: float
    radius: float  # zero for a line
    begin: float  # angle at which an arc begins, rad; for a line x of its end
    end: float  # the same at its end; z
    sag: float = 0.0  # of a line in its middle

    def at(self, t: float) -> Point:
        """Point at a share t of it, from 0 to 1."""
        if self.radius > 0.0:
            angle = self.begin + t * (self.end - self.begin)
            return self.x + self.radius * math.cos(angle), self.z + self.radius * math.sin(angle)
        z = self.z + t * (self.end - self.z) - 4.0 * self.sag * t * (1.0 - t)
        return self.x + t * (self.begin - self.x), z

    def share_ahead(self, t: float, chord: float) -> float:
        """Share at a chord (m) ahead of a share t, above 1 where that is beyond; NaN of a sagging line."""
        if self.sag != 0.0:
            return math.nan
        if self.radius == 0.0:
            return t + chord / max(self.length, TINY)
        if chord > 2.0 * self.radius:
            return math.inf
        return t + 2.0 * math.asin(0.5 * chord / self.radius) / max(self.end - self.begin, TINY)

    @property
    def length(self) -> float:
        """Length, of a sagging line to the second order."""
        if self.radius > 0.0:
            return self.radius * (self.end - self.begin)
        span = math.hypot(self.begin - self.x, self.end - self.z)
        return span * (1.0 + 8.0 / 3.0 * (self.sag / span) ** 2)


def tangent_angle(first: Circle, second: Circle) -> float:
    """Direction (rad) of the normal, away from the loop, of the line that touches both circles on its way.

    Raises `MisfitError` if they lie in each other.
    """
    x0, z0, r0 = first
    x1, z1, r1 = second
    apart = math.hypot(x1 - x0, z1 - z0)
    if abs(r0 - r1) >= apart:
        raise MisfitError(f"wheels at x = {x0:.4g} m and {x1:.4g} m lie in each other")
    return math.atan2(z1 - z0, x1 - x0) - math.acos((r0 - r1) / apart)


def _within(circles: Sequence[Circle], number: int) -> WithinError:
    """Say how far a circle is from touching the belt about its two neighbours."""
    before, this, after = (circles[(number + k) % len(circles)] for k in (-1, 0, 1))
    angle = tangent_angle(before, after)
    apart = (before[0] - this[0]) * math.cos(angle) + (before[1] - this[1]) * math.sin(angle)
    depth = apart + before[2] - this[2]
    return WithinError(number, depth, this[1] + depth / math.sin(angle))


def belt(circles: Sequence[Circle], sag: float = 0.0) -> list[Piece]:
    """Belt about circles (x, z, radius) in their order round the loop: an arc, a line, the next arc, ...

    The last line, which ends at the first circle, sags. Raises `WithinError` if a circle lies within the belt
    about the others, `MisfitError` if two lie in each other.
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
    """Point of a belt: the whole part of u, which may go round it again, is the piece, the rest the share."""
    k = math.floor(u)
    return pieces[k % len(pieces)].at(u - k)


def pins_along(pieces: Sequence[Piece], pitch: float, count: int) -> list[float]:
    """Places (see `point_at`) of count + 1 pins, each a pitch from the one before."""
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

        # a piece is left only where rounding leaves no doubt
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
    """Length along the belt, m, by which a chain of so many links overlaps its begin, or lacks it."""
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
    """Value (m) that makes a belt, its `shape`, so long that a chain of so many links closes on it.

    `what` names the value, for errors. A MisfitError with the length that is missing or left over, and the
    number of shoes that fits, beyond the value's bounds.
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
        chain = f"a chain of {count} shoes of {pitch:.5g} m"
        raise MisfitError(f"{chain} is too {how} by {length:.4f} m with {what} {value:.4g} m: {advice}")
    return float(brentq(left_over, *bounds, xtol=1e-16, rtol=1e-15))
