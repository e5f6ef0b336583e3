"""Travel on two tracks: what straight travel, a grade and a turn ask for, and what ground and drive give.

Two tracks at the distance B, each on a rectangle of the length L and the shoes' width; the names of parts of
the resistance are those of the Caterpillar Performance Handbook (rolling and grade resistance).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar, root

from exudyn_crawler.assessment.forces import Floats, Numbers
from exudyn_crawler.assessment.pressure import Footprints, track_loads, track_pressure

ALONG, ACROSS = 160, 24
"""Parts of a footprint along and across over which friction is summed."""
LEAST_SLIP, GREATEST_SLIP = 1e-6, 1e3
"""Of a track along itself over that across at its ends, between which the turn is looked for."""
BALANCED = 1e-6
"""Part of the shear strength below the tracks by which forces of a turn may be out of balance."""


class Compaction(NamedTuple):
    """Ground that tracks compact by Bekker's law, p = (k_c / b + k_phi) z^n."""

    k_c: float
    """N/m^(n+1)."""
    k_phi: float
    """N/m^(n+2)."""
    exponent: float


def sinkage_resistance(pressure: Numbers, law: Compaction, width: float) -> Numbers:
    """Return the resistance (N) of both tracks by compaction: 2 b k z^(n+1) / (n + 1), k = k_c / b + k_phi.

    `pressure` below the tracks, Pa; `width` b of the shoes, m. Bekker 1956 (remembered); sinkage z is that of
    the mean pressure.
    """
    modulus = law.k_c / width + law.k_phi
    sinkage = (np.maximum(pressure, 0.0) / modulus) ** (1.0 / law.exponent)
    return 2.0 * width * modulus * sinkage ** (law.exponent + 1.0) / (law.exponent + 1.0)


class TravelResistance(NamedTuple):
    """Resistance of a machine to straight travel: the one that every item of an assessment takes."""

    rolling: float
    """f, of chain, rollers and ground over the force on the ground."""
    idler: float
    """Friction of one idler, on which both runs pull at rest, N."""
    footprints: Footprints
    compaction: Compaction | None = None

    def pull(self, load: Numbers, against: Numbers = 0.0) -> Numbers:
        """Return the pull (N) of both tracks.

        `load` (N) normal to the ground; `against` (N) what pushes along the ground against the travel: weight
        on a grade, wind, bank.
        """
        sinks: Numbers = 0.0
        if self.compaction is not None:
            pressure = load / self.footprints.area
            sinks = sinkage_resistance(pressure, self.compaction, self.footprints.width)
        return against + self.rolling * load + 2.0 * self.idler + sinks

    def on_grade(self, weight: float, slope: Numbers) -> Numbers:
        """Return the pull (N) of both tracks of a weight (N) up a slope (rad)."""
        return self.pull(weight * np.cos(slope), weight * np.sin(slope))

    @property
    def formula(self) -> str:
        """Formula of the pull of both tracks."""
        sinks = "" if self.compaction is None else " + 2 b k z^(n+1) / (n + 1)"
        return f"V (sin a + f cos a) + 4 T f of the idlers{sinks}"


def traction(load: Numbers, friction: float, cohesion: float = 0.0, area: float = 0.0) -> Numbers:
    """Greatest pull (N) of the ground on a track that presses with a load (N): c A + P mu.

    Mohr and Coulomb, mu = tan(phi) or a coefficient of traction; `cohesion` in Pa, `area` in m2.
    """
    return cohesion * area + friction * load


def greatest_slope(
    resistance: TravelResistance, weight: float, available: Callable[[float], Numbers]
) -> float:
    """Return the greatest slope (rad) on which a pull is enough for travel.

    `available` gives the pull (N) of both tracks at a load (N) normal to the ground. The slope is pi / 2
    where it lifts the machine, 0 where it does not even move it on the level.
    """

    def missing(slope: float) -> float:
        return float(resistance.on_grade(weight, slope) - available(weight * np.cos(slope)))

    if missing(0.0) >= 0.0:
        return 0.0
    steepest = minimize_scalar(lambda slope: -missing(slope), bounds=(0.0, 0.5 * np.pi), method="bounded").x
    if missing(steepest) <= 0.0:
        return 0.5 * np.pi
    return float(brentq(missing, 0.0, steepest, xtol=1e-12))


