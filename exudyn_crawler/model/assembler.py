"""Assembler of a machine: the bodies, markers, joints and loads of its parts, and their couplings."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from exudyn_crawler.case import Case, CellTerrain
from exudyn_crawler.ground import packed
from exudyn_crawler.ground.laws import Impact
from exudyn_crawler.model.bodies import Bodies, Modes, second_moment
from exudyn_crawler.model.flexible_shoes import FloatingShoe
from exudyn_crawler.model.forces.arms import Arms
from exudyn_crawler.model.forces.cells import CellTable
from exudyn_crawler.model.forces.loads import Loads
from exudyn_crawler.model.forces.teeth import Teeth
from exudyn_crawler.model.forces.wheels import Wheels
from exudyn_crawler.model.joints.drive import Speeds
from exudyn_crawler.model.joints.friction import Frictions
from exudyn_crawler.model.joints.hold import Held
from exudyn_crawler.model.joints.motor import Motors
from exudyn_crawler.model.joints.pin import ROWS, Pins
from exudyn_crawler.model.joints.play import METRIC, Plays
from exudyn_crawler.model.joints.pull import Pull
from exudyn_crawler.model.joints.recoil import Recoils
from exudyn_crawler.model.kinds import Joints
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.shoe_mesh import DrivePoint
from exudyn_crawler.model.state import BODY_COORDINATES, friction_name

DRIVE = "drive"
TURN = "turn"
"""Names of the rows of the drive's two speeds."""


class Body(NamedTuple):
    """Body: integrals over its mass, see `Bodies`, and its reference pose at zero coordinates."""

    name: str
    mass: float  # kg
    first: np.ndarray  # (3,): kg m
    second: np.ndarray  # (3, 3): kg m2
    reference: np.ndarray  # (6,): m, global, and rad
    bends: bool = False

    @classmethod
    def rigid(
        cls,
        name: str,
        mass: float,
        inertia: np.ndarray,
        reference: np.ndarray,
        com: ArrayLike = (0.0, 0.0, 0.0),
    ) -> "Body":
        """Return a rigid body with an inertia (3, 3) about its COM, kg m2.

        `com` (3,) is the COM in the body's frame, m.
        """
        center = np.array(com, dtype=float)
        return cls(name, mass, mass * center, second_moment(mass, inertia, center), reference)


class Hinge(NamedTuple):
    """Pin of a link, or bearing of a body that rotates in a frame."""

    markers: tuple[int, int]  # of the rear and of the front body
    name: str
    link: int  # from 1; 0 for a pin outside the chain
    compliance: np.ndarray  # (ROWS,): m/N and rad/(N m)
    relaxation: np.ndarray  # (ROWS,): s
    rubs: bool  # True: with a moment about its axis by `Frictions`

    @property
    def row_names(self) -> tuple[str, ...]:
        """Names of its rows: of the pin, and of its friction if it has any."""
        return (self.name, friction_name(self.name)) if self.rubs else (self.name,)


class Motor(NamedTuple):
    """Motor of a body that turns against a frame."""

    bodies: tuple[int, int]  # frame and that body
    name: str
    limit: float  # N m
    lag: float  # rad/s


