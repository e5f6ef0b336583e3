"""Forces of the cells on shoes, compiled: wrench and its derivative, trial memory, a coarse grid of forces.

A shoe is a list of points that `covering` has frozen for the step: a place on its underside, the cell below
it and the area that it stands for. Nothing here reads or writes the map of the ground. Derivatives leave out
how the areas change as the outline moves (1 % of them) and how turning arms turn velocities (0.2 % at 0.1
rad/s).
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import carray, types
from numba.np.unsafe.ndarray import to_fixed_tuple

from exudyn_crawler.ground.cells.law import (
    LawKernel,
    Memory,
    Probe,
    call_at,
    compile_entry,
    prepare,
    respond,
    within_law,
)
from exudyn_crawler.ground.frames import (
    Frame,
    Matrix,
    Vector,
    allocating,
    along,
    compiled,
    cross,
    dot,
    scaled,
    turned,
    turned_back,
    within,
)
from exudyn_crawler.ground.rotations import FloatArray, IntArray

PLACE, NORMAL, GROUND, BEFORE, DEEPEST, PREPARED, SHEAR, MOBILIZED = 0, 3, 6, 7, 10, 12, 14, 17
"""First column of what a point is: its place in the shoe's frame (m), the cell's normal, the distance of the
cell's plane from the origin along it (m), where the place was when a step was last accepted (m, global); and
the cell's memory: greatest sinkage and pressure, `Probe.prepared`, shear and mobilized share."""
POINT = 18
TRIAL, TRACTION = 6, 5
"""Trial memory of a point: greatest sinkage, pressure, shear along x and y, mobilized share; and beside it,
in the column `TRACTION`, the normal traction on the shoe (Pa)."""
NOTHING = (0.0, 0.0, 0.0)
FRAME = 18
"""Numbers of a frame: r, the rows of R, v and omega, global."""


class ShoePoints(NamedTuple):
    """Points of the shoes and what the kernel makes of them; all arrays stay the same through a run.

    Attributes
    ----------
    addresses : array (2,)
        Of the compiled law: `prepare` and `press`.
    constants : array (constants,)
        Of the law.
    corners : array (4, 3)
        Of the underside in the shoe's frame, anticlockwise seen from above; of one z, m.
    counts : array (shoes,)
        Number of points of each shoe.
    cells : array (shoes, most)
        Cell of each point.
    areas : array (shoes, most)
        True area of each point, m2.
    points : array (shoes, most, POINT)
    trial : array (shoes, most, TRIAL)
    force : array (shoes, most, 3)
        On the shoe at each point, N, global.
    wrench : array (shoes, 6)
        Force (N) and moment about the frame's origin (N m) on each shoe, global.
    tangent : array (shoes, 6, 6)
        Its weighted derivative by displacements and small rotations (global components).
    bending : array (shoes,)
        Row of each shoe in the next two arrays: all rigid ones share the first, which stays in the cache.
    bent : array (1 + flexible shoes, most, 6)
        Displacement of the points of flexible shoes by their modes (m), and its rate (m/s), shoes' axes.
    slopes : array (1 + flexible shoes, most, 9)
        Weighted derivative of each point's force by its displacement, row by row.
    """

    addresses: IntArray
    constants: FloatArray
    corners: FloatArray
    counts: IntArray
    cells: IntArray
    areas: FloatArray
    points: FloatArray
    trial: FloatArray
    force: FloatArray
    wrench: FloatArray
    tangent: FloatArray
    bending: IntArray
    bent: FloatArray
    slopes: FloatArray


@within
def frame_at(row: FloatArray) -> Frame:
    """Frame of its numbers."""
    rows = (row[3], row[4], row[5]), (row[6], row[7], row[8]), (row[9], row[10], row[11])
    return Frame((row[0], row[1], row[2]), rows, (row[12], row[13], row[14]), (row[15], row[16], row[17]))


@within
def arm_of(points: FloatArray, bent: FloatArray, a: int, R: Matrix) -> Vector:
    """Place of a point from its shoe's origin, m, global."""
    return turned(R, (points[a, 0] + bent[a, 0], points[a, 1] + bent[a, 1], points[a, 2] + bent[a, 2]))


