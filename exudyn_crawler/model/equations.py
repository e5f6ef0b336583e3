"""Equations of motion of a system of tables: residual, and matrix of its weighted derivatives.

The unknowns are the coordinates, in the order of `model.state`, then the multipliers of the joints. The
residual of a coordinate is inertia less forces plus constraint forces; that of a multiplier is given by its
row of a joint. Both are sums over bodies, terrain, loads and rows.

The matrix is exact except for three effects, which change over seconds and not over a step. The first is the
rotation and motion of the forces of constraints (except moments of pins), loads and wheels with the bodies.
The second is the change of centrifugal and gyroscopic forces with the rates, the third the motion of the
outline of an overlap. The residual has all of them, so that they cost iterations and not accuracy.
"""

import numpy as np

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.packed import FloatArray, IntArray
from exudyn_crawler.ground.rows import ForceRows, Weights
from exudyn_crawler.model import bodies, elimination, kinds, terrain
from exudyn_crawler.model.bodies import Bodies, add_bodies, add_body, attitude_of, write_angles
from exudyn_crawler.model.forces import loads
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.rows import ACTED_ON, STIFFNESS, JointRows, Motion, gap_rate
from exudyn_crawler.model.tables import FrontRows, read_system


@inner
def _add_forces(
    bodies: Bodies, rows: ForceRows, row: FloatArray, on_terrain: FloatArray, residual: FloatArray
) -> None:
    """Subtract the forces of rows on their bodies from the residual, and add those on units of the terrain.

    `on_terrain` (units, 2) are forces on heave and tilt; `row` (6 + m,) is scratch.
    """
    for p in range(rows.acting[0]):
        for side in range(2):
            b = rows.bodies[p, side]
            if b >= 0:
                last = row.shape[0] if bodies.modal[b] >= 0 else 6
                row.fill(0.0)
                for r in range(rows.wrench.shape[1]):
                    for c in range(last):
                        row[c] += rows.jacobian[p, side, r, c] * rows.wrench[p, r]
                add_body(bodies, b, row, -1.0, residual)
        unit = rows.unit[p]
        if unit >= 0:
            for c in range(2):
                for r in range(rows.wrench.shape[1]):
                    on_terrain[unit, c] += rows.unit_jacobian[p, r, c] * rows.wrench[p, r]


@inner
def _add_joints(
    bodies: Bodies, rows: JointRows, state: FloatArray, multipliers: FloatArray, out: FloatArray
) -> None:
    """Add the forces of all constraints, and write their residuals behind those of the coordinates."""
    n = out.shape[0] - multipliers.shape[0]
    for r in range(multipliers.shape[0]):
        multiplier = multipliers[r]
        residual = rows.scale[r] * rows.gap[r] + rows.share[r] * multiplier
        if rows.relaxation[r] > 0.0:
            residual += STIFFNESS * rows.relaxation[r] * gap_rate(bodies, rows, r, state)
        out[n + r] = residual
        d = rows.directed[r]
        for side in range(2 if d < 0 else ACTED_ON):
            b = rows.bodies[r, side] if d < 0 else rows.acted_on[d, side]
            if b >= 0:
                along = rows.jacobian[r, side] if d < 0 else rows.directions[d, side]
                add_body(bodies, b, along, multiplier, out)


@kernel
def residual(
    system: IntArray,
    state: FloatArray,
    multipliers: FloatArray,
    inputs: Inputs,
    weights: Weights,
    out: FloatArray,
) -> None:
    """Write the residual of all equations: forces, then the residuals of the rows of joints.

    `system` is a block of `tables.System`. `state` (3, coordinates) are coordinates, rates and accelerations,
    `multipliers` in N and N m; `out` (coordinates + multipliers,) is overwritten.
    """
    tables = read_system(system).tables
    work = read_system(system).work
    bodies = tables.bodies
    markers = tables.markers
    # scratch: coordinates of bodies and their modes, rates, accelerations, forces
    rows = np.zeros((4, work.joints.jacobian.shape[2]))
    tensor = np.empty((3, 3))
    out.fill(0.0)
    on_terrain = work.on_terrain
    on_terrain.fill(0.0)
    # elements leave those of other weights, which would be taken for masses
    if weights.acceleration != 0.0 and weights.position == weights.velocity == 0.0:
        for kind in range(len(work.forces.rows)):
            work.forces.rows[kind].tangent.fill(0.0)
    write_angles(bodies, state[0])
    kinds.write_forces(tables.forces, tables.terrain, bodies, markers, state, inputs, weights, work.forces)
    for kind in range(len(work.forces.rows)):
        _add_forces(bodies, work.forces.rows[kind], rows[0], on_terrain, out)
    inertias = work.first, work.second, work.turning
    add_bodies(bodies, tables.modes, state, inputs.gravity, inertias, rows, tensor, out)
    terrain.add_terrain(tables.terrain, state, inputs.gravity[2], on_terrain, out)
    loads.add_loads(bodies, markers, tables.loads, inputs.loads, inputs.shift, state, out)
    motion = Motion(state, multipliers, inputs, weights)
    kinds.write_joints(tables.joints, bodies, markers, motion, work.joints)
    _add_joints(bodies, work.joints, state, multipliers, out)


