"""Side frames whose wheels run on the shoes' rails; bogies or sprung arms carry some of their rollers."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import ClassVar, Literal

import numpy as np

from exudyn_crawler.case.gear.arms import Arm, arm_errors
from exudyn_crawler.case.gear.base import NOT_COMPILED, POSTS, SIDE_FRAME, Gear, WheelLabel, Whole
from exudyn_crawler.case.gear.deflections import TYRE, LoadedContact, arm_spring
from exudyn_crawler.case.parameters import base, sizes
from exudyn_crawler.case.parameters.car_body import Part
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.track import SIDES, Shoe, Track
from exudyn_crawler.case.ph4100c import GRAVITY
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, Parameters, option, quantity

ACROSS = (1, 5)
"""Coordinates of a side frame across the track: y and yaw."""
WIDEST_GAP = 0.5  # greatest gap of the rails, fraction of a roller's radius; the roller drops by 3 % of it
FARTHEST_RAILS = 0.02  # greatest offset of the rails' middle from the shoe's, fraction of the shoe's width
TIPPING = 0.24  # m, from the middle of the track to that of a rail of the P&H 4100C


class Bogie(Parameters):
    """Body that swings about a pivot of the side frame and carries two rollers, which share their load.

    Nothing stops its swing but the rails below its rollers.
    """

    rollers: tuple[int, int] = quantity("1", "numbers of two neighbouring rollers, rear to front")
    pivot: base.Two = quantity("m", "x and z of the pivot's axis in the frame", (-10.0, 10.0))
    mass: base.Mass = quantity(
        "kg", "mass of the bogie with its rollers, not included in the frame's mass", (10.0, 2e4)
    )
    com: base.Two = quantity(
        "m", "x and z of the bogie's COM from the pivot", (-2.0, 2.0), default=(0.0, 0.0)
    )
    inertia: base.Inertia = quantity(
        "kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of the bogie about its COM (tensor)"
    )

    def _errors(self) -> Errors:
        rear, front = self.rollers
        if front != rear + 1:
            yield f"rollers must be two neighbours, rear to front, such as [2, 3], got {list(self.rollers)}"


class RunningGear(Gear):
    """Side frame whose wheels run on the shoes' rails, of an open or a closed track.

    Places are in the frame's own axes: x along the travel, y lateral, z up, from the height of the lower
    rollers' axes above the middle line of the track.
    """

    chain_parts: ClassVar[tuple[str, ...]] = ()
    """Files of `model.parts` that drive and tighten the chain."""

    mass: base.Mass = quantity("kg", "mass of half of the machine without its shoes", (1e4, 2e6))
    inertia: base.Inertia = quantity(
        "kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of this mass about its COM (tensor)"
    )
    com: base.Three = quantity("m", "COM of this mass in the frame", (-10.0, 10.0))
    rollers: tuple[base.Roller, ...] = quantity(
        "m", "x of the lower rollers' axes, rear to front", min_length=2
    )
    bogies: tuple[Bogie, ...] = option(
        "bogies: bodies on pivots of the frame that carry two rollers each", ()
    )
    arms: tuple[Arm, ...] = option("sprung arms on pivots of the frame that carry one roller each", ())
    tread_width: base.Length = quantity("m", "width of each tread, centred on its rail", (0.02, 1.0))
    strips: Literal[1, 2] = quantity(
        "1", "number of contact strips of a tread, which share its load on a tilted rail", default=2
    )
    stiffness: base.Stiffness = quantity("N/m^exponent", "contact stiffness of tread on rail", (1e6, 1e12))
    exponent: base.Exponent = quantity("1", "exponent of the penetration", (1.0, 1.6), default=1.0)
    damping: base.Damping = quantity("N s/m", "greatest damping coefficient of a tread's contact", (0.0, 1e8))
    damping_depth: base.Depth = quantity("m", "penetration at which the damping is full", (1e-7, 1e-2))
    rolling_resistance: base.Coefficient = quantity(
        "1", "rolling resistance of a wheel over its normal force", (0.0, 0.2)
    )
    resistance_speed: base.Speed = quantity(
        "m/s",
        "speed of a wheel over the rail at which the rolling resistance is 0.7 of its full value",
        (1e-5, 0.1),
    )

    @property
    def parts(self) -> tuple[str, ...]:
        """Files of `model.parts` that build the gear, in the order of their bodies."""
        return (*super().parts, "frame", *self.chain_parts, "bogie", "arm")

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies other than shoes: the side frame, then the bodies that move in it."""
        return (SIDE_FRAME, *self.tumblers, *self.sliding_idlers, *self.bogie_names, *self.arm_names)

    @property
    def bogie_names(self) -> tuple[str, ...]:
        """Names of the bogies, track by track, rear to front."""
        return self._on_tracks(f"bogie {number}" for number in range(1, len(self.bogies) + 1))

    @property
    def arm_names(self) -> tuple[str, ...]:
        """Names of the arms, track by track, in the order of `arms`."""
        return self._on_tracks(f"arm {number}" for number in range(1, len(self.arms) + 1))

    def _on_tracks(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return the names of one track's bodies, of two tracks with their sides, right first."""
        of_one = tuple(names)
        return of_one if self.tracks == 1 else tuple(f"{side} {name}" for side in SIDES for name in of_one)

    @property
    def wheel_labels(self) -> list[WheelLabel]:
        """Kinds and numbers of the wheels in their order."""
        return [WheelLabel("roller", number) for number in range(1, len(self.rollers) + 1)]

    @property
    def frame(self) -> Part:
        """Side frame of one track."""
        return Part(self.mass, np.array(self.com), base.inertia_tensor(self.inertia))

    @property
    def frame_parts(self) -> list[Part]:
        """Rigid parts of the side frame, or of the machine on two tracks."""
        return [self.frame]

    @property
    def holds(self) -> tuple[int, ...]:
        """Coordinates of the side frame with a hold."""
        return ACROSS

    @property
    def tipping(self) -> float:
        """Lateral distance from the middle at which a weight tips the frame, m."""
        return TIPPING

    @property
    def length(self) -> float:
        """Distance of the outer lower rollers, m."""
        return self.rollers[-1] - self.rollers[0]

    @property
    def strip_places(self) -> np.ndarray:
        """Lateral positions y of the strips' middles from that of their tread: array (strips,), m."""
        # two strips at the Gauss points resist tilting as an even contact over the width does
        points, _ = np.polynomial.legendre.leggauss(self.strips)
        return 0.5 * self.tread_width * points

    @property
    def resistances(self) -> np.ndarray:
        """Rolling resistance coefficients of a track's wheels: array (wheels,)."""
        return np.full(len(self.rollers), self.rolling_resistance)

    @property
    def flange(self) -> tuple[float, float, float]:
        """Play (m), stiffness (N/m) and damping (N s/m) of the flanges of a wheel; zeros: no flanges."""
        return 0.0, 0.0, 0.0

    @property
    def flange_height(self) -> float:
        """Height of the flanges above a tread, m."""
        return 0.0

    @property
    def slide_places(self) -> tuple[base.Three, ...]:
        """Slides: x of rear and front end, z of the top, m."""
        return ()

    def frame_start(self, case: Whole) -> np.ndarray:
        """Return the origin of side frame or machine at t = 0, on rails that have not settled: (3,), m."""
        raise NotImplementedError

    def bogie_reference(self, case: Whole) -> np.ndarray:
        """Return the bogies' pivots (m, global) and angles (rad) at t = 0: array (tracks * bogies, 6)."""
        return self._pivots([bogie.pivot for bogie in self.bogies], case)

    def arm_reference(self, case: Whole) -> np.ndarray:
        """Return the arms' pivots (m, global) and angles (rad) at t = 0: array (tracks * arms, 6)."""
        return self._pivots([arm.pivot for arm in self.arms], case)

    def _pivots(self, places: Sequence[base.Two], case: Whole) -> np.ndarray:
        start = self.frame_start(case)
        pivots = [(x, y, z) for y in self.middles for x, z in places]
        reference = np.zeros((len(pivots), 6))
        reference[:, :3] = start + np.reshape(pivots, (-1, 3))
        return reference

    def first_wheels(self, case: Whole) -> np.ndarray:
        """Return x and z in the frame, and radius, of one track's wheels at t = 0: array (wheels, 3), m."""
        raise NotImplementedError

    def extent(self, case: Whole) -> tuple[float, float, float]:
        """Return x of the frame's rear and front end, and z of the lowest wheel above its rollers, m."""
        raise NotImplementedError

    def wrenches(self, machine: np.ndarray) -> np.ndarray:
        """Return the wrenches other than those on shoes: array (n, 6), N and N m; `machine` (6,) is first."""
        return machine[None]

    @property
    def carried_mass(self) -> float:
        """Mass that the shoes carry, without their own, kg."""
        bogies = self.tracks * sum(bogie.mass for bogie in self.bogies)
        arms = self.tracks * sum(arm.mass for arm in self.arms)
        return bogies + sum(part.mass for part in self.frame_parts) + arms

    def standing(self, case: Whole) -> np.ndarray:
        """Return True for shoes below the outer rollers or between them: array (shoes,)."""
        start = self.frame_start(case)
        half = 0.5 * case.track.pitch
        coms = self.shoe_reference(case)
        rear = self.rollers[0] + start[0]
        front = self.rollers[-1] + start[0]
        within = (coms[:, 0] >= rear - half) & (coms[:, 0] <= front + half)
        return within & (coms[:, 2] < start[2])

    def first_loads(self, case: Whole) -> np.ndarray:
        """Return the loads on the shoes, without their weight, at t = 0: array (shoes,), N.

        The carried mass acts evenly on the shoes below it.
        """
        under = self.standing(case)
        return super().first_loads(case) + under * self.carried_mass * case.gravity / max(1, under.sum())

    def errors(self, case: Whole) -> Errors:
        """Yield an error for each contradiction to the rest of the case."""
        kind = f"gear.kind {self.kind!r}"
        if not case.can_be_compiled:
            yield f"{NOT_COMPILED} do not go with {kind}"
        elif not case.is_compiled:
            yield from self.engine_errors()
        rails = case.shoe.rails
        if rails is None:
            yield f"shoe.rails must be given with {kind}: its wheels run on them"
        elif self.tread_width > rails.width:
            width = f"the rails' width {rails.width} m"
            yield f"gear.tread_width must not exceed {width}, got {self.tread_width}"
        if case.drive.on is not None:
            yield f"drive.on must be none with {kind}, which is always driven; a speed of zero is a brake"
        if case.drive.slip is not None and (not self.loops or self.holds == POSTS):
            yield "drive.slip must be none: only closed tracks on the ground have a drawbar that holds it"
        yield from self._bogie_errors()
        yield from arm_errors(self.arms, self.rollers, {n for bogie in self.bogies for n in bogie.rollers})
        yield from self.turn_errors(case.drive)
        if any(load != 0.0 for phase in case.loads.phases for load in phase.loads):
            yield f"loads must be zero on every shoe with {kind}: its rollers carry the machine"
        yield from self.track_errors(case.shoe, self.loop(case.track))
        if case.machine is not None:
            gravity = case.gravity_vector()
            yield from case.machine.balance_errors(self.frame_parts, self.rollers, self.tipping, gravity)

    def engine_errors(self) -> Errors:
        """Yield an error for each part that is not made of Exudyn's items."""
        yield from ()

    def _bogie_errors(self) -> Errors:
        """Yield an error for each bogie with missing or shared rollers, or with a pivot not between them."""
        carrier: dict[int, int] = {}
        for number, bogie in enumerate(self.bogies):
            name = f"gear.bogies[{number}]"
            if not all(1 <= roller <= len(self.rollers) for roller in bogie.rollers):
                yield f"{name}.rollers must be in 1..{len(self.rollers)}, got {list(bogie.rollers)}"
                return
            for roller in bogie.rollers:
                if roller in carrier:
                    other = f"gear.bogies[{carrier[roller]}]"
                    yield f"{name}.rollers must not be those of another bogie, {other} has roller {roller}"
                carrier[roller] = number
            rear, front = (self.rollers[roller - 1] for roller in bogie.rollers)
            if not rear < bogie.pivot[0] < front:
                between = f"between its rollers at x = {rear:.4g} and {front:.4g} m"
                yield f"{name}.pivot must be {between}, got {list(bogie.pivot)}"

    def implausible(self, shoe: Shoe, chain: Track) -> Iterator[str]:
        """Yield a warning for each inertia that does not fit its mass."""
        yield from sizes.thin_inertia("gear", self.mass, self.inertia)
        yield from sizes.far_inertia("gear", self.mass, self.inertia, self.length)
        for number, bogie in enumerate(self.bogies):
            rear, front = (self.rollers[roller - 1] for roller in bogie.rollers)
            turning = f"gear.bogies[{number}]", bogie.mass, bogie.inertia
            yield from sizes.thin_inertia(*turning)
            yield from sizes.far_inertia(*turning, front - rear)
        for number, arm in enumerate(self.arms):
            yield from sizes.thin_inertia(f"gear.arms[{number}]", arm.mass, arm.inertia)

    @property
    def roller_load(self) -> float:
        """Load of a lower roller for an even distribution of the carried weight, N."""
        return self.carried_mass * GRAVITY / (self.tracks * len(self.rollers))

    def implausible_treads(self, radius: float) -> Iterator[str]:
        """Yield a warning for an implausible deflection or damping of treads of a radius (m), and of arms."""
        load = self.roller_load
        words = "a roller's tread"
        share = "half of its even share of the weight"
        law = self.stiffness, self.exponent, self.damping
        tread = LoadedContact("gear.", words, 0.5 * load, share, *law, 0.5 * load / GRAVITY)
        yield from tread.implausible(TYRE * radius, f"{TYRE:g} of its radius")
        for number, arm in enumerate(self.arms):
            yield from arm_spring(f"gear.arms[{number}]", arm, self.rollers[arm.roller - 1], load)

    def turn_errors(self, drive: Drive) -> Errors:
        """Yield an error for a turn of a single track."""
        if drive.turn_rate is not None:
            yield f"drive.turn_rate must be none with gear.kind {self.kind!r}: one track alone does not turn"

    def track_errors(self, shoe: Shoe, chain: Track) -> Errors:
        """Yield an error for each property of rails and of one track's chain that does not fit the gear."""
        yield from ()


def overlap_errors(wheels: str, places: Sequence[float], radius: float) -> Errors:
    """Yield an error if wheels at `places` (x, m) are out of order or less than a diameter apart."""
    if np.any(np.diff(places) < 2.0 * radius):
        got = fields.shown(list(places))
        yield f"{wheels} must be in order and at least a diameter, {2.0 * radius:.4g} m, apart, got {got}"


def implausible_rails(shoe: Shoe, chain: Track, radius: float) -> Iterator[str]:
    """Yield a warning for rails off the shoe's middle, and for gaps too wide for rollers of a radius (m)."""
    if shoe.rails is None:
        return
    beside = 0.5 * (shoe.rails.left + shoe.rails.right) - shoe.underside_center[1]
    if abs(beside) > FARTHEST_RAILS * shoe.width:
        yield f"shoe.rails: the middle between them is {abs(beside):.3g} m beside that of the shoe"
    gap = chain.pitch - (shoe.rails.front - shoe.rails.rear)
    if WIDEST_GAP * radius < gap < 2.0 * radius:
        drop = radius - math.sqrt(radius**2 - 0.25 * gap**2)
        yield (
            f"shoe.rails: from shoe to shoe they leave a gap of {gap:.3g} m, into which rollers of "
            f"{2.0 * radius:.3g} m in diameter drop by {drop:.2g} m; are rear and front in m?"
        )
