"""Pull of a side frame's drive on its chain, which keeps the frame's speed.

It acts forward on the frame and backward on the chain, at the pins of the two links next to the tumbler.
Their shares change linearly as the tumbler moves from one to the next. The pull follows from the speed of the
frame alone, so that the direction of the force is not the gradient of the constraint (a servo constraint).
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import along, cross, turned
from exudyn_crawler.ground.packed import Ints1
from exudyn_crawler.model.bodies import Bodies, attitude_of, frame_of, read_body
from exudyn_crawler.model.markers import NOTHING, Markers, direction, end_of
from exudyn_crawler.model.rows import JointRows, Motion

FORWARD = (1.0, 0.0, 0.0)


class Pull(NamedTuple):
    """Points of a chain at which a frame pulls; no markers without a pull."""

    row: int  # of the frame's speed, whose multiplier is the pull
    frame: int  # body that pulls
    tumbler: float  # x in the frame where the chain is pulled, m
    pitch: float  # of the chain, m
    ahead: float  # x of the front pins in a shoe, m
    markers: Ints1  # (shoes,): middle of every shoe's front pins


@inner
def write_rows(pull: Pull, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows) -> None:
    """Direct the multiplier of the frame's speed, whose row is written, at the frame and two shoes."""
    if pull.markers.shape[0] == 0:
        return
    rows.directed[pull.row] = 0
    acted_on = rows.acted_on[0]
    directions = rows.directions[0]
    attitude = attitude_of(bodies, pull.frame)
    frame = frame_of(bodies, pull.frame, motion.state, attitude)
    first = bodies.reference[0, 0] + motion.state[0, bodies.coordinate[0]]
    behind = (frame.r[0] + pull.tumbler - first - pull.ahead) / pull.pitch
    link = min(max(math.floor(behind), 0), pull.markers.shape[0] - 3)
    part = min(max(behind - link, 0.0), 1.0)
    acted_on[0] = pull.frame
    for c in range(directions.shape[1]):
        directions[0, c] = FORWARD[c] if c < 3 else 0.0
    for k in range(2):
        shoe = link + k
        marker = pull.markers[link + k]
        row = directions[1 + k]
        share = 1.0 - part if k == 0 else part
        read_body(bodies, shoe, motion.state[0], row)
        shoe_at = attitude_of(bodies, shoe)
        end = end_of(markers, marker, shoe_at, row)
        origin = frame_of(bodies, shoe, motion.state, shoe_at).r
        arm = along(along(origin, 1.0, end.lever), -1.0, frame.r)
        turning = turned(attitude.axes, cross(arm, FORWARD))
        for c in range(3):
            directions[0, 3 + c] += share * turning[c]
        direction(markers, marker, end, shoe_at, FORWARD, NOTHING, -share, row)
        acted_on[1 + k] = shoe
