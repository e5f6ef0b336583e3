"""Equations of a side frame on its rollers, beside those of the track that it rolls over.

The frame's x is prescribed. What it takes along x beyond the machine's force and the rollers' is the pull of
the drive, an unknown: it acts forward on the frame and backward on the chain, at the pins of the two links
next to the tumbler, in shares that change evenly as the tumbler goes from one to the next.
"""

import math

import numpy as np
from numba import types
from numba.extending import overload

from exudyn_crawler.ground.frames import Frame, Vector, along, cross, dot, inlined, turned, turned_back
from exudyn_crawler.ground.rotations import Attitude, FloatArray, attitude, shoe_frame
from exudyn_crawler.model.compiled.bodies import Body, Inertia, add_mass, body_residual
from exudyn_crawler.model.compiled.elimination import front, solving_within
from exudyn_crawler.model.compiled.joints import ROWS, direction, end_of
from exudyn_crawler.model.compiled.own import add_own, modal_start, read_own, shoe_attitude
from exudyn_crawler.model.compiled.records import Inputs, Memory, Model, Weights
from exudyn_crawler.model.compiled.rollers import (
    FORCES,
    FRAME,
    TOUCHED,
    Meeting,
    Rollers,
    Rolling,
    SideFrame,
    bending,
    meet,
    rows_at,
    write_change,
)

RISE = 0.02
"""m, more than a rail ever bends."""


@inlined
def _side_of(model: Model) -> SideFrame:
    """Numbers of the side frame, named."""
    body, place, rollers = model.side
    return SideFrame(Body(*body), place, Rollers(*rollers))


@solving_within
def frame_attitude(state: FloatArray) -> Attitude:
    """Attitude of the side frame, whose coordinates are the last ones."""
    first = state.shape[1] - FRAME
    return attitude(state[0, first + 1], state[0, first + 2], 0.0)


@solving_within
def _frame_state(model: Model, state: FloatArray, inputs: Inputs) -> FloatArray:
    """Coordinates of the frame as those of a free body, their rates and accelerations: (3, 6)."""
    own, first, place = np.zeros((3, 6)), state.shape[1] - FRAME, _side_of(model).place
    for rate in range(3):
        own[rate, 0] = inputs.travel[rate]
        for k in range(FRAME):
            own[rate, 2 + k] = state[rate, first + k]
    for k in range(3):
        own[0, k] += place[k]
    return own


@solving_within
def _shoe_of(model: Model, state: FloatArray, s: int, own: FloatArray) -> Frame:
    """Frame of a shoe, and its coordinates and those of its modes with their rates in `own` (2, 6 + m)."""
    modal = modal_start(model.sizes, model.row[s])
    read_own(s, modal, state[0], own[0])
    read_own(s, modal, state[1], own[1])
    for k in range(6):
        own[0, k] += model.reference[s, k]
    return shoe_frame(own[0], own[1], shoe_attitude(state, s))


@solving_within
def _may_touch(rollers: Rollers, place: Vector, frame: Frame, shoe: Frame) -> bool:
    """Whether a strip is near a shoe's rail, however that bends."""
    apart = along(along(frame.r, 1.0, turned(frame.R, place)), -1.0, shoe.r)
    center, rail = turned_back(shoe.R, apart), rollers.rail
    dx = center[0] - min(max(center[0], rail[0]), rail[1])
    dz = center[2] - rail[2]
    return dx * dx + dz * dz < (rollers.radius + RISE) ** 2


