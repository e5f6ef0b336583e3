"""Equations of motion of a system of tables: residual, and matrix of its weighted derivatives.

The unknowns are the coordinates, in the order of `model.state`, then the multipliers of the joints. The
residual is inertia less forces plus constraint forces for the first, and the gaps of the constraints for the
second. Both are sums over bodies, joints and force elements.

The matrix is exact but for three things, which change over seconds and not over a step: how the forces of
constraints (but for `joints.write_turned`), loads and wheels turn and move with the bodies, how centrifugal
and gyroscopic forces change with the rates, and how the outline of an overlap moves. The residual has all of
them, so that they cost iterations and not accuracy.
"""

import numpy as np

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.packed import FloatArray, IntArray
from exudyn_crawler.ground.rotations import ForceRows, Weights
from exudyn_crawler.model import bodies, elimination, joints
from exudyn_crawler.model.bodies import Bodies, add_bodies, add_body, attitude_of, write_angles
from exudyn_crawler.model.forces import cells, loads, teeth, units, wheels
from exudyn_crawler.model.joints import ROWS, motor_speed, motor_torque
from exudyn_crawler.model.tables import FrontRows, Inputs, Tables, Workspace, read_system

STIFFNESS = 1e9
"""N/m and N m/rad, what turns a gap of a constraint into a residual beside forces: about what closing it
within a step of some ms takes of a shoe's mass."""


@inner
def _add_rows(bodies: Bodies, rows: ForceRows, count: int, row: FloatArray, residual: FloatArray) -> None:
    """Take the forces of elements on their bodies off the residual; `row` (6 + m,) is scratch."""
    for p in range(count):
        for side in range(2):
            b = rows.bodies[p, side]
            if b >= 0:
                last = row.shape[0] if bodies.modal[b] >= 0 else 6
                row.fill(0.0)
                for r in range(rows.wrench.shape[1]):
                    for c in range(last):
                        row[c] += rows.jacobian[p, side, r, c] * rows.wrench[p, r]
                add_body(bodies, b, row, -1.0, residual)


@inner(merged=True)
def _add_pin(
    bodies: Bodies, b: int, jacobian: FloatArray, multipliers: FloatArray, residual: FloatArray
) -> None:
    """Add the forces of a pin, whose Jacobian is (ROWS, 6 + m), on one of its bodies."""
    first, modal = bodies.coordinate[b], bodies.modal[b]
    last = jacobian.shape[1] if modal >= 0 else 6
    for start, end, to in ((0, 6, first), (6, last, modal - 6)):
        for c in range(start, end):
            force = residual[to + c]
            for r in range(ROWS):
                force += multipliers[r] * jacobian[r, c]
            residual[to + c] = force


@inner
def _add_joints(
    system: IntArray, inputs: Inputs, multipliers: FloatArray, level: float, out: FloatArray
) -> None:
    """Add the forces of all constraints, and write their residuals behind the coordinates'."""
    tables, work = read_system(system)
    bodies, between, pulls = tables.bodies, tables.joints.bodies, work.pulled.shape[0] > 0
    n, pins = out.shape[0] - multipliers.shape[0], ROWS * tables.joints.pins.shape[0]
    for r in range(0, pins, ROWS):
        for k in range(r, r + ROWS):
            out[n + k] = STIFFNESS * work.gap[k]
        for side in range(2):
            own = work.jacobian[r : r + ROWS, side]
            _add_pin(bodies, between[r, side], own, multipliers[r : r + ROWS], out)
    for r in range(pins, between.shape[0]):
        is_speed = r < pins + 2
        if is_speed and inputs.active[r - pins] <= 0.0:
            out[n + r] = multipliers[r]
            continue
        out[n + r] = STIFFNESS * (level if is_speed else 1.0) * work.gap[r]
        if pulls and r == pins:
            for k in range(work.pulled.shape[0]):
                add_body(bodies, work.pulled[k], work.pull[k], multipliers[r], out)
            continue
        for side in range(2):
            b = between[r, side]
            if b >= 0:
                add_body(bodies, b, work.jacobian[r, side], multipliers[r], out)


