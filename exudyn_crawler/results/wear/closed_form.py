"""Work of a pin in a lap of its chain, by tensions and bends at tumbler and idler, without a run."""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.case.gear.closed import Closed


class Bends(NamedTuple):
    """Angles by which a hinge bends on to a wheel, and again off it, rad."""

    tumbler: float
    idler: float


class WheelTensions(NamedTuple):
    """Mean tensions of the chain beside its end wheels, N."""

    tumbler_below: float
    tumbler_above: float
    idler_above: float
    idler_below: float


def bends(shoes_per_turn: float, pitch: float, idler_radius: float, rise: float) -> Bends:
    """Return the bends of a chain: 2 pi / n on the tumbler, 2 atan(p / 2 / (R + h)) on the idler.

    n is the number of shoes in a turn of the tumbler, p the pitch, R the idler's radius, h the `rise` of the
    rails above the pins, m.
    """
    return Bends(2.0 * math.pi / shoes_per_turn, 2.0 * math.atan2(0.5 * pitch, idler_radius + rise))


def bends_of(case: Case) -> Bends:
    """Return the bends of the chain of a closed track."""
    closed = case.part(Closed)
    rails = case.shoe.roller_path
    rise = rails.height - case.track.pin_height
    pitch = closed.chain_pitch(case.track)
    return bends(closed.tumbler.shoes_per_turn, pitch, closed.idler.radius, rise)


def pin_work(radius: float, angles: Bends, tensions: WheelTensions) -> float:
    """Return the work F r abs(theta) of a pin in a lap, J: r [a_t (T1 + T2) + a_i (T3 + T4)].

    Neighbouring shoes turn by the bend as they come on to a wheel, under the tension there, and back as they
    leave it. `radius` of the pin is in m.
    """
    at_tumbler = angles.tumbler * (tensions.tumbler_below + tensions.tumbler_above)
    return radius * (at_tumbler + angles.idler * (tensions.idler_above + tensions.idler_below))


def pin_drag(case: Case, tension: float) -> float:
    """Return the resistance (N) to the motion of a chain by the losses of its pins, with one tension (N).

    ``mu r (2 a_t T + 2 a_i T) / p``, and of rubber bushes ``pi / 2 eta k (a_t^2 + a_i^2) / p`` by Reid's law
    (`model.joints.friction`): what each pin takes in a lap, at the bends over tumbler and idler alone.
    """
    pitch = case.part(Closed).chain_pitch(case.track)
    law = case.track.pin.law(case.track.pitch)
    angles = bends_of(case)
    rubbed = pin_work(law.lever, angles, WheelTensions(*[tension] * 4))
    twisted = 0.5 * math.pi * law.loss * law.stiffness * (angles.tumbler**2 + angles.idler**2)
    return (rubbed + twisted) / pitch


def take_up_of(growth: float, shoes: int, pitch: float) -> float:
    """Return the take-up (m) for a growth of the pitch (m): half of that of the chain, N p g / 2."""
    return 0.5 * shoes * pitch * growth


class GrowthLimit(NamedTuple):
    """Growth of the pitch at which something ends."""

    limit: str
    growth: float
    how: str


def growth_limits(case: Case, take_up: float, turning: GrowthLimit) -> list[GrowthLimit]:
    """Return the limits of the growth of a chain's pitch, the least first.

    `take_up` (m) is that of the chain now, `turning` the limit at which pins and bushes are turned.
    """
    closed = case.part(Closed)
    now = closed.pitch_growth
    shoes = case.track.shoe_count // case.gear.tracks
    pitch = case.track.pitch
    tumbler = closed.tumbler
    radius = tumbler.radius(pitch)
    reach = tumbler.tip_radius(pitch) - radius
    left = closed.idler.range[1] - take_up
    limits = [
        GrowthLimit(
            "adjuster used up",
            now + max(left, 0.0) / take_up_of(1.0, shoes, pitch),
            f"take-up {1e3 * take_up:.1f} of {1e3 * closed.idler.range[1]:.1f} mm, N p g / 2",
        ),
        GrowthLimit(
            "bushes at the tips of the teeth",
            reach / radius,
            f"bushes stand R g higher, tips {1e3 * reach:.2f} mm above the pins' circle of "
            f"{1e3 * radius:.1f} mm; geometry, teeth without play",
        ),
        turning,
    ]
    return sorted(limits, key=lambda limit: limit.growth)


def mean_tensions(
    tension: np.ndarray, x: np.ndarray, upper: np.ndarray, ends: tuple[float, float], pitch: float
) -> WheelTensions:
    """Return the mean tensions (N) of links 0.6 to 2.6 pitches from the wheels' axes.

    `tension` (N), `x` of the pins in the frame (m) and `upper`, True for the upper run, are (times, joints);
    `ends` are x of tumbler and idler, m.
    """
    rear, front = ends

    def mean(run: np.ndarray, begin: float, end: float) -> float:
        here = run & (x > begin) & (x < end)
        return float(tension[here].mean()) if here.any() else math.nan

    near, far = 0.6 * pitch, 2.6 * pitch
    return WheelTensions(
        mean(~upper, rear + near, rear + far),
        mean(upper, rear + near, rear + far),
        mean(upper, front - far, front - near),
        mean(~upper, front - far, front - near),
    )
