"""A reduced elastic shoe as Exudyn's floating-frame body takes it.

The integrals over the body are those of the nodal-based floating frame of reference formulation with modal
reduction (Zwölfer and Gerstmayr, Acta Mechanica 2020, doi 10.1007/s00707-020-02886-2), with the consistent
mass matrix of the finite elements. Only a few massless nodes go along: four round every joint centre, which
carry the motion of its spider, and three that move as means of the top face:
of its right, of its left and of all of it.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, FlexibleShoes, Track
from exudyn_crawler.case.files.case_file import check_modes
from exudyn_crawler.case.parameters.flexible import CONSTRAINT_MODES
from exudyn_crawler.model.drive_point import pulled_node
from exudyn_crawler.model.reductions import cached_reduction
from exudyn_crawler.model.shoe_mesh import check_footprint, check_rails, pin_interfaces
from fem import CachedReduction, ElasticBody, Interface, Material, Nested, ReducedBody, nested_reduction
from fem.patches import Underside, integrate_underside
from meshes import mesh_named
from meshes.checks import check_surfaces

MACHINE_LOAD, DRIVE = "machine load", "drive"
"""Loads whose static answers may join the modes."""

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
        Massless nodes, m: `NODES_A_JOINT` of every joint, then the top face's (right, left, whole).
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
    def side_nodes(self) -> tuple[int, int]:
        """Massless nodes that move as the means of the top face weighted to the right and to the left."""
        return self.top_node - 2, self.top_node - 1

    @property
    def reach(self) -> float:
        """Distance across the shoe of these nodes from the top face's own, m."""
        right, left = self.side_nodes
        return float(self.positions[left, 1] - self.positions[right, 1]) / 2.0

    @property
    def mass(self) -> float:
        """Mass of the mesh, kg."""
        return float(self.integrals["mass"])

    @property
    def mode_count(self) -> int:
        """Number of modes that answer dynamically."""
        return self.modes.shape[1]


def _material(flexible: FlexibleShoes) -> Material:
    return Material(flexible.youngs_modulus, flexible.poissons_ratio, flexible.density)


@lru_cache(maxsize=4)
def _finite_elements(mesh_name: str, material: Material, track: Track) -> tuple[ElasticBody, list[Interface]]:
    mesh = mesh_named(mesh_name)
    return ElasticBody(mesh, material), pin_interfaces(mesh, mesh_name, track)


def shoe_model(flexible: FlexibleShoes, track: Track) -> tuple[ElasticBody, list[Interface]]:
    """Finite-element model of a flexible shoe and its four joint centres; remembered.

    Raises
    ------
    ValueError
        If the mesh has no bores where the track's pins are, or lacks its underside or the surface that is
        loaded.
    """
    body, interfaces = _finite_elements(flexible.mesh, _material(flexible), track)
    check_surfaces(body.mesh, flexible.load_surface, flexible.mesh)
    check_modes(len(body.mesh.nodes), CONSTRAINT_MODES + flexible.recovered_modes)
    return body, interfaces


@lru_cache(maxsize=4)
def _reduction(
    mesh: str,
    material: Material,
    track: Track,
    fixed_modes: int,
    load_surface: str | None,
    node: int | None,
) -> CachedReduction:
    body, interfaces = _finite_elements(mesh, material, track)
    loads = {}
    if load_surface is not None:
        loads[MACHINE_LOAD] = body.surface_load(load_surface, np.array([0.0, 0.0, -1.0]))
    if node is not None:
        loads[DRIVE] = np.zeros_like(body.mesh.nodes)
        loads[DRIVE][node, 0] = 1.0
    return cached_reduction(body, interfaces, fixed_modes, loads)


def check_shoe(case: Case) -> None:
    """Refuse a mesh of the flexible shoes that does not fit the track, its shoes or the machine's memory.

    Raises
    ------
    ValueError
        Naming what does not fit.
    """
    flexible = case.flexible_shoes()
    body, _ = shoe_model(flexible, case.track)
    check_footprint(body.mesh, flexible.mesh, case.shoe)
    if case.undercarriage is not None and case.shoe.rails is not None:
        check_rails(body.mesh, flexible.mesh, case.shoe.rails)


def whole_reduction(case: Case) -> CachedReduction:
    """Reduce the shoe of a case to all the modes that its stress is made of; remembered, and kept on disk.

    They are the constraint modes and `recovered_modes` fixed-interface modes. The static answer to a force
    along x on the node that the drive pulls joins them, if there is one: no fixed-interface mode knows of a
    force on a single node.

    Raises
    ------
    ValueError
        If the case has no flexible shoes or their mesh does not fit the track.
    """
    flexible = case.flexible_shoes()
    body, _ = shoe_model(flexible, case.track)
    loaded = flexible.load_surface if flexible.load_mode else None
    node = pulled_node(case, body.mesh)
    return _reduction(flexible.mesh, _material(flexible), case.track, flexible.recovered_modes, loaded, node)


