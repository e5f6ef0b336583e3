"""Travel on two tracks: pull for straight travel, grades and turns, and the pull of ground and drive.

Two tracks have the distance B and press on rectangles of the length L and the shoes' width. Parts of the
resistance have the names of the Caterpillar Performance Handbook (rolling and grade resistance).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar, root

from exudyn_crawler.assessment.forces import Floats, Numbers
from exudyn_crawler.assessment.pressure import Footprints, track_loads, track_pressure

ALONG, ACROSS = 160, 24
"""Number of parts of a footprint along and across in the sum of friction."""
LEAST_SLIP, GREATEST_SLIP = 1e-6, 1e3
"""Search range of the turn: slip of a track along itself over its slip across at its ends."""
BALANCED = 1e-6
"""Tolerance of the forces of a turn, fraction of the shear strength below the tracks."""


class Compaction(NamedTuple):
    """Ground that tracks compact by Bekker's law, p = (k_c / b + k_phi) z^n."""

    k_c: float
    """N/m^(n+1)."""
    k_phi: float
    """N/m^(n+2)."""
    exponent: float


def sinkage_resistance(pressure: Numbers, law: Compaction, width: float) -> Numbers:
    """Return the compaction resistance (N) of both tracks: 2 b k z^(n+1) / (n + 1), k = k_c / b + k_phi.

    `pressure` below the tracks, Pa; `width` b of the shoes, m. Bekker 1956 (remembered); the sinkage z is
    that of the mean pressure.
    """
    modulus = law.k_c / width + law.k_phi
    sinkage = (np.maximum(pressure, 0.0) / modulus) ** (1.0 / law.exponent)
    return 2.0 * width * modulus * sinkage ** (law.exponent + 1.0) / (law.exponent + 1.0)


class TravelResistance(NamedTuple):
    """Resistance of a machine to straight travel, common to all items of an assessment."""

    rolling: float
    """Rolling resistance f of chain, rollers and ground over the force on the ground."""
    idler: float
    """Friction of an idler that both runs pull at rest, N."""
    pins: float
    """Resistance of a chain by the losses of its pins with the tension at rest, N."""
    footprints: Footprints
    compaction: Compaction | None = None

    def pull(self, load: Numbers, against: Numbers = 0.0) -> Numbers:
        """Return the pull (N) of both tracks.

        `load` (N) acts normal to the ground. `against` (N) acts along the ground against the travel: weight
        on a grade, wind, bank.
        """
        sinks: Numbers = 0.0
        if self.compaction is not None:
            pressure = load / self.footprints.area
            sinks = sinkage_resistance(pressure, self.compaction, self.footprints.width)
        return against + self.rolling * load + 2.0 * (self.idler + self.pins) + sinks

    def on_grade(self, weight: float, slope: Numbers) -> Numbers:
        """Return the pull (N) of both tracks for a weight (N) up a slope (rad)."""
        return self.pull(weight * np.cos(slope), weight * np.sin(slope))

    @property
    def formula(self) -> str:
        """Formula of the pull of both tracks."""
        sinks = "" if self.compaction is None else " + 2 b k z^(n+1) / (n + 1)"
        pins = " + 2 W / p of the pins" if self.pins else ""
        return f"V (sin a + f cos a) + 4 T f of the idlers{pins}{sinks}"


def traction(load: Numbers, friction: float, cohesion: float = 0.0, area: float = 0.0) -> Numbers:
    """Return the greatest pull (N) of the ground on a track that presses with a load (N): c A + P mu.

    Mohr and Coulomb, mu = tan(phi) or a coefficient of traction; `cohesion` in Pa, `area` in m2.
    """
    return cohesion * area + friction * load


def greatest_slope(
    resistance: TravelResistance, weight: float, available: Callable[[float], Numbers]
) -> float:
    """Return the greatest slope (rad) on which the available pull is enough for travel.

    `available` gives the pull (N) of both tracks at a load (N) normal to the ground. The slope is pi / 2 if
    the pull lifts the machine, 0 if it does not move the machine on the level.
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
    """Turn with drive and friction in balance."""

    slip: float
    """Slip kappa: slip of a track along itself over its slip across at the ends of its length."""
    moment: float
    """Friction moment against the turn, N m."""
    pull: float
    """Forward pull of one track, N; the other track pulls backward with the same force."""
    pole: float = 0.0
    """X of the tracks' pole of rotation from the middle of their length, m."""


def share_across(slip: float) -> float:
    """Return the lateral friction of a track over mu V L / 4 when it also slips along itself.

    sqrt(1 + k^2) - k^2 arsinh(1 / k), even pressure on a line (derived; `docs/closed-track.md`).
    """
    return float(np.sqrt(1.0 + slip**2) - slip**2 * np.arcsinh(1.0 / slip))


