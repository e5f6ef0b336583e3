"""Interface of gears: the members that every kind gives a case.

Callers ask a gear for the result itself (wheels, names of bodies, start positions of shoes, errors), never
for its kind. A gear takes the rest of a case as arguments: the case as a `Whole`, or shoe and chain.
"""

from collections.abc import Iterator
from typing import ClassVar, Literal, NamedTuple, Protocol

import numpy as np

from exudyn_crawler.case.parameters.car_body import Part
from exudyn_crawler.case.parameters.closed_track import Play
from exudyn_crawler.case.parameters.contact import PairContact, SphereContact
from exudyn_crawler.case.parameters.drive import Drive
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.case.parameters.machine_cycle import MachineCycle
from exudyn_crawler.case.parameters.terrain import CellContact, CellTerrain, Terrain
from exudyn_crawler.case.parameters.track import SIDES, Shoe, Track
from exudyn_crawler.settings.parameters import Errors, Parameters

SIDE_FRAME = "side frame"
"""Name of the body that rolls over the shoes; on two tracks it is the machine without shoes and tumblers."""
NOT_COMPILED = "contact.model 'spheres' and terrain_formulation 'constrained'"
"""Values of a case that has no compiled equations of motion."""
POSTS = (0, 1, 2, 3, 4, 5)
"""Coordinates of a side frame that posts hold: all six."""


WheelKind = Literal["roller", "idler", "carrier", "slide"]


class WheelLabel(NamedTuple):
    """Kind and number of a wheel, and its name in tables and histories."""

    kind: WheelKind
    number: int = 0  # from 1, rear to front; 0: the only one
    line: int = 0  # line of a slide, from 1, rear to front
    track: str = ""  # "right" or "left" on a machine with two tracks

    @property
    def words(self) -> str:
        """Name for readers, such as "roller 3", "slide 1, line 2" or "right idler"."""
        number = f" {self.number}" if self.number else ""
        line = f", line {self.line}" if self.line else ""
        track = f"{self.track} " if self.track else ""
        return f"{track}{self.kind}{number}{line}"


class Whole(Protocol):
    """Members of a case that its gear may use."""

    @property
    def shoe(self) -> Shoe:
        """Shoe, its rails included."""

    @property
    def track(self) -> Track:
        """Chain of all shoes."""

    @property
    def gear(self) -> "Gear":
        """Gear itself."""

    @property
    def terrain(self) -> Terrain | CellTerrain:
        """Ground."""

    @property
    def contact(self) -> PairContact | SphereContact | CellContact:
        """Contact of shoes and terrain."""

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
    def can_be_compiled(self) -> bool:
        """Existence of compiled equations of motion, true or false."""

    @property
    def is_compiled(self) -> bool:
        """Use of the compiled equations of motion in a run, true or false."""

    def gravity_vector(self) -> np.ndarray:
        """Return the acceleration of gravity: array (3,), m/s2."""


