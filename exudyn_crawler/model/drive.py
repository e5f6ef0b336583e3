"""Drive of the front shoe, and what holds it at rest."""

from collections.abc import Callable

import numpy as np

from exudyn_crawler.case import Drive, StepProfile
from exudyn_crawler.model.drive_point import DrivePoint
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.items import at_time, coordinate_marker, hold
from exudyn_crawler.model.shoes import ShoeBody


def add_drives(
    mbs: "exu.MainSystem", drive: Drive, fixed: int, shoe: ShoeBody, point: DrivePoint
) -> tuple[int, ...]:
    """All that moves the front shoe: the drive at its point and, where the case has one, the turn."""
    if point.is_frame:
        moved = _add_drive(mbs, drive, fixed, shoe.node)
    else:
        moved = _add_point_drive(mbs, drive, point, shoe)
    if drive.turn_rate is None:
        return (moved,)
    return moved, _add_turn(mbs, drive.turn_rate, shoe.node)


def add_holds(mbs: "exu.MainSystem", fixed: int, shoe: ShoeBody, point: DrivePoint) -> tuple[int, ...]:
    """What keeps the front shoe at rest in x, y and about z.

    Along x it acts where the drive will: its force, which the drive takes over, bends the shoe, and from
    another place the run would start with a jolt.
    """
    name = "hold of the front shoe"
    if point.is_frame:
        along = hold(mbs, fixed, shoe.node, 0, name)
    else:
        along = _hold_point(mbs, point, shoe, f"{name} (x)")
    return along, *(hold(mbs, fixed, shoe.node, axis, name) for axis in (1, 5))


def _add_drive(mbs: "exu.MainSystem", drive: Drive, fixed: int, node: int) -> int:
    """Prescribed travel of the front shoe's COM along x, as a constraint."""
    distance = at_time(drive.speed.integral)
    speed = at_time(drive.speed.value)

    def travel(_mbs, t, _item, _offset):
        return distance(t)

    def rate(_mbs, t, _item, _offset):
        return speed(t)

    return mbs.AddObject(
        items.ObjectConnectorCoordinate(
            name="drive",
            markerNumbers=[fixed, coordinate_marker(mbs, node, 0)],
            offset=1.0,  # Exudyn calls the offset functions only where the offset is not zero
            offsetUserFunction=travel,
            offsetUserFunction_t=rate,
            # on velocity level a halved step leaves no error in the acceleration
            velocityLevel=True,
        )
    )


def _add_point_drive(mbs: "exu.MainSystem", drive: Drive, point: DrivePoint, shoe: ShoeBody) -> int:
    """Prescribed velocity along x of a point of the front shoe, as a constraint.

    Like the drive of the COM it stands on velocity level.
    """
    speed = at_time(drive.speed.value)

    def residual(_mbs, t, _item, q, q_t, _velocity_level):
        values = np.array(q)
        return [point.gradient(values[3:6], values[6:]) @ np.array(q_t) - speed(t)]

    return _constrain_point(mbs, point, shoe, "drive", residual, velocity_level=True)


def _hold_point(mbs: "exu.MainSystem", point: DrivePoint, shoe: ShoeBody, name: str) -> int:
    """Keep a point of the front shoe where it is along x."""
    # the coordinates come with those of reference
    start = mbs.GetNode(shoe.node)["referenceCoordinates"][0] + point.place[0]

    def residual(_mbs, _t, _item, q, _q_t, _velocity_level):
        values = np.array(q)
        return [values[0] + point.arm(values[3:6], values[6:])[0] - start]

    return _constrain_point(mbs, point, shoe, name, residual, velocity_level=False)


def _constrain_point(
    mbs: "exu.MainSystem",
    point: DrivePoint,
    shoe: ShoeBody,
    name: str,
    residual: Callable[..., list[float]],
    velocity_level: bool,
) -> int:
    """Constraint on the motion of a point of the front shoe along x."""
    # the coordinates come in the order of the markers, none of the ground's
    nodes = [shoe.node, shoe.modal_node] if shoe.modal_node is not None else [_empty(mbs), shoe.node]

    def jacobian(_mbs, _t, _item, q, _q_t, _velocity_level):
        values = np.array(q)
        return point.gradient(values[3:6], values[6:])[None, :]

    return mbs.AddObject(
        items.ObjectConnectorCoordinateVector(
            name=name,
            markerNumbers=[mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=n)) for n in nodes],
            scalingMarker1=np.zeros((1, 6 if shoe.modal_node is None else point.rows.shape[1])),
            constraintUserFunction=residual,
            jacobianUserFunction=jacobian,
            velocityLevel=velocity_level,
        )
    )


def _empty(mbs: "exu.MainSystem") -> int:
    """Node without coordinates, where a connector needs another."""
    return mbs.AddNode(items.NodePointGround())


def _add_turn(mbs: "exu.MainSystem", turn_rate: StepProfile, node: int) -> int:
    """Prescribed angular velocity of the front shoe about its own z axis: a non-holonomic constraint.

    With the angles (a, b, c) about x, y, z it reads ``a' sin b + c' = rate(t)``.
    """
    rate = at_time(turn_rate.value)
    empty = mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=_empty(mbs)))
    marker = mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=node))

    def residual(_mbs, t, _item, q, q_t, _velocity_level):
        return [np.sin(q[4]) * q_t[3] + q_t[5] - rate(t)]

    def jacobian(_mbs, _t, _item, q, _q_t, _velocity_level):
        return np.array([[0.0, 0.0, 0.0, np.sin(q[4]), 0.0, 1.0]])

    return mbs.AddObject(
        items.ObjectConnectorCoordinateVector(
            name="turn",
            markerNumbers=[empty, marker],
            scalingMarker1=np.zeros((1, 6)),
            constraintUserFunction=residual,
            jacobianUserFunction=jacobian,
            velocityLevel=True,
        )
    )
