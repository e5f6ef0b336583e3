"""Motors that turn tumblers against their frame, and keep sliding idlers from spinning."""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import dot
from exudyn_crawler.ground.packed import Floats1, Ints2
from exudyn_crawler.model.bodies import Bodies, attitude_of
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.rows import ALONG_JACOBIAN, STIFFNESS, JointRows, Motion

SLOW = 10.0
"""Commanded speed over `Motors.lag` below which a motor lags by the same fraction of its speed."""
STEEP = 0.95
"""Torque over the greatest one up to which a motor's law is steep enough to be inverted."""
BRAKE = 1e-3
"""Lag of a motor that has to stand, over `Motors.lag`."""


class Motors(NamedTuple):
    """Motors, one row each; k of them.

    The multiplier of a motor is the negative torque on its tumbler about the tumbler's axis. It follows from
    the prescribed speed, or, if the torque is limited, from the lag behind that speed.
    """

    first: int  # row of the first one
    bodies: Ints2  # (k, 2): frame, and the tumbler that turns against it or the idler that does not
    limit: Floats1  # (k,): greatest torque, N m; infinite where the speed is kept
    lag: Floats1  # (k,): rad/s at which there is 0.7 of the greatest torque, see `droop`


@inner
def droop(lag: float, wanted: float) -> float:
    """Return the lag (rad/s) with 0.7 of the greatest torque at a commanded speed (rad/s); see `Motors`.

    It falls with a speed below `SLOW` times `lag`. A motor that has to stand holds as a brake does.
    """
    return lag * min(1.0, max(BRAKE, abs(wanted) / (SLOW * lag)))


@inner
def torque(limit: float, width: float, lag: float, held: float) -> tuple[float, float]:
    """Return the torque (N m) of a motor at a `lag` (rad/s) behind its speed, linearized, and its slope.

    The law ``limit lag / sqrt(lag^2 + width^2)`` is linearized where it has the torque `held` of the present
    iteration: from the lag alone a steep law would end far beyond. Near its limit it is so at the lag.
    """
    part = held / limit
    ratio = part / math.sqrt(1.0 - part * part) if abs(part) < STEEP else lag / width
    root = math.sqrt(1.0 + ratio * ratio)
    slope = limit / (width * root**3)
    return limit * ratio / root + slope * (lag - width * ratio), slope


@inner
def write_rows(motors: Motors, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows) -> None:
    """Write the rows of all motors; the Jacobian has the angles' axes projected on the tumbler's."""
    for k in range(motors.bodies.shape[0]):
        row = motors.first + k
        axis = attitude_of(bodies, motors.bodies[k, 1]).axes[1]
        speed = 0.0
        for side in range(2):
            b = motors.bodies[k, side]
            sign = 2.0 * side - 1.0
            attitude = attitude_of(bodies, b)
            rows.bodies[row, side] = b
            for c in range(3):
                by_angle = sign * dot(attitude.axes[c], axis)
                rows.jacobian[row, side, 3 + c] = by_angle
                speed += by_angle * motion.state[1, bodies.coordinate[b] + 3 + c]
        lag = motion.inputs.motors[k] - speed
        rows.relaxation[row] = 0.0
        rows.directed[row] = ALONG_JACOBIAN
        if motors.limit[k] < np.inf:
            width = droop(motors.lag[k], motion.inputs.motors[k])
            moment, slope = torque(motors.limit[k], width, lag, -motion.multipliers[row])
            rows.gap[row] = moment
            rows.scale[row] = 1.0
            rows.slope[row] = -motion.weights.velocity * slope
            rows.share[row] = 1.0
        else:
            level = STIFFNESS * motion.weights.level
            rows.gap[row] = -lag
            rows.scale[row] = level
            rows.slope[row] = level * (motion.weights.velocity if motion.weights.velocity != 0.0 else 1.0)
            rows.share[row] = 0.0