@inner
def _write_motions(
    ground: terrain.TerrainTable,
    rows: ForceRows,
    first: int,
    sizes: tuple[int, int, int],
    motions: FloatArray,
    forces: FloatArray,
) -> None:
    """Write the motions of elements by the coordinates of their bodies and of the terrain, row under row.

    `first` is the first of the elements; `forces` receive the tangents times these motions.
    """
    kinds = rows.wrench.shape[1]
    forces[:] = 0.0
    for slot in range(motions.shape[0]):
        p, r = first + slot // kinds, slot % kinds
        row = motions[slot]
        force = forces[slot]
        second = row[sizes[0] :]
        of_terrain = row[sizes[0] + sizes[1] :]
        for c in range(sizes[0]):
            row[c] = rows.jacobian[p, 0, r, c]
        for c in range(sizes[1]):
            second[c] = rows.jacobian[p, 1, r, c]
        heave = rows.unit_jacobian[p, r, 0]
        tilt = rows.unit_jacobian[p, r, 1]
        u = rows.unit[p]
        for k in range(sizes[2]):
            of_terrain[k] = heave * ground.heave[u, k] + tilt * ground.tilt[u, k]
        for k in range(kinds):
            factor = rows.tangent[p, k, r]
            force = forces[slot - r + k]
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
    matrix = elimination.front(fronts, values, f)
    has_term = elimination.terms(fronts, values, f)
    firsts = (places.body[f, a], places.body[f, b], places.terrain[f])
    k = 0
    for part in range(3):
        for c in range(sizes[part]):
            into[k] = firsts[part] + c
            k += 1
    for r in range(block.shape[0]):
        row = block[r]
        to = matrix[into[r]]
        k = 0
        for part in range(3):
            there = to[firsts[part] :]
            here = row[k:]
            for c in range(sizes[part]):
                there[c] += here[c]
            k += sizes[part]
        c = 0
        while c < k and row[c] == 0.0 and block[c, r] == 0.0:
            c += 1
        if c < k:
            has_term[into[r]] = 1


@inner(allocates=True)
def _add_elements(system: IntArray, kind: int, values: FloatArray) -> None:
    """Add the tangents of elements, ``J^T K J``; consecutive ones of the same bodies are added at once."""
    tables = read_system(system).tables
    work = read_system(system).work
    rows = work.forces.rows[kind]
    count = rows.acting[0]
    if count == 0:
        return
    places = tables.rows
    modal = tables.bodies.modal
    ground = tables.terrain
    fronts = tables.fronts
    first = 0
    motions_each, m = rows.jacobian.shape[2:]
    width = 2 * m + ground.heave.shape[1]
    into = np.empty(width, dtype=np.int64)
    scratch = np.empty((3, max(motions_each * count, width) * width))
    for last in range(1, count + 1):
        a, b = rows.bodies[first, 0], rows.bodies[first, 1]
        if last < count and rows.bodies[last, 0] == a and rows.bodies[last, 1] == b:
            continue
        sizes = (
            m if modal[a] >= 0 else 6,
            0 if b < 0 else (m if modal[b] >= 0 else 6),
            ground.heave.shape[1] if rows.unit[first] >= 0 else 0,
        )
        n = sizes[0] + sizes[1] + sizes[2]
        length = motions_each * (last - first)
        motions = scratch[0, : n * length].reshape((length, n))
        forces = scratch[1, : n * length].reshape((length, n))
        block = scratch[2, : n * n].reshape((n, n))
        _write_motions(ground, rows, first, sizes, motions, forces)
        np.dot(motions.T, forces, block)
        f = places.front[a] if b < 0 else min(places.front[a], places.front[b])
        _add_block(places, fronts, (f, a, b), sizes, block, into, values)
        first = last