@within_law
def _probe(points, areas, bent, a, frame, arm, normal):
    """`Probe` of a point."""
    x = along(frame.r, 1.0, arm)
    velocity = along(frame.v, 1.0, cross(frame.omega, arm))
    velocity = along(velocity, 1.0, turned(frame.R, (bent[a, 3], bent[a, 4], bent[a, 5])))
    rate = -dot(normal, velocity)
    moved = (x[0] - points[a, BEFORE], x[1] - points[a, BEFORE + 1], x[2] - points[a, BEFORE + 2])
    shear = (points[a, SHEAR], points[a, SHEAR + 1], points[a, SHEAR + 2])
    return Probe(
        points[a, GROUND] - dot(normal, x),
        rate,
        areas[a],
        along(moved, -dot(moved, normal), normal),
        along(velocity, rate, normal),
        Memory(points[a, DEEPEST], points[a, DEEPEST + 1], shear, points[a, MOBILIZED]),
        (points[a, PREPARED], points[a, PREPARED + 1]),
    )


@within_law
def press_shoe(law, points, areas, bent, frame, weights, trial, force, wrench, tangent, slopes):
    """Write what the cells do to one shoe at a frame.

    Parameters
    ----------
    law : named tuple
        Constants.
    frame : array (FRAME,)
    weights : array (2,)
        Of the derivatives by displacements and by velocities; without any, the tangent is left as it is.
    points, areas, bent, trial, force, wrench, tangent, slopes : array
        As of `ShoePoints`, of this shoe; the latter five are overwritten.
    """
    at, count = frame_at(frame), points.shape[0]
    by_place, by_velocity = weights[0], weights[1]
    tangents = by_place != 0.0 or by_velocity != 0.0
    F, M, by_x, by_y = NOTHING, NOTHING, NOTHING, NOTHING
    for a in range(count):
        arm = arm_of(points, bent, a, at.R)
        n = (points[a, NORMAL], points[a, NORMAL + 1], points[a, NORMAL + 2])
        probe = _probe(points, areas, bent, a, at, arm, n)
        answer = respond(law, probe, tangents)
        memory, v = answer.memory, probe.slip_velocity
        trial[a, 0], trial[a, 1] = memory.deepest, memory.pressure
        trial[a, 2], trial[a, 3], trial[a, 4] = memory.shear[0], memory.shear[1], memory.mobilized
        trial[a, TRACTION] = answer.normal
        f = along(scaled(answer.normal, n), -1.0, answer.shear)
        f = scaled(probe.area, along(f, -answer.drag, v))
        force[a, 0], force[a, 1], force[a, 2] = f[0], f[1], f[2]
        F, M = along(F, 1.0, f), along(M, 1.0, cross(arm, f))
        if tangents:
            by_x, by_y = along(by_x, points[a, 0], f), along(by_y, points[a, 1], f)
            # b n' + h m' + c 1 by displacements; the depth falls along n
            position, velocity, m = -probe.area * by_place, -probe.area * by_velocity, answer.direction
            normal = position * (answer.normal_by_depth - answer.across)
            normal += velocity * (answer.normal_by_rate - answer.drag)
            b = along(scaled(normal, n), -position, answer.tangential_by_depth)
            c = position * answer.across + velocity * answer.drag
            x, y, z = scaled(b[0], n), scaled(b[1], n), scaled(b[2], n)
            if answer.along != answer.across:
                h = scaled(position * (answer.along - answer.across), m)
                x, y, z = along(x, h[0], m), along(y, h[1], m), along(z, h[2], m)
            slopes[a, 0], slopes[a, 1], slopes[a, 2] = x[0] + c, x[1], x[2]
            slopes[a, 3], slopes[a, 4], slopes[a, 5] = y[0], y[1] + c, y[2]
            slopes[a, 6], slopes[a, 7], slopes[a, 8] = z[0], z[1], z[2] + c
    for i in range(3):
        wrench[i], wrench[3 + i] = F[i], M[i]
    if tangents:
        _write_tangent(points, at.R, by_place, slopes, (F, by_x, by_y), tangent)


@allocating
def _write_tangent(points, R, by_place, slopes, forces, tangent):
    """Write the derivative of a wrench by motions of its shoe, of the derivatives (9, points) of its points.

    The arms are linear in the places X, Y on the underside, so that sums of these times 1, X, Y, X2, XY, Y2
    make it, whatever the number of points; `forces` are those of forces times 1, X, Y.
    """
    count = points.shape[0]
    monomials = np.empty((count, 6))
    for a in range(count):
        X, Y = points[a, 0], points[a, 1]
        monomials[a, 0], monomials[a, 1], monomials[a, 2] = 1.0, X, Y
        monomials[a, 3], monomials[a, 4], monomials[a, 5] = X * X, X * Y, Y * Y
    sums = np.dot(slopes.T, monomials)
    z = points[0, 2] if count > 0 else 0.0
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


@allocating
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


@within_law
def prepare_points(law, points):
    """Write `Probe.prepared` of all points of one shoe."""
    for a in range(points.shape[0]):
        prepared = prepare(law, points[a, DEEPEST], points[a, DEEPEST + 1])
        points[a, PREPARED], points[a, PREPARED + 1] = prepared[0], prepared[1]


