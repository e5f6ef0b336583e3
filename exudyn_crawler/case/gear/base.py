"""Contract of gears: what every kind gives a case.

Who asks a gear asks for the thing that is wanted (wheels, names of bodies, where shoes start, what is
refused), never for its kind. A gear takes what it needs of the rest of a case as arguments: shoe and chain,
or the case as a `Whole`.
"""

from collections.abc import Iterator
from typing import ClassVar, Literal, NamedTuple, Protocol

import numpy as np

from exudyn_crawler.case.parameters.car_body import Part
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.case.parameters.machine_cycle import MachineCycle
from exudyn_crawler.case.parameters.track import SIDES, Shoe, Track
from exudyn_crawler.settings.parameters import Errors, Parameters

SIDE_FRAME = "side frame"
"""Name of the body that rolls over the shoes; of a machine on two tracks all of it but shoes and tumblers."""
POSTS = (0, 1, 2, 3, 4, 5)
"""Coordinates of a side frame that posts hold: all."""


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
    """Gear, which moves the shoes and carries the machine; the members here are those of shoes alone."""

    kind: str

    phrase: ClassVar[str] = "Track of {shoes} shoes, whose front shoe is dragged"
    """Words for readers: what stands on which shoes; `mass` is that of all but the shoes, in t."""

    quantities: ClassVar[frozenset[str]] = frozenset()
    """Words by which the catalogue of quantities says that one needs such a gear."""
    tracks: ClassVar[int] = 1
    """Number of tracks; of two the right one comes first."""
    loops: ClassVar[int] = 0
    """Number of chains that are closed."""
    rigid_joint: ClassVar[str] = SIDES[0]
    """Side of the joint of a link of rigid shoes."""
    shoes_stand: ClassVar[bool] = False
    """True where the drive moves no shoe over the ground."""

    @property
    def parts(self) -> tuple[str, ...]:
        """Files of `model.parts` that its machine is made of, in the order of their bodies."""
        return ("shoes",)

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
    def pin_compliance(self) -> float:
        """Compliance of pins across the chain: m/N sideways, rad/(N m) in yaw and roll."""
        return 0.0

    @property
    def is_set_by_tension(self) -> bool:
        """True where the place of an idler is what gives its chain the tension at rest."""
        return False

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

    def shoes_by_strips(self, bends: np.ndarray) -> np.ndarray:
        """Shoes, from 0, with every strip of a tread in a history; `bends` (shoes,): the flexible ones."""
        return np.arange(len(bends))

    def joints(self, chain: Track) -> np.ndarray:
        """Numbers of the links; link i joins shoe i and the next one of its track."""
        return chain.shoes if self.loops else chain.joints

    def shoe_reference(self, shoe: Shoe, chain: Track) -> np.ndarray:
        """Positions of the COMs (m, global) and angles (rad) of the shoes at t = 0: array (shoes, 6)."""
        coms = chain.com_positions(shoe.com_height)
        return np.hstack((coms, np.zeros_like(coms)))

    def standing(self, case: Whole) -> np.ndarray:
        """True for shoes that carry the machine as it stands at t = 0: array (shoes,)."""
        return np.ones(case.track.shoe_count, dtype=bool)

    def first_loads(self, case: Whole) -> np.ndarray:
        """Loads on the shoes beside their weight at t = 0: array (shoes,), N."""
        return case.loads.loads(0.0)[0]

    def way(self, drive: Drive, times: np.ndarray) -> np.ndarray:
        """Way along x and y of the track's middle by times (s), as the drive wants it: (times, 2), m."""
        travels = drive.travel(times)
        return np.column_stack((travels, np.zeros_like(travels)))

    @property
    def carried_mass(self) -> float:
        """Mass on the shoes beside their own, kg."""
        return 0.0

    def whole_mass(self, case: Whole) -> float:
        """Return the mass of all parts, shoes included, kg."""
        return self.carried_mass + case.track.shoe_count * case.shoe.mass

    def words(self, case: Whole) -> str:
        """Say what stands on which shoes, for readers."""
        whole, carried = (f"{1e-3 * mass:.4g}" for mass in (self.whole_mass(case), self.carried_mass))
        shoes = case.track.shoe_count // self.tracks
        return self.phrase.format(whole=whole, carried=carried, shoes=shoes)

    def wrenches(self, machine: np.ndarray) -> np.ndarray:
        """Forces and moments beside those on shoes: array (n, 6), N and N m; `machine` (6,) is on a frame."""
        return np.zeros((0, 6))

    def active(self, driven: bool, turned: bool, drawn: bool = False) -> np.ndarray:
        """Equations of the drive of a shoe or a frame, and of its turn, that hold: array (2,), 1 or 0.

        A frame that is `drawn` has a drawbar that holds its speed.
        """
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
