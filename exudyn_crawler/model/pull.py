"""Pull of a frame's drive on the chain: an action between frame and shoes that keeps the frame's speed.

It acts forward on the frame and backward on the chain, at the pins of the two links next to the tumbler, in
shares that change evenly as the tumbler goes from one to the next. How large it is follows from the speed of
the frame alone, so that the direction of the force is not the gradient of what it keeps (a servo constraint).
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.frames import along, cross, turned
from exudyn_crawler.ground.rotations import FloatArray
from exudyn_crawler.ground.rows import IntArray
from exudyn_crawler.model.bodies import Bodies, attitude_of, frame_of, read_body
from exudyn_crawler.model.elimination import solving_within
from exudyn_crawler.model.joints import Markers, direction, end_of

PULLED = 3
"""Bodies that the pull acts on: the frame and two shoes."""


class Pull(NamedTuple):
    """Where a frame pulls its chain.

    Attributes
    ----------
    frame : int
        Body that pulls.
    tumbler : float
        x in the frame where the chain is pulled, m.
    pitch : float
        Of the chain, m.
    ahead : float
        x of the front pins in a shoe, m.
    markers : array (shoes,)
        Middle of every shoe's front pins.
    """

    frame: int
    tumbler: float
    pitch: float
    ahead: float
    markers: IntArray


@solving_within
def write_pull(
    pull: Pull, bodies: Bodies, markers: Markers, state: FloatArray, pulled: IntArray, directions: FloatArray
) -> None:
    """Write the bodies (PULLED,) and the generalized forces (PULLED, 6 + m) of a unit pull on each."""
    at = attitude_of(bodies, pull.frame, state[0])
    frame = frame_of(bodies, pull.frame, state, at)
    first = bodies.reference[0, 0] + state[0, bodies.coordinate[0]]
    behind = (frame.r[0] + pull.tumbler - first - pull.ahead) / pull.pitch
    link = min(max(math.floor(behind), 0), pull.markers.shape[0] - 3)
    part = min(max(behind - link, 0.0), 1.0)
    force = (1.0, 0.0, 0.0)
    pulled[0] = pull.frame
    for c in range(directions.shape[1]):
        directions[0, c] = force[c] if c < 3 else 0.0
    for k in range(2):
        s, marker, row = link + k, pull.markers[link + k], directions[1 + k]
        share = 1.0 - part if k == 0 else part
        read_body(bodies, s, state[0], row)
        shoe_at = attitude_of(bodies, s, state[0])
        end, origin = end_of(markers, marker, shoe_at, row), frame_of(bodies, s, state, shoe_at).r
        moment = cross(along(along(origin, 1.0, end.lever), -1.0, frame.r), force)
        turning = turned(at.axes, moment)
        for c in range(3):
            directions[0, 3 + c] += share * turning[c]
        direction(markers, marker, end, shoe_at, force, (0.0, 0.0, 0.0), -share, row)
        pulled[1 + k] = s
