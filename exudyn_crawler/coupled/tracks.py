"""Machines on tracks as items of a user's model of Exudyn."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from exudyn_crawler.case import Case
from exudyn_crawler.coupled.block import TrackBlock
from exudyn_crawler.coupled.film import Film
from exudyn_crawler.coupled.placement import Placement
from exudyn_crawler.coupled.rest import SHARE, rest_under
from exudyn_crawler.coupled.user_model import CarItems
from exudyn_crawler.model.exudyn import RigidBodyInertia, exu, items
from exudyn_crawler.results.history import History, states

TRACKS = "exudyn_crawler tracks"
"""Name of the list of tracks in mbs.variables."""
UNTURNED = np.eye(3)


class CoupledTrack:
    """Machine on its tracks in a user's model: items of Exudyn, and the state of the track.

    Attributes
    ----------
    body, node, marker : int
        Numbers of the car body in Exudyn, of its node, and of a marker at its origin.
    position : numpy.ndarray
        Origin of the car body at rest, in the user's frame, m: array (3,).
    axes : numpy.ndarray
        Rotation matrix of the car body at rest, from its axes to the user's frame: array (3, 3).
    velocity, angular_velocity : numpy.ndarray
        Creep of the car body at rest, in the user's frame, m/s and rad/s: arrays (3,).
    gravity : numpy.ndarray
        Acceleration of gravity in the user's frame, m/s2: array (3,).
    """

    def __init__(self, mbs: "exu.MainSystem", car: CarItems, block: TrackBlock) -> None:
        self._mbs = mbs
        self._history: tuple[np.ndarray, History] | None = None
        self.film: Film | None = None
        self.car = car
        self.block = block
        self.body = car.body
        self.node = car.node
        self.marker = car.marker
        self.position, self.axes = car.placement.pose(block.pose)
        self.velocity, self.angular_velocity = (car.placement.turn @ one for one in block.velocity)
        self.gravity = car.placement.turn @ block.system.case.gravity_vector()

    @property
    def case(self) -> Case:
        """Case of the machine, with the take-up for its chains' tension at rest."""
        return self.block.system.case

    def set_speeds(self, speeds: ArrayLike) -> None:
        """Command the speed of each track, m/s, right and left, from the next step on; see `set_torques`."""
        self.block.commands.speeds(speeds)

    def set_torques(self, torques: ArrayLike) -> None:
        """Command the torque of each tumbler's motor, N m, right and left, from the next step on.

        A controller does this in the user function of Exudyn before a step (SetPreStepUserFunction). A
        command stays until the next one; it replaces the drive of the case. ValueError for another number of
        values than of tracks, or for torques of a track without motors.
        """
        self.block.commands.torques(torques)

    @property
    def history(self) -> History:
        """History of the last step, or of the start: all quantities of a run, at one time."""
        row = self.block.system.state()
        if self._history is None or not np.array_equal(row, self._history[0]):
            self._history = row, states.system_history(self.block.system, row[None])
        return self._history[1]

    def add_sensor(self, quantity: str, name: str = "", **place: Any) -> int:
        """Add a sensor of a quantity of the track, whose values Exudyn stores; return its number.

        `quantity` is one of the catalogue, such as "link_tension", "contact_force" or "drive_moment"; `place`
        selects among its dimensions, ``shoe=5, axis="z"``; contacts are summed by shoe. The values are in the
        frame of the case. ValueError for a quantity that the case does not have.
        """

        def values(*_: object) -> list[float]:
            series = self.history.quantity(quantity)
            if "contact" in series.dims:
                series = self.history.contacts_by_shoe()[quantity]
            return np.ravel(series.isel(time=0).sel(**place)).tolist()

        values()  # refuses a wrong name before the run
        return self._mbs.AddSensor(
            items.SensorUserFunction(
                name=name, sensorNumbers=[], factors=[], storeInternal=True, sensorUserFunction=values
            )
        )

    def add_graphics(self, interval: float = 0.02) -> int:
        """Draw shoes, wheels, frames and ground in Exudyn's renderer and SolutionViewer; return the object.

        They are graphics of a ground object. Its states are stored at the interval (s), in memory, and the
        nearest one to the drawn time is shown.
        """
        self.film = Film(self.block, interval)
        visualization = items.VObjectGround(graphicsDataUserFunction=self.film.graphics_at_shown_time)
        return self._mbs.AddObject(items.ObjectGround(visualization=visualization))

    def store_frame(self, time: float) -> None:
        """Store the last step, up to a time (s), for the graphics, if there are any and it is due."""
        if self.film is not None:
            self.film.store(time)

    def place(self, point: ArrayLike) -> np.ndarray:
        """Return a point of the car body (..., 3), m in its axes, at rest in the user's frame."""
        return np.asarray(self.position + np.asarray(point, dtype=float) @ self.axes.T)

    def at(self, point: ArrayLike, axes: ArrayLike = UNTURNED) -> dict[str, Any]:
        """Return the arguments of Exudyn's CreateRigidBody for a body that rests on the car body.

        They are position, attitude, gravity, and velocities: friction holds a track by a slow creep, which
        the bodies on it share. The body's origin is at a point (3,), m, in the axes of the car body; `axes`
        (3, 3) is its rotation matrix against these.
        """
        arm = self.axes @ np.asarray(point, dtype=float)
        return {
            "referencePosition": self.position + arm,
            "referenceRotationMatrix": self.axes @ np.asarray(axes, dtype=float),
            "initialVelocity": self.velocity + np.cross(self.angular_velocity, arm),
            "initialAngularVelocity": self.angular_velocity,
            "gravity": self.gravity,
        }


