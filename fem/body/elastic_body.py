"""Elastic body: mesh and material with their matrices, rigid properties and loads."""

from functools import cached_property, lru_cache

import numpy as np
import scipy.linalg
from scipy.sparse import bsr_array, csr_array

from fem.body.eigen import lowest_modes
from fem.body.elasticity import Material, mass_matrix, stiffness_matrix
from fem.body.element_stress import nodal_gradient_operator, nodal_stress
from fem.body.mesh import Floats, Integers, Mesh
from fem.body.solver import Solve, factorized
from fem.body.surfaces import surface_weights
from fem.memory import give_back_memory

SHIFT_FREQUENCY_RATIO = 0.3
"""Ratio of the spectral shift's frequency to that of a rod as long as the body's greatest extent."""


def rigid_modes(positions: Floats, center: Floats) -> Floats:
    """Return the displacements (3n, 6) of unit translations along and unit rotations about x, y, z."""
    modes = np.zeros((len(positions), 3, 6))
    modes[:, range(3), range(3)] = 1.0
    for axis in range(3):
        modes[:, :, 3 + axis] = np.cross(np.eye(3)[axis], positions - center)
    return modes.reshape(-1, 6)


@lru_cache(maxsize=2)
def _gradient_operator(mesh: Mesh) -> csr_array:
    operator = nodal_gradient_operator(mesh)
    give_back_memory()
    return operator


