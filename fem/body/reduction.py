"""Craig-Bampton reduction of an elastic body with interfaces.

R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
(1968) 1313-1319. The modes are orthonormalised as in multibody codes: they are eigenvectors of the
reduced pencil, their mass matrix is the identity, their stiffness diagonal.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array

from fem.body.eigen import is_small, iterated_modes, lowest_modes
from fem.body.elastic_body import ElasticBody
from fem.body.interfaces import (
    Interface,
    check_interfaces,
    rigid_motion_of_centers,
    spider_transformation,
)
from fem.body.mesh import Floats
from fem.body.reduced import ReducedBody
from fem.body.solver import Backend, Solve, factorized
from fem.memory import give_back_memory

BALANCED = 1e-9
"""Norm of a balanced load below which it is rounding, fraction of the load's norm."""
RIGID_RESIDUAL = 1e-6
"""Greatest ratio of a rigid-body mode's strain energy to that of the first elastic mode."""


class Partition:
    """Elastic body with interfaces tied by spiders, and its exact static responses.

    Parameters
    ----------
    body : ElasticBody
    interfaces : sequence of Interface
        Their nodes must not overlap.
    backend : str, optional
        See `solver.factorized`.

    Raises
    ------
    ValueError
        If the interfaces do not fit the mesh.
    """

    def __init__(
        self,
        body: ElasticBody,
        interfaces: Sequence[Interface],
        backend: Backend | None = None,
    ) -> None:
        check_interfaces(body.mesh, interfaces)
        self.body = body
        self.interfaces = tuple(interfaces)
        self.backend = backend

    @cached_property
    def _spiders(self) -> tuple[csr_array, csr_array]:
        return spider_transformation(self.body.mesh, self.interfaces)

    @property
    def of_centers(self) -> csr_array:
        """Matrix (3n, 6 i) from motions of the joint centres to displacements."""
        return self._spiders[0]

    @property
    def of_rest(self) -> csr_array:
        """Matrix (3n, r) from free motions to displacements with the joint centres held."""
        return self._spiders[1]

    @property
    def stiffness(self) -> csr_array:
        """Stiffness (r, r) in N/m with the joint centres held; only its factors are kept in memory."""
        matrix = csr_array(self.of_rest.T @ self.body.stiffness @ self.of_rest)
        matrix.sort_indices()
        return matrix

    @property
    def mass(self) -> csr_array:
        """Mass (r, r) in kg with the joint centres held."""
        return csr_array(self.of_rest.T @ self.body.mass_matrix @ self.of_rest)

    @cached_property
    def _solver(self) -> Solve:
        return factorized(self.stiffness, self.backend)

    def held_response(self, forces: Floats, refined: bool = True) -> Floats:
        """Solve for displacements (3n, k) in m under forces (3n, k) in N with the joint centres held."""
        return self.of_rest @ self._solver(np.asfortranarray(self.of_rest.T @ forces), refined)

    @cached_property
    def constraint_modes(self) -> Floats:
        """Static displacements (3n, 6 i) under unit motions of one joint centre, the others held."""
        unit = self.of_centers.toarray()
        return unit - self.held_response(self.body.stiffness @ unit)

    @cached_property
    def _center_flexibility(self) -> Floats:
        stiffness = self.constraint_modes.T @ (self.body.stiffness @ self.constraint_modes)
        rigid = np.linalg.qr(rigid_motion_of_centers(self.interfaces, np.zeros(3)))[0]
        elastic = scipy.linalg.null_space(rigid.T)
        return elastic @ np.linalg.solve(elastic.T @ stiffness @ elastic, elastic.T)

    def fixed_interface_modes(self, count: int) -> Floats:
        """Find the first modes (3n, count) with the joint centres held, orthonormal in mass."""
        if count == 0:
            return np.zeros((self.of_rest.shape[0], 0))
        mass = self.mass
        if is_small(mass.shape[0], count):
            _, modes = lowest_modes(self.stiffness, mass, count)
        else:
            _, modes = iterated_modes(self._solver, mass, count)
        return self.of_rest @ modes

    def static_response(self, forces: Floats | None = None, center_loads: Floats | None = None) -> Floats:
        """Find the displacements under nodal forces and loads on the joint centres by inertia relief.

        The rigid acceleration that the loads cause balances them. The displacements are those of the full
        model with its spiders, orthogonal in mass to the rigid-body modes.

        Parameters
        ----------
        forces : array (3n, k), optional
            Nodal forces in N.
        center_loads : array (6 i, k), optional
            Force and moment on each joint centre in N and N m.

        Returns
        -------
        array (3n, k)
            In m.

        Raises
        ------
        ValueError
            If there are no loads of either kind.
        """
        rigid = self.body.rigid_modes
        moved = self.body.mass_matrix @ rigid
        inertia = rigid.T @ moved
        at_centers = rigid_motion_of_centers(self.interfaces, self.body.center_of_mass)
        either = center_loads if forces is None else forces
        if either is None:
            raise ValueError("forces or center_loads must not both be None")
        columns = either.shape[1]
        loads = np.zeros((len(rigid), columns)) if forces is None else forces
        pulls = np.zeros((len(at_centers), columns)) if center_loads is None else center_loads
        resultant = rigid.T @ loads + at_centers.T @ pulls
        balanced = loads - moved @ np.linalg.solve(inertia, resultant)
        centers = self._center_flexibility @ (pulls + self.constraint_modes.T @ balanced)
        # unrefined solutions differ by some 1e-9; modes are refined, since runs depend on them
        answer = self.constraint_modes @ centers + self.held_response(balanced, refined=False)
        return answer - rigid @ np.linalg.solve(inertia, moved.T @ answer)


