"""Start of a closed track: a chain that closes about its wheels, and the positions of its shoes.

A chain that is too short for its idler's take-up pulls a frame down on sprung arms. It then closes about
road wheels that are all higher in the frame; the equilibrium starts from there.
"""

import math
from contextlib import suppress
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case.gear.base import WheelLabel
from exudyn_crawler.case.gear.closed_frame import MAKERS_SAG, ClosedFrame
from exudyn_crawler.case.gear.deflections import MOST_TURNED
from exudyn_crawler.case.parameters import assembly
from exudyn_crawler.case.parameters.track import Shoe, Track

CLEARANCE = 0.5  # m, between the lowest shoes of a frame on posts and the ground
MOST_SAG = 0.5  # greatest sag of the upper run, fraction of its length
TAKE_UPS = 81  # number of take-ups in the idler's range that a search tries
ROLLERS = (1, 2)
"""Numbers of the outer rollers among the wheels of a `_Loop`."""


class Assembled(NamedTuple):
    """Start of a closed track at t = 0."""

    take_up: float  # of the idler, m
    sag: float  # of the upper run, m
    frame: np.ndarray  # (3,): origin of the side frame, m, global
    shoes: np.ndarray  # (shoes, 6): COMs (m, global) and angles (rad); the pitch angle falls along the chain
    tumbler: np.ndarray  # (6,): centre (m, global) and angles (rad) of the tumbler
    sunk: float  # m, sinkage of the frame on its arms


@lru_cache(maxsize=64)
def assembled(closed: ClosedFrame, shoe: Shoe, chain: Track) -> Assembled:
    """Return the start of a closed chain about its wheels, with the COM of its first shoe at `first_com`.

    Raises `assembly.MisfitError` if the chain does not close.
    """
    pitch = closed.chain_pitch(chain)
    take_up, sag, sunk, pieces = _closed(closed, shoe, chain)
    places = assembly.pins_along(pieces, pitch, chain.shoe_count)
    pins = np.array([assembly.point_at(pieces, place) for place in places])
    # the first shoe is the rearmost one with both pins ahead of the first roller
    first = next(k for k, place in enumerate(places) if place >= 2.0)
    apart = np.diff(pins, axis=0)
    middles = 0.5 * (pins[1:] + pins[:-1])
    angles = np.unwrap(np.arctan2(-apart[:, 1], apart[:, 0]))
    angles = angles - 2.0 * math.pi * np.round(angles[0] / (2.0 * math.pi))
    middle = np.array([chain.pin_ahead - 0.5 * pitch, chain.pin_height])
    c = np.cos(angles)
    s = np.sin(angles)
    coms = middles - np.column_stack((c * middle[0] + s * middle[1], c * middle[1] - s * middle[0]))
    coms = np.roll(coms, -first, axis=0)
    angles = np.roll(angles, -first)
    if first:
        angles[-first:] -= 2.0 * math.pi
    height = closed.roller_radius + shoe.roller_path.height + shoe.com_height - sunk
    height += CLEARANCE if closed.support == "posts" else 0.0
    frame = np.array([chain.first_com[0] - coms[0, 0], chain.first_com[1], height])
    shoes = np.zeros((chain.shoe_count, 6))
    shoes[:, :3] = frame + np.column_stack((coms[:, 0], np.zeros(len(coms)), coms[:, 1]))
    shoes[:, 4] = angles - 2.0 * math.pi * round(angles[0] / (2.0 * math.pi))
    x, z = closed.tumbler.place
    gap = math.atan2(pins[0, 1] - z, pins[0, 0] - x)
    tumbler = np.array([*(frame + np.array([x, 0.0, z])), 0.0, -gap, 0.0])
    return Assembled(take_up, sag, frame, shoes, tumbler, sunk)


