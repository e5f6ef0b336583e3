"""Friction of pins: a moment about a pin's axis that opposes the turning of its bodies.

The moment ``M = (mu r F + pi / 2 eta k abs(d)) w / hypot(w, w0) + k d`` depends on the rate w of the hinge,
its angle d from the unloaded one, and the radial force F of the pin, which are multipliers of its rows. Its
row is that of a law, so that the multiplier is the moment: the matrix has the exact derivatives of the law by
angle, rate and force, without a coupling of the shoes that would enlarge the fronts. The force is that of the
same iteration, not of the last step, so that a start, a halved step and a restart need no memory.

The first term is Coulomb friction of a pin in a bush, the second the loss of a rubber bush (Reid: it is
independent of the rate, and a cycle of amplitude a loses ``pi eta k a^2``), the third its stiffness.
"""

import math
from typing import NamedTuple

from exudyn_crawler.case.parameters.pin import PinLaw
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.frames import Vector, basis, dot
from exudyn_crawler.ground.packed import Ints1
from exudyn_crawler.model.bodies import Bodies, read_body
from exudyn_crawler.model.joints.pin import ROWS, Pins, link_ends, plane_axis
from exudyn_crawler.model.markers import NOTHING, Markers, axis_of, direction
from exudyn_crawler.model.rows import ALONG_JACOBIAN, JointRows, Motion


class Frictions(NamedTuple):
    """Pins with friction, one row each; k of them."""

    first: int  # row of the first one
    pins: Ints1  # (k,): numbers of the pins
    law: PinLaw


@kernel
def pin_moment(
    law: PinLaw, angle: float, rate: float, force: float, resists: float
) -> tuple[float, float, float, float]:
    """Return the moment (N m) against a hinge's turning, and its derivatives by angle, rate and force.

    `angle` (rad), `rate` (rad/s) and radial `force` (N) are those of the hinge; `resists` is the part of the
    friction that acts, 0 in a search for rest. The derivatives are in N m/rad, N m s/rad and m.
    """
    twist = angle - law.unloaded
    root = math.sqrt(rate * rate + law.fading * law.fading)
    sense = resists * rate / root
    by_rate = resists * law.fading * law.fading / root**3
    rubber = 0.5 * math.pi * law.loss * law.stiffness
    friction = law.lever * force + rubber * abs(twist)
    by_angle = law.stiffness + math.copysign(rubber, twist) * sense
    return friction * sense + law.stiffness * twist, by_angle, friction * by_rate, law.lever * sense


@inner
def _load_axis(pins: Pins, axes: tuple[Vector, Vector, Vector], r: int) -> Vector:
    """Return the axis of the multiplier r of a pin's force, global."""
    return axes[r] if pins.in_plane else basis(r)


@inner
def write_rows(
    frictions: Frictions, pins: Pins, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows
) -> None:
    """Write the rows of all pins with friction."""
    row = rows.scratch[0]
    for k in range(frictions.pins.shape[0]):
        p = frictions.pins[k]
        r = frictions.first + k
        load = pins.first + ROWS * p
        rear = pins.markers[p, 0]
        front = pins.markers[p, 1]
        link = link_ends((rear, front), bodies, markers, motion.state, rows.scratch)
        at_a, at_b = link.attitudes
        behind, ahead = link.ends
        across = axis_of(behind, at_a, 1)
        direction(markers, rear, behind, at_a, NOTHING, across, -1.0, rows.jacobian[r, 0])
        direction(markers, front, ahead, at_b, NOTHING, across, 1.0, rows.jacobian[r, 1])
        rate = 0.0
        for side in range(2):
            body = link.bodies[side]
            read_body(bodies, body, motion.state[1], row)
            for c in range(row.shape[0] if bodies.modal[body] >= 0 else 6):
                rate += rows.jacobian[r, side, c] * row[c]
            rows.bodies[r, side] = body
        x = axis_of(ahead, at_b, 0)
        angle = math.atan2(-dot(x, axis_of(behind, at_a, 2)), dot(x, axis_of(behind, at_a, 0)))
        axes = plane_axis(at_a, 0), plane_axis(at_a, 1), plane_axis(at_a, 2)
        square = axial = 0.0
        for c in range(3):
            part = motion.multipliers[load + c]
            square += part * part
            axial += part * dot(_load_axis(pins, axes, c), across)
        force = math.sqrt(max(0.0, square - axial * axial))
        moment, by_angle, by_rate, by_force = pin_moment(
            frictions.law, angle, rate, force, motion.inputs.resists
        )
        rows.gap[r] = -moment
        rows.scale[r] = rows.share[r] = 1.0
        rows.slope[r] = -(motion.weights.position * by_angle + motion.weights.velocity * by_rate)
        rows.relaxation[r] = 0.0
        rows.directed[r] = ALONG_JACOBIAN
        rows.loaded[k, 0] = r
        rows.loaded[k, 1] = load
        for c in range(3):
            radial = motion.multipliers[load + c] - axial * dot(_load_axis(pins, axes, c), across)
            rows.by_load[k, c] = -by_force * radial / force if force > 0.0 else 0.0
