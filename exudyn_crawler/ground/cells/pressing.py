"""Forces of the cells on shoes, compiled: wrench and its derivative, trial memory, a coarse grid of forces.

A shoe is a list of points that `tiles.cover` froze for the step: each has a location on the underside, a cell
below it and an area. Nothing here reads or writes the map of the ground. Derivatives neglect the change of
the areas as the outline moves (1 % of them) and the effect of rotating arms on velocities (0.2 % at 0.1
rad/s).
"""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import carray, types
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import ArrayLike

from exudyn_crawler.ground import packed
from exudyn_crawler.ground.cells.law import LawKernel, Memory, Probe, call_at, compile_entry, prepare, respond
from exudyn_crawler.ground.cells.layouts import (
    BENT,
    BENT_WIDTH,
    BLOCK,
    BLOCK_WIDTH,
    FRAME,
    POINT,
    POINT_WIDTH,
    ROW,
    TRIAL,
    TRIAL_WIDTH,
    arm_of,
    frame_at,
    triple_of,
)
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.frames import Frame, Matrix, Vector, along, cross, dot, turned, turned_back
from exudyn_crawler.ground.packed import FloatArray, IntArray

NOTHING = (0.0, 0.0, 0.0)

Law = Any
"""Constants of a law, in the law's own named tuple; its type tells the compiler the law."""


