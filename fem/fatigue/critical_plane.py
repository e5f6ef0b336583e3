"""Damage on the critical plane: the plane at a surface node whose normal stress does the most damage.

If nothing presses on a surface, the greatest normal stresses are on planes perpendicular to it, so that
the search is over one angle about the surface's normal: first 10 degrees apart, then, at the worst
nodes, 1 degree apart about the worst plane.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fem.body.mesh import Floats, Integers, Mesh, triangle_normals
from fem.body.shapes import Columns
from fem.fatigue.damage import TOLERANCE, CountedDamage, Counting
from fem.stress.folds import Fold, StressBlock, fold_stresses
from fem.stress.low_rank import NODE_BLOCK, SEGMENT, ModalHistory

APART, FINE = np.radians(10.0), np.radians(1.0)
"""Steps of the angle, of the first search and of the finer one."""
FINEST = 100
"""Nodes whose worst plane is searched in fine steps."""
DamageOnPlanes = Callable[[Integers, Floats], Floats]
"""Gives the damage (n, a, s) of nodes (n,) on planes at angles (n, a), by survival."""


def surface_normals(mesh: Mesh) -> Floats:
    """Outward unit normals (n, 3) of the nodes of the surface, weighted by area; zero elsewhere."""
    areas = triangle_normals(mesh.nodes[mesh.boundary[:, :3]])
    sums = np.zeros_like(mesh.nodes)
    for column in mesh.boundary.T:
        np.add.at(sums, column, areas)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.divide(sums, lengths, out=np.zeros_like(sums), where=lengths > 0.0)


def plane_normals(normals: Floats, angles: Floats) -> Floats:
    """Unit vectors (n, a, 3) perpendicular to normals (n, 3), at angles (n, a) about them."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normals, first)
    return np.cos(angles)[..., None] * first[:, None] + np.sin(angles)[..., None] * second[:, None]


def normal_stress_rows(directions: Floats) -> Floats:
    """Rows (..., 6) that make the normal stress in directions (..., 3) of the six components."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return np.stack((x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * x * z), axis=-1)


class _OnPlanes(Fold[Floats]):
    """Damage (n, a, s) by the normal stress on planes of each node, of rows (n, a, 6)."""

    components = None

    def __init__(self, rows: Floats, counting: Counting) -> None:
        self._rows = rows
        self._counting = counting

    def start(self, nodes: Integers, times: int) -> None:
        """Begin with no damage."""
        self._counting.check(times)
        n, planes = self._rows.shape[:2]
        self._stress = np.empty((min(n, NODE_BLOCK), 6, min(times, SEGMENT)), dtype=np.float32)
        self._counted = CountedDamage(self._counting, n * planes)

    def add(self, block: StressBlock) -> None:
        """Gather the stresses of a block of nodes, and count those of a segment."""
        of = block.nodes
        times = block.times
        whole = block.segment
        planes = self._rows.shape[1]
        if self._stress.dtype != block.stress.dtype:
            self._stress = np.empty(self._stress.shape, block.stress.dtype)
        gathered = self._stress[: of.stop - of.start, :, : whole.stop - whole.start]
        gathered[:, :, times.start - whole.start : times.stop - whole.start] = block.stress
        for node in range(of.start, of.stop) if times.stop == whole.stop else ():
            signals = self._rows[node] @ gathered[node - of.start]
            self._counted.add(slice(node * planes, (node + 1) * planes), signals, whole.start)

    def finish(self) -> Floats:
        """Damage of all nodes."""
        damage = self._counted.damage.sum(axis=2)
        return damage.reshape(*self._rows.shape[:2], -1)


def damage_on_planes(
    stress_modes: Columns,
    q: ModalHistory,
    normals: Floats,
    angles: Floats,
    counting: Counting,
    nodes: Integers,
    tolerance: float | None = TOLERANCE,
) -> Floats:
    """Damage (n, a, s) on planes of surface nodes by one pass of a history that is repeated, by survival.

    Parameters
    ----------
    stress_modes, q, counting, tolerance
        As of `damage.recover_damage`.
    normals : array (n of the mesh, 3)
        Of `surface_normals`.
    angles : array (n, a)
        Of the planes about the nodes' normals, see `plane_normals`.
    nodes : int array (n,)
        Numbers of surface nodes.

    Raises
    ------
    ValueError
        As of `damage.recover_damage`; or if a node is not of the surface.
    """
    inside = nodes[~normals[nodes].any(axis=1)]
    if len(inside):
        raise ValueError(f"nodes must be of the surface, got {inside[:5].tolist()}")
    rows = normal_stress_rows(plane_normals(normals[nodes], angles))
    return fold_stresses(stress_modes, q, _OnPlanes(rows, counting), nodes, tolerance)


class CriticalPlanes(NamedTuple):
    """Planes of n nodes on which the damage is greatest.

    Attributes
    ----------
    damage : array (n, s)
        By survival.
    angles : array (n,)
        Of the planes about the nodes' normals, in rad.
    """

    damage: Floats
    angles: Floats


def critical_planes(damage_on: DamageOnPlanes, nodes: Integers) -> CriticalPlanes:
    """Search the worst plane of every node (n,), in fine steps at the nodes of the greatest damage.

    Parameters
    ----------
    damage_on : callable
        As of `damage_on_planes`, or sums of it over the histories of a life.
    """
    coarse = np.broadcast_to(np.arange(0.0, np.pi - 0.5 * APART, APART), (len(nodes), round(np.pi / APART)))
    planes = _worst(damage_on(nodes, coarse), coarse)
    worst = np.argsort(-planes.damage.max(axis=1), kind="stable")[:FINEST]
    around = planes.angles[worst, None] + np.arange(-APART, APART + 0.5 * FINE, FINE)
    finer = _worst(damage_on(nodes[worst], around), around)
    planes.damage[worst], planes.angles[worst] = finer
    return planes


def _worst(damage: Floats, angles: Floats) -> CriticalPlanes:
    """Plane with the greatest damage (n, a, s) of those at angles (n, a)."""
    of = np.arange(len(damage)), damage.max(axis=2).argmax(axis=1)
    return CriticalPlanes(damage[of], angles[of])