class ElasticBody:
    """Elastic body in its own axes; all lengths in m, matrices with xyz per node.

    Parameters
    ----------
    mesh : Mesh
    material : Material
    """

    def __init__(self, mesh: Mesh, material: Material) -> None:
        self.mesh = mesh
        self.material = material
        self._held_solver: Solve | None = None

    @property
    def stiffness(self) -> csr_array:
        """Stiffness matrix (3n, 3n) in N/m, converted from its stored blocks."""
        return csr_array(self._stiffness)

    @cached_property
    def _stiffness(self) -> bsr_array:
        """Stiffness matrix in blocks (3, 3): two thirds of the memory of rows, but products half as fast."""
        matrix = stiffness_matrix(self.mesh, self.material)
        # the element matrices were six times as large
        give_back_memory()
        return matrix

    def forget_matrices(self) -> None:
        """Free the stiffness and mass matrices; they are assembled again at the next use."""
        self.__dict__.pop("_stiffness", None)
        self.__dict__.pop("mass_matrix", None)

    @cached_property
    def mass_matrix(self) -> csr_array:
        """Consistent mass matrix (3n, 3n) in kg."""
        matrix = mass_matrix(self.mesh, self.material.density)
        give_back_memory()
        return matrix

    @cached_property
    def _rigid_mass(self) -> Floats:
        modes = rigid_modes(self.mesh.nodes, np.zeros(3))
        return modes.T @ (self.mass_matrix @ modes)

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return float(self._rigid_mass[0, 0])

    @property
    def center_of_mass(self) -> Floats:
        """Centre of mass (3,) in m."""
        moment = self._rigid_mass[:3, 3:]
        return np.array([moment[1, 2], moment[2, 0], moment[0, 1]]) / self.mass

    @property
    def inertia(self) -> Floats:
        """Inertia tensor (3, 3) about the centre of mass in kg m2."""
        c = self.center_of_mass
        return self._rigid_mass[3:, 3:] - self.mass * (c @ c * np.eye(3) - np.outer(c, c))

    @cached_property
    def rigid_modes(self) -> Floats:
        """Rigid-body modes (3n, 6) about the centre of mass, not normalised."""
        return rigid_modes(self.mesh.nodes, self.center_of_mass)

    @property
    def gradient_operator(self) -> csr_array:
        """Matrix (3n, n) of `element_stress.nodal_gradient_operator`, cached for two meshes."""
        return _gradient_operator(self.mesh)

    @property
    def shift(self) -> float:
        """Spectral shift in 1/s2 that makes K + shift M definite, set by the body's size."""
        speed = np.sqrt(self.material.youngs_modulus / self.material.density)
        length = np.ptp(self.mesh.nodes, axis=0).max()
        return float((SHIFT_FREQUENCY_RATIO * np.pi * speed / length) ** 2)

    def free_modes(self, count: int) -> tuple[Floats, Floats]:
        """Find the first free-free modes, the six rigid-body modes included.

        Returns
        -------
        eigenvalues : array (count,)
            In 1/s2, ascending.
        modes : array (3n, count)
            Orthonormal in mass.

        Raises
        ------
        ValueError
            If the body has fewer modes.
        """
        return lowest_modes(self.stiffness, self.mass_matrix, count, self.shift)

    def natural_frequencies(self, count: int) -> Floats:
        """Return the first free-free frequencies (count,) in Hz, the six zeros included."""
        eigenvalues, _ = self.free_modes(count)
        return np.sqrt(np.maximum(eigenvalues, 0.0)) / (2 * np.pi)

    def stress(self, displacements: Floats, nodes: Integers | None = None) -> Floats:
        """Return the nodal stress (n or len(nodes), 6, m) in Pa of displacements (n, 3, m) in m."""
        return nodal_stress(self.gradient_operator, self.material, displacements, nodes)

    def surface_weights(self, surface: str | Integers) -> Floats:
        """Integrate each node's shape function over a surface: (n,) in m2, in sum its area.

        Parameters
        ----------
        surface : str or int array (k, 3 or 6)
            Name of a surface, or its triangles.

        Raises
        ------
        KeyError
            If there is no such surface.
        """
        faces = self.mesh.surface(surface) if isinstance(surface, str) else np.asarray(surface)
        return surface_weights(self.mesh, faces)

    def surface_load(self, surface: str | Integers, force: Floats) -> Floats:
        """Return the nodal forces (n, 3) in N of a total force (3,) in N spread evenly over a surface."""
        weights = self.surface_weights(surface)
        return weights[:, None] / weights.sum() * np.asarray(force, dtype=float)

    def balanced(self, forces: Floats) -> Floats:
        """Return self-equilibrated nodal forces (3n, m): the forces less the inertia of the rigid motion."""
        rigid = self.rigid_modes
        moved = self.mass_matrix @ rigid
        return np.asarray(forces - moved @ np.linalg.solve(rigid.T @ moved, rigid.T @ forces))

    def displacement_under(self, forces: Floats) -> Floats:
        """Find the displacements under loads by inertia relief, free of rigid motion.

        The rigid acceleration that the loads cause balances them. The displacements are orthogonal in mass to
        the rigid-body modes.

        Parameters
        ----------
        forces : array (3n, m)
            In N.

        Returns
        -------
        array (3n, m)
            In m.
        """
        rigid = self.rigid_modes
        moved = self.mass_matrix @ rigid
        inertia = rigid.T @ moved
        balanced = self.balanced(forces)
        held = self.statically_determinate
        answer = np.zeros_like(balanced)
        free = np.setdiff1d(np.arange(len(answer)), held)
        if self._held_solver is None:
            self._held_solver = factorized(csr_array(self.stiffness[free][:, free]))
        answer[free] = self._held_solver(balanced[free])
        return answer - rigid @ np.linalg.solve(inertia, moved.T @ answer)

    @cached_property
    def statically_determinate(self) -> Integers:
        """Six degrees of freedom of three far-apart nodes that hold the body without stress."""
        return self.determinate_of(np.arange(len(self.mesh.nodes)))

    def determinate_of(self, nodes: Integers) -> Integers:
        """Select six degrees of freedom (3 node + axis) of nodes that hold the body without stress."""
        positions = self.mesh.nodes[nodes]
        first = int(np.argmin(positions @ np.ones(3)))
        arm = positions - positions[first]
        second = int(np.argmax(np.linalg.norm(arm, axis=1)))
        axis = arm[second] / np.linalg.norm(arm[second])
        third = int(np.argmax(np.linalg.norm(np.cross(arm, axis), axis=1)))
        candidates = np.concatenate([3 * nodes[k] + np.arange(3) for k in (first, second, third)])
        rows = self.rigid_modes[candidates]
        scale = np.array([1, 1, 1, *([1 / np.ptp(positions, axis=0).max()] * 3)])
        *_, order = scipy.linalg.qr((rows * scale).T, mode="economic", pivoting=True)
        return np.sort(candidates[order[:6]])
