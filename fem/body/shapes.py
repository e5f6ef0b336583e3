"""Columns of modes and of static fields, for the recovery of displacement and stress."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fem.body.bores import AROUND, bore_faces
from fem.body.elasticity import Material
from fem.body.element_stress import von_mises
from fem.body.interfaces import Interface
from fem.body.mesh import Floats, Integers, Mesh


class SideBySide:
    """Arrays (n, c, m) side by side along their last axis, without a joint copy.

    Parameters
    ----------
    parts : sequence of array (n, c, m)
        At least one.

    Raises
    ------
    ValueError
        If they differ in n or c.
    """

    def __init__(self, parts: Sequence[Floats]) -> None:
        if len({part.shape[:2] for part in parts}) != 1:
            raise ValueError(
                f"parts must have the same nodes and components, got {[part.shape for part in parts]}"
            )
        self.parts = tuple(parts)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of nodes, components and columns."""
        n, c, _ = self.parts[0].shape
        return n, c, sum(part.shape[2] for part in self.parts)

    def __len__(self) -> int:
        """Return the number of nodes."""
        return len(self.parts[0])

    def __getitem__(self, nodes: Any) -> Floats:
        """Return the columns of some nodes, or of one, as an array."""
        return np.concatenate([part[nodes] for part in self.parts], axis=-1)


Columns = Floats | SideBySide
"""Array (n, c, m), or several side by side."""


def combined(columns: Columns, q: Floats, nodes: Integers | None = None) -> Floats:
    """Return the sums (t, n or len(nodes), c) of columns (n, c, m) times coordinates (t, m) or (m,)."""
    parts = columns.parts if isinstance(columns, SideBySide) else (columns,)
    cuts = np.cumsum([part.shape[2] for part in parts[:-1]])
    blocks = np.split(np.atleast_2d(q), cuts, axis=1)
    chosen = parts if nodes is None else [part[nodes] for part in parts]
    total = np.tensordot(blocks[0], chosen[0], axes=([1], [2]))
    for block, part in zip(blocks[1:], chosen[1:], strict=True):
        total += np.tensordot(block, part, axes=([1], [2]))
    return np.asarray(total)


def lengths(columns: Columns) -> Floats:
    """Return the Euclidean lengths (m,) of columns (n, c, m)."""
    parts = columns.parts if isinstance(columns, SideBySide) else (columns,)
    return np.sqrt(np.concatenate([np.einsum("ncm,ncm->m", part, part) for part in parts]))


class Shapes:
    """Elastic body of n nodes with m columns of displacement and stress.

    Parameters
    ----------
    mesh, material, interfaces
        See `reduced.ReducedBody`.
    modes : columns (n, 3, m)
        Displacement in m per unit of a coordinate.
    stress_modes : columns (n, 6, m)
        Nodal stress in Pa per unit, in the order xx, yy, zz, xy, yz, xz.
    """

    mesh: Mesh
    material: Material
    interfaces: tuple[Interface, ...]
    modes: Columns

    def __init__(
        self,
        mesh: Mesh,
        material: Material,
        interfaces: tuple[Interface, ...],
        modes: Columns,
        stress_modes: Columns,
    ) -> None:
        self.mesh = mesh
        self.material = material
        self.interfaces = interfaces
        self.modes = modes
        self._stress_modes = stress_modes

    @property
    def stress_modes(self) -> Columns:
        """Nodal stress (n, 6, m) in Pa per unit of a coordinate."""
        return self._stress_modes

    def forget_stress_modes(self) -> None:
        """Free stress modes that come from the modes; they are recovered again at the next use."""

    @property
    def nodes(self) -> Floats:
        """Positions of the nodes (n, 3) in m."""
        return self.mesh.nodes

    def displacement(self, q: Floats) -> Floats:
        """Return the elastic displacements (t, n, 3) in m of coordinates (t, m) or (m,)."""
        return combined(self.modes, q)

    def stress(self, q: Floats, nodes: Integers | None = None) -> Floats:
        """Return the nodal Cauchy stress (t, n or len(nodes), 6) in Pa of coordinates (t, m) or (m,)."""
        return combined(self.stress_modes, q, nodes)

    def von_mises(self, q: Floats, nodes: Integers | None = None) -> Floats:
        """Return the nodal von Mises stress (t, n or len(nodes)) in Pa of coordinates (t, m) or (m,)."""
        return von_mises(self.stress(q, nodes))

    @property
    def spider_nodes(self) -> Integers:
        """Numbers of the nodes inside spiders, ascending."""
        return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(i.nodes for i in self.interfaces)]))

    @property
    def held_nodes(self) -> Integers:
        """Numbers of the nodes whose stress is that of a coupling, ascending.

        They are the nodes inside spiders, without bores in which a pin is in contact and which have at least
        `bores.AROUND` nodes around.
        """
        held = [
            i.nodes
            for i in self.interfaces
            if i.spider != "contact" or bore_faces(self.mesh, i).around < AROUND
        ]
        return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *held]))

    @property
    def pressed_nodes(self) -> Integers:
        """Numbers of the nodes inside the other spiders, with the stress of a pin in contact, ascending."""
        return np.setdiff1d(self.spider_nodes, self.held_nodes)

    @property
    def nodes_away_from_spiders(self) -> Integers:
        """Numbers of the nodes that are neither held nor beside those, ascending."""
        near = np.concatenate([self.held_nodes, self.nodes_beside_spiders])
        return np.setdiff1d(np.arange(len(self.nodes)), near)

    @property
    def nodes_beside_spiders(self) -> Integers:
        """Numbers of the nodes of elements that touch held nodes, without these."""
        held = self.held_nodes
        inside = np.zeros(len(self.mesh.nodes), dtype=bool)
        inside[held] = True
        touching = inside[self.mesh.elements].any(axis=1)
        return np.setdiff1d(np.unique(self.mesh.elements[touching]), held)
