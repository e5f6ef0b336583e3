"""Damage on the critical plane: the plane at a surface node whose normal stress does the most.

Where nothing presses on a surface, the greatest normal stresses are in planes perpendicular to it, so that one
angle about the surface's normal is all there is to search: first 10 degrees apart, then, at the worst nodes, 1
degree apart about the worst plane.
"""

from typing import NamedTuple

import numpy as np

from fem.blocks import Fold, StressBlock, fold_stresses
from fem.damage import TOLERANCE, Counting, Damage, check_history
from fem.mesh import Floats, Integers, Mesh
from fem.rank import NODE_BLOCK

APART, FINE = np.radians(10.0), np.radians(1.0)
"""Steps of the angle, of the first search and of the finer one."""
FINEST = 100
"""Nodes whose worst plane is sought in fine steps."""


class PlaneDamage(NamedTuple):
    """Damage on the critical planes of n nodes.

    Attributes
    ----------
    damage : Damage
        By the normal stress on the critical plane.
    normals : array (n, 3)
        Of the critical planes, in body axes.
    """

    damage: Damage
    normals: Floats


def surface_normals(mesh: Mesh) -> Floats:
    """Outward unit normals (n, 3) of the nodes of the surface, weighted by area; zero elsewhere."""
    a, b, c = (mesh.nodes[mesh.boundary[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)
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


class _OnPlanes(Fold[Damage]):
    """Damage by the normal stress on the worst of some planes of each node, rows (n, a, 6).

    `worst` (n,) tells which it was.
    """

    components = None

    def __init__(self, rows: Floats, counting: Counting) -> None:
        self._rows, self._counting = rows, counting

    def start(self, nodes: Integers, times: int) -> None:
        """Begin with no damage."""
        n = len(nodes)
        self._nodes, self._stress = nodes, np.empty((min(n, NODE_BLOCK), 6, times))
        self._damage = np.zeros((n, *self._counting.shape))
        self.worst = np.zeros(n, dtype=np.int64)
        self._highest, self._lowest, self._bound = np.zeros(n), np.zeros(n), np.zeros(n)

    def add(self, block: StressBlock) -> None:
        """Gather the stresses of a block of nodes, and count them when they are whole."""
        of, at = block.nodes, block.times
        self._stress[: of.stop - of.start, :, at] = block.stress
        self._bound[of] = np.maximum(self._bound[of], block.bound)
        for node in range(of.start, of.stop) if at.stop == self._stress.shape[2] else ():
            signals = self._rows[node] @ self._stress[node - of.start]
            found = self._counting.damage(signals)
            worst = self.worst[node] = found.sum(axis=2).max(axis=1).argmax()
            self._damage[node] = found[worst]
            self._highest[node], self._lowest[node] = signals[worst].max(), signals[worst].min()

    def finish(self) -> Damage:
        """Damage and extremes on the worst planes."""
        return Damage(self._nodes, self._damage, self._highest, self._lowest, self._bound)


def plane_damage(
    stress_modes: Floats,
    q: Floats,
    normals: Floats,
    counting: Counting,
    nodes: Integers,
    tolerance: float | None = TOLERANCE,
) -> PlaneDamage:
    """Damage on the critical planes of surface nodes by one pass of a history that is repeated.

    Parameters
    ----------
    stress_modes, q, counting, tolerance
        As of `damage.recover_damage`.
    normals : array (n of the mesh, 3)
        Of `surface_normals`.
    nodes : int array (n,)
        Numbers of surface nodes.

    Raises
    ------
    ValueError
        As of `damage.recover_damage`; or if a node is not of the surface.
    """
    check_history(q, counting)
    inside = nodes[~normals[nodes].any(axis=1)]
    if len(inside):
        raise ValueError(f"nodes must be of the surface, got {inside[:5].tolist()}")
    coarse = np.broadcast_to(np.arange(0.0, np.pi - 1e-9, APART), (len(nodes), round(np.pi / APART)))
    first, angles = _search(stress_modes, q, normals[nodes], coarse, counting, nodes, tolerance)
    most = first.damage.sum(axis=2).max(axis=1)
    worst = np.argsort(-most, kind="stable")[:FINEST]
    around = angles[worst, None] + np.arange(-APART, APART + 0.5 * FINE, FINE)
    second, finer = _search(
        stress_modes, q, normals[nodes[worst]], around, counting, nodes[worst], tolerance
    )
    for one, other in ((first.damage, second.damage), (first.highest, second.highest)):
        one[worst] = other
    first.lowest[worst], angles[worst] = second.lowest, finer
    return PlaneDamage(first, plane_normals(normals[nodes], angles[:, None])[:, 0])


def _search(
    stress_modes: Floats,
    q: Floats,
    normals: Floats,
    angles: Floats,
    counting: Counting,
    nodes: Integers,
    tolerance: float | None,
) -> tuple[Damage, Floats]:
    """Damage on the worst of the planes at angles (n, a), and the angle (n,) of that."""
    fold = _OnPlanes(normal_stress_rows(plane_normals(normals, angles)), counting)
    found = fold_stresses(stress_modes, q, fold, nodes, tolerance)
    return found, angles[np.arange(len(nodes)), fold.worst]