@solving_within
def _add_tread(
    rolling: Rolling, t: int, met: Meeting, axes: tuple, origin: Vector, forces: FloatArray, own: FloatArray
) -> None:
    """Keep tread t, and add it to the residual of the frame (6,) and to that of the shoe (6 + m,).

    `axes` are those of the shoe's and of the frame's angles, `origin` the frame's (m, global).
    """
    force, foot = met.force, along(origin, 1.0, met.frame_arm)
    moment, frame_moment = cross(met.shoe_arm, force), cross(met.frame_arm, force)
    for k in range(3):
        rolling.force[t, k], rolling.foot[t, k] = force[k], foot[k]
        own[k] += force[k]
        own[3 + k] += dot(axes[0][k], moment)
        forces[k] -= force[k]
        forces[3 + k] -= dot(axes[1][k], frame_moment)
    x, z = met.tread.force
    for k in range(own.shape[0] - 6):
        own[6 + k] += rolling.rows[t, 0, k] * x + rolling.rows[t, 1, k] * z


@solving_within
def _roll(
    model: Model,
    state: FloatArray,
    inputs: Inputs,
    weights: Weights,
    rolling: Rolling,
    side: tuple[Frame, Attitude],
    forces: FloatArray,
    residual: FloatArray,
) -> None:
    """Add all treads to the residual of the shoes and to that of the frame as a free body (6,)."""
    rollers, sizes = _side_of(model).rollers, model.sizes
    frame, at = side
    derive = weights.position != 0.0 or weights.velocity != 0.0
    values, own = np.zeros((2, 6 + sizes.modes)), np.empty(6 + sizes.modes)
    strips, first = rollers.places.shape[1], model.reference[0, 0] + state[0, 0]
    for r in range(rollers.places.shape[0]):
        x, z = rollers.places[r, 0, 0], rollers.places[r, 0, 2]
        axis = frame.r[0] + turned(frame.R, (x, 0.0, z))[0]
        rear = math.floor((axis - first) / rollers.pitch)
        rolling.rear[r] = min(max(rear, 0), sizes.shoes - TOUCHED)
        for half in range(TOUCHED):
            s = rolling.rear[r] + half
            shoe, shoe_at = _shoe_of(model, state, s, values), shoe_attitude(state, s)
            modal = modal_start(sizes, model.row[s])
            own.fill(0.0)
            for k in range(strips):
                t = (r * strips + k) * TOUCHED + half
                rolling.depth[t] = 0.0
                place = (rollers.places[r, k, 0], rollers.places[r, k, 1], rollers.places[r, k, 2])
                if not _may_touch(rollers, place, frame, shoe):
                    continue
                rows = rolling.rows[t]
                if modal >= 0:
                    arm = along(along(frame.r, 1.0, turned(frame.R, place)), -1.0, shoe.r)
                    x = turned_back(shoe.R, arm)[0]
                    rows_at(rollers, k, min(max(x, rollers.rail[0]), rollers.rail[1]), rows)
                else:
                    rows.fill(0.0)
                met = meet(rollers, (place, inputs.drag), frame, shoe, bending(rows, values))
                if met.tread.depth <= 0.0:
                    continue
                rolling.depth[t] = met.tread.depth
                _add_tread(rolling, t, met, (shoe_at.axes, at.axes), frame.r, forces, own)
                if derive:
                    change = rolling.change[t]
                    write_change(met, shoe_at, at, weights.position, weights.velocity, change)
            add_own(s, modal, own, 1.0, residual)


@solving_within
def _pull(
    model: Model, state: FloatArray, inputs: Inputs, rolling: Rolling, frame: Frame, at: Attitude
) -> None:
    """Write the directions of a unit pull on frame and chain."""
    (_, place, rollers), sizes = _side_of(model), model.sizes
    tumbler = place[0] + inputs.travel[0] + rollers.tumbler
    behind = (tumbler - model.reference[0, 0] - state[0, 0] - rollers.pins[1, 0]) / rollers.pitch
    link = min(max(math.floor(behind), 0), sizes.shoes - 3)
    share = min(max(behind - link, 0.0), 1.0)
    rolling.link[0], rolling.share[0], rolling.share[1] = link, 1.0 - share, share
    rolling.pulling.fill(0.0)
    values, ahead = np.empty((2, 6 + sizes.modes)), (1.0, 0.0, 0.0)
    for k in range(2):
        shoe = _shoe_of(model, state, link + k, values)
        arm = _pull_at(model, state, link + k, 1, rolling.pull[k])
        moment = cross(along(along(shoe.r, 1.0, arm), -1.0, frame.r), ahead)
        for c in range(2):
            rolling.pulling[1 + c] += rolling.share[k] * dot(at.axes[c], moment)


