"""Pins: two markers coincide, and the axis y of one stays perpendicular to two axes of the other."""

import math
from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import Vector, along, basis, cross, dot, turned
from exudyn_crawler.ground.packed import FloatArray, Floats2, Ints2
from exudyn_crawler.ground.rotations import Attitude
from exudyn_crawler.model.bodies import Bodies, attitude_of, read_body
from exudyn_crawler.model.markers import NOTHING, End, Markers, axis_of, direction, end_of
from exudyn_crawler.model.rows import ALONG_JACOBIAN, STIFFNESS, JointRows, Motion

ROWS = 5
"""Number of equations of a pin: its position, and its axis y across the axes x and z of the shoe in front."""


class Pins(NamedTuple):
    """Pins of links, and bearings of bodies that rotate in a frame; p of them, each with `ROWS` rows.

    In a loop the equations of pins across the chain are redundant: their sums round the loop are zero for any
    motion of the shoes. A small compliance of these alone shares the loads among all pins as evenly as
    possible, and does not affect the motion in the chain's plane. Such pins therefore have their equations
    along the axes of that plane, turned by the rear body's yaw and roll.
    """

    first: int  # row of the first one
    markers: Ints2  # (p, 2): of the rear and of the front body
    compliance: Floats2  # (p, ROWS): m/N and rad/(N m)
    relaxation: Floats2  # (p, ROWS): s, damping times compliance
    in_plane: bool  # True: equations of positions along the axes of the chain's plane; False: global
    follows: bool  # True if moments turn with the front body from one iteration to the next


@inner(merged=True)
def plane_axis(attitude: Attitude, k: int) -> Vector:
    """Return axis k of a chain's plane, global: along the ground, across the chain, and normal to both."""
    if k == 2:
        return cross(attitude.axes[0], attitude.axes[1])
    return attitude.axes[k]


class LinkEnds(NamedTuple):
    """Both ends of a link, rear and front, at the coordinates of their bodies."""

    bodies: tuple[int, int]
    attitudes: tuple[Attitude, Attitude]
    ends: tuple[End, End]
    between: Vector  # from the rear to the front marker, m, global


@inner(merged=True)
def link_ends(
    pair: tuple[int, int], bodies: Bodies, markers: Markers, state: FloatArray, scratch: Floats2
) -> LinkEnds:
    """Return the ends of a link between two markers; `scratch` (2, 6 + m) gets its bodies' coordinates."""
    a, b = markers.body[pair[0]], markers.body[pair[1]]
    behind_row = scratch[0]
    ahead_row = scratch[1]
    read_body(bodies, a, state[0], behind_row)
    read_body(bodies, b, state[0], ahead_row)
    at_a = attitude_of(bodies, a)
    at_b = attitude_of(bodies, b)
    reference = bodies.reference
    apart = (
        reference[b, 0] + ahead_row[0] - reference[a, 0] - behind_row[0],
        reference[b, 1] + ahead_row[1] - reference[a, 1] - behind_row[1],
        reference[b, 2] + ahead_row[2] - reference[a, 2] - behind_row[2],
    )
    behind = end_of(markers, pair[0], at_a, behind_row)
    ahead = end_of(markers, pair[1], at_b, ahead_row)
    between = along(along(apart, 1.0, ahead.lever), -1.0, behind.lever)
    return LinkEnds((a, b), (at_a, at_b), (behind, ahead), between)


@inner(merged=True)
def _write_rigid(
    levers: tuple[Vector, Vector],
    attitudes: tuple[Attitude, Attitude],
    between: Vector,
    gap: FloatArray,
    jacobian: FloatArray,
) -> None:
    """Write a pin in a chain's plane between rigid bodies, the most frequent pin of a closed track."""
    rear, front = attitudes
    axes = rear.axes[0], rear.axes[1], plane_axis(rear, 2)
    across = turned(rear.R, basis(1))
    x = turned(front.R, basis(0))
    z = turned(front.R, basis(2))
    moments = cross(x, across), cross(z, across)
    for r in range(3):
        gap[r] = dot(between, axes[r])
    gap[3] = dot(across, x)
    gap[4] = dot(across, z)
    for side in range(2):
        attitude = attitudes[side]
        sign = 2.0 * side - 1.0
        for c in range(3):
            swept = cross(attitude.axes[c], levers[side])
            for r in range(3):
                jacobian[r, side, c] = sign * axes[r][c]
                jacobian[r, side, 3 + c] = sign * dot(swept, axes[r])
            for r in range(2):
                jacobian[3 + r, side, c] = 0.0
                jacobian[3 + r, side, 3 + c] = sign * dot(attitude.axes[c], moments[r])