@inner(merged=True)
def _gap_rate(tables: Tables, state: FloatArray, work: Workspace, row: int) -> float:
    """Rate (m/s or rad/s) of the gap of a constraint between two rigid bodies."""
    rate = 0.0
    for side in range(2):
        first = tables.bodies.coordinate[tables.joints.bodies[row, side]]
        for c in range(6):
            rate += work.jacobian[row, side, c] * state[1, first + c]
    return rate


@inner
def _add_closed(
    system: IntArray,
    state: FloatArray,
    inputs: Inputs,
    multipliers: FloatArray,
    level: float,
    out: FloatArray,
) -> None:
    """Add compliance of the pins of a closed track, and torques and residuals of its motors.

    The multiplier of a motor is the torque on its tumbler about that one's axis, with the other sign. It
    follows from the speed that is kept; where the torque is limited, from the lag behind that speed.
    """
    tables, work = read_system(system)
    joints, n = tables.closed, out.shape[0] - multipliers.shape[0]
    for p in range(joints.compliance.shape[0]):
        for r in range(ROWS):
            row = ROWS * p + r
            out[n + row] -= STIFFNESS * joints.compliance[p, r] * multipliers[row]
            if joints.relaxation[p, r] > 0.0:
                out[n + row] += STIFFNESS * joints.relaxation[p, r] * _gap_rate(tables, state, work, row)
    first = multipliers.shape[0] - joints.motors.shape[0]
    for k in range(joints.motors.shape[0]):
        speed = motor_speed(tables.bodies, joints.motors[k], state, work.motors[k])
        torque, lag = multipliers[first + k], inputs.motors[k] - speed
        if joints.limit[k] < np.inf:
            out[n + first + k] = torque + motor_torque(joints, k, lag)[0]
        else:
            out[n + first + k] = -STIFFNESS * level * lag
        for side in range(2):
            place = tables.bodies.coordinate[joints.motors[k, side]] + 3
            for c in range(3):
                out[place + c] += torque * work.motors[k, side, c]


@kernel
def residual(
    system: IntArray,
    state: FloatArray,
    multipliers: FloatArray,
    inputs: Inputs,
    weights: Weights,
    out: FloatArray,
) -> None:
    """Write the residual of all equations: forces, then gaps times `STIFFNESS`.

    `system` is a block of `tables.System`.
    `state` (3, coordinates) are coordinates, rates and accelerations, `multipliers` in N and N m; `out`
    (coordinates + multipliers,) is overwritten.
    """
    tables, work = read_system(system)
    bodies = tables.bodies
    # scratch: coordinates of bodies and their modes, rates, accelerations, forces
    rows, tensor = np.zeros((4, work.jacobian.shape[2])), np.empty((3, 3))
    out.fill(0.0)
    # elements leave those of other weights, which would be taken for masses
    if weights.acceleration != 0.0 and weights.position == weights.velocity == 0.0:
        for kind in range(len(work.elements)):
            work.elements[kind].tangent.fill(0.0)
    write_angles(bodies, state[0])
    work.counts[0] = units.unit_contacts(
        bodies, tables.flexible, tables.terrain, tables.contact, state, weights, work.units
    )
    cells.cell_forces(tables.cells, bodies, state, weights, work.cells)
    work.counts[1] = teeth.teeth_contacts(tables.teeth, bodies, tables.markers, state, weights, work.teeth)
    work.counts[2] = wheels.wheel_contacts(tables.wheels, bodies, state, inputs.drag, weights, work.wheels)
    for kind in range(len(work.elements)):
        _add_rows(bodies, work.elements[kind], work.counts[kind], rows[0], out)
    inertias = work.first, work.second, work.turning
    add_bodies(bodies, tables.modes, state, inputs.gravity, inertias, rows, tensor, out)
    units.add_terrain(
        tables.terrain, work.elements[0], work.counts[0], state, inputs.gravity[2], work.units, out
    )
    loads.add_loads(bodies, tables.markers, tables.loads, inputs.loads, inputs.shift, state, out)
    markers, closed = tables.markers, tables.closed.motors.shape[0] > 0
    joints.add_pins(bodies, markers, tables.joints.pins, closed, state, rows, work.gap, work.jacobian)
    joints.add_speeds(bodies, markers, tables.joints, state, inputs.speeds, rows, work.gap, work.jacobian)
    joints.add_holds(bodies, tables.joints, state, work.gap, work.jacobian)
    joints.write_pull(tables.pull, bodies, markers, state, work.pulled, work.pull)
    _add_joints(system, inputs, multipliers, weights.level, out)
    for p in range(work.turned.shape[0] if weights.position != 0.0 else 0):
        own, into = multipliers[ROWS * p :], work.turned[p]
        joints.write_turned(bodies, markers, tables.joints.pins[p], closed, own, state, rows[0], into)
    _add_closed(system, state, inputs, multipliers, weights.level, out)