@inner
def _add_joint_rows(system: IntArray, velocity: float, values: FloatArray) -> None:
    """Add the Jacobians of all constraints, and the directions of their forces, to the fronts.

    `velocity` is the weight of the derivatives by rates.
    """
    tables = read_system(system).tables
    work = read_system(system).work
    places = tables.rows
    fronts = tables.fronts
    modal = tables.bodies.modal
    rows = work.joints
    last = fronts.pivots.shape[0] - 1
    m = rows.jacobian.shape[2]
    for side in range(2):
        held = -1
        matrix = elimination.front(fronts, values, last)
        for r in range(rows.gap.shape[0]):
            b = rows.bodies[r, side]
            if b < 0:
                continue
            f = places.front[b]
            if f != held:
                matrix = elimination.front(fronts, values, f)
                held = f
            row = places.multiplier[f, r]
            base = places.body[f, b]
            elimination.terms(fronts, values, f)[row] = 1
            for c in range(m if modal[b] >= 0 else 6):
                matrix[row, base + c] += rows.slope[r] * rows.jacobian[r, side, c]
                if rows.directed[r] < 0:
                    matrix[base + c, row] += rows.jacobian[r, side, c]
    for r in range(rows.gap.shape[0]):
        first = rows.bodies[r, 0]
        f = places.front[first] if first >= 0 else last
        row = places.multiplier[f, r]
        rate = STIFFNESS * velocity * rows.relaxation[r]
        if rows.share[r] != 0.0:
            elimination.front(fronts, values, f)[row, row] += rows.share[r]
        for side in range(2 if rate > 0.0 else 0):
            place = places.body[f, rows.bodies[r, side]]
            for c in range(6):
                elimination.front(fronts, values, f)[row, place + c] += rate * rows.jacobian[r, side, c]
        if rows.directed[r] >= 0:
            _add_directions(system, r, values)
    for k in range(rows.loaded.shape[0]):
        r = rows.loaded[k, 0]
        f = places.front[rows.bodies[r, 0]]
        for c in range(3):
            column = places.multiplier[f, rows.loaded[k, 1] + c]
            elimination.front(fronts, values, f)[places.multiplier[f, r], column] += rows.by_load[k, c]


@inner
def _add_directions(system: IntArray, r: int, values: FloatArray) -> None:
    """Add the directions of a constraint's force to the fronts if they differ from its Jacobian."""
    tables = read_system(system).tables
    work = read_system(system).work
    places = tables.rows
    fronts = tables.fronts
    modal = tables.bodies.modal
    rows = work.joints
    d = rows.directed[r]
    for k in range(ACTED_ON):
        b = rows.acted_on[d, k]
        if b < 0:
            continue
        f = places.front[b]
        matrix = elimination.front(fronts, values, f)
        row = places.multiplier[f, r]
        base = places.body[f, b]
        for c in range(rows.directions.shape[2] if modal[b] >= 0 else 6):
            if rows.directions[d, k, c] != 0.0:
                matrix[base + c, row] += rows.directions[d, k, c]
                elimination.terms(fronts, values, f)[row] = 1


@inner
def _add_turning(system: IntArray, by_place: float, values: FloatArray) -> None:
    """Add the change of the moments of pins' forces with the rotation of their bodies to the fronts."""
    tables = read_system(system).tables
    work = read_system(system).work
    places = tables.rows
    fronts = tables.fronts
    rows = work.joints
    for p in range(rows.turned.shape[0]):
        for side in range(2):
            b = rows.turned[p, side]
            matrix = elimination.front(fronts, values, places.front[b])
            place = places.body[places.front[b], b] + 3
            for r in range(3):
                for c in range(3):
                    matrix[place + r, place + c] += by_place * rows.turning[p, side, r, c]


@inner
def _add_masses(system: IntArray, weights: Weights, values: FloatArray) -> None:
    """Add masses, stiffness and damping of bodies and terrain to the fronts."""
    tables = read_system(system).tables
    work = read_system(system).work
    places = tables.rows
    fronts = tables.fronts
    last = fronts.pivots.shape[0] - 1
    table = tables.bodies
    modes = tables.modes
    first = work.first
    second = work.second
    turning = work.turning
    for b in range(table.mass.shape[0]):
        inertia = bodies.Inertia(first[b], second[b], turning[b])
        f = places.front[b]
        attitude = attitude_of(table, b)
        matrix = elimination.front(fronts, values, f)
        bodies.add_body_matrix(table, b, modes, attitude, inertia, weights, places.body[f, b], matrix)
    whole = elimination.front(fronts, values, last)
    terrain.add_terrain_matrix(tables.terrain, weights, places.terrain[last], whole)


@kernel
def matrix(system: IntArray, weights: Weights, fronts: FloatArray) -> None:
    """Write the weighted derivative of the residual into the values of the fronts (size,).

    It is taken at the state of the last residual, with the same weights.
    """
    tables = read_system(system).tables
    work = read_system(system).work
    elimination.clear(tables.fronts, fronts)
    _add_masses(system, weights, fronts)
    for kind in range(len(work.forces.rows)):
        _add_elements(system, kind, fronts)
    _add_joint_rows(system, weights.velocity, fronts)
    _add_turning(system, weights.position, fronts)