class Assembler:
    """Collector of what the parts of a case's machine add; its methods return numbers of added items.

    `floating` is the shared data of flexible shoes, `point` the point of the front shoe at which the drive
    acts. The first modal coordinate has the number `first_modal`.
    """

    def __init__(
        self, case: Case, floating: FloatingShoe | None, point: DrivePoint, terrain_size: int
    ) -> None:
        self.case = case
        self.floating = floating
        self.point = point
        self.shoes = case.track.shoe_count
        self.first_modal = 6 * self.shoes + terrain_size
        self.mode_count = 0 if floating is None else floating.mode_count
        self.flexible = np.zeros(self.shoes, dtype=bool)
        if case.flexible is not None:
            self.flexible[np.array(case.flexible.shoes) - 1] = True
        self.bodies: list[Body] = []
        self.pins: list[Hinge] = []
        self.plays: list[tuple[Hinge, float]] = []  # links with play, distance of their contacts
        self.motors: list[Motor] = []
        self.drive = (0, 0)  # marker that it moves, body that it turns
        self.modes = packed.nothing(Modes)
        self.pull = packed.nothing(Pull)
        self.teeth = packed.nothing(Teeth)
        self.wheels = packed.nothing(Wheels)
        self.arms = packed.nothing(Arms)
        self.cells = packed.nothing(CellTable)
        # bodies, and names of rows, that the equations couple
        self.couplings: list[tuple[tuple[int, ...], tuple[str, ...]]] = []
        self._recoils: list[tuple[int, float, float, float]] = []  # pin, preload, compliance and stroke
        self._holds: list[tuple[int, int]] = []
        self._loads: list[tuple[int, int]] = []
        self._markers: list[tuple[int, np.ndarray, np.ndarray, np.ndarray]] = []

    def add_body(self, body: Body) -> int:
        """Add a body: shoes first, in their order."""
        self.bodies.append(body)
        return len(self.bodies) - 1

    def body_named(self, name: str) -> int:
        """Return the number of a body by its name."""
        return [body.name for body in self.bodies].index(name)

    def add_marker(
        self,
        body: int,
        place: ArrayLike,
        moved: np.ndarray | None = None,
        turned: np.ndarray | None = None,
    ) -> int:
        """Add a marker at a location (3,), m, in a body's frame; return its number.

        `moved` and `turned` (3, modes) are displacement and rotation of the marker by the body's modes.
        """
        none = np.zeros((3, self.mode_count))
        by_modes = none if moved is None else moved
        turned_by_modes = none if turned is None else turned
        self._markers.append((body, np.array(place, dtype=float), by_modes, turned_by_modes))
        return len(self._markers) - 1

    def body_of(self, marker: int) -> int:
        """Return the number of a marker's body."""
        return self._markers[marker][0]

    def add_pin(
        self,
        rear: int,
        front: int,
        name: str,
        link: int = 0,
        compliance: ArrayLike = (0.0,) * ROWS,
        relaxation: ArrayLike = (0.0,) * ROWS,
    ) -> None:
        """Add a pin between two markers, with friction if it is in the chain; for the rest see `Hinge`."""
        rubs = link > 0 and not self.case.track.pin.is_ideal
        arrays = np.array(compliance), np.array(relaxation)
        self.pins.append(Hinge((rear, front), name, link, *arrays, rubs))

    def add_play(self, rear: int, front: int, name: str, link: int, half: float) -> None:
        """Add a link with play between two markers; for `half` see `Plays`."""
        rigid = np.zeros(ROWS)
        self.plays.append((Hinge((rear, front), name, link, rigid, rigid, False), half))

    @property
    def hinges(self) -> list[Hinge]:
        """Pins, then links with play, in the order of their rows."""
        return [*self.pins, *(hinge for hinge, _ in self.plays)]

    def add_recoil(self, preload: float, compliance: float, stroke: float) -> None:
        """Make the last pin's row along the frame, with this compliance, the row of a recoil spring."""
        self._recoils.append((len(self.pins) - 1, preload, compliance, stroke))

    def add_motor(self, frame: int, body: int, name: str, limit: float, lag: float) -> None:
        """Add a motor of a body against a frame; for the rest see `Motor`."""
        self.motors.append(Motor((frame, body), name, limit, lag))

    def hold(self, body: int, coordinates: Iterable[int]) -> None:
        """Hold coordinates of a body at their values."""
        self._holds += [(body, coordinate) for coordinate in coordinates]

    def add_load(self, marker: int, beside: int = -1) -> None:
        """Add the next of the loads of `TimedInputs`, at a marker; `beside` as in `Loads`."""
        self._loads.append((marker, beside))

    def couple(self, bodies: Sequence[int], rows: Sequence[str] = ()) -> None:
        """Add a coupling of bodies, and of rows of joints by name, for the elimination."""
        self.couplings.append((tuple(bodies), tuple(rows)))

    @property
    def row_names(self) -> tuple[tuple[str, int], ...]:
        """Names of the joints in the order of their rows, and the number of rows of each."""
        holds = [
            f"hold of {self.bodies[body].name} ({BODY_COORDINATES[coordinate]})"
            for body, coordinate in self._holds
        ]
        single = [DRIVE, TURN, *holds, *(motor.name for motor in self.motors)]
        rubbing = [friction_name(pin.name) for pin in self.pins if pin.rubs]
        return (*((pin.name, ROWS) for pin in self.hinges), *((name, 1) for name in [*rubbing, *single]))

    def table_of_bodies(self) -> Bodies:
        """Return the table of all bodies.

        Shoes' coordinates are first; those of the other bodies follow the modes.
        """
        count = len(self.bodies)
        bends = np.array([body.bends for body in self.bodies])
        modal = np.full(count, -1)
        modal[bends] = self.first_modal + self.mode_count * np.arange(bends.sum())
        first_other = self.first_modal + self.mode_count * int(bends.sum())
        others = first_other + 6 * np.arange(count - self.shoes)
        return Bodies(
            coordinate=np.concatenate((6 * np.arange(self.shoes), others)),
            modal=modal,
            reference=np.array([body.reference for body in self.bodies]),
            mass=np.array([body.mass for body in self.bodies], dtype=float),
            first=np.array([body.first for body in self.bodies]),
            second=np.array([body.second for body in self.bodies]),
            of_angles=np.zeros((count, 2, 3)),
        )

    def table_of_markers(self) -> Markers:
        """Return the table of all markers."""
        body, position, moved, turned = (np.array(column) for column in zip(*self._markers, strict=True))
        bends = moved.any(axis=(1, 2)) | turned.any(axis=(1, 2))
        return Markers(body, position, moved, turned, np.where(bends, self.mode_count, 0))

    def tables_of_joints(self) -> Joints:
        """Return the tables of all joints, whose rows follow kind by kind."""
        rubbing = np.flatnonzero([pin.rubs for pin in self.pins])
        first_friction = ROWS * len(self.hinges)
        first_speed = first_friction + len(rubbing)
        first_hold = first_speed + 2
        pins = Pins(
            0,
            np.array([pin.markers for pin in self.pins], dtype=np.int64).reshape(-1, 2),
            np.array([pin.compliance for pin in self.pins], dtype=float).reshape(-1, ROWS),
            np.array([pin.relaxation for pin in self.pins], dtype=float).reshape(-1, ROWS),
            in_plane=self.case.gear.loops > 0,
            follows=isinstance(self.case.terrain, CellTerrain),
        )
        motors = Motors(
            first_hold + len(self._holds),
            np.array([motor.bodies for motor in self.motors], dtype=np.int64).reshape(-1, 2),
            np.array([motor.limit for motor in self.motors], dtype=float),
            np.array([motor.lag for motor in self.motors], dtype=float),
        )
        recoils = np.array(self._recoils, dtype=float).reshape(-1, 4)
        return Joints(
            pins=pins,
            plays=self._table_of_plays(),
            frictions=Frictions(first_friction, rubbing, self.case.track.pin.law(self.case.track.pitch)),
            drive=Speeds(first_speed, *self.drive),
            pull=self.pull._replace(row=first_speed),
            holds=Held(first_hold, np.array(self._holds, dtype=np.int64).reshape(-1, 2)),
            motors=motors,
            recoils=Recoils(ROWS * recoils[:, 0].astype(np.int64), *np.ascontiguousarray(recoils[:, 1:].T)),
        )

    def _table_of_plays(self) -> Plays:
        """Return the table of all links with play."""
        count = len(self.pins)
        play = self.case.gear.pin_play
        law = (1.0, 0.0, 1.0) if play is None else (play.stiffness, play.damping, play.damping_depth)
        return Plays(
            ROWS * count,
            1 if len(self.pull.markers) else 0,
            count,
            np.array([hinge.markers for hinge, _ in self.plays], dtype=np.int64).reshape(-1, 2),
            np.array([half for _, half in self.plays], dtype=float),
            self.case.gear.pin_clearance(self.case.track),
            0.0 if play is None else play.axial,
            Impact(law[0], 1.0, *law[1:]),
            METRIC * self.case.shoe.mass / self.case.solver.step**2,
        )

    def table_of_loads(self) -> Loads:
        """Return the table of all loads."""
        return Loads(*(np.array(column) for column in zip(*self._loads, strict=True)))
