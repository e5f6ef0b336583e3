"""Damage on the critical plane: the plane at a surface node with the most damage by its normal stress.

On a free surface the greatest normal stresses act on planes perpendicular to it. The search is therefore
over one angle about the surface's normal. It goes first in steps of 10 degrees, then, at the worst nodes,
in steps of 1 degree around the worst plane.
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
"""Angle steps of the first and of the finer search, rad."""
FINEST = 100
"""Number of nodes with a finer search of the worst plane."""
DamageOnPlanes = Callable[[Integers, Floats], Floats]
"""Function that returns the damage (n, a, s) of nodes (n,) on planes at angles (n, a), by survival."""


def surface_normals(mesh: Mesh) -> Floats:
    """Return outward unit normals (n, 3) of the surface nodes, weighted by area; zero elsewhere."""
    areas = triangle_normals(mesh.nodes[mesh.boundary[:, :3]])
    sums = np.zeros_like(mesh.nodes)
    for column in mesh.boundary.T:
        np.add.at(sums, column, areas)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.divide(sums, lengths, out=np.zeros_like(sums), where=lengths > 0.0)


def plane_normals(normals: Floats, angles: Floats) -> Floats:
    """Return unit vectors (n, a, 3) perpendicular to normals (n, 3), at angles (n, a) about them."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normals, first)
    return np.cos(angles)[..., None] * first[:, None] + np.sin(angles)[..., None] * second[:, None]


def normal_stress_rows(directions: Floats) -> Floats:
    """Return rows (..., 6) from the six stress components to the normal stress in directions (..., 3)."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return np.stack((x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * x * z), axis=-1)


class _OnPlanes(Fold[Floats]):
    """Damage (n, a, s) by the normal stress on planes of each node, from rows (n, a, 6)."""

    components = None

    def __init__(self, rows: Floats, counting: Counting) -> None:
        self._rows = rows
        self._counting = counting

    def start(self, nodes: Integers, times: int) -> None:
        """Begin without damage."""
        self._counting.check(times)
        n, planes = self._rows.shape[:2]
        self._stress = np.empty((min(n, NODE_BLOCK), 6, min(times, SEGMENT)), dtype=np.float32)
        self._counted = CountedDamage(self._counting, n * planes)

    def add(self, block: StressBlock) -> None:
        """Gather the stresses of a block of nodes; count their cycles at the end of a segment."""
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
        """Return the damage of all nodes."""
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
    """Find the damage (n, a, s) on planes of surface nodes by one pass of a repeated history, by survival.

    Parameters
    ----------
    stress_modes, q, counting, tolerance
        See `damage.recover_damage`.
    normals : array (n of the mesh, 3)
        Result of `surface_normals`.
    angles : array (n, a)
        Angles of the planes about the nodes' normals, see `plane_normals`.
    nodes : int array (n,)
        Numbers of surface nodes.

    Raises
    ------
    ValueError
        For the reasons of `damage.recover_damage`, or if a node is not on the surface.
    """
    inside = nodes[~normals[nodes].any(axis=1)]
    if len(inside):
        raise ValueError(f"nodes must be on the surface, got {inside[:5].tolist()}")
    rows = normal_stress_rows(plane_normals(normals[nodes], angles))
    return fold_stresses(stress_modes, q, _OnPlanes(rows, counting), nodes, tolerance)


class CriticalPlanes(NamedTuple):
    """Planes of greatest damage at n nodes.

    Attributes
    ----------
    damage : array (n, s)
        Damage by survival.
    angles : array (n,)
        Angles of the planes about the nodes' normals, in rad.
    """

    damage: Floats
    angles: Floats


def critical_planes(damage_on: DamageOnPlanes, nodes: Integers) -> CriticalPlanes:
    """Find the worst plane of every node (n,), in fine steps at the nodes of the greatest damage.

    Parameters
    ----------
    damage_on : callable
        Function like `damage_on_planes`, or the sum of it over the histories of a life.
    """
    coarse = np.broadcast_to(np.arange(0.0, np.pi - 0.5 * APART, APART), (len(nodes), round(np.pi / APART)))
    planes = _worst(damage_on(nodes, coarse), coarse)
    worst = np.argsort(-planes.damage.max(axis=1), kind="stable")[:FINEST]
    around = planes.angles[worst, None] + np.arange(-APART, APART + 0.5 * FINE, FINE)
    finer = _worst(damage_on(nodes[worst], around), around)
    planes.damage[worst], planes.angles[worst] = finer
    return planes


def _worst(damage: Floats, angles: Floats) -> CriticalPlanes:
    """Return the plane with the greatest damage (n, a, s) of those at angles (n, a)."""
    of = np.arange(len(damage)), damage.max(axis=2).argmax(axis=1)
    return CriticalPlanes(damage[of], angles[of])