@solving_within
def _pull_at(model: Model, state: FloatArray, s: int, end: int, out: FloatArray) -> Vector:
    """Write the direction (6 + m,) of a force along x on a shoe's pins, and give their arm (m, global)."""
    rollers, values = _side_of(model).rollers, np.empty(out.shape[0])
    read_own(s, modal_start(model.sizes, model.row[s]), state[0], values)
    at, rows = shoe_attitude(state, s), rollers.pin_rows[end]
    pins = end_of(rollers.pins[end], rows, rows, at, values)
    direction((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), pins, (rows, rows), at, 1.0, out)
    return pins.lever


@solving_within
def _add_side_frame(
    model: Model,
    state: FloatArray,
    multipliers: FloatArray,
    inputs: Inputs,
    weights: Weights,
    memory: Memory,
    residual: FloatArray,
) -> None:
    """Add frame, rollers, pull and the tension of the chain's ends, and write what the frame's x is off."""
    rolling, whole = Rolling(*memory.rolling), _frame_state(model, state, inputs)
    (body, _, rollers), at, forces = _side_of(model), frame_attitude(state), np.zeros(6)
    frame = shoe_frame(whole[0], whole[1], at)
    inertia = Inertia(rolling.first, rolling.second, rolling.turning)
    body_residual(body, at, whole, inputs.gravity, ((0.0, 0.0, 0.0), 0.0), forces, inertia)
    for k in range(3):
        forces[k] -= inputs.machine[k]
        moment = (inputs.machine[3], inputs.machine[4], inputs.machine[5])
        forces[3 + k] -= dot(at.axes[k], moment)
    _roll(model, state, inputs, weights, rolling, (frame, at), forces, residual)
    _pull(model, state, inputs, rolling, frame, at)
    drive, first = ROWS * model.sizes.pins, state.shape[1] - FRAME
    pull, last = multipliers[drive], model.sizes.shoes - 1
    for k in range(2):
        s = rolling.link[0] + k
        modal = modal_start(model.sizes, model.row[s])
        add_own(s, modal, rolling.pull[k], pull * rolling.share[k], residual)
    memory.off[drive] = forces[0] - pull
    for k in range(FRAME):
        residual[first + k] += forces[2 + k] - pull * rolling.pulling[k]
    if rollers.tension != 0.0:
        out = np.empty(6 + model.sizes.modes)
        for end in range(2):
            s = last * end
            _pull_at(model, state, s, end, out)
            tension = -rollers.tension if end == 1 else rollers.tension
            add_own(s, modal_start(model.sizes, model.row[s]), out, tension, residual)


@solving_within
def _add_touch(
    model: Model, rolling: Rolling, t: int, s: int, values: FloatArray, border: FloatArray
) -> None:
    """Add the derivative of a tread to the fronts of its shoe and of the frame."""
    matrix, change, rows = front(model.fronts, values, s), rolling.change[t], rolling.rows[t]
    modes = model.sizes.modes if model.row[s] >= 0 else 0
    frame, pull = model.places.frame[s, 0], model.places.frame[s, 1]
    last, last_pull = model.places.frame[model.sizes.shoes, 0], model.places.frame[model.sizes.shoes, 1]
    own = np.zeros((FORCES, 6 + modes))
    for r in range(FORCES):
        for c in range(6):
            own[r, c] = change[r, c]
        for k in range(modes):
            own[r, 6 + k] = change[r, 9] * rows[1, k] + change[r, 10] * rows[2, k]
    for c in range(6 + modes):
        for r in range(6):
            matrix[r, c] += own[r, c]
        matrix[pull, c] += own[6, c]
        for r in range(FRAME):
            matrix[frame + r, c] += own[7 + r, c]
        for k in range(modes):
            matrix[6 + k, c] += rows[0, k] * own[10, c] + rows[1, k] * own[11, c] + rows[2, k] * own[12, c]
    for c in range(FRAME):
        for r in range(6):
            matrix[r, frame + c] += change[r, 6 + c]
        for k in range(modes):
            matrix[6 + k, frame + c] += (
                rows[0, k] * change[10, 6 + c]
                + rows[1, k] * change[11, 6 + c]
                + rows[2, k] * change[12, 6 + c]
            )
        border[last_pull, last + c] += change[6, 6 + c]
        for r in range(FRAME):
            border[last + r, last + c] += change[7 + r, 6 + c]


