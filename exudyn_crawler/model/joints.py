"""Joints: gaps of constraints and their Jacobians, a function a kind of joint.

A constraint is a force and a moment on a body, or opposite ones on two. Its row of the Jacobian, over the
coordinates of a body, turns their rates into the rate of the gap, and its multiplier into generalized forces.

A frame's drive pulls its chain by an action between frame and shoes that keeps the frame's speed. It acts
forward on the frame and backward on the chain, at the pins of the two links next to the tumbler, in shares
that change evenly as the tumbler goes from one to the next. How large it is follows from the speed of the
frame alone, so that the direction of the force is not the gradient of what it keeps (a servo constraint).
"""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import Vector, along, basis, cross, dot, norm, turned, turned_back, upward
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Floats3, IntArray, Ints1, Ints2
from exudyn_crawler.ground.rotations import Attitude
from exudyn_crawler.model.bodies import Bodies, attitude_of, frame_of, moved, read_body

ROWS = 5
"""Equations of a pin: its place, and its axis y across the axes x and z of the shoe in front."""

SMALL = 1e-3
"""rad, rotation below which sine and cosine are taken as series."""

UNTURNED = (1.0, 0.5, 1.0 / 6.0)
"""`_factors` of no rotation."""


class Markers(NamedTuple):
    """Points of bodies at which joints, loads and drives act; k of them."""

    body: Ints1  # (k,): number of the body
    position: Floats2  # (k, 3): in the body's frame, m
    displacement: Floats3  # (k, 3, m): by the body's modes, in its frame; zero where it is rigid
    rotation: Floats3  # (k, 3, m): the same
    modes: Ints1  # (k,): number of modes that move it, none where its body is rigid


class Joints(NamedTuple):
    """Constraints, whose multipliers come in this order: pins, drive, turn, holds."""

    pins: Ints2  # (pins, 2): markers of the rear and of the front shoe of every link pin
    drive: int  # marker whose velocity along x is prescribed
    turn: int  # body whose angular velocity about its own axis z is prescribed
    holds: Ints2  # (holds, 2): body and coordinate that stays where it is
    bodies: Ints2  # (multipliers, 2): bodies that each constraint is between; -1 for none


class ClosedJoints(NamedTuple):
    """What the joints of a closed track have beside those of an open one.

    The equations of a loop's pins across the chain are redundant: their sums round the loop are zero whatever
    the shoes do. A little compliance of these alone shares the loads among all pins as evenly as can be, and
    leaves the motion in the chain's plane as it is. So pins have their equations along the axes of that
    plane, as the rear body's yaw and roll have turned them. Multipliers of motors come last.
    """

    compliance: Floats2  # (pins, ROWS): m/N and rad/(N m)
    relaxation: Floats2  # (pins, ROWS): s, damping times compliance
    motors: Ints2  # (motors, 2): frame and tumbler that turns against it, or idler that does not
    limit: Floats1  # (motors,): greatest torque, N m; infinite where the speed is kept
    lag: Floats1  # (motors,): rad/s at which there is 0.7 of the greatest torque


class End(NamedTuple):
    """A marker as its body carries it."""

    lever: Vector  # from the frame's origin, m, global
    rotation: Vector  # vector to turn about, rad, the body's frame
    factors: Vector  # as of `_factors`, of its length


@inner
def _factors(angle: float) -> tuple[float, float, float]:
    """``sin a / a``, ``(1 - cos a) / a^2`` and ``(a - sin a) / a^3``."""
    if angle < SMALL:
        square = angle * angle
        return 1.0 - square / 6.0, 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    s = math.sin(angle) / angle
    return s, (1.0 - math.cos(angle)) / angle**2, (1.0 - s) / angle**2


@inner(merged=True)
def end_of(markers: Markers, k: int, at: Attitude, row: FloatArray) -> End:
    """Marker k at the coordinates of its body and its modes (6 + m,)."""
    position = (markers.position[k, 0], markers.position[k, 1], markers.position[k, 2])
    if markers.modes[k] == 0:
        return End(turned(at.R, position), (0.0, 0.0, 0.0), UNTURNED)
    rotation = moved((0.0, 0.0, 0.0), markers.rotation[k], row)
    lever = turned(at.R, moved(position, markers.displacement[k], row))
    return End(lever, rotation, _factors(norm(rotation)))


