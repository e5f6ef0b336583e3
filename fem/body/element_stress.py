"""Stresses from nodal displacements, and scalar stress criteria.

Components are always in the order xx, yy, zz, xy, yz, xz; shear components are those of the tensor.

Recovery rule: the strain of each element at its quadrature points (four for tet10, one for tet4)
is extrapolated linearly to its corners; a mid-side node gets the mean of its edge's corners; a node of
the mesh gets the plain mean over its elements. CalculiX has the same rule.
"""

from functools import lru_cache
from typing import Literal

import numpy as np
from scipy.sparse import csr_array
from skfem import ElementTetP1
from skfem.quadrature import get_quadrature

from fem.body.elasticity import STIFFNESS_ORDER, Material, shape_gradients
from fem.body.mesh import TETRA_EDGES, Floats, Integers, Mesh

Criterion = Literal[
    "von mises",
    "signed von mises",
    "greatest principal",
    "least principal",
    "greatest shear",
]
CRITERIA: tuple[Criterion, ...] = (
    "von mises",
    "signed von mises",
    "greatest principal",
    "least principal",
    "greatest shear",
)

CORNERS = 4
AT_ONCE = 16
"""Number of displacement fields whose stress is recovered at once."""

ELEMENTS_AT_ONCE = 4096
"""Number of elements whose gradients are averaged at the nodes at once."""

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Tensor indices of the six components."""

DEVIATOR = np.array(
    [
        [np.sqrt(0.5), -np.sqrt(0.5), 0, 0, 0, 0],
        [np.sqrt(1 / 6), np.sqrt(1 / 6), -2 * np.sqrt(1 / 6), 0, 0, 0],
        [0, 0, 0, np.sqrt(2), 0, 0],
        [0, 0, 0, 0, np.sqrt(2), 0],
        [0, 0, 0, 0, 0, np.sqrt(2)],
    ]
) * np.sqrt(1.5)
"""Combinations (5, 6) of the stress components whose Euclidean length is the von Mises stress."""


def _extension(order: int) -> tuple[Floats, Floats]:
    """Return quadrature points (3, q) and the matrix (nodes, q) that extrapolates values from them."""
    if order == 1:
        return np.full((3, 1), 0.25), np.ones((4, 1))
    points, _ = get_quadrature(ElementTetP1, STIFFNESS_ORDER)
    barycentric = np.vstack([1.0 - points.sum(axis=0), points]).T
    corners = np.linalg.inv(barycentric)
    return points, np.vstack([corners, corners[TETRA_EDGES].mean(axis=1)])


def element_gradient_operator(mesh: Mesh) -> Floats:
    """Return the shape functions' gradients at the nodes of each element, extrapolated.

    Returns
    -------
    array (e, node, 3, function)
        In 1/m.
    """
    return _gradients_at(mesh, CORNERS + len(TETRA_EDGES))


@lru_cache(maxsize=2)
def corner_gradient_operator(mesh: Mesh) -> Floats:
    """Return rows (e, 4, 3, function) of `element_gradient_operator` at corners, cached for two meshes."""
    operator = np.ascontiguousarray(_gradients_at(mesh, CORNERS))
    operator.setflags(write=False)
    return operator


def _gradients_at(mesh: Mesh, count: int) -> Floats:
    """Return rows of `element_gradient_operator` at the first `count` nodes of each element."""
    points, extend = _extension(mesh.order)
    gradients = shape_gradients(mesh, points)
    return np.asarray(np.einsum("pq,bieq->epib", extend[:count], gradients, optimize=True))


def nodal_gradient_operator(mesh: Mesh) -> csr_array:
    """Return the matrix (3n, n) whose rows 3 k + i give d/dx_i of a nodal field at node k, averaged."""
    # four times the memory of the matrix, and therefore not cached
    local = element_gradient_operator(mesh)
    n = len(mesh.nodes)
    count = np.bincount(mesh.elements.ravel(), minlength=n)
    total = csr_array((3 * n, n))
    # the entries of all elements at once would take many times the memory of the matrix
    for first in range(0, len(local), ELEMENTS_AT_ONCE):
        of = slice(first, first + ELEMENTS_AT_ONCE)
        elements = mesh.elements[of].astype(np.int32)
        values = local[of] / count[elements][:, :, None, None]
        rows = 3 * elements[:, :, None, None] + np.arange(3, dtype=np.int32)[None, None, :, None]
        columns = elements[:, None, None, :]
        places = [np.broadcast_to(numbers, values.shape).ravel() for numbers in (rows, columns)]
        total = total + csr_array((values.ravel(), tuple(places)), shape=total.shape)
    return total


def stress_of_gradient(gradient: Floats, material: Material) -> Floats:
    """Return the stress (..., 6) in Pa of displacement gradients (..., i, j) = du_j/dx_i."""
    lam, mu = material.lame
    trace = lam * np.einsum("...ii->...", gradient)
    stress = np.empty((*gradient.shape[:-2], 6))
    for k, (i, j) in enumerate(VOIGT):
        stress[..., k] = mu * (gradient[..., i, j] + gradient[..., j, i])
        if i == j:
            stress[..., k] += trace
    return stress


def nodal_stress(
    operator: csr_array, material: Material, displacements: Floats, nodes: Integers | None = None
) -> Floats:
    """Recover the nodal stresses of displacement fields.

    Parameters
    ----------
    operator : sparse array (3n, n)
        Result of `nodal_gradient_operator`.
    material : Material
    displacements : array (n, 3, m)
        In m.
    nodes : int array, optional
        Nodes whose stress is recovered; all if left out.

    Returns
    -------
    array (n or len(nodes), 6, m)
        In Pa.
    """
    n, _, m = displacements.shape
    if nodes is not None:
        rows = (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()
        operator = operator[rows]
    stress = np.empty((operator.shape[0] // 3, 6, m))
    # gradients take more memory than the stress
    for first in range(0, m, AT_ONCE):
        columns = slice(first, first + AT_ONCE)
        fields = displacements[:, :, columns]
        gradient = (operator @ fields.reshape(n, -1)).reshape(-1, 3, 3, fields.shape[2])
        part = stress_of_gradient(np.moveaxis(gradient, 3, 1), material)
        stress[:, :, columns] = np.moveaxis(part, 1, 2)
    return stress


def stress_at_node(
    nodes: Floats, elements: Integers, material: Material, displacements: Floats, node: int
) -> Floats:
    """Recover the stress (6, m) in Pa of displacement fields at one node from its own elements alone.

    Parameters
    ----------
    nodes : array (n, 3)
        Nodes of the mesh, m.
    elements : int array (e, 4 or 10)
    material : Material
    displacements : array (n, 3, m)
        In m.
    node : int
    """
    about = elements[(elements == node).any(axis=1)]
    used, local = np.unique(about, return_inverse=True)
    part = Mesh(nodes[used], local.reshape(about.shape), {})
    place = np.searchsorted(used, [node])
    return nodal_stress(nodal_gradient_operator(part), material, displacements[used], place)[0]


def element_deviator(
    mesh: Mesh, material: Material, displacement: Floats, elements: Integers | None = None
) -> Floats:
    """Return the combinations `DEVIATOR` of a displacement's stress at all elements' nodes, (e, a, 5) in Pa.

    `displacement` is (n, 3) in m. `elements` selects elements by number, all if left out.
    """
    operator = corner_gradient_operator(mesh)
    nodes = mesh.elements
    if elements is not None:
        operator = operator[elements]
        nodes = nodes[elements]
    count, _, _, functions = operator.shape
    gradient = operator.reshape(count, 3 * CORNERS, functions) @ displacement[nodes]
    # deviator of each of the nine derivatives
    units = np.eye(9).reshape(9, 3, 3)
    deviators = stress_of_gradient(units, material) @ DEVIATOR.T
    corners = (gradient.reshape(-1, 9) @ deviators).reshape(count, CORNERS, -1)
    if mesh.order == 1:
        return corners
    starts, ends = TETRA_EDGES.T
    return np.concatenate((corners, 0.5 * (corners[:, starts] + corners[:, ends])), axis=1)


def von_mises(stress: Floats) -> Floats:
    """Return the von Mises equivalent stress of stresses (..., 6)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * (xy**2 + yz**2 + xz**2))


def principal(stress: Floats) -> Floats:
    """Return the principal stresses (..., 3) of stresses (..., 6), ascending."""
    tensor = np.empty((*stress.shape[:-1], 3, 3))
    for k, (i, j) in enumerate(VOIGT):
        tensor[..., i, j] = tensor[..., j, i] = stress[..., k]
    return np.linalg.eigvalsh(tensor)


def evaluate(criterion: Criterion, stress: Floats) -> Floats:
    """Evaluate a scalar criterion (...) of stresses (..., 6).

    "signed von mises" has the sign of the hydrostatic stress (tension positive); "greatest shear"
    is half the difference of the extreme principal stresses.

    Raises
    ------
    ValueError
        If the criterion is unknown.
    """
    if criterion == "von mises":
        return von_mises(stress)
    if criterion == "signed von mises":
        return np.where(stress[..., :3].sum(axis=-1) < 0.0, -1.0, 1.0) * von_mises(stress)
    if criterion not in CRITERIA:
        raise ValueError(f"criterion must be one of {CRITERIA}, got {criterion!r}")
    values = principal(stress)
    if criterion == "greatest principal":
        return values[..., 2]
    if criterion == "least principal":
        return values[..., 0]
    return 0.5 * (values[..., 2] - values[..., 0])
