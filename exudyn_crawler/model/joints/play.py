"""Pins with play in their bores: contact forces in place of constraints.

Each link has two contacts on the axis of its front body, the same distance to either side of its marker:
those of both pins of a link, or those of one pin at both ends of its bore. A contact presses where the
axis of the pin has left the circle of its clearance, along the radius. Faces stop the link along the axis
beyond the axial play. There is no friction.

A row is the law of a contact, linearized not where the bodies are but where the law has about their distance
and the present multiplier: at the distance u* with ``metric u* + force(u*) = metric u + multiplier``. At the
solution both are the same. On the way the multiplier is close to the force long before the distance is close
enough for a stiff law, so that Newton's method finds edges and directions of contacts within two iterations
(the proximal point of augmented Lagrangians: Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991).
"""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import Vector, along, basis, cross, dot, turned
from exudyn_crawler.ground.laws import Impact, step
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Ints2
from exudyn_crawler.ground.rotations import Attitude
from exudyn_crawler.model.bodies import Bodies, read_body
from exudyn_crawler.model.joints.pin import ROWS, LinkEnds, link_ends, write_turned
from exudyn_crawler.model.markers import NOTHING, UNTURNED, End, Markers, axis_of, direction
from exudyn_crawler.model.rows import JointRows, Motion

METRIC = 0.3
"""Metric of a chain, see above, in masses of a shoe over the square of a time step.

From this value to ten times of it, iterations change by -1 % for shoes of 59 kg in bores of 5e9 N/m, by -12
and -21 % for shoes of 4.7 t; a seventh of it takes 14 and 18 % more for these.
"""
ROUNDING = 1e-12
"""Relative error of a found depth."""
BISECTIONS = 60
"""Greatest number of trials for a depth; mostly 3 to 6."""


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
    metric: float  # N/m, weight of the distance against the force, see above: inertia of a shoe in a step


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
def contact_energy(law: Impact, depth: float) -> float:
    """Return the energy (J) in a contact at a depth (m), zero without contact."""
    if depth <= 0.0:
        return 0.0
    edge = law.damping_depth
    within = min(depth, edge)
    beyond = depth - within
    return law.stiffness * (within**3 / (6.0 * edge) + 0.5 * beyond * (beyond + edge))


@inner
def _level_axes(end: End, attitude: Attitude) -> tuple[Vector, Vector, Vector]:
    """Return an end's axes without the pitch of its body, global."""
    x, y, z = axis_of(end, attitude, 0), axis_of(end, attitude, 1), axis_of(end, attitude, 2)
    ahead = turned(attitude.R, basis(0))
    c = dot(ahead, attitude.axes[0])
    s = -dot(ahead, cross(attitude.axes[0], attitude.axes[1]))
    return along(along(NOTHING, c, x), s, z), y, along(along(NOTHING, c, z), -s, x)


@inner
def _depth(law: Impact, metric: float, pull: float, rate: float) -> float:
    """Return the depth (m) at which ``metric * depth`` and the force at a rate (m/s) add to a `pull` (N).

    The force never falls with the depth, so that there is one such depth.
    """
    low, high = 0.0, pull / metric
    depth = min(high, pull / (metric + law.stiffness) + 0.5 * law.damping_depth)
    for _ in range(BISECTIONS):
        force, stiffness, _ = contact_slopes(law, depth, rate)
        excess = metric * depth + force - pull
        if abs(excess) <= ROUNDING * pull:
            break
        if excess > 0.0:
            high = depth
        else:
            low = depth
        depth -= excess / (metric + stiffness)
        if depth <= low or depth >= high:
            depth = 0.5 * (low + high)
    return depth


@inner
def _add_contact(
    plays: Plays,
    arm: float,
    motion: Motion,
    link: tuple[FloatArray, ...],
    forces: FloatArray,
    tangent: FloatArray,
) -> None:
    """Add the forces of the contact at an `arm` (m) along the axis, and their weighted derivatives.

    `link` holds gaps, rates and multipliers of the link's rows.
    """
    gaps, rates, loads = link
    x = gaps[0] - arm * gaps[3]
    z = gaps[2] - arm * gaps[4]
    # this contact's part of the multipliers, which are the sum of both and their moments
    pull_x = plays.metric * x + 0.5 * (loads[0] - loads[3] / arm)
    pull_z = plays.metric * z + 0.5 * (loads[2] - loads[4] / arm)
    pull = math.sqrt(pull_x * pull_x + pull_z * pull_z)
    beyond = pull - plays.metric * plays.radial
    if beyond <= 0.0:
        return
    x_t = rates[0] - arm * rates[3]
    z_t = rates[2] - arm * rates[4]
    nx, nz = pull_x / pull, pull_z / pull
    rate = nx * x_t + nz * z_t
    depth = _depth(plays.law, plays.metric, beyond, rate)
    force, stiffness, damping = contact_slopes(plays.law, depth, rate)
    if force <= 0.0:
        return
    offset = plays.radial + depth
    around = force / offset
    # the normal turns with the pin's way around the bore
    mixed = damping * (nx * z_t - nz * x_t) / offset
    xx = stiffness * nx * nx + around * nz * nz - mixed * nx * nz
    xz = (stiffness - around) * nx * nz + mixed * nx * nx
    zx = (stiffness - around) * nx * nz - mixed * nz * nz
    zz = stiffness * nz * nz + around * nx * nx + mixed * nx * nz
    to_x, to_z = x - offset * nx, z - offset * nz
    force_x = force * nx + xx * to_x + xz * to_z
    force_z = force * nz + zx * to_x + zz * to_z
    weight, damped = motion.weights.position, motion.weights.velocity * damping
    xx = weight * xx + damped * nx * nx
    xz = weight * xz + damped * nx * nz
    zx = weight * zx + damped * nx * nz
    zz = weight * zz + damped * nz * nz
    for k in range(2):
        a = 1.0 if k == 0 else -arm
        forces[3 * k] += a * force_x
        forces[2 + 2 * k] += a * force_z
        for m in range(2):
            b = a if m == 0 else -arm * a
            tangent[3 * k, 3 * m] += b * xx
            tangent[3 * k, 2 + 2 * m] += b * xz
            tangent[2 + 2 * k, 3 * m] += b * zx
            tangent[2 + 2 * k, 2 + 2 * m] += b * zz


