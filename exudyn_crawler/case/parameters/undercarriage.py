"""What rides on a track: side frame, rollers and drive, whether they fit, and what the machine does to it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple, Self

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import base, drive, loads, terrain, track
from exudyn_crawler.case.parameters.base import Errors, Parameters, Place, Several, quantity

MARGIN = 4.0  # m of ground ahead of the track
FEWEST_SHOES = 4  # two links that the tumbler pulls lie between them
TIPPING = 0.24  # m, from the middle of the track to that of a rail of the P&H 4100C
WheelKind = Literal["roller", "idler", "carrier", "slide"]


class WheelLabel(NamedTuple):
    """Kind and number of a wheel, and the words for it that tables and histories have."""

    kind: WheelKind
    number: int = 0  # from 1, rear to front; 0: there is no other
    line: int = 0  # of a slide, from 1, rear to front
    track: str = ""  # "right" or "left" of a machine on two tracks

    @property
    def words(self) -> str:
        """Name for readers, such as "roller 3", "slide 1, line 2" or "right idler"."""
        number = f" {self.number}" if self.number else ""
        line = f", line {self.line}" if self.line else ""
        track = f"{self.track} " if self.track else ""
        return f"{track}{self.kind}{number}{line}"


class RunningGear(Parameters):
    """Side frame whose wheels run on the shoes' rails, of an open or a closed track.

    Places are in the frame's own axes: x along the travel, y lateral, z up, from the height of the lower
    rollers' axes above the middle line of the track.
    """

    mass: base.Mass = quantity("kg", "half of the machine without its shoes", (1e4, 2e6))
    inertia: base.Inertia = quantity("kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of it about its COM (tensor)")
    com: base.Three = quantity("m", "its COM", (-10.0, 10.0))
    rollers: tuple[base.Roller, ...] = quantity(
        "m", "x of the lower rollers' axes, rear to front", min_length=2
    )
    tread_width: base.Length = quantity("m", "width of each tread, in the middle of its rail", (0.02, 1.0))
    strips: Literal[1, 2] = quantity("1", "of a tread, which share its load on a tilted rail", default=2)
    stiffness: base.Stiffness = quantity("N/m^exponent", "contact stiffness of tread on rail", (1e6, 1e12))
    exponent: base.Exponent = quantity("1", "exponent of the depth", (1.0, 1.6), default=1.0)
    damping: base.Damping = quantity("N s/m", "greatest damping of a tread", (0.0, 1e8))
    damping_depth: base.Depth = quantity("m", "depth at which the damping is full", (1e-7, 1e-2))
    rolling_resistance: base.Coefficient = quantity("1", "of a wheel over its normal force", (0.0, 0.2))
    resistance_speed: base.Speed = quantity("m/s", "at which it has 0.7 of its value, 0 at rest", (1e-5, 0.1))

    @property
    def strip_places(self) -> np.ndarray:
        """Y of the strips' middles beside that of their tread: array (strips,), m."""
        # two resist tilting at the Gauss points as an evenly spread contact does
        points, _ = np.polynomial.legendre.leggauss(self.strips)
        return 0.5 * self.tread_width * points

    @property
    def wheel_labels(self) -> list[WheelLabel]:
        """Kinds and numbers of the wheels in their order."""
        return [WheelLabel("roller", number) for number in range(1, len(self.rollers) + 1)]

    @property
    def resistances(self) -> np.ndarray:
        """Of wheels against the travel over their normal force: array (wheels,)."""
        return np.full(len(self.rollers), self.rolling_resistance)


def overlap_errors(wheels: str, places: Sequence[float], radius: float) -> Errors:
    """Wheels at places (x, m) that are nearer to each other than their diameter."""
    if np.any(np.diff(places) < 2.0 * radius):
        yield f"{wheels} must stand in order and a diameter {2.0 * radius:g} m apart, got {list(places)}"