def craig_bampton(
    body: ElasticBody,
    interfaces: Sequence[Interface],
    n_fixed_modes: int = 76,
    residual_loads: Mapping[str, Floats] | None = None,
    backend: Backend | None = None,
    partition: Partition | None = None,
) -> ReducedBody:
    """Reduce a body to constraint modes, fixed-interface modes and optional residual modes.

    The rigid-body modes are the six combinations of constraint modes that move all joint centres as one rigid
    body. They are removed exactly, not by a frequency limit.

    Parameters
    ----------
    body : ElasticBody
    interfaces : sequence of Interface
        Attachment points; each gives six constraint modes.
    n_fixed_modes : int
        Number of fixed-interface modes.
    residual_loads : mapping of str to array, optional
        Nodal forces (n, 3) in N by name. The static mode of each load joins the basis, so that truncation
        does not lose its stress.
    backend : str, optional
        See `solver.factorized`.
    partition : Partition, optional
        The body with the same interfaces, if it has been factorized already.

    Returns
    -------
    ReducedBody
        With 6 i + n_fixed_modes + len(residual_loads) - 6 modes.

    Raises
    ------
    ValueError
        If interfaces do not fit, the mesh has fewer modes, a residual load only moves the body as a whole,
        or the basis is linearly dependent.
    RuntimeError
        If a rigid-body mode stores energy, or an elastic mode does not.
    """
    partition = partition or Partition(body, interfaces, backend)
    available = partition.of_rest.shape[1]
    if not 0 <= n_fixed_modes <= available:
        raise ValueError(
            f"n_fixed_modes must lie in 0..{available}, the mesh's free motions, got {n_fixed_modes}"
        )
    loads = {
        name: np.asarray(force, dtype=float).reshape(-1) for name, force in (residual_loads or {}).items()
    }
    for name, load in loads.items():
        if load.shape != (3 * len(body.mesh.nodes),) or not np.isfinite(load).all():
            raise ValueError(
                f"residual load {name!r} must be finite and ({len(body.mesh.nodes)}, 3), "
                f"got {load.size} numbers, {np.isfinite(load).sum()} of them finite"
            )
    columns = [partition.constraint_modes, partition.fixed_interface_modes(n_fixed_modes)]
    if loads:
        columns.append(partition.held_response(_balanced(body, loads)))
    basis = np.column_stack(columns)
    columns.clear()
    centers = np.zeros((6 * len(partition.interfaces), basis.shape[1]))
    centers[:, : len(centers)] = np.eye(len(centers))
    turn, eigenvalues, ritz = _elastic_combinations(body, basis, partition.interfaces)
    modes = basis @ turn
    del basis
    give_back_memory()
    return ReducedBody.from_modes(
        body,
        partition.interfaces,
        np.sqrt(eigenvalues) / (2 * np.pi),
        modes.reshape(-1, 3, modes.shape[1]),
        (centers @ turn).reshape(len(partition.interfaces), 6, -1),
        {"n_fixed_modes": n_fixed_modes, "residual_loads": list(loads)},
        ritz,
    )


def _balanced(body: ElasticBody, loads: Mapping[str, Floats]) -> Floats:
    """Balance loads (3n,), see `ElasticBody.balanced`: array (3n, loads); raise an error if one vanishes."""
    forces = np.column_stack(list(loads.values()))
    balanced = body.balanced(forces)
    for name, force, rest in zip(loads, forces.T, balanced.T, strict=True):
        if np.linalg.norm(rest) <= BALANCED * np.linalg.norm(force):
            raise ValueError(
                f"residual load {name!r} must deform the body, but the inertia balances it at every node"
            )
    return balanced


class Nested(NamedTuple):
    """Reduction inside another one with M modes.

    Attributes
    ----------
    body : ReducedBody
        Inner reduction with m modes.
    inside : array (M, m)
        Its modes in the coordinates of the outer reduction: inner ``modes`` = outer ``modes @ inside``.
    """

    body: ReducedBody
    inside: Floats

    def with_modes(self, modes: Sequence[int]) -> Self:
        """Return the reduction with a selection of its modes, see `ReducedBody.with_modes`."""
        return type(self)(self.body.with_modes(modes), self.inside[:, list(modes)])


