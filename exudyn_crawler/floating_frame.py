"""A reduced elastic shoe as Exudyn's floating-frame body takes it.

The integrals over the body are those of the nodal-based floating frame of reference formulation with modal
reduction (Zwölfer and Gerstmayr, Acta Mechanica 2020, doi 10.1007/s00707-020-02886-2), with the consistent
mass matrix of the finite elements. Only a few massless nodes go along: four round every joint centre, which
carry the motion of its spider, and one that moves as the mean of the top face.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.parameters.flexible import FlexibleShoes
from exudyn_crawler.underside import Underside, integrate_underside
from fem import ElasticBody, Interface, Material, ReducedBody, craig_bampton, read_mesh
from meshes import JOINT_CENTERS, SHOE_SIZES, shoe_mesh

ARM = 0.05
"""m, distance of a joint's massless nodes from its centre."""
JOINT_OFFSETS = ARM * np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
"""Corners of a tetrahedron: their mean is the centre, and no axis of rotation is preferred."""
NODES_A_JOINT = len(JOINT_OFFSETS)


@dataclass(frozen=True)
class FloatingShoe:
    """Everything that the multibody system needs of a flexible shoe; m modes.

    Attributes
    ----------
    reduced : fem.ReducedBody
        Modes, stress modes and surfaces.
    joints : tuple of str
        Names of the joint centres, in the order of their nodes.
    positions : array (nodes, 3)
        Massless nodes, m: `NODES_A_JOINT` of every joint, then the top face's.
    modes : array (3 nodes, m)
        Their displacements.
    integrals : dict
        Inertia of the body as Exudyn's `ObjectFFRFreducedOrder` names it.
    underside : Underside
        Integrated modes of the underside.
    """

    reduced: ReducedBody
    joints: tuple[str, ...]
    positions: NDArray
    modes: NDArray
    integrals: dict[str, NDArray | float]
    underside: Underside

    def joint_nodes(self, joint: str) -> list[int]:
        """Massless nodes of a joint centre."""
        first = NODES_A_JOINT * self.joints.index(joint)
        return list(range(first, first + NODES_A_JOINT))

    @property
    def top_node(self) -> int:
        """Massless node that moves as the mean of the top face."""
        return len(self.positions) - 1

    @property
    def mode_count(self) -> int:
        """Number of modes that answer dynamically."""
        return self.modes.shape[1]


@lru_cache(maxsize=4)
def shoe_model(flexible: FlexibleShoes) -> tuple[ElasticBody, list[Interface]]:
    """Finite-element model of a flexible shoe and its four joint centres."""
    mesh = shoe_mesh(flexible.mesh) if flexible.mesh in SHOE_SIZES else read_mesh(flexible.mesh)
    material = Material(flexible.youngs_modulus, flexible.poissons_ratio, flexible.density)
    interfaces = [
        Interface(name, np.array(center), mesh.nodes_of(f"bore {name}"))
        for name, center in JOINT_CENTERS.items()
    ]
    return ElasticBody(mesh, material), interfaces


@lru_cache(maxsize=4)
def floating_shoe(flexible: FlexibleShoes, footprint: tuple[float, ...]) -> FloatingShoe:
    """Reduce the mesh of a flexible shoe and integrate what the multibody system needs.

    The last few results are remembered: a run builds its system twice.

    Parameters
    ----------
    footprint : tuple of float (5)
        Underside that contact takes the shoe to have: least and greatest x, least and greatest y, z; m.
    """
    body, interfaces = shoe_model(flexible)
    mesh = body.mesh
    reduced = craig_bampton(body, interfaces, n_fixed_modes=flexible.fixed_modes)
    positions, rows = _massless_nodes(reduced)
    under = mesh.nodes_of("underside")
    return FloatingShoe(
        reduced=reduced,
        joints=tuple(JOINT_CENTERS),
        positions=positions,
        modes=rows.reshape(-1, rows.shape[2]),
        integrals=_integrals(body, reduced.modes),
        underside=integrate_underside(mesh.nodes[under, :2], reduced.modes[under], np.array(footprint)),
    )


def _massless_nodes(reduced: ReducedBody) -> tuple[NDArray, NDArray]:
    """Positions (nodes, 3) and mode rows (nodes, 3, modes) of the massless nodes."""
    positions, rows = [], []
    for interface, pilot in zip(reduced.interfaces, reduced.pilots, strict=True):
        for offset in JOINT_OFFSETS:
            positions.append(interface.center + offset)
            rows.append(pilot[:3] + np.cross(pilot[3:], offset, axisa=0, axisc=0))
    weights = reduced.weights("top")
    positions.append(weights @ reduced.nodes / weights.sum())
    rows.append(reduced.mean_rows(weights))
    return np.array(positions), np.array(rows)


def _skew(vectors: NDArray) -> NDArray:
    """Skew matrices of nodal vectors (nodes, 3, columns), stacked: (3 nodes, 3 columns)."""
    nodes, _, columns = vectors.shape
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    out = np.zeros((nodes, 3, columns, 3))
    out[:, 0, :, 1], out[:, 0, :, 2] = -z, y
    out[:, 1, :, 0], out[:, 1, :, 2] = z, -x
    out[:, 2, :, 0], out[:, 2, :, 1] = -y, x
    return out.reshape(3 * nodes, 3 * columns)


def _integrals(body: ElasticBody, modes: NDArray) -> dict[str, NDArray | float]:
    """Inertia integrals of a body and its modes (nodes, 3, m), about the origin of its axes."""
    nodes, _, count = modes.shape
    mass = body.mass_matrix
    translation = np.tile(np.eye(3), (nodes, 1))
    shapes = modes.reshape(3 * nodes, count)
    shapes_skew = _skew(modes)
    place_skew = _skew(body.mesh.nodes[:, :, None])
    mass_shapes, mass_shapes_skew = mass @ shapes, mass @ shapes_skew
    mass_translation = mass @ translation
    return {
        "mass": body.mass,
        "inertia": place_skew.T @ (mass @ place_skew),
        "centerOfMass": mass_translation.T @ body.mesh.nodes.ravel() / body.mass,
        "mPsiTildePsi": shapes_skew.T @ mass_shapes,
        "mPsiTildePsiTilde": shapes_skew.T @ mass_shapes_skew,
        "mPhitTPsi": translation.T @ mass_shapes,
        "mPhitTPsiTilde": translation.T @ mass_shapes_skew,
        "mXRefTildePsi": place_skew.T @ mass_shapes,
        "mXRefTildePsiTilde": place_skew.T @ mass_shapes_skew,
    }
