"""Contract of gears: what every kind gives a case, and what all side frames have.

Who asks a gear asks for the thing that is wanted (wheels, names of bodies, where shoes start, what is
refused), never for its kind. A gear takes what it needs of the rest of a case as arguments: shoe and chain,
or the case as a `Whole`.
"""

from collections.abc import Iterator, Sequence
from typing import ClassVar, Literal, NamedTuple, Protocol

import numpy as np

from exudyn_crawler.case.parameters import base, sizes
from exudyn_crawler.case.parameters.base import Errors, Parameters, quantity
from exudyn_crawler.case.parameters.car_body import Part
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.case.parameters.machine_cycle import MachineCycle
from exudyn_crawler.case.parameters.track import Shoe, Track

SIDE_FRAME = "side frame"
"""Name of the body that rolls over the shoes; of a machine on two tracks all of it but shoes and tumblers."""
ACROSS = (1, 5)
"""Coordinates of a side frame across the track: y and yaw."""
POSTS = (0, 1, 2, 3, 4, 5)
"""All of them, which posts hold."""
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


class Whole(Protocol):
    """Case as its gear sees it."""

    @property
    def shoe(self) -> Shoe:
        """Shoe, its rails included."""

    @property
    def track(self) -> Track:
        """Chain of all shoes."""

    @property
    def drive(self) -> Drive:
        """Drive."""

    @property
    def loads(self) -> LoadCycle:
        """Loads on the shoes."""

    @property
    def machine(self) -> MachineCycle | None:
        """Force and moment on the side frame."""

    @property
    def gravity(self) -> float:
        """Acceleration of gravity, m/s2."""

    @property
    def is_compiled(self) -> bool:
        """True where a run takes the compiled equations of motion."""

    def gravity_vector(self) -> np.ndarray:
        """Acceleration of gravity: array (3,), m/s2."""


class Gear(Parameters):
    """What moves the shoes and carries the machine; the members here are those of shoes alone."""

    kind: str

    quantities: ClassVar[frozenset[str]] = frozenset()
    """Words by which the catalogue of quantities says that one needs such a gear."""
    tracks: ClassVar[int] = 1
    """Number of tracks; of two the right one comes first."""
    loops: ClassVar[int] = 0
    """Number of chains that are closed."""

    @property
    def middles(self) -> np.ndarray:
        """Y of the middles of the tracks in the axes of the side frame: array (tracks,), m."""
        return np.zeros(self.tracks)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies beside the shoes: a side frame, then what turns in it."""
        return ()

    @property
    def tumblers(self) -> tuple[str, ...]:
        """Names of the tumblers that are bodies."""
        return ()

    @property
    def sliding_idlers(self) -> tuple[str, ...]:
        """Names of the idlers that are bodies: those that tensioners push."""
        return ()

    @property
    def wheel_labels(self) -> list[WheelLabel]:
        """Kinds and numbers of the wheels that press on rails, in their order."""
        return []

    @property
    def wheel_names(self) -> list[str]:
        """Names of these wheels."""
        return [label.words for label in self.wheel_labels]

    @property
    def frame_parts(self) -> list[Part]:
        """Rigid parts of the side frame, or of the machine on two tracks."""
        return []

    @property
    def holds(self) -> tuple[int, ...]:
        """Coordinates of the side frame that are held."""
        return ()

    @property
    def single(self) -> "Gear":
        """Gear of one of the tracks by itself."""
        return self

    def loop(self, chain: Track) -> Track:
        """Chain of one of the tracks."""
        return chain.with_(shoe_count=chain.shoe_count // self.tracks)

    def chain_pitch(self, chain: Track) -> float:
        """Distance of the pins of a shoe, m."""
        return chain.pitch

    def joints(self, chain: Track) -> np.ndarray:
        """Numbers of the links; link i joins shoe i and the next one of its track."""
        return chain.shoes if self.loops else chain.joints

    def shoe_reference(self, shoe: Shoe, chain: Track) -> np.ndarray:
        """Positions of the COMs (m, global) and angles (rad) of the shoes at t = 0: array (shoes, 6)."""
        coms = chain.com_positions(shoe.com_height)
        return np.hstack((coms, np.zeros_like(coms)))

    def first_loads(self, case: Whole) -> np.ndarray:
        """Loads on the shoes at t = 0: array (shoes,), N."""
        return case.loads.loads(0.0)[0]

    def way(self, drive: Drive, time: float) -> np.ndarray:
        """Way along x and y of the track's middle by a time (s), as the drive wants it: array (2,), m."""
        return np.array([drive.travel(time), 0.0])

    def drags(self, speeds: np.ndarray) -> np.ndarray:
        """Resistance of wheels over their normal force, (..., wheels), against speeds of tracks, m/s."""
        return np.zeros((*speeds.shape[:-1], 0))

    def wrenches(self, machine: np.ndarray) -> np.ndarray:
        """Forces and moments beside those on shoes: array (n, 6), N and N m; `machine` (6,) is on a frame."""
        return np.zeros((0, 6))

    def active(self, driven: bool, turned: bool) -> np.ndarray:
        """Equations of the drive of a shoe or a frame, and of its turn, that hold: array (2,), 1 or 0."""
        return np.array([driven, turned], dtype=float)

    def motors(self, speeds: np.ndarray, chain: Track) -> np.ndarray:
        """Speeds of the motors (rad/s) at speeds of the tracks (tracks,), m/s."""
        return np.zeros(0)

    def errors(self, case: Whole) -> Errors:
        """Lines that say what does not fit the rest of the case; the first is raised."""
        yield from ()

    def implausible(self, shoe: Shoe, chain: Track) -> Iterator[str]:
        """Lines that say what no machine is known to have."""
        yield from ()

    def reach_errors(self, chain: Track, travel: float, time: float) -> Errors:
        """Lines that say what is off the track after a travel (m), at a time (s)."""
        yield from ()