class Gear(Parameters):
    """Gear, which moves the shoes and carries the machine; the members here are those of shoes alone."""

    kind: str

    phrase: ClassVar[str] = "Track of {shoes} shoes, pulled at its front shoe"
    """Template of the words for readers: masses `whole` and `carried` in t, number of `shoes` of a track."""

    quantities: ClassVar[frozenset[str]] = frozenset()
    """Words in the catalogue of quantities for those that this gear has."""
    tracks: ClassVar[int] = 1
    """Number of tracks; the right one comes first."""
    loops: ClassVar[int] = 0
    """Number of closed chains."""
    rigid_joint: ClassVar[str] = SIDES[0]
    """Position of the joint across a link of rigid shoes: a side, or the middle."""
    shoes_stand: ClassVar[bool] = False
    """True if the drive moves no shoe over the ground."""

    @property
    def parts(self) -> tuple[str, ...]:
        """Files of `model.parts` that build the gear, in the order of their bodies."""
        return ("shoes",)

    @property
    def middles(self) -> np.ndarray:
        """Lateral positions y of the tracks' middles in the side frame's axes: array (tracks,), m."""
        return np.zeros(self.tracks)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies other than shoes: the side frame, then the bodies that move in it."""
        return ()

    @property
    def tumblers(self) -> tuple[str, ...]:
        """Names of the tumblers that are bodies."""
        return ()

    @property
    def sliding_idlers(self) -> tuple[str, ...]:
        """Names of the idlers that are bodies, because they slide on springs."""
        return ()

    @property
    def wheel_labels(self) -> list[WheelLabel]:
        """Kinds and numbers of the wheels on rails, in their order."""
        return []

    @property
    def wheel_names(self) -> list[str]:
        """Names of the wheels on rails, in their order."""
        return [label.words for label in self.wheel_labels]

    @property
    def frame_parts(self) -> list[Part]:
        """Rigid parts of the side frame, or of the machine on two tracks."""
        return []

    @property
    def holds(self) -> tuple[int, ...]:
        """Coordinates of the side frame with a hold."""
        return ()

    @property
    def pin_compliance(self) -> float:
        """Lateral compliance of the pins: m/N sideways, rad/(N m) in yaw and roll."""
        return 0.0

    @property
    def pin_play(self) -> Play | None:
        """Play of the chain's pins; None for ideal joints."""
        return None

    def pin_clearance(self, chain: Track) -> float:
        """Return the radius of a bore less that of its pin, m."""
        return 0.0

    def shoe_pitch(self, chain: Track) -> float:
        """Return the distance between the joint centres of a shoe, m; a pull adds the clearance."""
        return self.chain_pitch(chain) - self.pin_clearance(chain)

    @property
    def is_set_by_tension(self) -> bool:
        """True if the chain's tension at rest determines the idler's take-up."""
        return False

    @property
    def single(self) -> "Gear":
        """Gear of a single track."""
        return self

    def loop(self, chain: Track) -> Track:
        """Return the chain of one track."""
        return chain.with_(shoe_count=chain.shoe_count // self.tracks)

    def chain_pitch(self, chain: Track) -> float:
        """Return the distance between the pins of a shoe, m."""
        return chain.pitch

    def shoes_by_strips(self, bends: np.ndarray) -> np.ndarray:
        """Return the shoes, from 0, with every strip of a tread in a history; `bends`: flexible shoes."""
        return np.arange(len(bends))

    def joints(self, chain: Track) -> np.ndarray:
        """Return the numbers of the links; link i connects shoe i and the next one of its track."""
        return chain.shoes if self.loops else chain.joints

    def links(self, chain: Track) -> np.ndarray:
        """Return the shoes behind and ahead of every link: array (links, 2); for the numbers see `joints`.

        A closed track's last link connects its last shoe and its first.
        """
        # an open track has no link ahead of its last shoe, so no link leads back to its first shoe
        rear = self.joints(chain)
        count = chain.shoe_count // self.tracks
        return np.column_stack((rear, np.where(rear % count, rear + 1, rear + 1 - count)))

    def shoe_reference(self, case: Whole) -> np.ndarray:
        """Return the COMs (m, global) and angles (rad) of the shoes at t = 0: array (shoes, 6)."""
        coms = case.track.com_positions(case.shoe.com_height)
        return np.hstack((coms, np.zeros_like(coms)))

    def standing(self, case: Whole) -> np.ndarray:
        """Return True for shoes that carry the machine at t = 0: array (shoes,)."""
        return np.ones(case.track.shoe_count, dtype=bool)

    def first_loads(self, case: Whole) -> np.ndarray:
        """Return the loads on the shoes, without their weight, at t = 0: array (shoes,), N."""
        return case.loads.loads(0.0)[0]

    def way(self, drive: Drive, times: np.ndarray) -> np.ndarray:
        """Return the prescribed x and y displacement of the track's middle at times (s): (times, 2), m."""
        travels = drive.travel(times)
        return np.column_stack((travels, np.zeros_like(travels)))

    @property
    def carried_mass(self) -> float:
        """Mass that the shoes carry, without their own, kg."""
        return 0.0

    def whole_mass(self, case: Whole) -> float:
        """Return the mass of all parts, shoes included, kg."""
        return self.carried_mass + case.track.shoe_count * case.shoe.mass

    def words(self, case: Whole) -> str:
        """Describe the gear, its mass and its shoes for readers."""
        whole, carried = (f"{1e-3 * mass:.4g}" for mass in (self.whole_mass(case), self.carried_mass))
        shoes = case.track.shoe_count // self.tracks
        return self.phrase.format(whole=whole, carried=carried, shoes=shoes)

    def wrenches(self, machine: np.ndarray) -> np.ndarray:
        """Return the wrenches other than those on shoes: array (n, 6), N and N m.

        `machine` (6,) is the wrench on the side frame, N and N m.
        """
        return np.zeros((0, 6))

    def active(self, driven: bool, turned: bool, drawn: bool = False) -> np.ndarray:
        """Return the active constraints of the drive, for travel and turn: array (2,), 1 or 0.

        `drawn` is true if a drawbar holds the speed of the side frame.
        """
        return np.array([driven, turned], dtype=float)

    def motors(self, speeds: np.ndarray, chain: Track) -> np.ndarray:
        """Return the speeds of the motors (rad/s) for speeds of the tracks (tracks,), m/s."""
        return np.zeros(0)

    def errors(self, case: Whole) -> Errors:
        """Yield an error for each contradiction to the rest of the case; the first one is raised."""
        yield from ()

    def implausible(self, shoe: Shoe, chain: Track) -> Iterator[str]:
        """Yield a warning for each value that no known machine has."""
        yield from ()

    def reach_errors(self, chain: Track, travel: float, time: float) -> Errors:
        """Yield an error for each part that is off the track after a travel (m), at a time (s)."""
        yield from ()