class ShoePoints(NamedTuple):
    """Points of the shoes and the results of the kernel; all arrays stay the same through a run."""

    addresses: packed.Ints1  # (2,): of the compiled law: `prepare` and `press`
    constants: packed.Floats1  # of the law
    corners: packed.Floats2  # (4, 3): of the underside, shoe's frame, anticlockwise from above; of one z, m
    counts: packed.Ints1  # (shoes,): number of points of each shoe
    cells: packed.Ints2  # (shoes, most): cell of each point
    areas: packed.Floats2  # (shoes, most): true area of each point, m2
    points: packed.Floats4  # (shoes, blocks, POINT_WIDTH, BLOCK)
    trial: packed.Floats3  # (shoes, most, TRIAL_WIDTH)
    force: packed.Floats3  # (shoes, most, 3): on the shoe at each point, N, global
    wrench: packed.Floats2  # (shoes, 6): force (N) and moment about the frame's origin (N m), global
    # (shoes, 6, 6): weighted derivative of the wrench by displacements and small rotations, global
    tangent: packed.Floats3
    block: packed.Floats2  # (BLOCK_WIDTH, BLOCK): workspace of the points that are computed together
    # (shoes,): row of each shoe in the next two: all rigid ones share the first, which stays in the cache
    bending: packed.Ints1
    # (1 + flexible shoes, blocks, BENT_WIDTH, BLOCK): motion of the points of flexible shoes
    bent: packed.Floats4
    # (1 + flexible shoes, 9 most): weighted derivative of each point's force by its displacement: array
    # (9, points), its rows one after the other
    slopes: packed.Floats2

    @classmethod
    def allocate(
        cls, law: LawKernel, constants: ArrayLike, corners: ArrayLike, most: int, bending: IntArray
    ) -> "ShoePoints":
        """Return arrays for shoes with at most `most` points each; `bending` is the field of that name."""
        shoes = len(bending)
        bend = 1 + int(bending.max(initial=0))
        blocks = -(-most // BLOCK)
        return cls(
            addresses=np.array(addresses_of(law)),
            constants=np.array(constants, dtype=float),
            corners=np.array(corners, dtype=float),
            counts=np.zeros(shoes, dtype=np.int64),
            cells=np.zeros((shoes, most), dtype=np.int64),
            areas=np.zeros((shoes, most)),
            points=np.zeros((shoes, blocks, POINT_WIDTH, BLOCK)),
            trial=np.zeros((shoes, most, TRIAL_WIDTH)),
            force=np.zeros((shoes, most, 3)),
            wrench=np.zeros((shoes, 6)),
            tangent=np.zeros((shoes, 6, 6)),
            block=np.zeros((BLOCK_WIDTH, BLOCK)),
            bending=bending,
            bent=np.zeros((bend, blocks, BENT_WIDTH, BLOCK)),
            slopes=np.zeros((bend, 9 * most)),
        )


@inner(merged=True)
def _move(points: FloatArray, bent: FloatArray, frame: Frame, size: int, block: FloatArray) -> None:
    """Write the motion of a block's points against the ground, the first rows of its workspace."""
    r, R, v, omega = frame
    for k in range(size):
        n = triple_of(points, POINT.normal, k)
        arm = arm_of(points, bent, k, R)
        x = along(r, 1.0, arm)
        velocity = along(v, 1.0, cross(omega, arm))
        velocity = along(velocity, 1.0, turned(R, triple_of(bent, BENT.rate, k)))
        rate = -dot(n, velocity)
        moved = along(x, -1.0, triple_of(points, POINT.before, k))
        slip = along(moved, -dot(moved, n), n)
        velocity = along(velocity, rate, n)
        block[ROW.depth, k] = points[POINT.ground, k] - dot(n, x)
        block[ROW.rate, k] = rate
        for c in range(3):
            block[ROW.slip + c, k] = slip[c]
            block[ROW.velocity + c, k] = velocity[c]
            block[ROW.arm + c, k] = arm[c]


@inner(merged=True)
def _probe(points: FloatArray, block: FloatArray, k: int) -> Probe:
    """Return the `Probe` of a point of a block whose motion is written."""
    shear = triple_of(points, POINT.shear, k)
    return Probe(
        block[ROW.depth, k],
        block[ROW.rate, k],
        triple_of(block, ROW.slip, k),
        triple_of(block, ROW.velocity, k),
        Memory(points[POINT.deepest, k], points[POINT.pressure, k], shear, points[POINT.mobilized, k]),
        (points[POINT.prepared, k], points[POINT.prepared + 1, k]),
    )


@inner(merged=True)
def _write_response(
    law: Law, points: FloatArray, tangents: bool, nearby: bool, block: FloatArray, trial: FloatArray, k: int
) -> None:
    """Write the response of a law to a point of a block."""
    answer = respond(law, _probe(points, block, k), tangents, nearby)
    memory = answer.memory
    trial[k, TRIAL.deepest] = memory.deepest
    trial[k, TRIAL.pressure] = memory.pressure
    trial[k, TRIAL.shear] = memory.shear[0]
    trial[k, TRIAL.shear + 1] = memory.shear[1]
    trial[k, TRIAL.mobilized] = memory.mobilized
    trial[k, TRIAL.traction] = answer.normal
    block[ROW.normal, k] = answer.normal
    block[ROW.drag, k] = answer.drag
    for c in range(3):
        block[ROW.shear + c, k] = answer.shear[c]
    if tangents:
        block[ROW.by_depth, k] = answer.normal_by_depth
        block[ROW.by_rate, k] = answer.normal_by_rate
        block[ROW.along, k] = answer.along
        block[ROW.across, k] = answer.across
        for c in range(3):
            block[ROW.tangential_by_depth + c, k] = answer.tangential_by_depth[c]
            block[ROW.direction + c, k] = answer.direction[c]


@inner(merged=True)
def _respond(
    law: Law, points: FloatArray, tangents: bool, size: int, block: FloatArray, trial: FloatArray
) -> None:
    """Write a law's response to a block of known motion, and the trial memory."""
    for k in range(size):
        _write_response(law, points, tangents, True, block, trial, k)
    count = 0
    for k in range(size):
        if math.isnan(block[ROW.normal, k]):
            block[ROW.again, count] = k
            count += 1
    for j in range(count):
        _write_response(law, points, tangents, False, block, trial, int(block[ROW.again, j]))


@inner(merged=True)
def _push(points: FloatArray, areas: FloatArray, size: int, block: FloatArray) -> None:
    """Write the forces of a block's points."""
    for k in range(size):
        for c in range(3):
            stress = block[ROW.normal, k] * points[POINT.normal + c, k] - block[ROW.shear + c, k]
            viscous = block[ROW.drag, k] * block[ROW.velocity + c, k]
            block[ROW.force + c, k] = areas[k] * (stress - viscous)


@inner(merged=True)
def _slope(
    points: FloatArray, areas: FloatArray, by_place: float, by_velocity: float, size: int, block: FloatArray
) -> None:
    """Write weighted derivatives of the forces of a block's points by displacements, its last rows.

    They are ``b n' + h m' + c 1``; the depth falls along n.
    """
    for k in range(size):
        position = -areas[k] * by_place
        velocity = -areas[k] * by_velocity
        across = block[ROW.across, k]
        drag = block[ROW.drag, k]
        normal = position * (block[ROW.by_depth, k] - across) + velocity * (block[ROW.by_rate, k] - drag)
        further = position * (block[ROW.along, k] - across)
        for r in range(3):
            b = normal * points[POINT.normal + r, k] - position * block[ROW.tangential_by_depth + r, k]
            h = further * block[ROW.direction + r, k]
            for c in range(3):
                slope = b * points[POINT.normal + c, k] + h * block[ROW.direction + c, k]
                block[ROW.slopes + 3 * r + c, k] = slope
            block[ROW.slopes + 4 * r, k] += position * across + velocity * drag


class PressedShoe(NamedTuple):
    """Arrays of `ShoePoints` of one shoe, or their addresses; the last six are written."""

    points: packed.Floats3
    areas: packed.Floats1
    bent: packed.Floats3
    trial: packed.Floats2
    force: packed.Floats2
    wrench: packed.Floats1
    tangent: packed.Floats2
    slopes: packed.Floats2
    block: packed.Floats2


@inner(merged=True)
def press_shoe(law: Law, count: int, frame: FloatArray, weights: FloatArray, shoe: PressedShoe) -> None:
    """Write the forces of the cells on a shoe with `count` points at a frame (FRAME,).

    `weights` (2,) are those of `press`.
    """
    points = shoe.points
    block = shoe.block
    pose = frame_at(frame)
    by_place = weights[0]
    by_velocity = weights[1]
    tangents = by_place != 0.0 or by_velocity != 0.0
    F = NOTHING
    M = NOTHING
    by_x = NOTHING
    by_y = NOTHING
    for b in range(points.shape[0]):
        first = b * BLOCK
        these = points[b]
        size = min(BLOCK, count - first)
        areas = shoe.areas[first:]
        _move(these, shoe.bent[b], pose, size, block)
        _respond(law, these, tangents, size, block, shoe.trial[first:])
        _push(these, areas, size, block)
        for k in range(size):
            f = triple_of(block, ROW.force, k)
            shoe.force[first + k, 0] = f[0]
            shoe.force[first + k, 1] = f[1]
            shoe.force[first + k, 2] = f[2]
            F = along(F, 1.0, f)
            M = along(M, 1.0, cross(triple_of(block, ROW.arm, k), f))
            if tangents:
                by_x = along(by_x, these[POINT.place, k], f)
                by_y = along(by_y, these[POINT.place + 1, k], f)
        if tangents:
            _slope(these, areas, by_place, by_velocity, size, block)
            for q in range(9):
                for k in range(size):
                    shoe.slopes[q, first + k] = block[ROW.slopes + q, k]
    for i in range(3):
        shoe.wrench[i] = F[i]
        shoe.wrench[3 + i] = M[i]
    if tangents:
        _write_tangent(points, pose.R, by_place, shoe.slopes, (F, by_x, by_y), shoe.tangent)


@inner(allocates=True)
def _write_tangent(
    points: FloatArray,
    R: Matrix,
    by_place: float,
    slopes: FloatArray,
    forces: tuple[Vector, Vector, Vector],
    tangent: FloatArray,
) -> None:
    """Write the derivative of a wrench by motions of its shoe, from those (9, points) of its points.

    The arms are linear in the coordinates X, Y on the underside. The sums of the derivatives times 1, X, Y,
    X2, XY and Y2 therefore suffice for any number of points; `forces` are the sums of the forces times 1, X,
    Y.
    """
    count = slopes.shape[1]
    monomials = np.empty((count, 6))
    for a in range(count):
        X, Y, _ = triple_of(points[a // BLOCK], POINT.place, a % BLOCK)
        monomials[a, 0] = 1.0
        monomials[a, 1] = X
        monomials[a, 2] = Y
        monomials[a, 3] = X * X
        monomials[a, 4] = X * Y
        monomials[a, 5] = Y * Y
    sums = np.dot(slopes, monomials)
    z = points[0, POINT.place + 2, 0] if count > 0 else 0.0
    _congruence(sums, R, z, tangent)
    # the arms rotate while the forces stay: sum of a f' - (a . f) 1
    trace = 0.0
    for j in range(3):
        for i in range(3):
            turning = R[i][0] * forces[1][j] + R[i][1] * forces[2][j] + R[i][2] * z * forces[0][j]
            turning *= by_place
            tangent[3 + i, 3 + j] += turning
            trace += turning if i == j else 0.0
    for i in range(3):
        tangent[3 + i, 3 + i] -= trace


@inner(allocates=True)
def _congruence(sums: FloatArray, R: Matrix, z: float, out: FloatArray) -> None:
    """Write the sum of ``B' g B`` with B = [1, -[arm]x], from sums (9, 6) of g as in `_write_tangent`."""
    first = np.empty((9, 3))
    second = np.empty((9, 3, 3))
    for q in range(9):
        s = sums[q]
        out[q // 3, q % 3] = s[0]
        m = (s[3], s[4], z * s[1]), (s[4], s[5], z * s[2]), (z * s[1], z * s[2], z * z * s[0])
        for k in range(3):
            first[q, k] = R[k][0] * s[1] + R[k][1] * s[2] + R[k][2] * z * s[0]
            u = (dot(R[k], m[0]), dot(R[k], m[1]), dot(R[k], m[2]))
            for p in range(3):
                second[q, k, p] = dot(u, R[p])
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            out[i, 3 + j] = first[3 * i + j2, j1] - first[3 * i + j1, j2]
            out[3 + i, j] = first[3 * i2 + j, i1] - first[3 * i1 + j, i2]
            out[3 + i, 3 + j] = (
                second[3 * i2 + j2, i1, j1]
                - second[3 * i2 + j1, i1, j2]
                - second[3 * i1 + j2, i2, j1]
                + second[3 * i1 + j1, i2, j2]
            )


@inner(merged=True)
def prepare_points(law: Law, count: int, points: FloatArray) -> None:
    """Write `Probe.prepared` of all points of one shoe."""
    for b in range(points.shape[0]):
        for k in range(min(BLOCK, count - b * BLOCK)):
            prepared = prepare(law, points[b, POINT.deepest, k], points[b, POINT.pressure, k])
            points[b, POINT.prepared, k] = prepared[0]
            points[b, POINT.prepared + 1, k] = prepared[1]


@cache
def addresses_of(of_law: LawKernel) -> tuple[int, int]:
    """Return the addresses of `prepare_points` and `press_shoe` compiled for a law."""
    constants_type = of_law.constants
    size = len(of_law.constants._fields)
    numbers = types.CPointer(types.float64)
    shoe_of_numbers = types.NamedUniTuple(numbers, len(PressedShoe._fields), PressedShoe)

    def law_points(constants, count, points):
        law = constants_type(*to_fixed_tuple(carray(constants, (size,)), size))
        blocks = (count + BLOCK - 1) // BLOCK
        prepare_points(law, count, carray(points, (blocks, POINT_WIDTH, BLOCK)))
        return 0

    def law_press(constants, count, frame, weights, at):
        law = constants_type(*to_fixed_tuple(carray(constants, (size,)), size))
        blocks = (count + BLOCK - 1) // BLOCK
        shoe = PressedShoe(
            points=carray(at.points, (blocks, POINT_WIDTH, BLOCK)),
            areas=carray(at.areas, (count,)),
            bent=carray(at.bent, (blocks, BENT_WIDTH, BLOCK)),
            trial=carray(at.trial, (count, TRIAL_WIDTH)),
            force=carray(at.force, (count, 3)),
            wrench=carray(at.wrench, (6,)),
            tangent=carray(at.tangent, (6, 6)),
            slopes=carray(at.slopes, (9, count)),
            block=carray(at.block, (BLOCK_WIDTH, BLOCK)),
        )
        press_shoe(law, count, carray(frame, (FRAME,)), carray(weights, (2,)), shoe)
        return 0

    return (
        compile_entry(of_law, law_points, (numbers, types.intp, numbers)),
        compile_entry(of_law, law_press, (numbers, types.intp, numbers, numbers, shoe_of_numbers)),
    )


@kernel
def press(shoes: ShoePoints, frames: FloatArray, weights: FloatArray) -> None:
    """Write wrenches, tangents, forces and trial memory of all shoes at their frames (shoes, FRAME).

    `weights` (2,) are those of the derivatives by displacements and by velocities; if both are zero, the
    tangents are not written.
    """
    for s in range(shoes.counts.shape[0]):
        row = shoes.bending[s]
        shoe = PressedShoe(
            points=shoes.points[s],
            areas=shoes.areas[s],
            bent=shoes.bent[row],
            trial=shoes.trial[s],
            force=shoes.force[s],
            wrench=shoes.wrench[s],
            tangent=shoes.tangent[s],
            slopes=shoes.slopes[row],
            block=shoes.block,
        )
        call_at(shoes.addresses[1], shoes.constants, shoes.counts[s], frames[s], weights, shoe)


class Hats(NamedTuple):
    """Mesh of an even grid around a point: its first node, and the coordinates in it; bilinear hats."""

    i: int
    j: int
    u: float
    v: float


@inner
def hats_at(low: FloatArray, high: FloatArray, last: tuple[int, int], x: float, y: float) -> Hats:
    """Return the mesh of a point (m, the shoe's frame) in a grid with corners `low` and `high`."""
    u = (x - low[0]) / (high[0] - low[0]) * last[0]
    v = (y - low[1]) / (high[1] - low[1]) * last[1]
    i, j = min(max(int(u), 0), last[0] - 1), min(max(int(v), 0), last[1] - 1)
    return Hats(i, j, u - i, v - j)


@inner
def share_of(hats: Hats, k: int) -> float:
    """Return the weight of the k-th node of a mesh at a point."""
    u = hats.u if k >= 2 else 1.0 - hats.u
    return u * (hats.v if k % 2 == 1 else 1.0 - hats.v)


@inner
def spread_forces(
    points: FloatArray,
    forces: FloatArray,
    low: FloatArray,
    high: FloatArray,
    nodes: FloatArray,
) -> None:
    """Add forces (count, 3) at the points of a shoe to the nodes (a, b, 3) of its grid, global, N.

    A force goes to the four nodes around its point. This keeps forces and moments, and bending moments at the
    lines of nodes.
    """
    last = nodes.shape[0] - 1, nodes.shape[1] - 1
    for a in range(forces.shape[0]):
        x, y, _ = triple_of(points[a // BLOCK], POINT.place, a % BLOCK)
        hats = hats_at(low, high, last, x, y)
        for k in range(4):
            i = hats.i + k // 2
            j = hats.j + k % 2
            share = share_of(hats, k)
            for c in range(3):
                nodes[i, j, c] += share * forces[a, c]


@kernel
def coarse_forces(shoes: ShoePoints, frames: FloatArray, out: FloatArray) -> None:
    """Write the forces on a grid of the undersides (shoes, a, b, 3): N, in the axes of each shoe.

    The nodes divide the underside evenly, from its least x and y to its greatest.
    """
    out.fill(0.0)
    low = shoes.corners[0]
    high = shoes.corners[2]
    for s in range(out.shape[0]):
        R = frame_at(frames[s]).R
        count = shoes.counts[s]
        spread_forces(shoes.points[s], shoes.force[s, :count], low, high, out[s])
        for i in range(out.shape[1]):
            for j in range(out.shape[2]):
                force = turned_back(R, (out[s, i, j, 0], out[s, i, j, 1], out[s, i, j, 2]))
                out[s, i, j, 0] = force[0]
                out[s, i, j, 1] = force[1]
                out[s, i, j, 2] = force[2]
