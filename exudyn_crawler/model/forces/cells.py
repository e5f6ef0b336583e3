"""Ground of cells under shoes as force elements: a wrench on a rigid shoe, forces at nodes of a flexible one.

Bilinear hat functions on a coarse grid of its underside couple a flexible shoe with the cells. The modes move
the nodes of the grid, the hats move the points in between, and the points' forces go back to the nodes. This
keeps force and moment, and the bending moments on the grid's lines.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground import packed, pairs
from exudyn_crawler.ground.cells import contact, ground, pressing
from exudyn_crawler.ground.cells.layouts import BENT, BLOCK, FRAME, IN_FRAME, POINT, frame_at, triple_of
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.frames import Vector, along, turned
from exudyn_crawler.ground.packed import FloatArray, IntArray
from exudyn_crawler.ground.rotations import Attitude, moments_on_angles
from exudyn_crawler.ground.rows import ForceRows, Weights
from exudyn_crawler.model.bodies import Bodies, attitude_of, frame_of, write_angles
from exudyn_crawler.model.markers import write_point

WRENCH = 6
"""Number of motions of a rigid shoe: displacement of its COM (m) and rotation (rad), global."""


class CellTable(NamedTuple):
    """Undersides of shoes on cells, with a grid of nodes for flexible shoes."""

    flexible: packed.Ints1  # (shoes,): row of a shoe among the flexible ones, -1 for a rigid one
    nodes: packed.Floats3  # (along, across, 3): nodes of the grid in the shoe's frame, m
    rows: packed.Floats4  # (along, across, 3, modes): displacement of the nodes by the modes


class CellWorkspace(NamedTuple):
    """Workspace of the cells' forces."""

    shoes: pressing.ShoePoints
    frames: packed.Floats2  # (shoes, FRAME): of the shoes at the last state
    # (flexible shoes, 2, along, across, 3): displacement of the grid's nodes by the modes (m), and its rate
    # (m/s), in the shoes' axes
    bent: packed.Floats5
    # (flexible shoes, most points, 4): `pressing.Hats` of every point, which stay for a step
    hats: packed.Floats3
    rigid: ForceRows  # rigid shoes: force, moment about the COM
    flexible: ForceRows  # flexible ones: forces at the nodes

    @classmethod
    def allocate(cls, table: CellTable, shoes: pressing.ShoePoints) -> "CellWorkspace":
        """Return a workspace for these shoes."""
        flexible = int((table.flexible >= 0).sum())
        modes = table.rows.shape[3]
        rigid = ForceRows.allocate(len(table.flexible) - flexible, WRENCH, modes)
        rigid.bodies[:, 0] = np.flatnonzero(table.flexible < 0)
        bending = ForceRows.allocate(flexible, table.nodes.size, modes)
        bending.bodies[:, 0] = np.flatnonzero(table.flexible >= 0)
        rigid.acting[0] = len(rigid.unit)
        bending.acting[0] = len(bending.unit)
        frames = np.zeros((len(table.flexible), FRAME))
        bent = np.zeros((flexible, 2, *table.nodes.shape))
        hats = np.zeros((flexible, shoes.areas.shape[1], 4))
        return cls(shoes=shoes, frames=frames, bent=bent, hats=hats, rigid=rigid, flexible=bending)


class OnCells(NamedTuple):
    """Tables of a track on cells."""

    bodies: Bodies
    table: CellTable
    work: CellWorkspace


ON_CELLS = packed.type_of(OnCells)
_read = packed.reader(ON_CELLS)


@inner(merged=True)
def _hats(values: FloatArray) -> pressing.Hats:
    """Return the mesh of a point from its numbers (4,)."""
    return pressing.Hats(int(values[0]), int(values[1]), values[2], values[3])