def share_along(slip: float) -> float:
    """Return the pull of a slipping track over mu V / 2: k arsinh(1 / k) (derived)."""
    return float(slip * np.arcsinh(1.0 / slip))


def turn_of_lines(weight: float, length: float, gauge: float, friction: float) -> Turn:
    """Return the turn on the spot of tracks as lines of even pressure; the slip depends on L / B alone.

    F B = mu V L / 4 g(k) with F = mu V / 2 k arsinh(1 / k) (derived). The shoes' width is neglected; see
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
    """Return the turn of tracks as rectangles, with the moment of the shoes' width and varying pressure.

    The result holds for any radius, on the spot or about a track that is held. Friction at a turning rate
    fixes the slips along the tracks and the pole across them; chain speeds and radius only add to these.

    Parameters
    ----------
    weight : float
        N.
    footprint : Footprints
        Footprints of both tracks.
    friction : float
        Friction coefficient of shoes on the ground, the same along and across.
    ahead, aside : float
        X and y of the weight from the middle, m; pressure is a trapezoid or a triangle along the tracks.
    cohesion : float
        Cohesion of the ground, Pa: shear strength below pressing shoes, beside the friction.

    Raises
    ------
    ValueError
        If the lighter track cannot give the pull for the turn: it slips, and the machine stands.

    Notes
    -----
    A shoe at (x, y) of the machine, h beside its track's middle, slips with (u - h w, (x - x0) w) and bears
    ``-(c + mu p) v / |v|``. The slips u of both tracks and the pole x0 make the sums of forces along and
    across, and of moments, zero (derived; Merritt and Steeds have lines without width).
    """
    gauge, length, _ = footprint
    x, beside, press = _pressed(weight, footprint, ahead, aside)
    held = friction * press + cohesion * (0.5 * footprint.area / len(x)) * (press > 0.0)
    y = beside + np.array([[-0.5 * gauge], [0.5 * gauge]])

    def forces(unknown: Floats) -> tuple[Floats, Floats]:
        """Return the forces ahead and to the left (2, n), N, as the machine turns to the left."""
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
    """Return x and lateral position of a footprint's parts (n,), m, and the load on them (2, n), N."""
    gauge, length, width = footprint
    along = length * ((np.arange(ALONG) + 0.5) / ALONG - 0.5)
    across = width * ((np.arange(ACROSS) + 0.5) / ACROSS - 0.5)
    x, beside = (place.ravel() for place in np.meshgrid(along, across, indexing="ij"))
    shape = track_pressure(1.0, ahead, length, 1.0)
    end = np.copysign(1.0, ahead) * 0.5 * length
    # distance from the loaded end, which has the greatest pressure
    away = np.abs(end - x)
    fall = (shape.greatest - shape.least) / shape.length
    line = np.maximum(shape.greatest - fall * away, 0.0)
    left, right = track_loads(weight, aside, gauge)
    return x, beside, np.array([[right], [left]]) * line / line.sum()


class TrackDrive(NamedTuple):
    """Drive of one track."""

    torque: float
    """Greatest torque of its tumbler or sprocket, N m."""
    radius: float
    """Pitch radius, m: teeth times pitch over 2 pi."""
    efficiency: float = 1.0
    """Efficiency of the chain, from the tumbler's torque to its pull."""

    @property
    def pull(self) -> float:
        """Greatest pull of the chain, N: T eta / r."""
        return self.torque * self.efficiency / self.radius


def ends_by(needed: float, drive: float, ground: float) -> str:
    """Return the outcome for a needed pull (N) of one track: "goes", "stalls" (drive) or "slips" (ground)."""
    if needed <= min(drive, ground):
        return "goes"
    return "stalls" if drive <= ground else "slips"


class Blocked(NamedTuple):
    """Loads of a track that a stone or a shoe blocks while its drive pulls."""

    tension: float
    """Chain tension at the blocked place, N: tension at rest plus the full pull of the stalled drive."""
    yaw_moment: float
    """Yaw moment on the car body, N m, limited by the ground below the other track."""
    idler_push: float
    """Force on an idler that both runs pull with this tension, N."""
    ground_pull: float
    """Force along the ground, N: the lesser of the pulls of drive and ground."""


def blocked_track(stall_pull: float, rest_tension: float, ground_pull: float, gauge: float) -> Blocked:
    """Return the loads of a blocked track: the loop bears all of the stalled drive's pull.

    A block between shoe and frame leaves the ground without load. A block by the ground gives at most the
    pull of ground and friction, with the moment F B / 2 on the car body (derived). DIN 22261-2 treats loads
    by overload response in section 6.1; only its contents were seen.
    """
    through_ground = min(stall_pull, ground_pull)
    tension = rest_tension + stall_pull
    return Blocked(tension, 0.5 * through_ground * gauge, 2.0 * tension, through_ground)