def tracks_of(mbs: "exu.MainSystem") -> list[CoupledTrack]:
    """Return the tracks of a user's model, in the order of their addition."""
    return list(mbs.variables.get(TRACKS, ()))


def add_track(
    mbs: "exu.MainSystem",
    case: Case,
    name: str = "",
    carried_mass: float = 0.0,
    carried_com: ArrayLike = (0.0, 0.0, 0.0),
    replaces_upper: bool = False,
    position: ArrayLike = (0.0, 0.0, 0.0),
    heading: float = 0.0,
) -> CoupledTrack:
    """Add the machine of a case, at rest on its tracks, to a user's model before its assembly.

    The machine's car body becomes a rigid body of Exudyn, on which the user's model stands. Its axes are
    those of the side frame: x along the travel, y to the left, z up, from the middle of the machine at the
    height of the lower rollers' axes. `exudyn_crawler.solve_dynamic` integrates the whole model.

    Parameters
    ----------
    mbs : exudyn.MainSystem
        The user's model.
    case : Case
        Case with a machine: `Case.rolled()`, `Case.closed()`, `Case.shovel()`, or that of a datasheet.
    name : str
        Name of the rigid body; that of the case if it is empty.
    carried_mass : float
        Mass that the user's model puts on the car body, kg, for the rest at the start.
    carried_com : array_like
        COM of this mass in the axes of the car body, m: (3,).
    replaces_upper : bool
        True if the user's model has the upper structure of a machine on two tracks; the car body then has
        none, and `carried_mass` includes it.
    position : array_like
        Origin of the case's frame in the user's model, m: (3,).
    heading : float
        Direction of the case's x axis in the user's model, rad, positive to the left.

    Returns
    -------
    CoupledTrack
        Numbers of the car body's items, and its pose at rest, on which the user places the model.

    Raises
    ------
    ValueError
        If the case has no machine, or a value is not allowed.
    EquilibriumError
        If the machine finds no rest under the mass.
    """
    com, place = (np.array(values, dtype=float) for values in (carried_com, position))
    for what, values, shape in (
        ("carried_mass", carried_mass, ()),
        ("carried_com", com, (3,)),
        ("position", place, (3,)),
        ("heading", heading, ()),
    ):
        if np.shape(values) != shape or not np.isfinite(values).all():
            raise ValueError(f"{what} must be {'3 finite numbers' if shape else 'finite'}, got {values}")
    if carried_mass < 0.0:
        raise ValueError(f"carried_mass must be at least 0 kg, got {carried_mass:g}")
    placement = Placement(place, heading)
    rest = rest_under(case, carried_mass, com, replaces_upper)
    block = TrackBlock(rest, placement)
    pose = placement.pose(block.pose)
    velocity, spin = block.velocity
    car_mass = rest.car_body.times(SHARE)
    made = mbs.CreateRigidBody(
        name or case.name,
        referencePosition=pose.position,
        referenceRotationMatrix=pose.axes,
        initialVelocity=placement.turn @ velocity,
        initialAngularVelocity=placement.turn @ spin,
        inertia=RigidBodyInertia(car_mass.mass, car_mass.inertia, car_mass.first / car_mass.mass),
        gravity=placement.turn @ case.gravity_vector(),
        returnDict=True,
    )
    body = made["bodyNumber"] if "bodyNumber" in made else made["objectNumber"]
    marker = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body))
    wrench = -placement.of_wrench @ block.wrench
    force = mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=wrench[:3]))
    torque = mbs.AddLoad(items.LoadTorqueVector(markerNumber=marker, loadVector=wrench[3:]))
    track = CoupledTrack(mbs, CarItems(body, made["nodeNumber"], marker, force, torque, placement), block)
    mbs.variables.setdefault(TRACKS, []).append(track)
    return track