def nested_reduction(body: ReducedBody, n_fixed_modes: int, residual_loads: Sequence[str] = ()) -> Nested:
    """Reduce a reduced body to fewer Ritz vectors.

    Craig-Bampton bases nest: a reduction with fewer fixed-interface modes lies inside one with more. A small
    Rayleigh-Ritz projection in the coordinates of the larger one gives the same body as `craig_bampton`.

    Parameters
    ----------
    body : ReducedBody
        Result of `craig_bampton` with all of its modes.
    n_fixed_modes : int
        Number of its fixed-interface modes to keep.
    residual_loads : sequence of str
        Names of its residual loads to keep.

    Raises
    ------
    ValueError
        If the body has fewer fixed-interface modes, lacks these loads, or has lost some of its modes.
    """
    most = body.parameters["n_fixed_modes"]
    loads = body.parameters["residual_loads"]
    if body.ritz.shape[1] == 0:
        raise ValueError("body must have all modes of its reduction, got one without some of them")
    if not 0 <= n_fixed_modes <= most:
        raise ValueError(f"n_fixed_modes must lie in 0..{most}, those of the body, got {n_fixed_modes}")
    unknown = sorted(set(residual_loads) - set(loads))
    if unknown:
        raise ValueError(f"residual_loads must be among those of the body, {loads}, got {unknown}")
    wanted = [name in residual_loads for name in loads]
    if n_fixed_modes == most and all(wanted):
        return Nested(body, np.eye(len(body.frequencies)))
    constraints = 6 * len(body.interfaces)
    chosen = np.r_[np.arange(constraints + n_fixed_modes), constraints + most + np.flatnonzero(wanted)]
    vectors = body.ritz[:, chosen]
    # six combinations of the constraint modes are rigid: the elastic parts span six directions fewer
    spanned = np.linalg.svd(vectors / np.linalg.norm(vectors, axis=0), full_matrices=False)[0]
    spanned = spanned[:, : len(chosen) - 6]
    eigenvalues, turn = np.linalg.eigh(spanned.T @ body.modal_stiffness @ spanned)
    inside = spanned @ turn
    inside = inside * _senses(body.pilots.reshape(constraints, -1) @ inside)
    nested = replace(
        body,
        frequencies=np.sqrt(eigenvalues) / (2 * np.pi),
        modes=body.modes @ inside,
        pilots=body.pilots @ inside,
        parameters={"n_fixed_modes": n_fixed_modes, "residual_loads": list(residual_loads)},
        ritz=inside.T @ vectors,
    )
    return Nested(nested, inside)


def _senses(motions: Floats) -> Floats:
    """Return signs (m,) that make the first large motion of the joint centres (6 i, m) positive in each mode.

    The sign of an eigenvector depends on rounding, but a stored modal coordinate needs a fixed sign. The
    greatest motion does not determine it: a symmetric body has two motions of one size.
    """
    large = np.abs(motions) > 0.9 * np.abs(motions).max(axis=0)
    first = np.take_along_axis(motions, large.argmax(axis=0)[None], axis=0)[0]
    return np.where(first < 0.0, -1.0, 1.0)


def _elastic_combinations(
    body: ElasticBody, basis: Floats, interfaces: Sequence[Interface]
) -> tuple[Floats, Floats, Floats]:
    """Find the combinations (b, m) of a basis (3n, b) that are elastic modes.

    Also return their eigenvalues (m,) and the basis' elastic part in their coordinates (m, b).
    """
    mass = basis.T @ (body.mass_matrix @ basis)
    stiffness = basis.T @ (body.stiffness @ basis)
    scale = 1.0 / np.sqrt(np.diag(mass))
    mass = mass * np.outer(scale, scale)
    stiffness = stiffness * np.outer(scale, scale)
    weakest = np.linalg.eigvalsh(mass)[0]
    if weakest < 1e-13:
        raise ValueError(
            f"residual_loads must differ from each other and from the other modes, got a basis of "
            f"{len(mass)} modes that is linearly dependent: least eigenvalue of its scaled mass {weakest:.1e}"
        )
    rigid = np.zeros((len(mass), 6))
    rigid[: 6 * len(interfaces)] = rigid_motion_of_centers(interfaces, body.center_of_mass)
    rigid = rigid / scale[:, None]
    elastic = scipy.linalg.null_space((mass @ rigid).T)
    eigenvalues, vectors = scipy.linalg.eigh(elastic.T @ stiffness @ elastic, elastic.T @ mass @ elastic)
    energy = np.diag(rigid.T @ stiffness @ rigid) / np.diag(rigid.T @ mass @ rigid)
    if np.abs(energy).max() > RIGID_RESIDUAL * eigenvalues[0] or eigenvalues[0] <= 0:
        raise RuntimeError(
            f"rigid-body modes have eigenvalues up to {np.abs(energy).max():.2e} 1/s2, the first "
            f"elastic one {eigenvalues[0]:.2e}: the body has a mechanism or the solution failed"
        )
    turn = scale[:, None] * (elastic @ vectors)
    turn = turn * _senses(turn[: 6 * len(interfaces)])
    return turn, eigenvalues, (turn / scale[:, None]).T @ mass / scale