@inner(merged=True)
def axis_of(end: End, at: Attitude, k: int) -> Vector:
    """Axis k of an end, global: ``R exp(rotation) e_k``."""
    t, (s, c, _) = end.rotation, end.factors
    once = cross(t, basis(k))
    return turned(at.R, along(along(basis(k), s, once), c, cross(t, once)))


@inner
def _by_rotation(end: End, moment: Vector) -> Vector:
    """Part of a moment (the shoe's frame) that the rates of an end's rotation vector feel.

    An end turns at ``T rotation'`` with ``T = 1 + (1 - cos a)/a^2 t~ + (a - sin a)/a^3 t~ t~``; this is its
    transpose times the moment.
    """
    t, (_, c, d) = end.rotation, end.factors
    once = cross(t, moment)
    return along(along(moment, -c, once), d, cross(t, once))


@inner(merged=True)
def _work(shapes: FloatArray, force: Vector, k: int) -> float:
    """Work of a force (the body's frame) along mode k of shapes (3, m)."""
    return force[0] * shapes[0, k] + force[1] * shapes[1, k] + force[2] * shapes[2, k]


@inner(merged=True)
def direction(
    markers: Markers,
    k: int,
    end: End,
    at: Attitude,
    force: Vector,
    moment: Vector,
    sign: float,
    out: FloatArray,
) -> None:
    """Write the generalized force (6 + m,) of a force and a moment (global) at marker k, times a sign.

    Of a rigid body the latter m stay as they are.
    """
    turning = turned(at.axes, along(moment, 1.0, cross(end.lever, force)))
    for c in range(3):
        out[c] = sign * force[c]
        out[3 + c] = sign * turning[c]
    if markers.modes[k] == 0:
        return
    own, shapes = turned_back(at.R, force), markers.displacement[k]
    for m in range(shapes.shape[1]):
        out[6 + m] = sign * _work(shapes, own, m)
    if dot(moment, moment) != 0.0:
        own, shapes = _by_rotation(end, turned_back(at.R, moment)), markers.rotation[k]
        for m in range(shapes.shape[1]):
            out[6 + m] += sign * _work(shapes, own, m)


@inner(merged=True)
def plane_axis(at: Attitude, k: int) -> Vector:
    """Axis k of a chain's plane, global: along the ground, across the chain, and normal to both."""
    if k == 2:
        return cross(at.axes[0], at.axes[1])
    return at.axes[k]


@inner(merged=True)
def _rigid_pin(
    levers: tuple[Vector, Vector],
    attitudes: tuple[Attitude, Attitude],
    between: Vector,
    gap: FloatArray,
    jacobian: FloatArray,
) -> None:
    """Write a pin in a chain's plane between rigid bodies; most pins of a closed track are of that kind."""
    rear, front = attitudes
    axes = rear.axes[0], rear.axes[1], plane_axis(rear, 2)
    across, x, z = turned(rear.R, basis(1)), turned(front.R, basis(0)), turned(front.R, basis(2))
    moments = cross(x, across), cross(z, across)
    gap[0], gap[1], gap[2] = dot(between, axes[0]), dot(between, axes[1]), dot(between, axes[2])
    gap[3], gap[4] = dot(across, x), dot(across, z)
    for side in range(2):
        at, lever, sign = attitudes[side], levers[side], 2.0 * side - 1.0
        for c in range(3):
            swept = cross(at.axes[c], lever)
            for r in range(3):
                jacobian[r, side, c] = sign * axes[r][c]
                jacobian[r, side, 3 + c] = sign * dot(swept, axes[r])
            for r in range(2):
                jacobian[3 + r, side, c] = 0.0
                jacobian[3 + r, side, 3 + c] = sign * dot(at.axes[c], moments[r])


