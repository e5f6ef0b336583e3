"""Drives: prescribed speeds of a case, of a marker along x and of a body about its own axis z."""

from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import turned, upward
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.bodies import Bodies, attitude_of, read_body
from exudyn_crawler.model.markers import NOTHING, Markers, direction, end_of
from exudyn_crawler.model.rows import ALONG_JACOBIAN, STIFFNESS, JointRows, Motion


class Speeds(NamedTuple):
    """Marker with a prescribed velocity along x, and body with a prescribed rotation about its own axis z.

    Each has a row; the multiplier of an inactive row is zero.
    """

    first: int  # row of the marker's speed; that of turning is next
    marker: int
    turning: int  # body


@inner
def write_speed(row: int, speed: float, acts: bool, body: int, weights: Weights, rows: JointRows) -> None:
    """Complete a row on a body's speed, after its Jacobian is written and the coordinates are read.

    `rows.scratch[1]` are the rates of the body's coordinates and modes, `speed` is the prescribed speed.
    """
    rate = -speed
    for c in range(rows.scratch.shape[1]):
        rate += rows.jacobian[row, 0, c] * rows.scratch[1, c]
    level = STIFFNESS * weights.level
    rows.gap[row] = rate
    rows.bodies[row, 0] = body if acts else -1
    rows.bodies[row, 1] = -1
    rows.scale[row] = level if acts else 0.0
    # a constraint on velocity answers a change of the coordinates by its rate
    rows.slope[row] = level * (weights.velocity if weights.velocity != 0.0 else 1.0)
    rows.share[row] = 0.0 if acts else 1.0
    rows.relaxation[row] = 0.0
    rows.directed[row] = ALONG_JACOBIAN


@inner
def write_rows(drive: Speeds, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows) -> None:
    """Write the rows of both speeds."""
    for k in range(2):
        row = drive.first + k
        body = markers.body[drive.marker] if k == 0 else drive.turning
        read_body(bodies, body, motion.state[0], rows.scratch[0])
        read_body(bodies, body, motion.state[1], rows.scratch[1])
        attitude = attitude_of(bodies, body)
        jacobian = rows.jacobian[row, 0]
        if k == 0:
            end = end_of(markers, drive.marker, attitude, rows.scratch[0])
            direction(markers, drive.marker, end, attitude, (1.0, 0.0, 0.0), NOTHING, 1.0, jacobian)
        else:
            about = turned(attitude.axes, upward(attitude.R))
            for c in range(3):
                jacobian[3 + c] = about[c]
        write_speed(row, motion.inputs.speeds[k], motion.inputs.active[k] > 0.0, body, motion.weights, rows)