@inner
def _write_motions(
    terrain: units.TerrainTable,
    rows: ForceRows,
    first: int,
    sizes: tuple[int, int, int],
    motions: FloatArray,
    forces: FloatArray,
) -> None:
    """Write motions of elements by the coordinates of their bodies and the terrain's, row under row.

    The first of the elements is given; `forces` get their tangents times these motions.
    """
    kinds = rows.wrench.shape[1]
    forces[:] = 0.0
    for at in range(motions.shape[0]):
        p, r = first + at // kinds, at % kinds
        row, force = motions[at], forces[at]
        second, of_terrain = row[sizes[0] :], row[sizes[0] + sizes[1] :]
        for c in range(sizes[0]):
            row[c] = rows.jacobian[p, 0, r, c]
        for c in range(sizes[1]):
            second[c] = rows.jacobian[p, 1, r, c]
        heave, tilt, u = rows.unit_jacobian[p, r, 0], rows.unit_jacobian[p, r, 1], rows.unit[p]
        for k in range(sizes[2]):
            of_terrain[k] = heave * terrain.heave[u, k] + tilt * terrain.tilt[u, k]
        for k in range(kinds):
            factor, force = rows.tangent[p, k, r], forces[at - r + k]
            # a node of a grid knows its neighbours alone
            if factor != 0.0:
                for c in range(row.shape[0]):
                    force[c] += factor * row[c]


@inner
def _add_block(
    places: FrontRows,
    fronts: elimination.Fronts,
    numbers: tuple[int, int, int],
    sizes: tuple[int, int, int],
    block: FloatArray,
    into: IntArray,
    values: FloatArray,
) -> None:
    """Add a tangent by the coordinates of two bodies and the terrain; `numbers` are of front and bodies."""
    f, a, b = numbers
    matrix, met = elimination.front(fronts, values, f), elimination.marks(fronts, values, f)
    firsts, k = (places.body[f, a], places.body[f, b], places.terrain[f]), 0
    for part in range(3):
        for c in range(sizes[part]):
            into[k] = firsts[part] + c
            k += 1
    for r in range(block.shape[0]):
        row, to, k = block[r], matrix[into[r]], 0
        for part in range(3):
            there, here = to[firsts[part] :], row[k:]
            for c in range(sizes[part]):
                there[c] += here[c]
            k += sizes[part]
        c = 0
        while c < k and row[c] == 0.0 and block[c, r] == 0.0:
            c += 1
        if c < k:
            met[into[r]] = 1.0