@inner
def _add_faces(
    plays: Plays,
    motion: Motion,
    link: tuple[FloatArray, FloatArray, FloatArray],
    forces: FloatArray,
    tangent: FloatArray,
) -> None:
    """Add the force of the end faces, and its weighted derivative; for `link` see `_add_contact`."""
    gaps, rates, loads = link
    pull = plays.metric * gaps[1] + loads[1]
    sign = 1.0 if pull > 0.0 else -1.0
    beyond = sign * pull - plays.metric * plays.axial
    if beyond <= 0.0:
        return
    rate = sign * rates[1]
    depth = _depth(plays.law, plays.metric, beyond, rate)
    force, stiffness, damping = contact_slopes(plays.law, depth, rate)
    if force <= 0.0:
        return
    forces[1] += sign * force + stiffness * (gaps[1] - sign * (plays.axial + depth))
    tangent[1, 1] += motion.weights.position * stiffness + motion.weights.velocity * damping


@inner
def _write_gaps(
    markers: Markers,
    pair: tuple[int, int],
    link: LinkEnds,
    gaps: FloatArray,
    directions: FloatArray,
) -> None:
    """Write the gaps of a link and their derivatives by the coordinates of both bodies."""
    attitudes, ends, between = link.attitudes, link.ends, link.between
    axes = _axes_of_rows(link)
    across = axis_of(ends[0], attitudes[0], 1)
    for r in range(ROWS):
        axis = axes[r]
        force = axis if r < 3 else NOTHING
        moment = NOTHING if r < 3 else cross(axis, across)
        gaps[r] = dot(between if r < 3 else across, axis)
        direction(markers, pair[0], ends[0], attitudes[0], force, moment, -1.0, directions[r, 0])
        direction(markers, pair[1], ends[1], attitudes[1], force, moment, 1.0, directions[r, 1])
        if r < 3:
            # these axes turn with the body, and do not bend with its end
            swept = cross(axis, between)
            for c in range(3):
                directions[r, 1, 3 + c] += dot(attitudes[1].axes[c], swept)
    # level axes do not pitch with the body
    directions[0, 1, 4] += gaps[2]
    directions[2, 1, 4] -= gaps[0]
    directions[3, 1, 4] += gaps[4]
    directions[4, 1, 4] -= gaps[3]


@inner
def _axes_of_rows(link: LinkEnds) -> tuple[Vector, Vector, Vector, Vector, Vector]:
    """Return the axis of each row without the front body's pitch, global.

    Distances are along the axes of the body's frame, angles of the pin are about those of its bent end.
    """
    end, attitude = link.ends[1], link.attitudes[1]
    x, y, z = _level_axes(End(end.lever, NOTHING, UNTURNED), attitude)
    bent_x, _, bent_z = _level_axes(end, attitude)
    return x, y, z, bent_x, bent_z


@inner(allocates=True)
def stored_energy(
    plays: Plays, bodies: Bodies, markers: Markers, state: FloatArray, scratch: Floats2
) -> float:
    """Return the energy (J) in the contacts of all links with play; `scratch` is that of `JointRows`."""
    energy = 0.0
    gaps = np.zeros(ROWS)
    for p in range(plays.markers.shape[0]):
        link = link_ends((plays.markers[p, 0], plays.markers[p, 1]), bodies, markers, state, scratch)
        axes = _axes_of_rows(link)
        across = axis_of(link.ends[0], link.attitudes[0], 1)
        for r in range(ROWS):
            gaps[r] = dot(link.between if r < 3 else across, axes[r])
        for side in range(2):
            arm = (2.0 * side - 1.0) * plays.half[p]
            offset = math.hypot(gaps[0] - arm * gaps[3], gaps[2] - arm * gaps[4])
            energy += contact_energy(plays.law, offset - plays.radial)
        energy += contact_energy(plays.law, abs(gaps[1]) - plays.axial)
    return energy


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
        link = link_ends((rear, front), bodies, markers, motion.state, rows.scratch)
        a, b = link.bodies
        d = plays.directed + ROWS * p
        directions = rows.directions[d : d + ROWS]
        _write_gaps(markers, (rear, front), link, gaps, directions)
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
        first = plays.first + ROWS * p
        of_link = gaps, rates, motion.multipliers[first : first + ROWS]
        _add_contact(plays, -plays.half[p], motion, of_link, forces, tangent)
        _add_contact(plays, plays.half[p], motion, of_link, forces, tangent)
        _add_faces(plays, motion, of_link, forces, tangent)
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
            axes = _axes_of_rows(link)
            for r in range(3):
                force = along(force, motion.multipliers[first + r], axes[r])
            write_turned(plays.turned + p, (rear, front), force, bodies, markers, motion.state, rows)