class Undercarriage(base.PH4100C, RunningGear, values=ph4100c.UNDERCARRIAGE):
    """What rides on one track: the side frame with its share of the machine, and how it rolls on the shoes.

    The frame's origin is at x = `start` at t = 0. The rollers are fixed in the frame, whose travel is the
    drive; heave, roll and pitch are free, y and yaw are held.
    """

    start: Place = quantity("m", "x of the frame's origin at t = 0, global")
    ends: base.Two = quantity("m", "x of the frame's rear and front end", (-20.0, 20.0))
    radius: float = quantity("m", "radius of the treads", (0.05, 1.5), ge=1e-2, le=100)
    tumbler: Place = quantity("m", "x where the drive tumbler pulls the chain", (-20.0, 20.0))
    end_tension: float = quantity("N", "pull on the chain's ends", (0.0, 5e6), ge=0, le=1e10, default=0.0)

    def _errors(self) -> Errors:
        rear, front = self.ends
        if front <= rear:
            yield f"ends must be rear and front end in this order, got {self.ends}"
        yield from overlap_errors("rollers", self.rollers, self.radius)
        if outside := [x for x in self.rollers if not rear + self.radius <= x <= front - self.radius]:
            ends = f"the frame's ends {self.ends} by their radius {self.radius:g} m"
            yield f"rollers must be within {ends}, got {outside}"
        if not rear <= self.tumbler <= front:
            yield f"tumbler must be within the frame's ends {self.ends}, got {self.tumbler}"

    def track_errors(self, shoe: track.Shoe, chain: track.Track) -> Errors:
        """What of shoes with rails and of the track does not go with a side frame that rolls over them."""
        rails = shoe.rails
        assert rails is not None
        gap = chain.pitch - (rails.front - rails.rear)
        if not 0.0 <= gap < 2.0 * self.radius:
            crossed = f"from 0 to their diameter {2.0 * self.radius:g} m, got {gap:.4g} m"
            yield f"shoe.rails must leave a gap from shoe to shoe that rollers cross, {crossed}"
        if (count := chain.shoe_count) < FEWEST_SHOES:
            yield f"track.shoe_count must be at least {FEWEST_SHOES} with an undercarriage, got {count}"

    def shares_of_links(self, ahead: np.typing.ArrayLike, links: int, pitch: float) -> np.ndarray:
        """Shares of the links in a tumbler's pull `ahead` (m) of link 1's pins: array (times, links)."""
        place = np.asarray(ahead, dtype=float)[..., None] / pitch
        return np.clip(1.0 - np.abs(place - np.arange(links)), 0.0, None)


class Part(NamedTuple):
    """Rigid part of a body."""

    mass: float  # kg
    com: np.ndarray  # (3,), m, in the body's axes
    inertia: np.ndarray  # (3, 3): tensor about its COM, kg m2


class CarBody(base.PH4100C, values=ph4100c.CAR_BODY):
    """Machine on two closed tracks: its car body, which both side frames are fixed to, and upper structure.

    All of it is one rigid body: the upper structure stands still at its slew angle. Places are in the
    machine's axes: x along the travel, y to the left, z up, from the middle between the tracks at the height
    of the lower rollers' axes. Track 1 is the right one, whose middle is at `track.first_com`.
    """

    track_distance: base.Length = quantity("m", "of the tracks' middles", (1.0, 20.0))
    mass: base.Mass = quantity("kg", "of the car body without side frames", (1e2, 1e6))
    inertia: base.Inertia = quantity("kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of it about its COM (tensor)")
    com: base.Three = quantity("m", "its COM", (-10.0, 10.0))
    upper_mass: base.Mass = quantity("kg", "of the upper structure with dipper", (1e2, 2e6))
    upper_inertia: base.Inertia = quantity("kg m2", "the same of it about its COM, straight ahead (tensor)")
    upper_com: base.Three = quantity("m", "its COM, straight ahead", (-20.0, 20.0))
    swing_axis: Place = quantity("m", "x of the axis it turns about", (-5.0, 5.0), default=0.0)
    slew: float = quantity("rad", "its angle, to the left", (-3.2, 3.2), ge=-10, le=10, default=0.0)

    @property
    def middles(self) -> tuple[float, float]:
        """Y of the tracks' middles, right and left, m."""
        return -0.5 * self.track_distance, 0.5 * self.track_distance

    def upper_at(self, angle: float) -> tuple[np.ndarray, np.ndarray]:
        """COM of the upper structure at a slew angle (rad), (3,), m, and its inertia tensor, kg m2."""
        c, s, axis = math.cos(angle), math.sin(angle), np.array([self.swing_axis, 0.0, 0.0])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        inertia = turn @ base.inertia_tensor(self.upper_inertia) @ turn.T
        return axis + turn @ (np.array(self.upper_com) - axis), inertia

    def parts(self, side_frame: Part) -> list[Part]:
        """Rigid parts of the machine, `side_frame` being the right one's in its own axes."""
        com, inertia = self.upper_at(self.slew)
        mirror = np.diag([1.0, -1.0, 1.0])
        right, left = (np.array([0.0, y, 0.0]) for y in self.middles)
        return [
            Part(side_frame.mass, right + side_frame.com, side_frame.inertia),
            Part(side_frame.mass, left + mirror @ side_frame.com, mirror @ side_frame.inertia @ mirror),
            Part(self.mass, np.array(self.com), base.inertia_tensor(self.inertia)),
            Part(self.upper_mass, com, inertia),
        ]


