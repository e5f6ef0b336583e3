"""Forces of the cells on shoes, compiled: wrench and its derivative, trial memory, a coarse grid of forces.

A shoe is a list of points that `tiles.cover` froze for the step: a place on its underside, the cell below
it and the area that it stands for. Nothing here reads or writes the map of the ground. Derivatives leave out
how the areas change as the outline moves (1 % of them) and how turning arms turn velocities (0.2 % at 0.1
rad/s).
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from numba import carray, types
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import ArrayLike

from exudyn_crawler.ground import frames, packed
from exudyn_crawler.ground.cells import law
from exudyn_crawler.ground.cells.law import LawKernel, compile_entry, prepare, respond
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.frames import along, cross, dot, turned, turned_back
from exudyn_crawler.ground.packed import FloatArray, IntArray

PLACE, NORMAL, GROUND, BEFORE, DEEPEST, PREPARED, SHEAR, MOBILIZED = 0, 3, 6, 7, 10, 12, 14, 17
"""First row of what a point is: its place in the shoe's frame (m), the cell's normal, the distance of the
cell's plane from the origin along it (m), where the place was when a step was last accepted (m, global); and
the cell's memory: greatest sinkage and pressure, `Probe.prepared`, shear and mobilized share."""
POINT = 18
BLOCK = 64
"""Points of a shoe that stand together, a row for each number: processors take several at once."""
TRIAL, TRACTION = 6, 5
"""Trial memory of a point: greatest sinkage, pressure, shear along x and y, mobilized share; and beside it,
in the column `TRACTION`, the normal traction on the shoe (Pa)."""
DEPTH, RATE, SLIP, VELOCITY, ARM, FORCE = 0, 1, 2, 5, 8, 11
"""First row of what the workspace of a block has: as of `Probe`, places of the points from their shoe's
origin (m, global), forces there (N);"""
NORMAL_STRESS, STRESS, DRAG, BY_DEPTH, BY_RATE = 14, 15, 18, 19, 20
"""as of `Response`, normal traction, shear, drag, and derivatives of the first by depth and rate;"""
COUPLED, ALONG, ACROSS, TOWARDS, SLOPES, AGAIN, ROWS = 21, 24, 25, 26, 29, 38, 39
"""`tangential_by_depth`, `along`, `across` and `direction`; `ShoePoints.slopes`; points that the law is asked
about again; and the number of rows."""
NOTHING = (0.0, 0.0, 0.0)
FRAME = 18
"""Numbers of a frame: r (m), the rows of R, v (m/s) and omega (rad/s), global."""