@inner
def add_pins(
    bodies: Bodies,
    markers: Markers,
    pins: IntArray,
    in_plane: bool,
    state: FloatArray,
    rows: FloatArray,
    gap: FloatArray,
    jacobian: FloatArray,
) -> None:
    """Write gaps and Jacobians of all pins into the first rows of both; `rows` (2, 6 + m) are scratch.

    The gap of a pin's place has global components, `in_plane` those along the axes of the chain's plane.
    """
    for p in range(pins.shape[0]):
        rear, front = pins[p, 0], pins[p, 1]
        a, b = markers.body[rear], markers.body[front]
        read_body(bodies, a, state[0], rows[0])
        read_body(bodies, b, state[0], rows[1])
        at_a, at_b = attitude_of(bodies, a), attitude_of(bodies, b)
        reference = bodies.reference
        apart = (
            reference[b, 0] + rows[1, 0] - reference[a, 0] - rows[0, 0],
            reference[b, 1] + rows[1, 1] - reference[a, 1] - rows[0, 1],
            reference[b, 2] + rows[1, 2] - reference[a, 2] - rows[0, 2],
        )
        behind, ahead = end_of(markers, rear, at_a, rows[0]), end_of(markers, front, at_b, rows[1])
        between = along(along(apart, 1.0, ahead.lever), -1.0, behind.lever)
        own, by = gap[ROWS * p : ROWS * p + ROWS], jacobian[ROWS * p : ROWS * p + ROWS]
        if in_plane and markers.modes[rear] == 0 and markers.modes[front] == 0:
            _rigid_pin((behind.lever, ahead.lever), (at_a, at_b), between, own, by)
            continue
        across = axis_of(behind, at_a, 1)
        for r in range(ROWS):
            force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
            if r < 3 and in_plane:
                force = plane_axis(at_a, r)
                own[r] = dot(between, force)
            elif r < 3:
                force = basis(r)
                own[r] = between[r]
            else:
                axis = axis_of(ahead, at_b, 0 if r == 3 else 2)
                own[r] = dot(across, axis)
                moment = cross(axis, across)
            direction(markers, rear, behind, at_a, force, moment, -1.0, by[r, 0])
            direction(markers, front, ahead, at_b, force, moment, 1.0, by[r, 1])


@inner
def add_speeds(
    bodies: Bodies,
    markers: Markers,
    joints: Joints,
    state: FloatArray,
    speeds: FloatArray,
    rows: FloatArray,
    gap: FloatArray,
    jacobian: FloatArray,
) -> None:
    """Write gaps (m/s, rad/s) and Jacobians of drive and turn, whose `speeds` are (2,); scratch as above."""
    first, nothing = ROWS * joints.pins.shape[0], (0.0, 0.0, 0.0)
    for k in range(2):
        b = markers.body[joints.drive] if k == 0 else joints.turn
        read_body(bodies, b, state[0], rows[0])
        read_body(bodies, b, state[1], rows[1])
        at = attitude_of(bodies, b)
        if k == 0:
            end = end_of(markers, joints.drive, at, rows[0])
            direction(markers, joints.drive, end, at, (1.0, 0.0, 0.0), nothing, 1.0, jacobian[first + k, 0])
        else:
            about = turned(at.axes, upward(at.R))
            for c in range(jacobian.shape[2]):
                jacobian[first + k, 0, c] = about[c - 3] if 3 <= c < 6 else 0.0
        speed = -speeds[k]
        for c in range(rows.shape[1]):
            speed += jacobian[first + k, 0, c] * rows[1, c]
        gap[first + k] = speed


@inner
def add_holds(
    bodies: Bodies, joints: Joints, state: FloatArray, gap: FloatArray, jacobian: FloatArray
) -> None:
    """Write gaps and Jacobians of coordinates that stay where they are."""
    for k in range(joints.holds.shape[0]):
        row, b, coordinate = ROWS * joints.pins.shape[0] + 2 + k, joints.holds[k, 0], joints.holds[k, 1]
        gap[row] = state[0, bodies.coordinate[b] + coordinate]
        jacobian[row, 0].fill(0.0)
        jacobian[row, 0, coordinate] = 1.0


PULLED = 3
"""Bodies that the pull acts on: the frame and two shoes."""


class Pull(NamedTuple):
    """Where a frame pulls its chain."""

    frame: int  # body that pulls
    tumbler: float  # x in the frame where the chain is pulled, m
    pitch: float  # of the chain, m
    ahead: float  # x of the front pins in a shoe, m
    markers: Ints1  # (shoes,): middle of every shoe's front pins