def ground_below(chain: track.Track, units: terrain.Terrain) -> terrain.Terrain:
    """Terrain with as many units along x as a track of any length needs."""
    end = chain.first_com[0] + chain.shoe_count * chain.pitch + MARGIN
    return units.with_(columns=math.ceil((end - units.origin[0]) / units.unit_length))


def length_errors(frame: Undercarriage, chain: track.Track, travel: float, time: float) -> Errors:
    """Rollers or tumbler off the track after a travel (m), at a time (s)."""
    first, last = chain.first_com[0], chain.first_com[0] + (chain.shoe_count - 1) * chain.pitch
    rear_pin, front_pin = first + chain.pin_ahead, last - chain.pitch + chain.pin_ahead
    for name, place, least, greatest in (
        ("rear roller", frame.rollers[0], first, last),
        ("front roller", frame.rollers[-1], first, last),
        ("tumbler", frame.tumbler, rear_pin, front_pin),
    ):
        x = frame.start + travel + place
        if not least <= x <= greatest:
            at = f"at t = {time:.3g} s the {name} is at x = {x:.4g} m"
            reach = f"the shoes reach from {least:.4g} to {greatest:.4g} m; more shoes mend it"
            yield f"track must be long enough for the drive: {at}, {reach}"


class MachinePhase(loads.PhaseEnd):
    """Part of a machine's cycle: force and moment on the side frame at its end."""

    force: base.Vector = quantity("N", "force at the frame's origin beside the frame's weight, global")
    moment: base.Vector = quantity("N m", "moment about the frame's origin, global")


class Pose(NamedTuple):
    """Upper structure of a shovel at the end of a phase: of its dipper, places from the swing axis."""

    name: str
    end: float  # s
    swing: float  # rad, from straight ahead to the left
    reach: float  # m
    height: float  # m above the rollers' axes
    payload: float  # kg
    bank: tuple[float, float] = (0.0, 0.0)  # N, of the bank on the dipper, away from the machine and up

    def turned(self, ahead: float, up: float) -> np.ndarray:
        """Vector so far ahead of the upper structure, and up: array (3,)."""
        return np.array([ahead * math.cos(self.swing), ahead * math.sin(self.swing), up])