@inner
def write_rows(pins: Pins, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows) -> None:
    """Write the rows of all pins, and the rotation of their forces' moments if the weights ask for it."""
    for p in range(pins.markers.shape[0]):
        rear = pins.markers[p, 0]
        front = pins.markers[p, 1]
        link = link_ends((rear, front), bodies, markers, motion.state, rows.scratch)
        a, b = link.bodies
        at_a, at_b = link.attitudes
        behind, ahead = link.ends
        between = link.between
        first = pins.first + ROWS * p
        for r in range(ROWS):
            rows.bodies[first + r, 0] = a
            rows.bodies[first + r, 1] = b
            rows.scale[first + r] = STIFFNESS
            rows.slope[first + r] = STIFFNESS
            rows.share[first + r] = -STIFFNESS * pins.compliance[p, r]
            rows.relaxation[first + r] = pins.relaxation[p, r]
            rows.directed[first + r] = ALONG_JACOBIAN
        gap = rows.gap[first : first + ROWS]
        jacobian = rows.jacobian[first : first + ROWS]
        if pins.in_plane and markers.modes[rear] == 0 and markers.modes[front] == 0:
            _write_rigid((behind.lever, ahead.lever), (at_a, at_b), between, gap, jacobian)
            continue
        across = axis_of(behind, at_a, 1)
        for r in range(ROWS):
            force = NOTHING
            moment = NOTHING
            if r < 3:
                force = plane_axis(at_a, r) if pins.in_plane else basis(r)
                gap[r] = dot(between, force) if pins.in_plane else between[r]
            else:
                axis = axis_of(ahead, at_b, 0 if r == 3 else 2)
                gap[r] = dot(across, axis)
                moment = cross(axis, across)
            direction(markers, rear, behind, at_a, force, moment, -1.0, jacobian[r, 0])
            direction(markers, front, ahead, at_b, force, moment, 1.0, jacobian[r, 1])
    if motion.weights.position != 0.0:
        _write_turning(pins, bodies, markers, motion.state, motion.multipliers, rows)


@inner
def _write_turning(
    pins: Pins,
    bodies: Bodies,
    markers: Markers,
    state: FloatArray,
    multipliers: FloatArray,
    rows: JointRows,
) -> None:
    """Write the change of the moments of the pins' forces with the rotation of their bodies.

    In a tight, slow chain this stiffness holds the shoes in line, and no equation solver may leave it out.
    """
    for p in range(pins.markers.shape[0] if rows.turned.shape[0] > 0 else 0):
        rear = attitude_of(bodies, markers.body[pins.markers[p, 0]])
        first = pins.first + ROWS * p
        force = NOTHING
        for r in range(3):
            axis = plane_axis(rear, r) if pins.in_plane else basis(r)
            force = along(force, multipliers[first + r], axis)
        pair = pins.markers[p, 0], pins.markers[p, 1]
        write_turned(p, pair, force, bodies, markers, state, rows)


@inner
def write_turned(
    place: int,
    pair: tuple[int, int],
    force: Vector,
    bodies: Bodies,
    markers: Markers,
    state: FloatArray,
    rows: JointRows,
) -> None:
    """Write the change of the moments of a force at two markers at its place among the rotating pairs."""
    row = rows.scratch[0]
    for side in range(2):
        marker = pair[side]
        b = markers.body[marker]
        rows.turned[place, side] = b
        read_body(bodies, b, state[0], row)
        attitude = attitude_of(bodies, b)
        lever = end_of(markers, marker, attitude, row).lever
        for j in range(3):
            moment = cross(cross(attitude.axes[j], lever), force)
            for i in range(3):
                rows.turning[place, side, i, j] = (2.0 * side - 1.0) * dot(attitude.axes[i], moment)


@inner
def turn_moments(
    pins: Pins, bodies: Bodies, markers: Markers, change: FloatArray, multipliers: FloatArray
) -> None:
    """Keep the moments of pins that follow, whose multipliers are along axes that pitch with the front body.

    `change` (coordinates + multipliers,) has been subtracted from both. Newton's method then has the rotation
    of these moments, on the rear body too, although no entry of its matrix couples the two bodies.
    """
    for p in range(pins.markers.shape[0] if pins.follows else 0):
        pitch = -change[bodies.coordinate[markers.body[pins.markers[p, 1]]] + 4]
        row = pins.first + ROWS * p + 3
        c = math.cos(pitch)
        s = math.sin(pitch)
        x, z = multipliers[row], multipliers[row + 1]
        multipliers[row] = c * x - s * z
        multipliers[row + 1] = s * x + c * z
