"""How far contacts and springs of a gear give way under the machine, and how much they are damped.

Contacts of steel give way by 0.01 to 0.1 mm (Hertz's line contact); those of the cases are softer, so that
steps need not be shorter than a millisecond. What lies outside of the bounds here is no machine's.
"""

import math
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

from exudyn_crawler.case.gear.arms import Arm
from exudyn_crawler.case.parameters.closed_track import Recoil, Tensioner
from exudyn_crawler.case.ph4100c import GRAVITY
from exudyn_crawler.settings import fields

_newtons = partial(fields.in_units, units={"GN": 1e9, "MN": 1e6, "kN": 1e3, "N": 1.0})
SHALLOWEST = 1e-6  # m, that a contact plausibly gives way at least
TYRE = 0.05  # of a roller's radius: how far its tread plausibly sinks into a rail, with rubber on it
TOOTH = 0.5  # of a lug's radius: how far it plausibly sinks into a tooth
PULL = 0.5  # of the weight on a track: its pull on the chain
SIDEWAYS = 0.3  # of a roller's load, which presses sideways on its flanges
MOST_DAMPED = 10.0  # of critical: damping beyond which nothing moves
LEAST_PRESSED = 1e-3  # m, by which the spring of an idler plausibly is pressed at least
MOST_PRESSED = 5.0  # pitches, at most
MOST_TURNED = 0.5  # rad, by which the weight plausibly turns a sprung arm from its place


class LoadedContact(NamedTuple):
    """Contact whose force is stiffness times depth to the power of an exponent, under a load."""

    path: str  # of the table with its stiffness and damping, and their beginning: "gear." or "gear.guide_"
    words: str  # what touches what
    load: float  # N
    share: str  # which load that is
    stiffness: float  # N/m^exponent
    exponent: float
    damping: float  # N s/m
    mass: float  # kg that moves against it

    @property
    def depth(self) -> float:
        """Depth (m) under the load."""
        return float((self.load / self.stiffness) ** (1.0 / self.exponent))

    def implausible(self, deepest: float, bound: str) -> Iterator[str]:
        """Lines about a depth beyond the deepest (m), which `bound` says in words, or none, and damping."""
        depth = self.depth
        under = f"under {self.share}, {_newtons(self.load)}"
        gives = f"{self.path}stiffness: {self.words} gives way by {depth:.3g} m {under}"
        unit = "N/m" if self.exponent == 1.0 else "N/m^exponent"
        if depth > deepest:
            yield f"{gives}, more than {bound}, {deepest:.3g} m; it is in {unit}"
        elif depth < SHALLOWEST:
            yield f"{gives}, less than {SHALLOWEST:g} m, the least of steel on steel; it is in {unit}"
        else:
            tangent = self.exponent * self.load / depth
            yield from over_damped(f"{self.path}damping", self.damping, tangent, self.mass)


def over_damped(path: str, damping: float, stiffness: float, mass: float) -> Iterator[str]:
    """Line about a damping far beyond the critical one, 2 sqrt(k m), of a mass (kg) on a stiffness (N/m)."""
    critical = 2.0 * math.sqrt(stiffness * mass)
    if damping > MOST_DAMPED * critical:
        times = f"{damping / critical:.3g} times the critical one of {mass:.4g} kg"
        yield f"{path}: {damping:g} N s/m is {times}, more than {MOST_DAMPED:g}; it is in N s/m"


def idler_spring(path: str, spring: Tensioner | Recoil, pitch: float, chain: float) -> Iterator[str]:
    """Lines about a spring that its preload presses too far, or hardly, and that is damped too much.

    With the idler move about half of the shoes, `chain` (kg).
    """
    if not spring.preload:
        return
    pressed = spring.preload / spring.stiffness
    presses = (
        f"{path}.stiffness: its preload of {_newtons(spring.preload)} presses the spring by {pressed:.3g} m"
    )
    if pressed > MOST_PRESSED * pitch:
        yield f"{presses}, more than {MOST_PRESSED:g} pitches; it is in N/m"
    elif pressed < LEAST_PRESSED:
        yield f"{presses}, less than {LEAST_PRESSED:g} m: it stands as on shims; it is in N/m"
    yield from over_damped(f"{path}.damping", spring.damping, spring.stiffness, spring.mass + chain)


def arm_spring(path: str, arm: Arm, roller: float, load: float) -> Iterator[str]:
    """Lines about the spring of an arm whose roller at x (m) carries a load, N."""
    lever = abs(roller - arm.pivot[0])
    turned = (load * lever - arm.torque) / arm.stiffness
    if abs(turned) > MOST_TURNED:
        way = "up" if turned > 0.0 else "down"
        turns = f"it turns {way} by {abs(turned):.3g} rad, more than {MOST_TURNED:g}"
        units = "torque is in N m, stiffness in N m/rad"
        yield f"{path}: under an even share of the weight, {_newtons(load)}, {turns}; {units}"
    if arm.stop is not None and arm.stop_stiffness < arm.stiffness:
        softer = f"{arm.stop_stiffness:g} N m/rad is softer than the spring's {arm.stiffness:g}"
        yield f"{path}.stop_stiffness: {softer}, so that it stops nothing"
    mass = load / GRAVITY
    critical = 2.0 * lever * math.sqrt(arm.stiffness * mass)
    if arm.damping > MOST_DAMPED * critical:
        times = f"{arm.damping / critical:.3g} times the critical one of {mass:.4g} kg on its roller"
        yield f"{path}.damping: {arm.damping:g} N m s/rad is {times}, more than {MOST_DAMPED:g}"
