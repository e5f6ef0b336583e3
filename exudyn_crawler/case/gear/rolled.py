"""Rolled gear: a side frame rolls over the shoes of an open chain on the ground."""

import math
from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.base import Whole
from exudyn_crawler.case.gear.running_gear import RunningGear, implausible_rails, overlap_errors
from exudyn_crawler.case.parameters import base
from exudyn_crawler.case.parameters.base import Place
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case.parameters.track import Shoe, Track
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, option, quantity

MARGIN = 4.0  # m of ground ahead of the track
FEWEST_SHOES = 4  # the tumbler pulls two links between them


class Rolled(base.PH4100C, RunningGear, values=ph4100c.UNDERCARRIAGE):
    """Side frame with its share of the machine, which rolls over the shoes of one track at the drive's speed.

    The frame's origin is at x = `start` at t = 0. The rollers are fixed in the frame, whose travel is the
    drive; heave, roll and pitch are free, y and yaw are held.
    """

    kind: Literal["rolled"] = option("side frame that rolls over shoes on the ground", "rolled")

    quantities: ClassVar[frozenset[str]] = frozenset({"frame", "rolled"})
    shoes_stand: ClassVar[bool] = True
    phrase: ClassVar[str] = "Side frame of {carried} t that rolls over {shoes} shoes"
    chain_parts: ClassVar[tuple[str, ...]] = ("pull",)

    start: Place = quantity("m", "x of the frame's origin at t = 0, global")
    ends: base.Two = quantity("m", "x of the frame's rear and front ends", (-20.0, 20.0))
    radius: float = quantity("m", "radius of the rollers' treads", (0.05, 1.5), ge=1e-2, le=100)
    tumbler: Place = quantity("m", "x of the point at which the drive tumbler pulls the chain", (-20.0, 20.0))
    end_tension: float = quantity(
        "N", "outward force on both ends of the chain", (0.0, 5e6), ge=0, le=1e10, default=0.0
    )

    def _errors(self) -> Errors:
        rear, front = self.ends
        if front <= rear:
            yield f"ends must be rear and front end in this order, got {self.ends}"
        yield from overlap_errors("rollers", self.rollers, self.radius)
        if outside := [x for x in self.rollers if not rear + self.radius <= x <= front - self.radius]:
            ends = f"the frame's ends {self.ends} by their radius {self.radius:.4g} m"
            yield f"rollers must be within {ends}, got {fields.shown(outside)}"
        if not rear <= self.tumbler <= front:
            yield f"tumbler must be within the frame's ends {self.ends}, got {self.tumbler}"

    def first_wheels(self, case: Whole) -> np.ndarray:
        """Return x and z in the frame, and the radius, of the wheels at t = 0: array (wheels, 3), m."""
        return np.array([(x, 0.0, self.radius) for x in self.rollers])

    def extent(self, case: Whole) -> tuple[float, float, float]:
        """Return x of the frame's rear and front end, m, and infinity: no wheel is above the rollers."""
        return (*self.ends, math.inf)

    def frame_start(self, case: Whole) -> np.ndarray:
        """Return the origin of the side frame at t = 0, on rails that have not settled: array (3,), m."""
        height = case.shoe.com_height + case.shoe.roller_path.height + self.radius
        return np.array([self.start, case.track.first_com[1], height])

    def way(self, drive: Drive, times: np.ndarray) -> np.ndarray:
        """Return the displacement of the track's middle (times, 2), m: zero, since the shoes stand still."""
        return np.zeros((len(times), 2))

    def implausible(self, shoe: Shoe, chain: Track) -> Iterator[str]:
        """Yield a warning for each inertia, tread and gap of the rails that no known machine has."""
        yield from super().implausible(shoe, chain)
        yield from self.implausible_treads(self.radius)
        yield from implausible_rails(shoe, chain, self.radius)

    def wrenches(self, machine: np.ndarray) -> np.ndarray:
        """Return the wrenches of the machine and of the chain's end tension: array (3, 6), N and N m."""
        ends = np.zeros((2, 6))
        ends[:, 0] = -self.end_tension, self.end_tension
        return np.vstack((machine, ends))

    def track_errors(self, shoe: Shoe, chain: Track) -> Errors:
        """Yield an error for each property of rails and track that a side frame cannot roll over."""
        rails = shoe.roller_path
        gap = chain.pitch - (rails.front - rails.rear)
        if not 0.0 <= gap < 2.0 * self.radius:
            crossed = f"from 0 to their diameter {2.0 * self.radius:.4g} m, got {gap:.4g} m"
            yield f"shoe.rails must leave a gap from shoe to shoe that rollers cross, {crossed}"
        if (count := chain.shoe_count) < FEWEST_SHOES:
            yield f"track.shoe_count must be at least {FEWEST_SHOES} with gear.kind 'rolled', got {count}"

    def shares_of_links(self, ahead: np.typing.ArrayLike, links: int, pitch: float) -> np.ndarray:
        """Return the links' shares of the pull of a tumbler `ahead` (m) of link 1's pins: (times, links)."""
        place = np.asarray(ahead, dtype=float)[..., None] / pitch
        return np.clip(1.0 - np.abs(place - np.arange(links)), 0.0, None)

    def reach_errors(self, chain: Track, travel: float, time: float) -> Errors:
        """Yield an error if outer roller or tumbler is off the track after a travel (m), at a time (s)."""
        first = chain.first_com[0]
        last = first + (chain.shoe_count - 1) * chain.pitch
        rear_pin = first + chain.pin_ahead
        front_pin = last - chain.pitch + chain.pin_ahead
        for name, place, least, greatest in (
            ("rear roller", self.rollers[0], first, last),
            ("front roller", self.rollers[-1], first, last),
            ("tumbler", self.tumbler, rear_pin, front_pin),
        ):
            x = self.start + travel + place
            if not least <= x <= greatest:
                instant = f"at t = {time:.3g} s the {name} is at x = {x:.4g} m"
                reach = f"the shoes reach from {least:.4g} to {greatest:.4g} m; more shoes mend it"
                yield f"track must be long enough for the drive: {instant}, {reach}"


def ground_below(chain: Track, units: Terrain) -> Terrain:
    """Return the terrain with as many units along x as the track needs."""
    end = chain.first_com[0] + chain.shoe_count * chain.pitch + MARGIN
    return units.with_(columns=math.ceil((end - units.origin[0]) / units.unit_length))
