"""Pins with play in their bores: contact forces in place of constraints.

Each link has two contacts on the axis of its front body, the same distance to either side of its marker:
those of both pins of a link, or those of one pin at both ends of its bore. A contact presses where the
axis of the pin has left the circle of its clearance, along the radius. Faces stop the link along the axis
beyond the axial play. There is no friction.
"""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import Vector, along, basis, cross, dot, turned
from exudyn_crawler.ground.laws import Impact, step
from exudyn_crawler.ground.packed import FloatArray, Floats1, Ints2
from exudyn_crawler.ground.rotations import Attitude
from exudyn_crawler.model.bodies import Bodies, attitude_of, read_body
from exudyn_crawler.model.joints.pin import ROWS, write_turned
from exudyn_crawler.model.markers import NOTHING, End, Markers, axis_of, direction, end_of
from exudyn_crawler.model.rows import JointRows, Motion


class Plays(NamedTuple):
    """Links with play; p of them, each with the `ROWS` rows of a pin.

    A law gives the multipliers. They are the force on the rear body along the front body's axes without its
    pitch, and the moments about the axes across it. The force acts at the rear marker on both bodies, so that
    forces and moments are in balance within the play, too.
    """

    first: int  # row of the first one
    directed: int  # first row of directions
    turned: int  # first place among the rotating pairs of bodies
    markers: Ints2  # (p, 2): of the rear and of the front body
    half: Floats1  # (p,): distance of both contacts from the marker, m
    radial: float  # radius of a bore less that of its pin, m
    axial: float  # way to either side until the faces meet, m
    law: Impact  # of a contact, and of the faces


@inner
def contact_slopes(law: Impact, depth: float, rate: float) -> tuple[float, float, float]:
    """Return the force (N) of a contact, and its derivatives by depth (N/m) and by its rate (N s/m).

    The stiffness rises linearly and the damping with STEP to their full values at `law.damping_depth`, so
    that neither jumps where bodies meet. The force is never negative.
    """
    if depth <= 0.0:
        return 0.0, 0.0, 0.0
    edge = law.damping_depth
    part = min(depth / edge, 1.0)
    faded = step(depth, 0.0, 0.0, edge, 1.0)
    force = law.stiffness * (depth - (1.0 - 0.5 * part) * min(depth, edge)) + law.damping * rate * faded
    if force <= 0.0:
        return 0.0, 0.0, 0.0
    by_depth = law.stiffness * part + law.damping * rate * 6.0 * part * (1.0 - part) / edge
    return force, by_depth, law.damping * faded


@inner
def _level_axes(end: End, attitude: Attitude) -> tuple[Vector, Vector, Vector]:
    """Return an end's axes without the pitch of its body, global."""
    x, y, z = axis_of(end, attitude, 0), axis_of(end, attitude, 1), axis_of(end, attitude, 2)
    ahead = turned(attitude.R, basis(0))
    c = dot(ahead, attitude.axes[0])
    s = -dot(ahead, cross(attitude.axes[0], attitude.axes[1]))
    return along(along(NOTHING, c, x), s, z), y, along(along(NOTHING, c, z), -s, x)


@inner
def _add_contact(
    plays: Plays,
    arm: float,
    motion: Motion,
    gaps: FloatArray,
    rates: FloatArray,
    forces: FloatArray,
    tangent: FloatArray,
) -> None:
    """Add the forces of the contact at an `arm` (m) along the axis, and their weighted derivatives."""
    x = gaps[0] - arm * gaps[3]
    z = gaps[2] - arm * gaps[4]
    offset = math.sqrt(x * x + z * z)
    if offset <= plays.radial:
        return
    x_t = rates[0] - arm * rates[3]
    z_t = rates[2] - arm * rates[4]
    nx, nz = x / offset, z / offset
    force, stiffness, damping = contact_slopes(plays.law, offset - plays.radial, nx * x_t + nz * z_t)
    weights = motion.weights
    outward = weights.position * stiffness + weights.velocity * damping
    around = weights.position * force / offset
    # the normal turns with the pin's way around the bore
    mixed = weights.position * damping * (nx * z_t - nz * x_t) / offset
    xx = outward * nx * nx + around * nz * nz - mixed * nx * nz
    xz = (outward - around) * nx * nz + mixed * nx * nx
    zx = (outward - around) * nx * nz - mixed * nz * nz
    zz = outward * nz * nz + around * nx * nx + mixed * nx * nz
    for k in range(2):
        a = 1.0 if k == 0 else -arm
        forces[3 * k] += a * force * nx
        forces[2 + 2 * k] += a * force * nz
        for m in range(2):
            b = a if m == 0 else -arm * a
            tangent[3 * k, 3 * m] += b * xx
            tangent[3 * k, 2 + 2 * m] += b * xz
            tangent[2 + 2 * k, 3 * m] += b * zx
            tangent[2 + 2 * k, 2 + 2 * m] += b * zz