def integrated_reduction(case: Case) -> Nested:
    """Modes that a run of a case integrates, and where they lie in `whole_reduction`; remembered.

    Raises
    ------
    ValueError
        If the case has no flexible shoes, their mesh does not fit the track or no mode remains.
    """
    return integrated_in(case.flexible_shoes(), whole_reduction(case).body)


@lru_cache(maxsize=4)
def integrated_in(flexible: FlexibleShoes, whole: ReducedBody) -> Nested:
    """Modes of flexible shoes that are integrated, and where they lie in the whole reduction; remembered."""
    nested = nested_reduction(whole, flexible.fixed_modes, [MACHINE_LOAD] if flexible.load_mode else [])
    if flexible.modes is not None:
        return nested.with_modes([number - 1 for number in flexible.modes])
    if flexible.highest_frequency is not None:
        frequencies = nested.body.frequencies
        below = np.flatnonzero(frequencies <= flexible.highest_frequency)
        if len(below) == 0:
            raise ValueError(
                f"highest_frequency must be at least that of the first mode, {frequencies[0]:.1f} Hz, "
                f"got {flexible.highest_frequency:g} Hz"
            )
        return nested.with_modes(below.tolist())
    return nested


def floating_shoe(case: Case) -> FloatingShoe:
    """Reduce the mesh of a case's flexible shoes and integrate what the multibody system needs.

    The last few results are remembered: a run builds its system twice.

    Raises
    ------
    ValueError
        If the case has no flexible shoes, their mesh does not fit the track or no mode remains.
    """
    check_shoe(case)
    reduced = integrated_reduction(case).body
    return _floating_shoe(case.flexible_shoes(), case.track, tuple(case.shoe.footprint.tolist()), reduced)


@lru_cache(maxsize=4)
def _floating_shoe(
    flexible: FlexibleShoes, track: Track, footprint: tuple[float, ...], reduced: ReducedBody
) -> FloatingShoe:
    body, interfaces = shoe_model(flexible, track)
    mesh = body.mesh
    positions, rows = _massless_nodes(reduced, flexible.load_surface)
    under = mesh.nodes_of("underside")
    return FloatingShoe(
        reduced=reduced,
        joints=tuple(interface.name for interface in interfaces),
        positions=positions,
        modes=rows.reshape(-1, rows.shape[2]),
        integrals=_integrals(body, reduced.modes),
        underside=integrate_underside(mesh.nodes[under, :2], reduced.modes[under], np.array(footprint)),
    )


def _massless_nodes(reduced: ReducedBody, loaded: str) -> tuple[NDArray, NDArray]:
    """Positions (nodes, 3) and mode rows (nodes, 3, modes) of the massless nodes."""
    positions, rows = [], []
    for interface, pilot in zip(reduced.interfaces, reduced.pilots, strict=True):
        for offset in JOINT_OFFSETS:
            positions.append(interface.center + offset)
            rows.append(pilot[:3] + np.cross(pilot[3:], offset, axisa=0, axisc=0))
    weights = reduced.weights(loaded)
    for one in (*side_weights(weights, reduced.nodes), weights):
        positions.append(one @ reduced.nodes / one.sum())
        rows.append(reduced.mean_rows(one))
    return np.array(positions), np.array(rows)


def side_weights(weights: NDArray, nodes: NDArray) -> tuple[NDArray, NDArray]:
    """Weights (n,) of a surface that grow evenly from nothing at one side to the right and to the left.

    Both together are the even ones twice. A load that both share in unequal parts presses with a pressure
    that changes evenly across the shoe.

    Parameters
    ----------
    weights : array (n,)
        Even ones: shares of the surface's area.
    nodes : array (n, 3)
        m.
    """
    across = nodes[:, 1] - weights @ nodes[:, 1] / weights.sum()
    part = across / np.abs(across[weights != 0.0]).max()
    return weights * (1.0 - part), weights * (1.0 + part)


def weights_a_metre(weights: NDArray, nodes: NDArray) -> NDArray:
    """Weights (n,) that a load over a surface has more for each metre of shift to the left.

    Parameters are those of `side_weights`.
    """
    right, left = side_weights(weights, nodes)
    apart = left @ nodes[:, 1] / left.sum() - right @ nodes[:, 1] / right.sum()
    return np.asarray((left / left.sum() - right / right.sum()) / apart)


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