@inner
def _moved_by_nodes(hats: pressing.Hats, bent: FloatArray) -> Vector:
    """Return the value at a point of a field (along, across, 3) that is given at the nodes."""
    value = (0.0, 0.0, 0.0)
    for k in range(4):
        node = bent[hats.i + k // 2, hats.j + k % 2]
        value = along(value, pressing.share_of(hats, k), (node[0], node[1], node[2]))
    return value


@inner
def write_frames(bodies: Bodies, table: CellTable, state: FloatArray, work: CellWorkspace) -> None:
    """Write the shoes' frames, and the displacements of the grid's nodes by the modes."""
    modes = table.rows.shape[3]
    for s in range(table.flexible.shape[0]):
        frame = frame_of(bodies, s, state, attitude_of(bodies, s))
        row = work.frames[s]
        for c in range(3):
            row[IN_FRAME.r + c] = frame.r[c]
            row[IN_FRAME.v + c] = frame.v[c]
            row[IN_FRAME.omega + c] = frame.omega[c]
            for k in range(3):
                row[IN_FRAME.R + 3 * c + k] = frame.R[c][k]
        f = table.flexible[s]
        modal = bodies.modal[s]
        if f < 0:
            continue
        bent = work.bent[f].reshape((2, table.nodes.size))
        rows = table.rows.reshape((table.nodes.size, modes))
        bent.fill(0.0)
        for m in range(modes):
            z = state[0, modal + m]
            z_t = state[1, modal + m]
            for k in range(rows.shape[0]):
                bent[0, k] += rows[k, m] * z
                bent[1, k] += rows[k, m] * z_t


@kernel
def place_shoes(block: IntArray, state: FloatArray) -> None:
    """Write the frames and deformations of shoes at a state into a block of `OnCells`."""
    on = _read(block)
    write_angles(on.bodies, state[0])
    write_frames(on.bodies, on.table, state, on.work)


@kernel
def bend_before(block: IntArray, frames: FloatArray, bent: FloatArray) -> None:
    """Add the deformation at the last accepted step to the flexible shoes' points at that step.

    Also write the meshes of these points. `frames` (shoes, FRAME) and `bent`, the displacement of the grid's
    nodes (flexible shoes, along, across, 3), m, are those of the last accepted step; `block` is one of
    `OnCells`.
    """
    table = _read(block).table
    work = _read(block).work
    shoes = work.shoes
    for s in range(table.flexible.shape[0]):
        f = table.flexible[s]
        if f < 0:
            continue
        R = frame_at(frames[s]).R
        last = table.nodes.shape[0] - 1, table.nodes.shape[1] - 1
        low = table.nodes[0, 0]
        high = table.nodes[last[0], last[1]]
        for a in range(shoes.counts[s]):
            points = shoes.points[s, a // BLOCK]
            k = a % BLOCK
            values = work.hats[f, a]
            x, y, _ = triple_of(points, POINT.place, k)
            hats = pressing.hats_at(low, high, last, x, y)
            values[0], values[1], values[2], values[3] = hats
            moved = turned(R, _moved_by_nodes(hats, bent[f]))
            for c in range(3):
                points[POINT.before + c, k] += moved[c]


@inner
def _bend_points(table: CellTable, work: CellWorkspace) -> None:
    """Write the motion of the points of flexible shoes by the modes."""
    shoes = work.shoes
    for s in range(table.flexible.shape[0]):
        f = table.flexible[s]
        for a in range(shoes.counts[s] if f >= 0 else 0):
            b = a // BLOCK
            k = a % BLOCK
            hats = _hats(work.hats[f, a])
            for rate in range(2):
                moved = _moved_by_nodes(hats, work.bent[f, rate])
                first = BENT.moved if rate == 0 else BENT.rate
                for c in range(3):
                    shoes.bent[shoes.bending[s], b, first + c, k] = moved[c]


@kernel
def bend_shoes(block: IntArray) -> None:
    """Write the motion of the points of flexible shoes by the modes, in a block of `OnCells`."""
    _bend_points(_read(block).table, _read(block).work)


@inner(allocates=True)
def write_rows(
    table: CellTable, bodies: Bodies, state: FloatArray, weights: Weights, work: CellWorkspace
) -> None:
    """Press the shoes on the cells that were covered for the step, and write the elements."""
    if table.flexible.shape[0] == 0:
        return
    shoes = work.shoes
    rigid = work.rigid
    flexible = work.flexible
    write_frames(bodies, table, state, work)
    _bend_points(table, work)
    # derivatives of forces, which are negative in the residual
    by = np.array((-weights.position, -weights.velocity))
    pressing.press(work.shoes, work.frames, by)
    derive = by[0] != 0.0 or by[1] != 0.0
    count = 0
    for s in range(table.flexible.shape[0]):
        attitude = attitude_of(bodies, s)
        f = table.flexible[s]
        if f >= 0:
            _write_nodal(table, shoes, s, attitude, (work.bent[f, 0], work.hats[f]), derive, flexible, f)
            continue
        for r in range(WRENCH):
            rigid.wrench[count, r] = shoes.wrench[s, r]
            for c in range(WRENCH):
                rigid.jacobian[count, 0, r, c] = 1.0 if r == c and r < 3 else 0.0
                if derive:
                    rigid.tangent[count, r, c] = shoes.tangent[s, r, c]
        for c in range(3):
            for r in range(3):
                rigid.jacobian[count, 0, 3 + r, 3 + c] = attitude.axes[c][r]
        count += 1


@inner(allocates=True)
def _add_nodal_tangent(
    table: CellTable, shoes: pressing.ShoePoints, s: int, points: FloatArray, tangent: FloatArray
) -> None:
    """Add the tangents of a shoe's points at the nodes of its grid.

    The product of two hats is one of three functions along and one of three across. Their sums over the
    points of a mesh, given by `Hats`, suffice for all pairs of its nodes.
    """
    nodes = table.nodes
    across = table.nodes.shape[1]
    count = shoes.counts[s]
    sums = np.zeros((nodes.shape[0] - 1, across - 1, 9, 9))
    slope = np.empty(9)
    slopes = shoes.slopes[shoes.bending[s], : 9 * count].reshape((9, count))
    for a in range(count):
        i, j, u, v = _hats(points[a])
        for c in range(9):
            slope[c] = slopes[c, a]
        by_u = ((1.0 - u) * (1.0 - u), (1.0 - u) * u, u * u)
        by_v = ((1.0 - v) * (1.0 - v), (1.0 - v) * v, v * v)
        for p in range(3):
            for q in range(3):
                share = by_u[p] * by_v[q]
                into = sums[i, j, 3 * p + q]
                for c in range(9):
                    into[c] += share * slope[c]
    for i in range(sums.shape[0]):
        for j in range(sums.shape[1]):
            for k in range(4):
                first = 3 * ((i + k // 2) * across + j + k % 2)
                for m in range(4):
                    second = 3 * ((i + m // 2) * across + j + m % 2)
                    product = 3 * (k // 2 + m // 2) + k % 2 + m % 2
                    for r in range(3):
                        for c in range(3):
                            tangent[first + r, second + c] += sums[i, j, product, 3 * r + c]


@inner
def _write_nodal(
    table: CellTable,
    shoes: pressing.ShoePoints,
    s: int,
    attitude: Attitude,
    grid: tuple[FloatArray, FloatArray],
    derive: bool,
    rows: ForceRows,
    f: int,
) -> None:
    """Write the forces at the nodes of a flexible shoe, their tangent, and the nodes' motions.

    `grid` holds the displacements of its nodes, and the `Hats` of its points.
    """
    bent, hats = grid
    wrench = rows.wrench[f]
    tangent = rows.tangent[f]
    jacobian = rows.jacobian[f, 0]
    nodes = table.nodes
    across = table.nodes.shape[1]
    count = shoes.counts[s]
    low = nodes[0, 0]
    high = nodes[nodes.shape[0] - 1, across - 1]
    wrench.fill(0.0)
    at_nodes = wrench.reshape(nodes.shape)
    pressing.spread_forces(shoes.points[s], shoes.force[s, :count], low, high, at_nodes)
    if derive:
        tangent.fill(0.0)
        _add_nodal_tangent(table, shoes, s, hats, tangent)
    for i in range(nodes.shape[0]):
        for j in range(across):
            node = nodes[i, j]
            by = bent[i, j]
            place = (node[0] + by[0], node[1] + by[1], node[2] + by[2])
            arm = turned(attitude.R, place)
            first = 3 * (i * across + j)
            rows = table.rows[i, j]
            modes = table.rows.shape[3]
            write_point(attitude, arm, rows, modes, 1.0, jacobian[first : first + 3])


class TrackOnCells:
    """Cells under a track from step to step: covered before a step, committed after its acceptance."""

    def __init__(self, ground: ground.CellGround, parts: OnCells) -> None:
        self.ground = ground
        self._parts = parts
        self._work = parts.work
        self._block = packed.pack(parts, ON_CELLS)
        self._count_from_here()

    def _count_from_here(self) -> None:
        """Start slip at the state of the last frames."""
        self._before = self._work.frames.copy(), self._work.bent[:, 0].copy()

    def put_down(self, state: np.ndarray) -> None:
        """Start slip at a state (3, coordinates)."""
        place_shoes(self._block, state)
        self._count_from_here()

    def cover(self, state: np.ndarray) -> None:
        """Freeze the cells under the shoes at the predicted state (3, coordinates)."""
        place_shoes(self._block, state)
        self.ground.cover(self._work.frames, self._before[0])
        if len(self._work.bent):
            bend_before(self._block, *self._before)

    def forces(self, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
        """Return generalized forces of the covered cells on shoes and modes, at coordinates and rates: (n,).

        Those on modes are the forces at the nodes of the grids, through their rows.
        """
        place_shoes(self._block, np.stack((q, q_t)))
        bend_shoes(self._block)
        wrenches = self.ground.press(self._work.frames)
        (bodies, table, _) = self._parts
        angles = bodies.reference[:, 3:] + q[: wrenches.size].reshape(-1, 6)[:, 3:]
        wrenches[:, 3:] = moments_on_angles(angles, wrenches[:, 3:])
        if table.rows.shape[3] == 0:
            return wrenches.ravel()
        nodal = self.ground.coarse_forces(self._work.frames)[table.flexible >= 0]
        return np.concatenate((wrenches.ravel(), np.einsum("sabc,abcm->sm", nodal, table.rows).ravel()))

    def commit(self) -> None:
        """Store the state of the last residual in the cells' memory."""
        self.ground.commit()
        self._count_from_here()

    def contacts(self, numbers: int) -> np.ndarray:
        """Return contacts at the last residual (shoes, numbers): `ground.pairs.RESULTS`, then grid forces.

        The forces (N, the shoe's axes) are those at the nodes of a grid of the underside, for flexible shoes.
        """
        out = np.zeros((len(self._work.frames), numbers))
        contact.write_contacts(self.ground.shoes, self._work.frames, out)
        if numbers > pairs.RESULTS:
            out[:, pairs.RESULTS :] = self.ground.coarse_forces(self._work.frames).reshape(len(out), -1)
        return out