class Turn(NamedTuple):
    """Turn at which drive and friction are in balance."""

    slip: float
    """Of a track along itself over that across at the ends of its length, kappa."""
    moment: float
    """Of friction against the turn, N m."""
    pull: float
    """Of the track that pulls forward, N; the other one pulls as hard back."""
    pole: float = 0.0
    """X about which the tracks turn, from the middle of their length, m."""


def share_across(slip: float) -> float:
    """Part of mu V L / 4 that friction has across a track which also slips along itself.

    sqrt(1 + k^2) - k^2 arsinh(1 / k), even pressure on a line (derived; `docs/closed-track.md`).
    """
    return float(np.sqrt(1.0 + slip**2) - slip**2 * np.arcsinh(1.0 / slip))


def share_along(slip: float) -> float:
    """Part of mu V / 2 that a track pulls with as it slips: k arsinh(1 / k) (derived)."""
    return float(slip * np.arcsinh(1.0 / slip))


def turn_of_lines(weight: float, length: float, gauge: float, friction: float) -> Turn:
    """Turn on the spot of tracks as lines of even pressure: the slip follows from L / B alone.

    F B = mu V L / 4 g(k) with F = mu V / 2 k arsinh(1 / k) (derived). The shoes' width is left out, see
    `turn_of_footprints`.
    """

    def left_over(slip: float) -> float:
        return share_along(slip) - 0.5 * length / gauge * share_across(slip)

    slip = brentq(left_over, LEAST_SLIP, GREATEST_SLIP)
    moment = 0.25 * friction * weight * length * share_across(slip)
    return Turn(slip, moment, moment / gauge)


def turn_of_footprints(
    weight: float,
    footprint: Footprints,
    friction: float,
    ahead: float = 0.0,
    aside: float = 0.0,
    cohesion: float = 0.0,
) -> Turn:
    """Turn of tracks as rectangles: with the moment of the shoes' width, and pressure that changes along.

    It is that of any radius, on the spot or about a track that is held: the friction of a rate of turning
    asks for slips along the tracks and a pole across them, and chains and radius only add up to these.

    Parameters
    ----------
    weight : float
        N.
    footprint : Footprints
        Of both tracks.
    friction : float
        Of shoes on the ground, the same along and across.
    ahead, aside : float
        X and y of the weight from the middle, m: pressure is a trapezoid or a triangle along the tracks.
    cohesion : float
        Of the ground, Pa: shear strength where shoes press, beside the friction.

    Raises
    ------
    ValueError
        Where the lighter track cannot pull as hard as the turn asks: it slips, and the machine stands.

    Notes
    -----
    A shoe at (x, y) of the machine, h beside its track's middle, slips with (u - h w, (x - x0) w) and bears
    ``-(c + mu p) v / |v|``. Slips u of both tracks and the pole x0 follow from the sums of forces along and
    across, and of moments, which are zero (derived; Merritt and Steeds have lines without width).
    """
    gauge, length, _ = footprint
    x, beside, press = _pressed(weight, footprint, ahead, aside)
    held = friction * press + cohesion * (0.5 * footprint.area / len(x)) * (press > 0.0)
    y = beside + np.array([[-0.5 * gauge], [0.5 * gauge]])

    def forces(unknown: Floats) -> tuple[Floats, Floats]:
        """Forces ahead and to the left (2, n) as the machine turns to the left, N."""
        # slips of a light track grow beyond all bounds: its pull is what the ground gives
        right, left = 0.5 * length * np.sinh(unknown[:2])
        pole = 0.5 * length * unknown[2]
        ahead_speed = np.array([[-right], [left]]) - beside
        left_speed = np.broadcast_to(x - pole, ahead_speed.shape)
        speed = np.hypot(ahead_speed, left_speed)
        return -held * ahead_speed / speed, -held * left_speed / speed

    def out_of_balance(unknown: Floats) -> Floats:
        along, across = forces(unknown)
        moment = (x * across - y * along).sum() / length
        return np.array([along.sum(), across.sum(), moment]) / held.sum()

    slip = np.arcsinh(turn_of_lines(weight, length, gauge, 1.0).slip)
    solution = root(out_of_balance, np.array([slip, slip, ahead / length]), method="hybr", tol=1e-10)
    if not solution.success and np.abs(solution.fun).max() > BALANCED:
        lighter = float(held.sum(axis=1).min())
        raise ValueError(f"the lighter track slips at {lighter:.4g} N before the machine turns")
    along, _ = forces(solution.x)
    pull = float(along[0].sum())
    right, left = np.sinh(solution.x[:2])
    return Turn(0.5 * float(right + left), pull * gauge, pull, 0.5 * length * float(solution.x[2]))