@solving_within
def _assemble_side_frame(
    model: Model, state: FloatArray, weights: Weights, memory: Memory, values: FloatArray
) -> None:
    """Add the derivatives of frame, rollers and pull to the fronts."""
    rolling, (body, _, rollers) = Rolling(*memory.rolling), _side_of(model)
    border = front(model.fronts, values, model.places.border[0])
    last, pull = model.places.frame[model.sizes.shoes, 0], model.places.frame[model.sizes.shoes, 1]
    mass = np.zeros((6, 6))
    inertia = Inertia(rolling.first, rolling.second, rolling.turning)
    add_mass(body, frame_attitude(state), inertia, weights.acceleration, mass)
    for c in range(FRAME):
        border[pull, last + c] += mass[0, 2 + c]
        border[last + c, pull] -= rolling.pulling[c]
        for r in range(FRAME):
            border[last + r, last + c] += mass[2 + r, 2 + c]
    border[pull, pull] -= 1.0
    for k in range(2):
        s = rolling.link[0] + k
        matrix, row = front(model.fronts, values, s), model.places.frame[s, 1]
        for c in range(6 + (model.sizes.modes if model.row[s] >= 0 else 0)):
            matrix[c, row] += rolling.share[k] * rolling.pull[k, c]
    strips = rollers.places.shape[1]
    for t in range(rolling.depth.shape[0]):
        if rolling.depth[t] > 0.0:
            s = rolling.rear[t // (TOUCHED * strips)] + t % TOUCHED
            _add_touch(model, rolling, t, s, values, border)


def add_side_frame(
    model: Model,
    state: FloatArray,
    multipliers: FloatArray,
    inputs: Inputs,
    weights: Weights,
    memory: Memory,
    residual: FloatArray,
) -> None:
    """Add frame and rollers to the residual where there are any; for compiled callers.

    The model's type says so: a track without compiles nothing of them, which would take as long as all
    the rest.
    """
    raise NotImplementedError("compiled equations alone add a side frame")


def assemble_side_frame(
    model: Model, state: FloatArray, weights: Weights, memory: Memory, values: FloatArray
) -> None:
    """Add derivatives of frame and rollers to the fronts where there are any; for compiled callers."""
    raise NotImplementedError("compiled equations alone add a side frame")


def _is_framed(model: types.NamedTuple) -> bool:
    """Whether a model of this type has a side frame."""
    return len(model.types[Model._fields.index("side")]) > 0


@overload(add_side_frame)
def _add_if_framed(model, state, multipliers, inputs, weights, memory, residual):
    def add(model, state, multipliers, inputs, weights, memory, residual):
        _add_side_frame(model, state, multipliers, inputs, weights, memory, residual)

    def nothing(model, state, multipliers, inputs, weights, memory, residual):
        pass

    return add if _is_framed(model) else nothing


@overload(assemble_side_frame)
def _assemble_if_framed(model, state, weights, memory, values):
    def assemble(model, state, weights, memory, values):
        _assemble_side_frame(model, state, weights, memory, values)

    def nothing(model, state, weights, memory, values):
        pass

    return assemble if _is_framed(model) else nothing
