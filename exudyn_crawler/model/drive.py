"""Drive of the front shoe, and what holds it at rest."""

import numpy as np

from exudyn_crawler.case import Drive, StepProfile
from exudyn_crawler.model.drive_point import DrivePoint
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.items import at_time, coordinate_marker
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
    # the coordinates come in the order of the markers, none of the ground's
    nodes = [shoe.node, shoe.modal_node] if shoe.modal_node is not None else [_empty(mbs), shoe.node]

    def residual(_mbs, t, _item, q, q_t, _velocity_level):
        values = np.array(q)
        return [point.gradient(values[3:6], values[6:]) @ np.array(q_t) - speed(t)]

    def jacobian(_mbs, _t, _item, q, _q_t, _velocity_level):
        values = np.array(q)
        return point.gradient(values[3:6], values[6:])[None, :]

    return mbs.AddObject(
        items.ObjectConnectorCoordinateVector(
            name="drive",
            markerNumbers=[mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=n)) for n in nodes],
            scalingMarker1=np.zeros((1, 6 if shoe.modal_node is None else point.rows.shape[1])),
            constraintUserFunction=residual,
            jacobianUserFunction=jacobian,
            velocityLevel=True,
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
