"""Plausible deflection and damping of a gear's contacts and springs under the machine.

Steel contacts deflect by 0.01 to 0.1 mm (Hertz's line contact). Contacts of the cases are softer, so that
steps need not be shorter than a millisecond. No machine is outside the bounds given here.
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
SHALLOWEST = 1e-6  # m, least plausible penetration of a contact
TYRE = 0.05  # greatest plausible penetration of a tread, also of rubber, fraction of the roller's radius
TOOTH = 0.5  # greatest plausible penetration of a lug into a tooth, fraction of the lug's radius
PULL = 0.5  # pull on the chain, fraction of the weight on its track
SIDEWAYS = 0.3  # lateral force on a roller's flanges, fraction of the roller's load
MOST_DAMPED = 10.0  # greatest plausible damping ratio; motion beyond it is negligible
LEAST_PRESSED = 1e-3  # m, least plausible compression of an idler's spring by its preload
MOST_PRESSED = 5.0  # greatest plausible compression of an idler's spring, pitches
MOST_TURNED = 0.5  # rad, greatest plausible rotation of a sprung arm under the weight


class LoadedContact(NamedTuple):
    """Contact under a load; its force is stiffness times a power of the depth."""

    path: str  # text before the keys stiffness and damping: "gear." or "gear.guide_"
    words: str  # name of the contacting part
    load: float  # N
    share: str  # description of the load
    stiffness: float  # N/m^exponent
    exponent: float
    damping: float  # N s/m
    mass: float  # kg, mass that moves on the contact

    @property
    def depth(self) -> float:
        """Penetration under the load, m."""
        return float((self.load / self.stiffness) ** (1.0 / self.exponent))

    def implausible(self, deepest: float, bound: str) -> Iterator[str]:
        """Yield a warning for a depth above `deepest` (m) or near zero, else for too much damping.

        `bound` describes the greatest depth in words.
        """
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
    """Yield a warning for a damping (N s/m) far above the critical one, 2 sqrt(k m), in N/m and kg."""
    critical = 2.0 * math.sqrt(stiffness * mass)
    if damping > MOST_DAMPED * critical:
        times = f"{damping / critical:.3g} times the critical one of {mass:.4g} kg"
        size = fields.four_digits(damping)
        yield f"{path}: {size} N s/m is {times}, more than {MOST_DAMPED:g}; it is in N s/m"


def idler_spring(path: str, spring: Tensioner | Recoil, pitch: float, chain: float) -> Iterator[str]:
    """Yield a warning for an implausible compression of a spring by its preload, and for its damping.

    `chain` is the mass (kg) of the shoes that move with the idler, about half of them.
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
    """Yield a warning for an implausible spring, stop or damper of an arm.

    The `roller` at x (m) carries `load`, N.
    """
    lever = abs(roller - arm.pivot[0])
    turned = (load * lever - arm.torque) / arm.stiffness
    if abs(turned) > MOST_TURNED:
        way = "up" if turned > 0.0 else "down"
        turns = f"it turns {way} by {abs(turned):.3g} rad, more than {MOST_TURNED:g}"
        units = "torque is in N m, stiffness in N m/rad"
        yield f"{path}: under an even share of the weight, {_newtons(load)}, {turns}; {units}"
    if arm.stop is not None and arm.stop_stiffness < arm.stiffness:
        stop, spring = map(fields.four_digits, (arm.stop_stiffness, arm.stiffness))
        softer = f"{stop} N m/rad is softer than the spring's {spring}"
        yield f"{path}.stop_stiffness: {softer}, so that it stops nothing"
    mass = load / GRAVITY
    critical = 2.0 * lever * math.sqrt(arm.stiffness * mass)
    if arm.damping > MOST_DAMPED * critical:
        times = f"{arm.damping / critical:.3g} times the critical one of {mass:.4g} kg on its roller"
        size = fields.four_digits(arm.damping)
        yield f"{path}.damping: {size} N m s/rad is {times}, more than {MOST_DAMPED:g}"