@inner(allocates=True)
def _add_elements(system: IntArray, kind: int, values: FloatArray) -> None:
    """Add the tangents of elements, those of the same bodies that follow each other at once: ``J^T K J``."""
    tables, work = read_system(system)
    rows, count = work.elements[kind], work.counts[kind]
    if count == 0:
        return
    places, modal, terrain, first = tables.rows, tables.bodies.modal, tables.terrain, 0
    kinds, m = rows.jacobian.shape[2:]
    width = 2 * m + terrain.heave.shape[1]
    into, scratch = np.empty(width, dtype=np.int64), np.empty((3, max(kinds * count, width) * width))
    for last in range(1, count + 1):
        a, b = rows.bodies[first, 0], rows.bodies[first, 1]
        if last < count and rows.bodies[last, 0] == a and rows.bodies[last, 1] == b:
            continue
        sizes = (
            m if modal[a] >= 0 else 6,
            0 if b < 0 else (m if modal[b] >= 0 else 6),
            terrain.heave.shape[1] if rows.unit[first] >= 0 else 0,
        )
        n, length = sizes[0] + sizes[1] + sizes[2], kinds * (last - first)
        motions = scratch[0, : n * length].reshape((length, n))
        forces = scratch[1, : n * length].reshape((length, n))
        block = scratch[2, : n * n].reshape((n, n))
        _write_motions(terrain, rows, first, sizes, motions, forces)
        np.dot(motions.T, forces, block)
        f = places.front[a] if b < 0 else min(places.front[a], places.front[b])
        _add_block(places, tables.fronts, (f, a, b), sizes, block, into, values)
        first = last


@inner
def _add_joint_rows(system: IntArray, inputs: Inputs, weights: Weights, values: FloatArray) -> None:
    """Add the Jacobians of all constraints, and the directions of their forces, to the fronts."""
    tables, work = read_system(system)
    places, fronts, modal, m = tables.rows, tables.fronts, tables.bodies.modal, work.jacobian.shape[2]
    between, pulls = tables.joints.bodies, work.pulled.shape[0] > 0
    pins, last = ROWS * tables.joints.pins.shape[0], fronts.own.shape[0] - 1
    # a constraint on velocity answers a change of the coordinates by its rate
    speed = STIFFNESS * weights.level * (weights.velocity if weights.velocity != 0.0 else 1.0)
    for side in range(2):
        held = -1
        matrix = elimination.front(fronts, values, last)
        for r in range(between.shape[0]):
            is_speed, b = pins <= r < pins + 2, between[r, side]
            if b < 0 or (is_speed and inputs.active[r - pins] <= 0.0):
                continue
            f = places.front[b]
            if f != held:
                matrix, held = elimination.front(fronts, values, f), f
            row, base, factor = places.multiplier[f, r], places.body[f, b], speed if is_speed else STIFFNESS
            elimination.marks(fronts, values, f)[row] = 1.0
            for c in range(m if modal[b] >= 0 else 6):
                matrix[row, base + c] += factor * work.jacobian[r, side, c]
                if not (pulls and r == pins):
                    matrix[base + c, row] += work.jacobian[r, side, c]
    for k in range(2):
        if inputs.active[k] <= 0.0:
            row = places.multiplier[last, pins + k]
            elimination.front(fronts, values, last)[row, row] += 1.0
    for k in range(work.pulled.shape[0]):
        b = work.pulled[k]
        f = places.front[b]
        matrix = elimination.front(fronts, values, f)
        row, base = places.multiplier[f, pins], places.body[f, b]
        for c in range(m if modal[b] >= 0 else 6):
            if work.pull[k, c] != 0.0:
                matrix[base + c, row] += work.pull[k, c]
                elimination.marks(fronts, values, f)[row] = 1.0


@inner
def _add_turned(system: IntArray, by_place: float, values: FloatArray) -> None:
    """Add how the moments of the pins' forces change as their bodies turn to the fronts."""
    tables, work = read_system(system)
    places = tables.rows
    for p in range(work.turned.shape[0]):
        for side in range(2):
            b = tables.joints.bodies[ROWS * p, side]
            own = elimination.front(tables.fronts, values, places.front[b])
            place = places.body[places.front[b], b] + 3
            for r in range(3):
                for c in range(3):
                    own[place + r, place + c] += by_place * work.turned[p, side, r, c]