@cache
def addresses_of(kernel: LawKernel) -> tuple[int, int]:
    """Addresses of `prepare_points` and `press_shoe` compiled for a law."""
    constants_type, size = kernel.constants, len(kernel.constants._fields)  # type: ignore[attr-defined]
    numbers, number = types.CPointer(types.float64), types.intp

    def law_points(constants, count, points):
        law = constants_type(*to_fixed_tuple(carray(constants, (size,)), size))
        prepare_points(law, carray(points, (count, POINT)))
        return 0

    def law_press(
        constants, count, points, areas, bent, frame, weights, trial, force, wrench, tangent, slopes
    ):
        law = constants_type(*to_fixed_tuple(carray(constants, (size,)), size))
        press_shoe(
            law,
            carray(points, (count, POINT)),
            carray(areas, (count,)),
            carray(bent, (count, 6)),
            carray(frame, (FRAME,)),
            carray(weights, (2,)),
            carray(trial, (count, TRIAL)),
            carray(force, (count, 3)),
            carray(wrench, (6,)),
            carray(tangent, (6, 6)),
            carray(slopes, (count, 9)),
        )
        return 0

    return (
        compile_entry(kernel, law_points, (numbers, number, numbers)),
        compile_entry(kernel, law_press, (numbers, number, *10 * [numbers])),
    )


@compiled
def press(values: tuple, frames: FloatArray, weights: FloatArray) -> None:
    """Write wrenches, tangents, forces and trial memory of all shoes at their frames (shoes, FRAME).

    Parameters
    ----------
    values : tuple
        `ShoePoints` as a plain tuple.
    weights : array (2,)
        Of the derivatives by displacements and by velocities; without any, the tangents are left as they are.
    """
    shoes = ShoePoints(*values)
    for s in range(shoes.counts.shape[0]):
        call_at(
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
        )


class Hats(NamedTuple):
    """First node of the mesh of an even grid that a place is in, and how far within; bilinear hats there."""

    i: int
    j: int
    u: float
    v: float


@within
def hats_at(low: FloatArray, high: FloatArray, last: tuple[int, int], x: float, y: float) -> Hats:
    """Mesh of a place (m, the shoe's frame) in a grid of which `low` and `high` are the corners."""
    u = (x - low[0]) / (high[0] - low[0]) * last[0]
    v = (y - low[1]) / (high[1] - low[1]) * last[1]
    i, j = min(max(int(u), 0), last[0] - 1), min(max(int(v), 0), last[1] - 1)
    return Hats(i, j, u - i, v - j)


@within
def share_of(hats: Hats, k: int) -> float:
    """Share of a place that the k-th node of its mesh has."""
    u = hats.u if k >= 2 else 1.0 - hats.u
    return u * (hats.v if k % 2 == 1 else 1.0 - hats.v)


@within
def spread_forces(
    points: FloatArray, forces: FloatArray, low: FloatArray, high: FloatArray, nodes: FloatArray
) -> None:
    """Add forces at points to the nodes (a, b, 3) of an even grid of their underside, global, N.

    A force goes to the four nodes about its point, which keeps forces and moments, and bending moments at the
    lines of nodes.
    """
    last = nodes.shape[0] - 1, nodes.shape[1] - 1
    for a in range(points.shape[0]):
        hats = hats_at(low, high, last, points[a, 0], points[a, 1])
        for k in range(4):
            i, j, share = hats.i + k // 2, hats.j + k % 2, share_of(hats, k)
            for c in range(3):
                nodes[i, j, c] += share * forces[a, c]


@compiled
def coarse_forces(values: tuple, frames: FloatArray, out: FloatArray) -> None:
    """Write the forces on a grid of the undersides (shoes, a, b, 3): N, in the axes of each shoe.

    The nodes divide the underside evenly, from its least x and y to its greatest; `values` as of `press`.
    """
    shoes = ShoePoints(*values)
    out.fill(0.0)
    low, high = shoes.corners[0], shoes.corners[2]
    for s in range(out.shape[0]):
        R, count = frame_at(frames[s]).R, shoes.counts[s]
        spread_forces(shoes.points[s, :count], shoes.force[s, :count], low, high, out[s])
        for i in range(out.shape[1]):
            for j in range(out.shape[2]):
                force = turned_back(R, (out[s, i, j, 0], out[s, i, j, 1], out[s, i, j, 2]))
                out[s, i, j, 0], out[s, i, j, 1], out[s, i, j, 2] = force[0], force[1], force[2]