@inner
def write_pull(
    pull: Pull,
    bodies: Bodies,
    markers: Markers,
    state: FloatArray,
    pulled: IntArray,
    directions: FloatArray,
) -> None:
    """Write the bodies (PULLED,) and the generalized forces (PULLED, 6 + m) of a unit pull on each."""
    if pull.markers.shape[0] == 0:
        return
    at = attitude_of(bodies, pull.frame)
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
        shoe_at = attitude_of(bodies, s)
        end, origin = end_of(markers, marker, shoe_at, row), frame_of(bodies, s, state, shoe_at).r
        moment = cross(along(along(origin, 1.0, end.lever), -1.0, frame.r), force)
        turning = turned(at.axes, moment)
        for c in range(3):
            directions[0, 3 + c] += share * turning[c]
        direction(markers, marker, end, shoe_at, force, (0.0, 0.0, 0.0), -share, row)
        pulled[1 + k] = s


@inner
def write_turned(
    bodies: Bodies,
    markers: Markers,
    pair: IntArray,
    in_plane: bool,
    multipliers: FloatArray,
    state: FloatArray,
    row: FloatArray,
    out: FloatArray,
) -> None:
    """Write how the moments of a pin's force change as its bodies turn: (2, 3, 3), by their angles.

    `pair` are the markers of rear and front body, `in_plane` is as of `add_pins`, `multipliers` are those of
    the pin, and `row` (6 + m,) is scratch. In a tight chain that moves slowly this is what holds the shoes in
    line, and no equation solver may leave it out.
    """
    rear = attitude_of(bodies, markers.body[pair[0]])
    force = (0.0, 0.0, 0.0)
    for r in range(3):
        force = along(force, multipliers[r], plane_axis(rear, r) if in_plane else basis(r))
    for side in range(2):
        b = markers.body[pair[side]]
        read_body(bodies, b, state[0], row)
        at = attitude_of(bodies, b)
        lever = end_of(markers, pair[side], at, row).lever
        for j in range(3):
            moment = cross(cross(at.axes[j], lever), force)
            for i in range(3):
                out[side, i, j] = (2.0 * side - 1.0) * dot(at.axes[i], moment)


@inner
def turn_moments(
    bodies: Bodies, markers: Markers, pins: IntArray, change: FloatArray, multipliers: FloatArray
) -> None:
    """Keep the moments of pins, whose multipliers are along axes that pitch with the front body.

    `change` (coordinates + multipliers,) has been taken off both. Newton's method then knows how these
    moments turn, on the rear body too, although no entry of its matrix couples the two bodies.
    """
    for p in range(pins.shape[0]):
        pitch, row = -change[bodies.coordinate[markers.body[pins[p, 1]]] + 4], ROWS * p + 3
        c, s = math.cos(pitch), math.sin(pitch)
        a, b = multipliers[row], multipliers[row + 1]
        multipliers[row], multipliers[row + 1] = c * a - s * b, s * a + c * b


@inner
def motor_speed(bodies: Bodies, motor: IntArray, state: FloatArray, axes: FloatArray) -> float:
    """Speed (rad/s) of a motor's tumbler against its frame.

    `axes` (2, 3) get by how much the rates of the angles of frame and tumbler change it: their parts along
    the tumbler's axis.
    """
    at = attitude_of(bodies, motor[1])
    speed = 0.0
    for side in range(2):
        b, sign = motor[side], 2.0 * side - 1.0
        own = attitude_of(bodies, b)
        first = bodies.coordinate[b]
        for k in range(3):
            axes[side, k] = sign * dot(own.axes[k], at.axes[1])
            speed += axes[side, k] * state[1, first + 3 + k]
    return speed


@inner
def motor_torque(closed: ClosedJoints, k: int, lag: float) -> tuple[float, float]:
    """Torque (N m) of a motor whose torque is limited, behind its speed by `lag` (rad/s), and its slope."""
    width = closed.lag[k]
    root = math.sqrt(lag * lag + width * width)
    return closed.limit[k] * lag / root, closed.limit[k] * width * width / root**3