@inner
def _add_faces(
    plays: Plays, motion: Motion, gap: float, rate: float, forces: FloatArray, tangent: FloatArray
) -> None:
    """Add the force of the end faces, and its weighted derivative."""
    sign = 1.0 if gap > 0.0 else -1.0
    force, stiffness, damping = contact_slopes(plays.law, sign * gap - plays.axial, sign * rate)
    forces[1] += sign * force
    tangent[1, 1] += motion.weights.position * stiffness + motion.weights.velocity * damping


@inner
def _write_gaps(
    markers: Markers,
    pair: tuple[int, int],
    attitudes: tuple[Attitude, Attitude],
    ends: tuple[End, End],
    between: Vector,
    gaps: FloatArray,
    directions: FloatArray,
) -> None:
    """Write the gaps of a link and their derivatives by the coordinates of both bodies.

    `between` is the way from the rear to the front marker.
    """
    axes = _level_axes(ends[1], attitudes[1])
    across = axis_of(ends[0], attitudes[0], 1)
    for r in range(ROWS):
        axis = axes[r] if r < 3 else axes[0 if r == 3 else 2]
        force = axis if r < 3 else NOTHING
        gaps[r] = dot(between if r < 3 else across, axis)
        behind = NOTHING if r < 3 else cross(axis, across)
        ahead = cross(axis, between) if r < 3 else behind
        direction(markers, pair[0], ends[0], attitudes[0], force, behind, -1.0, directions[r, 0])
        direction(markers, pair[1], ends[1], attitudes[1], force, ahead, 1.0, directions[r, 1])
    # level axes do not pitch with the body
    directions[0, 1, 4] += gaps[2]
    directions[2, 1, 4] -= gaps[0]
    directions[3, 1, 4] += gaps[4]
    directions[4, 1, 4] -= gaps[3]


@inner(allocates=True)
def write_rows(plays: Plays, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows) -> None:
    """Write the rows of all links with play."""
    gaps, rates, forces = np.zeros(ROWS), np.zeros(ROWS), np.zeros(ROWS)
    tangent = np.zeros((ROWS, ROWS))
    behind_row = rows.scratch[0]
    ahead_row = rows.scratch[1]
    for p in range(plays.markers.shape[0]):
        rear = plays.markers[p, 0]
        front = plays.markers[p, 1]
        a, b = markers.body[rear], markers.body[front]
        read_body(bodies, a, motion.state[0], behind_row)
        read_body(bodies, b, motion.state[0], ahead_row)
        at_a = attitude_of(bodies, a)
        at_b = attitude_of(bodies, b)
        reference = bodies.reference
        apart = (
            reference[b, 0] + ahead_row[0] - reference[a, 0] - behind_row[0],
            reference[b, 1] + ahead_row[1] - reference[a, 1] - behind_row[1],
            reference[b, 2] + ahead_row[2] - reference[a, 2] - behind_row[2],
        )
        behind = end_of(markers, rear, at_a, behind_row)
        ahead = end_of(markers, front, at_b, ahead_row)
        between = along(along(apart, 1.0, ahead.lever), -1.0, behind.lever)
        d = plays.directed + ROWS * p
        directions = rows.directions[d : d + ROWS]
        _write_gaps(markers, (rear, front), (at_a, at_b), (behind, ahead), between, gaps, directions)
        read_body(bodies, a, motion.state[1], behind_row)
        read_body(bodies, b, motion.state[1], ahead_row)
        widths = 6 + markers.modes[rear], 6 + markers.modes[front]
        forces.fill(0.0)
        tangent.fill(0.0)
        for r in range(ROWS):
            rates[r] = 0.0
            for c in range(widths[0]):
                rates[r] += directions[r, 0, c] * behind_row[c]
            for c in range(widths[1]):
                rates[r] += directions[r, 1, c] * ahead_row[c]
        _add_contact(plays, -plays.half[p], motion, gaps, rates, forces, tangent)
        _add_contact(plays, plays.half[p], motion, gaps, rates, forces, tangent)
        _add_faces(plays, motion, gaps[1], rates[1], forces, tangent)
        first = plays.first + ROWS * p
        for r in range(ROWS):
            row = first + r
            rows.bodies[row, 0] = a
            rows.bodies[row, 1] = b
            rows.acted_on[d + r, 0] = a
            rows.acted_on[d + r, 1] = b
            rows.directed[row] = d + r
            rows.gap[row] = -forces[r]
            rows.scale[row] = 1.0
            rows.slope[row] = 1.0
            rows.share[row] = 1.0
            rows.relaxation[row] = 0.0
            rows.jacobian[row].fill(0.0)
            for k in range(ROWS):
                if tangent[r, k] != 0.0:
                    for side in range(2):
                        for c in range(widths[side]):
                            rows.jacobian[row, side, c] -= tangent[r, k] * directions[k, side, c]
        if motion.weights.position != 0.0:
            force = NOTHING
            axes = _level_axes(ahead, at_b)
            for r in range(3):
                force = along(force, motion.multipliers[first + r], axes[r])
            write_turned(plays.turned + p, (rear, front), force, bodies, markers, motion.state, rows)