class RunningGear(Gear):
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
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies beside the shoes: the side frame, then what turns in it."""
        return (SIDE_FRAME, *self.tumblers, *self.sliding_idlers)

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
        """Coordinates of the side frame that are held."""
        return ACROSS

    @property
    def tipping(self) -> float:
        """Distance beside its middle at which a weight tips the frame, m."""
        return TIPPING

    @property
    def length(self) -> float:
        """Length along which its wheels stand, m."""
        return self.rollers[-1] - self.rollers[0]

    @property
    def strip_places(self) -> np.ndarray:
        """Y of the strips' middles beside that of their tread: array (strips,), m."""
        # two resist tilting at the Gauss points as an evenly spread contact does
        points, _ = np.polynomial.legendre.leggauss(self.strips)
        return 0.5 * self.tread_width * points

    @property
    def resistances(self) -> np.ndarray:
        """Of wheels against the travel over their normal force: array (wheels,)."""
        return np.full(len(self.rollers), self.rolling_resistance)

    @property
    def flange(self) -> tuple[float, float, float]:
        """Play (m), stiffness (N/m) and damping (N s/m) of the flanges of a wheel; it has none."""
        return 0.0, 0.0, 0.0

    @property
    def flange_height(self) -> float:
        """Height of the flanges above a tread, m."""
        return 0.0

    @property
    def slide_places(self) -> tuple[base.Three, ...]:
        """X of rear and front end, z of the top of slides, m."""
        return ()

    def frame_start(self, shoe: Shoe, chain: Track) -> np.ndarray:
        """Origin of the side frame, or the machine, at t = 0, on rails that have not settled: (3,), m."""
        raise NotImplementedError

    def first_wheels(self, shoe: Shoe, chain: Track) -> np.ndarray:
        """X and z in the frame and radius of the wheels of one track at t = 0: array (wheels, 3), m."""
        raise NotImplementedError

    def extent(self, shoe: Shoe, chain: Track) -> tuple[float, float, float]:
        """X of the frame's rear and front end, and z of the lowest that is above it; m."""
        raise NotImplementedError

    def drags(self, speeds: np.ndarray) -> np.ndarray:
        """Resistance of wheels over their normal force, (..., wheels), against speeds of tracks, m/s."""
        faded = np.hypot(speeds, self.resistance_speed)
        drags = speeds[..., None] * self.resistances / faded[..., None]
        return drags.reshape(*speeds.shape[:-1], -1)

    def wrenches(self, machine: np.ndarray) -> np.ndarray:
        """Forces and moments beside those on shoes: array (n, 6), N and N m; the machine's (6,) first."""
        return machine[None]

    def first_loads(self, case: Whole) -> np.ndarray:
        """Loads on the shoes at t = 0: array (shoes,), N; the side frame weighs evenly on those below it."""
        start = self.frame_start(case.shoe, case.track)
        half = 0.5 * case.track.pitch
        coms = self.shoe_reference(case.shoe, case.track)
        rear = self.rollers[0] + start[0]
        front = self.rollers[-1] + start[0]
        under = (coms[:, 0] >= rear - half) & (coms[:, 0] <= front + half) & (coms[:, 2] < start[2])
        carried = sum(part.mass for part in self.frame_parts)
        return super().first_loads(case) + under * carried * case.gravity / max(1, under.sum())

    def errors(self, case: Whole) -> Errors:
        """Lines that say what does not fit the rest of the case."""
        kind = f"gear.kind {self.kind!r}"
        if not case.is_compiled:
            refused = "contact.model 'spheres' and terrain_formulation 'constrained'"
            yield f"formulation 'engine', {refused} do not go with {kind}"
        rails = case.shoe.rails
        if rails is None:
            yield f"shoe.rails must be given with {kind}, whose wheels run on them"
        elif self.tread_width > rails.width:
            width = f"the rails' width {rails.width} m"
            yield f"gear.tread_width must not exceed {width}, got {self.tread_width}"
        if case.drive.on is not None:
            yield f"drive.on must be None with {kind}, always moved or held; a speed of zero is a brake"
        yield from self.turn_errors(case.drive)
        if any(load != 0.0 for phase in case.loads.phases for load in phase.loads):
            yield f"loads must be zero on every shoe with {kind}, whose rollers carry the machine"
        yield from self.track_errors(case.shoe, self.loop(case.track))
        if case.machine is not None:
            gravity = case.gravity_vector()
            yield from case.machine.balance_errors(self.frame_parts, self.rollers, self.tipping, gravity)

    def implausible(self, shoe: Shoe, chain: Track) -> Iterator[str]:
        """Lines that say what no machine is known to have: an inertia that does not go with the mass."""
        yield from sizes.thin_inertia("gear", self.mass, self.inertia)
        yield from sizes.far_inertia("gear", self.mass, self.inertia, self.length)

    def turn_errors(self, drive: Drive) -> Errors:
        """Lines that refuse a turn of a single track."""
        if drive.turn_rate is not None:
            yield f"drive.turn_rate must be None with gear.kind {self.kind!r}: one track does not turn"

    def track_errors(self, shoe: Shoe, chain: Track) -> Errors:
        """Lines that say what of a shoe with rails, and of the chain of one track, does not fit."""
        yield from ()


def overlap_errors(wheels: str, places: Sequence[float], radius: float) -> Errors:
    """Wheels at places (x, m) that are nearer to each other than their diameter."""
    if np.any(np.diff(places) < 2.0 * radius):
        yield f"{wheels} must stand in order and a diameter {2.0 * radius:g} m apart, got {list(places)}"
