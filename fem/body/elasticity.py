"""Isotropic linear elasticity on tetrahedra: material, shape functions, stiffness and mass.

Stress and strain components are always in the order xx, yy, zz, xy, yz, xz.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, csr_array, kron
from skfem import Basis, ElementTetP1, ElementTetP2, MappingAffine, MappingIsoparametric, MeshTet1, MeshTet2
from skfem.mapping import Mapping

from fem.body.mesh import Floats, Mesh

STIFFNESS_ORDER = 2
"""Quadrature order of the stiffness: exact for straight edges (strains of tet10 are linear)."""

MASS_ORDER = {1: 2, 2: 7}
"""Quadrature order of the mass by element order: exact, for tet10 also with curved edges."""


@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic material.

    Parameters
    ----------
    youngs_modulus : float
        In Pa.
    poissons_ratio : float
        Inside (-1, 0.5).
    density : float
        In kg/m3.

    Raises
    ------
    ValueError
        If a value is out of its range.
    """

    youngs_modulus: float
    poissons_ratio: float
    density: float

    def __post_init__(self) -> None:
        for name in ("youngs_modulus", "density"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be finite and positive, got {value}")
        if not -1.0 < self.poissons_ratio < 0.5:
            raise ValueError(f"poissons_ratio must lie inside (-1, 0.5), got {self.poissons_ratio}")

    @property
    def lame(self) -> tuple[float, float]:
        """Lame's parameters (lambda, mu) in Pa."""
        e = self.youngs_modulus
        nu = self.poissons_ratio
        return e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))


def scalar_basis(mesh: Mesh, order: int | None = None, points: Floats | None = None) -> Basis:
    """Return the isoparametric shape functions of all elements as a basis of scikit-fem.

    Local functions are in the order of the element's nodes.

    Parameters
    ----------
    mesh : Mesh
    order : int, optional
        Quadrature order.
    points : array (3, q), optional
        Local coordinates in place of quadrature points.
    """
    local = ElementTetP1() if mesh.order == 1 else ElementTetP2()
    corners, t = np.unique(mesh.elements[:, :4], return_inverse=True)
    t = np.ascontiguousarray(t.reshape(-1, 4).T)
    linear = MeshTet1(np.ascontiguousarray(mesh.nodes[corners].T), t, sort_t=False)
    grid = linear
    # a mesh and its own mapping refer to each other: the cycle would keep hundreds of MB in memory
    mapping: Mapping = MappingAffine(linear)
    if mesh.order == 2:
        numbering = Basis(linear, local, mapping, quadrature=(np.full((3, 1), 0.25), np.ones(1)))
        positions = np.empty((3, numbering.N))
        positions[:, numbering.element_dofs] = mesh.nodes.T[:, mesh.elements.T]
        grid = MeshTet2(positions, t, sort_t=False)
        mapping = MappingIsoparametric(grid, grid.elem(), grid.bndelem)
    if points is not None:
        return Basis(grid, local, mapping, quadrature=(points, np.ones(points.shape[1])))
    return Basis(grid, local, mapping, intorder=order)


def _values_and_gradients(basis: Basis) -> tuple[Floats, Floats]:
    """Return the shape functions (a, e, q) and their gradients (a, 3, e, q) in 1/m."""
    shape = basis.dx.shape
    values = np.stack([np.broadcast_to(np.asarray(f[0]), shape) for f in basis.basis])
    gradients = np.stack([np.broadcast_to(f[0].grad, (3, *shape)) for f in basis.basis])
    return values, gradients


def shape_gradients(mesh: Mesh, points: Floats) -> Floats:
    """Return the gradients of the shape functions (a, 3, e, q) in 1/m at local points (3, q)."""
    return _values_and_gradients(scalar_basis(mesh, points=points))[1]


def _sum_blocks(mesh: Mesh, blocks: Floats) -> bsr_array:
    """Sum element blocks (e, a, b, k, k) into a (k n, k n) matrix with k rows per node, columns in order."""
    n = len(mesh.nodes)
    k = blocks.shape[-1]
    nodes = mesh.elements
    keys = (nodes[:, :, None] * n + nodes[:, None, :]).ravel()
    pairs, place = np.unique(keys, return_inverse=True)
    data = np.empty((len(pairs), k, k))
    flat = blocks.reshape(-1, k, k)
    for i in range(k):
        for j in range(k):
            data[:, i, j] = np.bincount(place, weights=flat[:, i, j], minlength=len(pairs))
    indptr = np.searchsorted(pairs, np.arange(n + 1) * n).astype(np.int32)
    columns = (pairs % n).astype(np.int32)
    return bsr_array((data, columns, indptr), shape=(k * n, k * n))


def stiffness_matrix(mesh: Mesh, material: Material) -> bsr_array:
    """Assemble the symmetric stiffness matrix (3n, 3n) in N/m, of blocks (3, 3), xyz per node."""
    lam, mu = material.lame
    basis = scalar_basis(mesh, STIFFNESS_ORDER)
    _, grad = _values_and_gradients(basis)
    g = np.ascontiguousarray(grad.transpose(2, 3, 0, 1))  # e, q, a, i
    e, q, a, _ = g.shape
    flat = g.reshape(e, q, 3 * a)
    outer = np.matmul((flat * basis.dx[:, :, None]).transpose(0, 2, 1), flat)
    outer = outer.reshape(e, a, 3, a, 3).transpose(0, 1, 3, 2, 4)  # integral of d_i N_a d_j N_b
    blocks = lam * outer + mu * outer.transpose(0, 1, 2, 4, 3)
    trace = mu * np.einsum("eabii->eab", outer)
    for i in range(3):
        blocks[..., i, i] += trace
    return _sum_blocks(mesh, blocks)


def mass_matrix(mesh: Mesh, density: float) -> csr_array:
    """Assemble the symmetric consistent mass matrix (3n, 3n) in kg, xyz per node."""
    basis = scalar_basis(mesh, MASS_ORDER[mesh.order])
    values, _ = _values_and_gradients(basis)
    v = np.ascontiguousarray(values.transpose(1, 0, 2))  # e, a, q
    scalar = np.matmul(v * (density * basis.dx)[:, None, :], v.transpose(0, 2, 1))
    scalars = csr_array(_sum_blocks(mesh, scalar[..., None, None]))
    return csr_array(kron(scalars, np.eye(3), format="csr"))