class _Loop(NamedTuple):
    """Wheels inside a closed chain, and their positions for a take-up of the idler."""

    closed: ClosedFrame
    rise: float  # height of the rails above the pins, m
    pitch: float  # pitch of the chain with wear, m
    new_pitch: float  # pitch of the new chain, m

    @property
    def upper_ends(self) -> list[WheelLabel]:
        """Foremost and rearmost support of the upper run; only these determine its shape."""
        upper = sorted(self.closed.upper.items(), key=lambda item: item[1])
        return [label for label, _ in upper[:: -max(1, len(upper) - 1)]]

    @property
    def names(self) -> list[str]:
        """Names of the wheels in their order round the loop; only the outer ones of each run are in it."""
        rollers = [label.words for label in self.closed.wheel_labels if label.kind == "roller"]
        return ["tumbler", rollers[0], rollers[-1], "idler", *(label.words for label in self.upper_ends)]

    @property
    def deepest(self) -> float:
        """Greatest sinkage (m) of the frame, limited by the arms' stops and by the height of both ends."""
        if not self.closed.sinks:
            return 0.0
        arms = self.closed.arms
        turned = [MOST_TURNED if arm.stop is None else arm.stop for arm in arms]
        places = [self.closed.rollers[arm.roller - 1] for arm in arms]
        lifts = [arm.lift(*of) for arm, *of in zip(arms, places, turned, strict=True)]
        ends = [self.circles(0.0)[end][1] - self._lift(end) for end in (0, 3)]
        return max(0.0, min(*lifts, *ends))

    @property
    def _climbed(self) -> float:
        """Radius of the pins on the tumbler over that of a new chain.

        Bushes of a worn chain climb teeth without play to at most the radius R (1 + g) of their own pitch.
        Those that carry little lie lower, so that the start takes the mean of both radii.
        """
        growth = self.pitch / self.new_pitch - 1.0
        return 1.0 + 0.5 * growth if self.closed.tumbler.depth is None else 1.0

    def circles(self, take_up: float, sunk: float = 0.0) -> list[assembly.Circle]:
        """Return the circles of the pins about the wheels, for a sinkage (m) of the frame on its arms."""
        closed = self.closed
        places = self.closed.upper
        (x, z), on_idler = closed.idler_circle(take_up, self.rise, self.pitch)
        rollers = closed.roller_radius + self.rise
        carriers = closed.carrier_radius + self.rise
        wheels = [(*closed.tumbler.place, closed.tumbler.radius(self.new_pitch) * self._climbed)]
        ways = dict.fromkeys(range(len(closed.rollers)), 0.0)
        if sunk:
            lifted = zip(closed.arms, closed.arms_lifted(sunk)[:, 0].tolist(), strict=True)
            ways |= {arm.roller - 1: way for arm, way in lifted}
        wheels += [(closed.rollers[k] + ways[k], sunk, rollers) for k in (0, len(ways) - 1)]
        wheels.append((x, z, on_idler))
        return wheels + [(*places[label], carriers) for label in self.upper_ends]

    def belt(self, take_up: float, sag: float = 0.0, sunk: float = 0.0) -> list[assembly.Piece]:
        """Return the belt about the wheels.

        Raises `assembly.MisfitError` for a wheel within the belt; the message names it and gives a remedy.
        """
        circles = self.circles(take_up, sunk)
        try:
            return assembly.belt(circles, sag)
        except assembly.WithinError as error:
            x, z, _ = circles[error.number]
            name = self.names[error.number]
            lies = f"{name} at x = {x:.4g} m, z = {z:.4g} m lies {1e3 * error.depth:.0f} mm within the chain"
            remedy = f"it touches the chain at z = {error.height:.4g} m"
            if error.number in ROLLERS:
                end = 0 if error.number == 1 else 3
                remedy = f"it touches the chain with {self.names[end]}.place at z = {self._lift(end):.4g} m"
            raise assembly.MisfitError(f"{lies} about the others; {remedy}") from error

    def _lift(self, end: int) -> float:
        """Return the axis height (m) of tumbler or idler with which the lower run is one straight line."""
        _, _, rollers = self.circles(0.0)[1]
        return self.circles(0.0)[end][2] - rollers

    def take_ups(self) -> tuple[float, float]:
        """Return the range of take-ups at which no wheel lies within the belt or in another wheel.

        The range has the take-up of least size that fits. Raises `assembly.MisfitError` if none fits.
        """
        tried = np.linspace(*self.closed.idler.range, TAKE_UPS)
        fit = np.array([self._fits(take_up) for take_up in tried])
        if not fit.any():
            self.belt(tried[np.abs(tried).argmin()])
        nearest = np.flatnonzero(fit)[np.abs(tried[fit]).argmin()]
        beyond = np.flatnonzero(~fit)
        first = max(beyond[beyond < nearest], default=-1) + 1
        last = min(beyond[beyond > nearest], default=len(tried)) - 1
        return float(tried[first]), float(tried[last])

    def _fits(self, take_up: float) -> bool:
        with suppress(assembly.MisfitError):
            return bool(assembly.belt(self.circles(take_up)))
        return False


def _closed(
    closed: ClosedFrame, shoe: Shoe, chain: Track
) -> tuple[float, float, float, list[assembly.Piece]]:
    """Return take-up, sag of the upper run and sinkage of the frame, m, and the belt of a chain that closes.

    Raises `assembly.MisfitError` if it does not close.
    """
    pitch = closed.chain_pitch(chain)
    count = chain.shoe_count
    loop = _Loop(closed, shoe.roller_path.height - chain.pin_height, pitch, chain.pitch)
    take_up = closed.idler.take_up
    if take_up is None:
        taut = assembly.closed_chain(loop.belt, pitch, count, loop.take_ups(), "an idler's take-up of")
        slack = closed.estimated_slack(shoe, chain)
        if not slack:
            return taut, 0.0, 0.0, loop.belt(taut)
        take_up = taut - slack
    fixed = float(take_up)
    deepest = loop.deepest
    if deepest and assembly.surplus(loop.belt(fixed), pitch, count) < 0.0:
        what = f"a take-up of {fixed:.4g} m and arms that give way by"

        def sunken(sunk: float) -> list[assembly.Piece]:
            return loop.belt(fixed, sunk=sunk)

        sunk = assembly.closed_chain(sunken, pitch, count, (deepest, 0.0), what)
        return fixed, 0.0, sunk, sunken(sunk)
    most = MOST_SAG * loop.belt(take_up)[-1].length
    what = f"a take-up of {take_up:.4g} m and a sag of"
    try:
        sag = assembly.closed_chain(lambda sag: loop.belt(fixed, sag), pitch, count, (0.0, most), what)
    except assembly.MisfitError as error:
        if closed.idler.sag is None or closed.idler.take_up is not None:
            raise
        makers = MAKERS_SAG * float(closed.upper_spans[-1])
        raise assembly.MisfitError(
            f"a chain of {count} shoes of {pitch:.4g} m has no idler.sag of {closed.idler.sag:g} m at rest; "
            f"makers ask for {100.0 * MAKERS_SAG:g} % of the span, {makers:.3g} m"
        ) from error
    return fixed, sag, 0.0, loop.belt(fixed, sag)