class MachineCycle(loads.Cycle):
    """Force and moment of the machine on one side frame, in phases whose ends are joined by cubic STEPs."""

    phases: Several[MachinePhase]

    @classmethod
    def shovel(
        cls,
        frame: Undercarriage | None = None,
        poses: Sequence[Pose] = tuple(Pose(*one) for one in ph4100c.SHOVEL_POSES),
        shovel: Mapping[str, Any] = ph4100c.SHOVEL,
        side: float = 1.0,
        down: Sequence[float] = (0.0, 0.0, -1.0),
    ) -> Self:
        """Cycle of a rope shovel from its weights and what its dipper meets.

        Statics gives this track its share: the resultant of all forces, at y from the middle between the
        tracks, rests on both in the ratio of their distances. Along x each share stands where the whole does.
        The lateral moment that is left is the pair of both tracks' forces: none of it is on the side frame.

        The weight of the side frame, that of the P&H 4100C if None, is taken off the share. Poses are at the
        ends of the phases, masses and places of the `shovel` as of `ph4100c.SHOVEL`; `side` is 1 on the left
        track and -1 on the right one, `down` as of `Terrain.down`. A ValueError if the machine tips over a
        track.
        """
        frame = frame or Undercarriage.ph4100c()
        gravity, phases = np.asarray(down, dtype=float), []
        for pose in poses:
            forces, places = _loads(shovel, pose, gravity)
            whole, moment = forces.sum(axis=0), np.cross(places, forces).sum(axis=0)
            aside = moment[0] / whole[2]
            share = 0.5 + side * aside / ph4100c.TRACK_DISTANCE
            if not 0.0 <= share <= 1.0:
                acts = f"its weight acts {aside:.3g} m beside the middle"
                raise ValueError(f"the machine tips sideways at the end of {pose.name!r}: {acts}")
            weight = frame.mass * ph4100c.GRAVITY * gravity
            force = tuple((share * whole - weight).tolist())
            turn = float(share * moment[1] - np.cross(frame.com, weight)[1])
            phases.append(MachinePhase(name=pose.name, end=pose.end, force=force, moment=(0.0, turn, 0.0)))
        return cls(phases=tuple(phases))

    @classmethod
    def slewing(
        cls,
        body: CarBody | None = None,
        poses: Sequence[Pose] = tuple(Pose(*one) for one in ph4100c.SHOVEL_POSES),
        down: Sequence[float] = (0.0, 0.0, -1.0),
    ) -> Self:
        """Cycle of a machine on two tracks that stands: how its upper structure slews, and its dipper's load.

        Poses have the dipper's payload and what the bank does to it; their swing takes the weight of the
        upper structure along. What changes with a dipper's reach alone is left out, and so is the slewing's
        angular momentum. The upper structure is that of a `body`, the P&H 4100C's if None, and slews from its
        `slew`; poses and `down` are as of `shovel`.
        """
        body = body or CarBody.ph4100c()
        gravity = ph4100c.GRAVITY * np.asarray(down, dtype=float)
        rest, _ = body.upper_at(body.slew)
        phases = []
        for pose in poses:
            dipper = np.array([body.swing_axis, 0.0, 0.0]) + pose.turned(pose.reach, pose.height)
            force = pose.payload * gravity + pose.turned(*pose.bank)
            moved = body.upper_at(pose.swing)[0] - rest
            moment = np.cross(dipper, force) + np.cross(moved, body.upper_mass * gravity)
            named = {"force": tuple(force.tolist()), "moment": tuple(moment.tolist())}
            phases.append(MachinePhase(name=pose.name, end=pose.end, **named))
        return cls(phases=tuple(phases))

    @property
    def components(self) -> list[drive.StepProfile]:
        """Force (N) and moment (N m) over time (s), global: x, y and z of each."""
        return self.profiles((*phase.force, *phase.moment) for phase in self.phases)

    def wrench(self, time: np.typing.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Force (N) and moment (N m) at each time (s): array (times, 3) each."""
        both = loads.values_of(self.components, time)
        return both[:, :3], both[:, 3:]

    def balance_errors(
        self, parts: Sequence[Part], rollers: Sequence[float], aside: float, gravity: np.ndarray
    ) -> Errors:
        """Phases at whose ends, and so ever, a roller would have to pull.

        `parts` are those of the side frame, or the machine, that stands on `rollers` (x, m) and tips where
        its weight acts more than `aside` (m) beside the middle; gravity: (3,), m/s2.
        """
        weight, rear, front = sum(part.mass for part in parts) * gravity, rollers[0], rollers[-1]
        turned = sum(np.cross(part.com, part.mass * gravity) for part in parts)
        for phase in self.phases:
            force = np.array(phase.force) + weight
            moment = np.array(phase.moment) + turned
            at = f"machine: at the end of {phase.name!r} it"
            if force[2] >= 0.0:
                yield f"{at} lifts the side frame"
            x, y = moment[1] / -force[2], -moment[0] / -force[2]
            if not rear <= x <= front:
                yield f"{at} tips: its weight acts at x = {x:.3g} m, rollers are from {rear:g} to {front:g} m"
            if abs(y) > aside:
                beside = f"{y:.3g} m beside the middle of the track, more than {aside:.4g} m"
                yield f"{at}s weight acts {beside}: the side frame tips"


def _loads(shovel: Mapping[str, Any], pose: Pose, down: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces on the machine (N) and their places from the swing axis at the rollers (m): (k, 3) each."""
    dipper = pose.turned(pose.reach, pose.height)
    places = pose.turned(0.0, shovel["lower_height"]), pose.turned(*shovel["upper_place"]), dipper, dipper
    upper, front = shovel["upper"], shovel["front"]
    masses = shovel["mass"] - upper - front, upper, front + pose.payload
    forces = [*(mass * ph4100c.GRAVITY * down for mass in masses), pose.turned(*pose.bank)]
    return np.array(forces), np.array(places)