@inner
def _add_closed_rows(
    system: IntArray, state: FloatArray, inputs: Inputs, weights: Weights, values: FloatArray
) -> None:
    """Add compliance of the pins and rows of the motors of a closed track to the fronts."""
    tables, work = read_system(system)
    joints, places, fronts = tables.closed, tables.rows, tables.fronts
    for p in range(joints.compliance.shape[0]):
        f = places.front[tables.joints.bodies[ROWS * p, 0]]
        matrix = elimination.front(fronts, values, f)
        for r in range(ROWS):
            row = places.multiplier[f, ROWS * p + r]
            matrix[row, row] -= STIFFNESS * joints.compliance[p, r]
            rate = STIFFNESS * weights.velocity * joints.relaxation[p, r]
            for side in range(2 if rate > 0.0 else 0):
                place = places.body[f, tables.joints.bodies[ROWS * p, side]]
                for c in range(6):
                    matrix[row, place + c] += rate * work.jacobian[ROWS * p + r, side, c]
    first = work.gap.shape[0] - joints.motors.shape[0]
    velocity = weights.velocity if weights.velocity != 0.0 else 1.0
    for k in range(joints.motors.shape[0]):
        factor = STIFFNESS * weights.level * velocity
        f = places.front[joints.motors[k, 1]]
        matrix, row = elimination.front(fronts, values, f), places.multiplier[f, first + k]
        if joints.limit[k] < np.inf:
            speed = motor_speed(tables.bodies, joints.motors[k], state, work.motors[k])
            factor = -weights.velocity * motor_torque(joints, k, inputs.motors[k] - speed)[1]
            matrix[row, row] += 1.0
        for side in range(2):
            place = places.body[f, joints.motors[k, side]] + 3
            for c in range(3):
                matrix[row, place + c] += factor * work.motors[k, side, c]
                matrix[place + c, row] += work.motors[k, side, c]


@inner
def _add_masses(system: IntArray, weights: Weights, values: FloatArray) -> None:
    """Add masses, stiffness and damping of bodies and terrain to the fronts."""
    tables, work = read_system(system)
    terrain, places, order, last = tables.terrain, tables.rows, tables.fronts, tables.fronts.own.shape[0] - 1
    for b in range(tables.bodies.mass.shape[0]):
        inertia, f = bodies.Inertia(work.first[b], work.second[b], work.turning[b]), places.front[b]
        at, own = attitude_of(tables.bodies, b), elimination.front(order, values, f)
        bodies.add_body_matrix(tables.bodies, b, tables.modes, at, inertia, weights, places.body[f, b], own)
    whole, first = elimination.front(order, values, last), places.terrain[last]
    for i in range(terrain.heave.shape[1]):
        whole[first + i, first + i] += weights.acceleration
        for k in range(terrain.heave.shape[1]):
            supports = weights.position * terrain.stiffness[i, k] + weights.velocity * terrain.damping[i, k]
            whole[first + i, first + k] += supports


@kernel
def matrix(system: IntArray, state: FloatArray, inputs: Inputs, weights: Weights, fronts: FloatArray) -> None:
    """Write the weighted derivative of the residual into the values of the fronts (size,).

    Arguments are as of `residual`, which was called with the same weights just before and at the same state.
    """
    tables, work = read_system(system)
    elimination.clear(tables.fronts, fronts)
    _add_masses(system, weights, fronts)
    for kind in range(len(work.elements)):
        _add_elements(system, kind, fronts)
    _add_joint_rows(system, inputs, weights, fronts)
    _add_turned(system, weights.position, fronts)
    _add_closed_rows(system, state, inputs, weights, fronts)