class ShoePoints(NamedTuple):
    """Points of the shoes and what the kernel makes of them; all arrays stay the same through a run."""

    addresses: packed.Ints1  # (2,): of the compiled law: `prepare` and `press`
    constants: packed.Floats1  # of the law
    corners: packed.Floats2  # (4, 3): of the underside, shoe's frame, anticlockwise from above; of one z, m
    counts: packed.Ints1  # (shoes,): number of points of each shoe
    cells: packed.Ints2  # (shoes, most): cell of each point
    areas: packed.Floats2  # (shoes, most): true area of each point, m2
    points: packed.Floats4  # (shoes, blocks, POINT, BLOCK)
    trial: packed.Floats3  # (shoes, most, TRIAL)
    force: packed.Floats3  # (shoes, most, 3): on the shoe at each point, N, global
    wrench: packed.Floats2  # (shoes, 6): force (N) and moment about the frame's origin (N m), global
    tangent: (
        packed.Floats3
    )  # (shoes, 6, 6): its weighted derivative by displacements and small rotations, global
    block: packed.Floats2  # (ROWS, BLOCK): workspace of the points that are computed together
    # (shoes,): row of each shoe in the next two: all rigid ones share the first, which stays in the cache
    bending: packed.Ints1
    # (1 + flexible shoes, blocks, 6, BLOCK): displacement of the points of flexible shoes by their modes (m),
    # and its rate (m/s), shoes' axes
    bent: packed.Floats4
    # (1 + flexible shoes, 9 most): weighted derivative of each point's force by its displacement: array
    # (9, points), its rows one after the other
    slopes: packed.Floats2

    @classmethod
    def allocate(
        cls, law: LawKernel, constants: ArrayLike, corners: ArrayLike, most: int, bending: IntArray
    ) -> "ShoePoints":
        """Arrays of shoes with so many points at most each, on cells of a law; `bending` is as above."""
        shoes, bend, blocks = len(bending), 1 + int(bending.max(initial=0)), -(-most // BLOCK)
        return cls(
            addresses=np.array(addresses_of(law)),
            constants=np.array(constants, dtype=float),
            corners=np.array(corners, dtype=float),
            counts=np.zeros(shoes, dtype=np.int64),
            cells=np.zeros((shoes, most), dtype=np.int64),
            areas=np.zeros((shoes, most)),
            points=np.zeros((shoes, blocks, POINT, BLOCK)),
            trial=np.zeros((shoes, most, TRIAL)),
            force=np.zeros((shoes, most, 3)),
            wrench=np.zeros((shoes, 6)),
            tangent=np.zeros((shoes, 6, 6)),
            block=np.zeros((ROWS, BLOCK)),
            bending=bending,
            bent=np.zeros((bend, blocks, 6, BLOCK)),
            slopes=np.zeros((bend, 9 * most)),
        )


@inner
def frame_at(row: FloatArray) -> frames.Frame:
    """Frame of its numbers."""
    rows = (row[3], row[4], row[5]), (row[6], row[7], row[8]), (row[9], row[10], row[11])
    return frames.Frame(
        (row[0], row[1], row[2]), rows, (row[12], row[13], row[14]), (row[15], row[16], row[17])
    )


@inner
def arm_of(points: FloatArray, bent: FloatArray, k: int, R: frames.Matrix) -> frames.Vector:
    """Place of a point of a block from its shoe's origin, m, global."""
    return turned(R, (points[0, k] + bent[0, k], points[1, k] + bent[1, k], points[2, k] + bent[2, k]))


@inner(merged=True, cached=False)
def _move(points, bent, at, size, block):
    """Write how the points of a block move against the ground, the first rows of its workspace."""
    r, R, v, omega = at
    for k in range(size):
        n = (points[NORMAL, k], points[NORMAL + 1, k], points[NORMAL + 2, k])
        arm = arm_of(points, bent, k, R)
        x = along(r, 1.0, arm)
        velocity = along(v, 1.0, cross(omega, arm))
        velocity = along(velocity, 1.0, turned(R, (bent[3, k], bent[4, k], bent[5, k])))
        rate = -dot(n, velocity)
        moved = (x[0] - points[BEFORE, k], x[1] - points[BEFORE + 1, k], x[2] - points[BEFORE + 2, k])
        slip, velocity = along(moved, -dot(moved, n), n), along(velocity, rate, n)
        block[DEPTH, k], block[RATE, k] = points[GROUND, k] - dot(n, x), rate
        for c in range(3):
            block[SLIP + c, k], block[VELOCITY + c, k], block[ARM + c, k] = slip[c], velocity[c], arm[c]


@inner(merged=True, cached=False)
def _probe(points, block, k):
    """`Probe` of a point of a block that moves."""
    shear = (points[SHEAR, k], points[SHEAR + 1, k], points[SHEAR + 2, k])
    return law.Probe(
        block[DEPTH, k],
        block[RATE, k],
        (block[SLIP, k], block[SLIP + 1, k], block[SLIP + 2, k]),
        (block[VELOCITY, k], block[VELOCITY + 1, k], block[VELOCITY + 2, k]),
        law.Memory(points[DEEPEST, k], points[DEEPEST + 1, k], shear, points[MOBILIZED, k]),
        (points[PREPARED, k], points[PREPARED + 1, k]),
    )


@inner(merged=True, cached=False)
def _write_answer(law, points, tangents, nearby, block, trial, k):
    """Write what the law answers to a point."""
    answer = respond(law, _probe(points, block, k), tangents, nearby)
    memory = answer.memory
    trial[k, 0], trial[k, 1] = memory.deepest, memory.pressure
    trial[k, 2], trial[k, 3], trial[k, 4] = memory.shear[0], memory.shear[1], memory.mobilized
    trial[k, TRACTION] = block[NORMAL_STRESS, k] = answer.normal
    block[DRAG, k] = answer.drag
    for c in range(3):
        block[STRESS + c, k] = answer.shear[c]
    if tangents:
        block[BY_DEPTH, k], block[BY_RATE, k] = answer.normal_by_depth, answer.normal_by_rate
        block[ALONG, k], block[ACROSS, k] = answer.along, answer.across
        for c in range(3):
            block[COUPLED + c, k], block[TOWARDS + c, k] = answer.tangential_by_depth[c], answer.direction[c]


@inner(merged=True, cached=False)
def _answer(law, points, tangents, size, block, trial):
    """Write what the law answers to a block that moves, and the memory on trial."""
    for k in range(size):
        _write_answer(law, points, tangents, True, block, trial, k)
    count = 0
    for k in range(size):
        if math.isnan(block[NORMAL_STRESS, k]):
            block[AGAIN, count] = k
            count += 1
    for j in range(count):
        _write_answer(law, points, tangents, False, block, trial, int(block[AGAIN, j]))


@inner(merged=True, cached=False)
def _push(points, areas, size, block):
    """Write the forces of a block's points."""
    for k in range(size):
        for c in range(3):
            stress = block[NORMAL_STRESS, k] * points[NORMAL + c, k] - block[STRESS + c, k]
            block[FORCE + c, k] = areas[k] * (stress - block[DRAG, k] * block[VELOCITY + c, k])


@inner(merged=True, cached=False)
def _slope(points, areas, by_place, by_velocity, size, block):
    """Write the weighted derivatives of the forces of a block's points by displacements, its last rows.

    They are ``b n' + h m' + c 1``; the depth falls along n.
    """
    for k in range(size):
        position, velocity = -areas[k] * by_place, -areas[k] * by_velocity
        across, drag = block[ACROSS, k], block[DRAG, k]
        normal = position * (block[BY_DEPTH, k] - across) + velocity * (block[BY_RATE, k] - drag)
        further = position * (block[ALONG, k] - across)
        for r in range(3):
            b = normal * points[NORMAL + r, k] - position * block[COUPLED + r, k]
            h = further * block[TOWARDS + r, k]
            for c in range(3):
                block[SLOPES + 3 * r + c, k] = b * points[NORMAL + c, k] + h * block[TOWARDS + c, k]
            block[SLOPES + 4 * r, k] += position * across + velocity * drag


class PressedShoe(NamedTuple):
    """Arrays of `ShoePoints` of one shoe; the last six are written."""

    points: packed.Floats3
    areas: packed.Floats1
    bent: packed.Floats3
    trial: packed.Floats2
    force: packed.Floats2
    wrench: packed.Floats1
    tangent: packed.Floats2
    slopes: packed.Floats2
    block: packed.Floats2


@inner(merged=True, cached=False)
def press_shoe(law, count, frame, weights, shoe):
    """Write the forces of the cells on a `PressedShoe` with `count` points at a frame (FRAME,).

    `weights` (2,) are those of `press`.
    """
    points, areas, bent, trial, force, wrench, tangent, slopes, block = shoe
    at, by_place, by_velocity = frame_at(frame), weights[0], weights[1]
    tangents = by_place != 0.0 or by_velocity != 0.0
    F, M, by_x, by_y = NOTHING, NOTHING, NOTHING, NOTHING
    for b in range(points.shape[0]):
        first = b * BLOCK
        these, size, stood = points[b], min(BLOCK, count - first), areas[first:]
        _move(these, bent[b], at, size, block)
        _answer(law, these, tangents, size, block, trial[first:])
        _push(these, stood, size, block)
        for k in range(size):
            f = (block[FORCE, k], block[FORCE + 1, k], block[FORCE + 2, k])
            force[first + k, 0], force[first + k, 1], force[first + k, 2] = f
            F = along(F, 1.0, f)
            M = along(M, 1.0, cross((block[ARM, k], block[ARM + 1, k], block[ARM + 2, k]), f))
            if tangents:
                by_x, by_y = along(by_x, these[0, k], f), along(by_y, these[1, k], f)
        if tangents:
            _slope(these, stood, by_place, by_velocity, size, block)
            for q in range(9):
                for k in range(size):
                    slopes[q, first + k] = block[SLOPES + q, k]
    for i in range(3):
        wrench[i], wrench[3 + i] = F[i], M[i]
    if tangents:
        _write_tangent(points, at.R, by_place, slopes, (F, by_x, by_y), tangent)


@inner(allocates=True)
def _write_tangent(points, R, by_place, slopes, forces, tangent):
    """Write the derivative of a wrench by motions of its shoe, of the derivatives (9, points) of its points.

    The arms are linear in the places X, Y on the underside, so that sums of these times 1, X, Y, X2, XY, Y2
    make it, whatever the number of points; `forces` are those of forces times 1, X, Y.
    """
    count = slopes.shape[1]
    monomials = np.empty((count, 6))
    for a in range(count):
        X, Y = points[a // BLOCK, 0, a % BLOCK], points[a // BLOCK, 1, a % BLOCK]
        monomials[a, 0], monomials[a, 1], monomials[a, 2] = 1.0, X, Y
        monomials[a, 3], monomials[a, 4], monomials[a, 5] = X * X, X * Y, Y * Y
    sums = np.dot(slopes, monomials)
    z = points[0, 2, 0] if count > 0 else 0.0
    _congruence(sums, R, z, tangent)
    # the arms turn under the forces: sum of a f' - (a . f) 1
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
def _congruence(sums, R, z, out):
    """Write the sum of ``B' g B`` with B = [1, -[arm]x], of sums (9, 6) of g as of `_write_tangent`."""
    first, second = np.empty((9, 3)), np.empty((9, 3, 3))
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


@inner(merged=True, cached=False)
def prepare_points(law, count, points):
    """Write `Probe.prepared` of all points of one shoe."""
    for b in range(points.shape[0]):
        for k in range(min(BLOCK, count - b * BLOCK)):
            prepared = prepare(law, points[b, DEEPEST, k], points[b, DEEPEST + 1, k])
            points[b, PREPARED, k], points[b, PREPARED + 1, k] = prepared[0], prepared[1]


@cache
def addresses_of(kernel: LawKernel) -> tuple[int, int]:
    """Addresses of `prepare_points` and `press_shoe` compiled for a law."""
    constants_type, size = kernel.constants, len(kernel.constants._fields)
    numbers, number = types.CPointer(types.float64), types.intp

    def law_points(constants, count, points):
        law = constants_type(*to_fixed_tuple(carray(constants, (size,)), size))
        prepare_points(law, count, carray(points, ((count + BLOCK - 1) // BLOCK, POINT, BLOCK)))
        return 0

    def law_press(
        constants, count, points, areas, bent, frame, weights, trial, force, wrench, tangent, slopes, block
    ):
        law = constants_type(*to_fixed_tuple(carray(constants, (size,)), size))
        blocks = (count + BLOCK - 1) // BLOCK
        shoe = PressedShoe(
            carray(points, (blocks, POINT, BLOCK)),
            carray(areas, (count,)),
            carray(bent, (blocks, 6, BLOCK)),
            carray(trial, (count, TRIAL)),
            carray(force, (count, 3)),
            carray(wrench, (6,)),
            carray(tangent, (6, 6)),
            carray(slopes, (9, count)),
            carray(block, (ROWS, BLOCK)),
        )
        press_shoe(law, count, carray(frame, (FRAME,)), carray(weights, (2,)), shoe)
        return 0

    return (
        compile_entry(kernel, law_points, (numbers, number, numbers)),
        compile_entry(kernel, law_press, (numbers, number, *11 * [numbers])),
    )


@kernel
def press(values: tuple, frames: FloatArray, weights: FloatArray) -> None:
    """Write wrenches, tangents, forces and trial memory of all shoes at their frames (shoes, FRAME).

    `values` is `ShoePoints` as a plain tuple. `weights` (2,) are those of the derivatives by displacements
    and by velocities; without any, the tangents are left as they are.
    """
    shoes = ShoePoints(*values)
    for s in range(shoes.counts.shape[0]):
        law.call_at(
            shoes.addresses[1],
            shoes.constants,
            shoes.counts[s],
            shoes.points[s],
            shoes.areas[s],
            shoes.bent[shoes.bending[s]],
            frames[s],
            weights,
            shoes.trial[s],
            shoes.force[s],
            shoes.wrench[s],
            shoes.tangent[s],
            shoes.slopes[shoes.bending[s]],
            shoes.block,
        )


class Hats(NamedTuple):
    """First node of the mesh of an even grid that a place is in, and how far within; bilinear hats there."""

    i: int
    j: int
    u: float
    v: float


@inner
def hats_at(low: FloatArray, high: FloatArray, last: tuple[int, int], x: float, y: float) -> Hats:
    """Mesh of a place (m, the shoe's frame) in a grid of which `low` and `high` are the corners."""
    u = (x - low[0]) / (high[0] - low[0]) * last[0]
    v = (y - low[1]) / (high[1] - low[1]) * last[1]
    i, j = min(max(int(u), 0), last[0] - 1), min(max(int(v), 0), last[1] - 1)
    return Hats(i, j, u - i, v - j)


@inner
def share_of(hats: Hats, k: int) -> float:
    """Share of a place that the k-th node of its mesh has."""
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
    """Add forces (count, 3) at the points of a shoe to the nodes (a, b, 3) of a grid of it, global, N.

    A force goes to the four nodes about its point, which keeps forces and moments, and bending moments at the
    lines of nodes.
    """
    last = nodes.shape[0] - 1, nodes.shape[1] - 1
    for a in range(forces.shape[0]):
        b, k = a // BLOCK, a % BLOCK
        hats = hats_at(low, high, last, points[b, 0, k], points[b, 1, k])
        for k in range(4):
            i, j, share = hats.i + k // 2, hats.j + k % 2, share_of(hats, k)
            for c in range(3):
                nodes[i, j, c] += share * forces[a, c]


@kernel
def coarse_forces(values: tuple, frames: FloatArray, out: FloatArray) -> None:
    """Write the forces on a grid of the undersides (shoes, a, b, 3): N, in the axes of each shoe.

    The nodes divide the underside evenly, from its least x and y to its greatest; `values` as of `press`.
    """
    shoes = ShoePoints(*values)
    out.fill(0.0)
    low, high = shoes.corners[0], shoes.corners[2]
    for s in range(out.shape[0]):
        R, count = frame_at(frames[s]).R, shoes.counts[s]
        spread_forces(shoes.points[s], shoes.force[s, :count], low, high, out[s])
        for i in range(out.shape[1]):
            for j in range(out.shape[2]):
                force = turned_back(R, (out[s, i, j, 0], out[s, i, j, 1], out[s, i, j, 2]))
                out[s, i, j, 0], out[s, i, j, 1], out[s, i, j, 2] = force[0], force[1], force[2]
