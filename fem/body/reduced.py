"""Reduced elastic body: modes, stress modes, interfaces, loads and the recovery of stresses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from fem.body.elastic_body import ElasticBody
from fem.body.elasticity import Material
from fem.body.interfaces import Interface, averaging_rows
from fem.body.mesh import Floats, Integers, Mesh
from fem.body.shapes import Shapes


@dataclass(frozen=True, eq=False)
class ReducedBody(Shapes):
    """Reduced elastic body in body axes; n nodes, m elastic modes, i interfaces.

    The modal mass matrix is the identity, the modal stiffness diag((2 pi f)^2). Rigid-body modes are left
    out, and all modes are orthogonal to them in mass.

    Parameters
    ----------
    mesh : Mesh
    material : Material
    interfaces : tuple of Interface
        Attachment points.
    frequencies : array (m,)
        In Hz, ascending.
    modes : array (n, 3, m)
        In m per unit of a modal coordinate (kg^-1/2).
    pilots : array (i, 6, m)
        Motion of each joint centre, in m and rad per unit.
    mass : float
        In kg.
    center_of_mass : array (3,)
        In m.
    inertia : array (3, 3)
        In kg m2 about the centre of mass.
    surface_weights : mapping of str to array (n,)
        Integrals of the shape functions in m2 by name of a surface.
    parameters : mapping
        Arguments of the reduction.
    ritz : array (m, b)
        Elastic part, in modal coordinates, of each Ritz vector: 6 i constraint modes, the fixed-interface
        modes, one for each residual load. Empty, (m, 0), if modes were left out.
    """

    mesh: Mesh
    material: Material
    interfaces: tuple[Interface, ...]
    frequencies: Floats
    modes: Floats
    pilots: Floats
    mass: float
    center_of_mass: Floats
    inertia: Floats
    surface_weights: Mapping[str, Floats]
    parameters: Mapping[str, Any]
    ritz: Floats

    @classmethod
    def from_modes(
        cls,
        body: ElasticBody,
        interfaces: Sequence[Interface],
        frequencies: Floats,
        modes: Floats,
        pilots: Floats,
        parameters: Mapping[str, Any],
        ritz: Floats,
    ) -> Self:
        """Return the reduced body with the mass, inertia and surfaces of an elastic body."""
        return cls(
            body.mesh,
            body.material,
            tuple(interfaces),
            frequencies,
            modes,
            pilots,
            body.mass,
            body.center_of_mass,
            body.inertia,
            {name: body.surface_weights(name) for name in body.mesh.surfaces},
            dict(parameters),
            ritz,
        )

    @cached_property
    def stress_modes(self) -> Floats:
        """Nodal stress (n, 6, m) in Pa per unit, in the order xx, yy, zz, xy, yz, xz.

        It is recovered at first use, since it takes twice the memory of the modes and a run does not need it.
        """
        return ElasticBody(self.mesh, self.material).stress(self.modes)

    def forget_stress_modes(self) -> None:
        """Free the stress modes; they are recovered again at the next use."""
        self.__dict__.pop("stress_modes", None)

    @property
    def modal_stiffness(self) -> Floats:
        """Modal stiffness matrix (m, m) in 1/s2, diagonal."""
        return np.diag((2 * np.pi * self.frequencies) ** 2)

    def with_modes(self, modes: Sequence[int]) -> Self:
        """Return the body with a selection of its modes, counted from 0.

        Raises
        ------
        ValueError
            If the selection is empty, or a mode appears twice or does not exist.
        """
        chosen = np.asarray(modes, dtype=np.int64)
        count = len(self.frequencies)
        if len(chosen) == 0 or len(np.unique(chosen)) < len(chosen):
            raise ValueError(f"modes must be different numbers, at least one, got {list(modes)}")
        if chosen.min() < 0 or chosen.max() >= count:
            raise ValueError(f"modes must lie in 0..{count - 1}, got {list(modes)}")
        return replace(
            self,
            frequencies=self.frequencies[chosen],
            modes=self.modes[:, :, chosen],
            pilots=self.pilots[:, :, chosen],
            parameters=dict(self.parameters) | {"modes": chosen.tolist()},
            ritz=np.zeros((len(chosen), 0)),
        )

    def weights(self, where: str | Integers) -> Floats:
        """Return the weights (n,) of a load: area shares of a named surface, equal ones of listed nodes.

        Raises
        ------
        KeyError
            If there is no such surface.
        ValueError
            If no node is given or one does not exist.
        """
        n = len(self.mesh.nodes)
        if isinstance(where, str):
            weights = self._weights_of(where)
            return weights / weights.sum()
        nodes = np.unique(np.asarray(where, dtype=np.int64))
        if len(nodes) == 0 or nodes[0] < 0 or nodes[-1] >= n:
            raise ValueError(f"nodes must be at least one, all in 0..{n - 1}, got {nodes[:1]}..{nodes[-1:]}")
        weights = np.zeros(n)
        weights[nodes] = 1.0 / len(nodes)
        return weights

    def load(self, where: str | Integers, force: Floats) -> Floats:
        """Return the modal load (m,) of a total force (3,) in N, spread evenly over a surface or nodes."""
        return np.asarray(force, dtype=float) @ self.mean_rows(self.weights(where))

    def mean_rows(self, weights: Floats) -> Floats:
        """Return weighted-mean displacement rows (3, m) of nodal weights (n,); these need not sum to 1.

        The transpose turns a force spread by the same weights into a modal load.

        Raises
        ------
        ValueError
            If the weights are not (n,) or have no positive sum.
        """
        weights = np.asarray(weights, dtype=float)
        total = weights.sum()
        if weights.shape != (len(self.mesh.nodes),) or not total > 0.0:
            raise ValueError(
                f"weights must be ({len(self.mesh.nodes)},) with a positive sum, "
                f"got {weights.shape} with sum {total}"
            )
        chosen = np.flatnonzero(weights)
        return np.tensordot(weights[chosen] / total, self.modes[chosen], axes=1)

    def motion_rows(self, weights: Floats, center: Floats) -> Floats:
        """Return weighted-mean motion rows (6, m) of nodal weights (n,) seen at a centre (3,).

        They give translation and rotation of the weighted least-squares rigid motion (RBE3). The transpose
        turns a force and a moment at the centre into a modal load.
        """
        chosen = np.flatnonzero(weights)
        rows = averaging_rows(
            self.mesh.nodes[chosen], np.asarray(weights)[chosen], np.asarray(center, dtype=float)
        )
        return rows @ self.modes[chosen].reshape(3 * len(chosen), -1)

    def polygon_weights(self, surface: str, polygon: Floats) -> Floats:
        """Return area weights (n,) in m2 of a surface's nodes with x, y inside a polygon (k, 2).

        Raises
        ------
        KeyError
            If there is no such surface.
        """
        x, y = self.mesh.nodes[:, 0], self.mesh.nodes[:, 1]
        inside = np.zeros(len(x), dtype=bool)
        corners = np.asarray(polygon, dtype=float)
        for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            crosses = (y0 > y) != (y1 > y)
            with np.errstate(divide="ignore", invalid="ignore"):
                crossing = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
            inside ^= crosses & (x < crossing)
        return np.where(inside, self._weights_of(surface), 0.0)

    def _weights_of(self, surface: str) -> Floats:
        """Return area weights (n,) in m2 of a named surface."""
        if surface not in self.surface_weights:
            raise KeyError(f"surface must be one of {sorted(self.surface_weights)}, got {surface!r}")
        return self.surface_weights[surface]