def _pressed(
    weight: float, footprint: Footprints, ahead: float, aside: float
) -> tuple[Floats, Floats, Floats]:
    """X and place beside the track's middle of the parts of a footprint (n,), and load on them (2, n), N."""
    gauge, length, width = footprint
    along = length * ((np.arange(ALONG) + 0.5) / ALONG - 0.5)
    across = width * ((np.arange(ACROSS) + 0.5) / ACROSS - 0.5)
    x, beside = (place.ravel() for place in np.meshgrid(along, across, indexing="ij"))
    shape = track_pressure(1.0, ahead, length, 1.0)
    end = np.copysign(1.0, ahead) * 0.5 * length
    # from the loaded end on, where the pressure is greatest
    away = np.abs(end - x)
    fall = (shape.greatest - shape.least) / shape.length
    line = np.maximum(shape.greatest - fall * away, 0.0)
    left, right = track_loads(weight, aside, gauge)
    return x, beside, np.array([[right], [left]]) * line / line.sum()


class TrackDrive(NamedTuple):
    """Drive of one track."""

    torque: float
    """Greatest of its tumbler or sprocket, N m."""
    radius: float
    """Of the pins' circle by pitches, teeth times pitch over 2 pi, m."""
    efficiency: float = 1.0
    """Of the chain, from the tumbler's torque to its pull."""

    @property
    def pull(self) -> float:
        """Greatest pull of the chain, N: T eta / r."""
        return self.torque * self.efficiency / self.radius


def ends_by(needed: float, drive: float, ground: float) -> str:
    """Word for what a pull (N) of one track comes to: "goes", "stalls" (drive first) or "slips" (ground)."""
    if needed <= min(drive, ground):
        return "goes"
    return "stalls" if drive <= ground else "slips"


class Blocked(NamedTuple):
    """One track that a stone or a shoe blocks while its drive pulls."""

    tension: float
    """Of its chain where it is blocked, N: what it has at rest, and all of the stalled drive's pull."""
    yaw_moment: float
    """On the car body, N m, as far as the other track's ground bears it."""
    idler_push: float
    """Of an idler on which both runs pull so, N."""
    ground_pull: float
    """Along the ground, N: the lesser of the drive's pull and the ground's."""


def blocked_track(stall_pull: float, rest_tension: float, ground_pull: float, gauge: float) -> Blocked:
    """Loads of a track that is blocked: the stalled drive's pull, and none of it through the ground.

    Blocked between shoe and frame the loop bears the pull by itself; blocked by the ground it is at most what
    ground and friction give, with the moment F B / 2 on the car body (derived; DIN 22261-2 has loads by what
    responds to overload in 6.1, of which the contents alone were seen).
    """
    through_ground = min(stall_pull, ground_pull)
    tension = rest_tension + stall_pull
    return Blocked(tension, 0.5 * through_ground * gauge, 2.0 * tension, through_ground)
