"""Springs, dampers and bump stops of arms that carry road wheels: moments between arm and side frame.

An arm turns about a pivot of its frame, whose bearing is a pin like those of the chain. Its upward rotation
counts from the nominal position of its wheel in the frame. There the spring, mostly a torsion bar, presses
the wheel down with a given moment.
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import along, basis, dot, turned, turned_back
from exudyn_crawler.ground.packed import FloatArray, Floats1, Ints2
from exudyn_crawler.ground.rows import ForceRows, Weights
from exudyn_crawler.model.bodies import Bodies, attitude_of, frame_of


class Arms(NamedTuple):
    """Sprung arms, k of them."""

    bodies: Ints2  # (k, 2): arm and frame
    up: Floats1  # (k,): 1 where turning about y lifts the wheel, which is behind its pivot, else -1
    torque: Floats1  # (k,): N m, moment of the spring at the wheel's nominal position, presses the wheel down
    stiffness: Floats1  # (k,): N m/rad
    damping: Floats1  # (k,): N m s/rad
    stop: Floats1  # (k,): rad up, at which the bump stop begins to act; infinite for none
    stop_stiffness: Floats1  # (k,): N m/rad of it, beside that of the spring


class ArmWorkspace(NamedTuple):
    """Springs of arms at a state."""

    rows: ForceRows  # moment on the arm about the frame's y, N m

    @classmethod
    def allocate(cls, arms: int, modes: int) -> "ArmWorkspace":
        """Return a workspace for `arms` arms."""
        return cls(ForceRows.allocate(arms, 1, modes))


@inner
def write_rows(arms: Arms, bodies: Bodies, state: FloatArray, weights: Weights, work: ArmWorkspace) -> None:
    """Write the rows of all arms."""
    rows = work.rows
    count = arms.torque.shape[0]
    for k in range(count):
        arm = arms.bodies[k, 0]
        frame = arms.bodies[k, 1]
        at_arm = attitude_of(bodies, arm)
        at_frame = attitude_of(bodies, frame)
        axis = turned(at_frame.R, basis(1))
        ahead = turned_back(at_frame.R, turned(at_arm.R, basis(0)))
        of_arm = frame_of(bodies, arm, state, at_arm)
        of_frame = frame_of(bodies, frame, state, at_frame)
        up = arms.up[k]
        angle = up * math.atan2(-ahead[2], ahead[0])
        rate = up * dot(along(of_arm.omega, -1.0, of_frame.omega), axis)
        torque = arms.torque[k] + arms.stiffness[k] * angle + arms.damping[k] * rate
        stiffness = arms.stiffness[k]
        if angle > arms.stop[k]:
            torque += arms.stop_stiffness[k] * (angle - arms.stop[k])
            stiffness += arms.stop_stiffness[k]
        rows.bodies[k, 0] = arm
        rows.bodies[k, 1] = frame
        rows.unit[k] = -1
        rows.wrench[k, 0] = -up * torque
        rows.tangent[k, 0, 0] = weights.position * stiffness + weights.velocity * arms.damping[k]
        rows.jacobian[k].fill(0.0)
        for c in range(3):
            rows.jacobian[k, 0, 0, 3 + c] = dot(at_arm.axes[c], axis)
            rows.jacobian[k, 1, 0, 3 + c] = -dot(at_frame.axes[c], axis)
    rows.acting[0] = count
