"""Flexible shoes: their finite elements, integrated modes, and the points at which loads act."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from weakref import WeakValueDictionary

import numpy as np

import fem
from exudyn_crawler.case import Case, FlexibleShoes, Track
from exudyn_crawler.case.parameters.track import PinCoupling
from exudyn_crawler.model import reductions, shoe_mesh
from fem.body.rectangle_motion import Underside, integrate_underside
from meshes import mesh_named
from meshes.checks import check_surfaces

MACHINE_LOAD, DRIVE = "machine load", "drive"
"""Loads whose static responses may join the modes."""


@dataclass(frozen=True)
class FloatingShoe:
    """Data of a flexible shoe for the multibody system; m modes."""

    reduced: fem.ReducedBody  # modes, stress modes and surfaces
    load_point: np.ndarray  # (3,): middle of the loaded surface, m
    load_rows: np.ndarray  # (3, m): its mean displacement by the modes
    beside: np.ndarray  # (3,): change of the load's point per metre that a load shifts to the left
    beside_rows: np.ndarray  # (3, m): change of its rows
    underside: Underside  # integrated modes of the underside

    @property
    def mode_count(self) -> int:
        """Number of integrated modes."""
        return self.load_rows.shape[1]


def _material(flexible: FlexibleShoes) -> fem.Material:
    return fem.Material(flexible.youngs_modulus, flexible.poissons_ratio, flexible.density)


@lru_cache(maxsize=4)
def _finite_elements(
    mesh_name: str, material: fem.Material, track: Track, pins: PinCoupling
) -> tuple[fem.ElasticBody, list[fem.Interface]]:
    mesh = mesh_named(mesh_name)
    if mesh.order == 1:
        raise ValueError(
            f"the mesh {mesh_name!r} must have tetrahedra with 10 nodes, got linear ones with 4, which are "
            "too stiff in bending; mesh it with elements of second order (gmsh -order 2)"
        )
    return fem.ElasticBody(mesh, material), shoe_mesh.pin_interfaces(mesh, mesh_name, track, pins)


def shoe_model(flexible: FlexibleShoes, track: Track) -> tuple[fem.ElasticBody, list[fem.Interface]]:
    """Return the finite-element model of a flexible shoe and its four joint centres; remembered.

    Raises `ValueError` if the mesh has linear elements, no bores at the track's pins, no underside or no
    surface for the load.
    """
    body, interfaces = _finite_elements(flexible.mesh, _material(flexible), track, flexible.pins)
    check_surfaces(body.mesh, flexible.load_surface, flexible.mesh)
    return body, interfaces


_partitions: WeakValueDictionary[fem.ElasticBody, fem.Partition] = WeakValueDictionary()


def partition(body: fem.ElasticBody, interfaces: Sequence[fem.Interface]) -> fem.Partition:
    """Return the elastic body of a shoe coupled to its joint centres; the same object while it is in use.

    Reduction and static fields share its factors, which take half a GB.
    """
    known = _partitions.get(body)
    if known is None:
        known = _partitions[body] = fem.Partition(body, interfaces)
    return known


@contextmanager
def factors_held(case: Case) -> Iterator[None]:
    """Hold the factors of a case's shoe within the context; its reduction and static fields share them.

    Afterwards a run needs neither the factors nor the matrices.
    """
    body, interfaces = shoe_model(case.part(FlexibleShoes), case.track)
    held = partition(body, interfaces)
    try:
        yield
    finally:
        del held
        body.forget_matrices()


@lru_cache(maxsize=4)
def _reduction(
    mesh: str,
    material: fem.Material,
    track: Track,
    pins: PinCoupling,
    fixed_modes: int,
    load_surface: str | None,
    node: int | None,
) -> fem.CachedReduction:
    body, interfaces = _finite_elements(mesh, material, track, pins)
    loads = {}
    if load_surface is not None:
        loads[MACHINE_LOAD] = body.surface_load(load_surface, np.array([0.0, 0.0, -1.0]))
    if node is not None:
        loads[DRIVE] = np.zeros_like(body.mesh.nodes)
        loads[DRIVE][node, 0] = 1.0
    folder = reductions.reductions_folder()
    factors = partition(body, interfaces)
    return fem.cached_craig_bampton(
        folder, body, interfaces, fixed_modes, loads, warn=reductions.warn, partition=factors
    )


def check_shoe(case: Case) -> None:
    """Raise an error if a flexible shoe's mesh does not fit the track, its shoes or the machine's memory."""
    flexible = case.part(FlexibleShoes)
    body, _ = shoe_model(flexible, case.track)
    rails = case.shoe.rails if case.gear.wheel_names else None
    shoe_mesh.check_fit(body.mesh, flexible.mesh, case.shoe, rails)


def whole_reduction(case: Case) -> fem.CachedReduction:
    """Reduce the shoe of a case to all modes of its stress; remembered, and cached on disk.

    The modes are the constraint modes and `recovered_modes` fixed-interface modes. The static response to a
    force along x on the node that the drive pulls, if there is one, joins them: no fixed-interface mode
    represents a force on a single node. Errors are those of `shoe_model`.
    """
    flexible = case.part(FlexibleShoes)
    body, _ = shoe_model(flexible, case.track)
    loaded = flexible.load_surface if flexible.load_mode else None
    node = shoe_mesh.pulled_node(case, body.mesh)
    return _reduction(
        flexible.mesh,
        _material(flexible),
        case.track,
        flexible.pins,
        flexible.recovered_modes,
        loaded,
        node,
    )


@lru_cache(maxsize=4)
def pin_contacts(flexible: FlexibleShoes, track: Track) -> tuple[fem.PinContact, ...]:
    """Find the pressures of pins in contact, of the shoe's own steel; remembered, and cached on disk."""
    body, interfaces = shoe_model(flexible, track)
    factors = partition(body, interfaces)
    return fem.cached_pin_contacts(
        reductions.reductions_folder(), factors, _material(flexible), warn=reductions.warn
    )


@lru_cache(maxsize=4)
def integrated_in(flexible: FlexibleShoes, whole: fem.ReducedBody) -> fem.Nested:
    """Return the integrated modes of flexible shoes, and their positions in the whole reduction; remembered.

    Raises `ValueError` if no mode remains.
    """
    nested = fem.nested_reduction(whole, flexible.fixed_modes, [MACHINE_LOAD] if flexible.load_mode else [])
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
    """Reduce the mesh of a case's flexible shoes and integrate the shape integrals of the multibody system.

    Errors are those of `check_shoe` and `integrated_in`.
    """
    check_shoe(case)
    flexible = case.part(FlexibleShoes)
    body = whole_reduction(case).body
    return _floating_shoe(flexible, tuple(case.shoe.footprint.tolist()), integrated_in(flexible, body).body)


@lru_cache(maxsize=4)
def _floating_shoe(
    flexible: FlexibleShoes, footprint: tuple[float, ...], reduced: fem.ReducedBody
) -> FloatingShoe:
    """Return the floating shoe; remembered, because a run builds its system twice."""
    under = reduced.mesh.nodes_of("underside")
    weights = reduced.weights(flexible.load_surface)
    spread = (*side_weights(weights, reduced.nodes), weights)
    right, left, middle = (share @ reduced.nodes / share.sum() for share in spread)
    by_right, by_left, rows = (reduced.mean_rows(share) for share in spread)
    part = 1.0 / (left[1] - right[1])
    return FloatingShoe(
        reduced=reduced,
        load_point=middle,
        load_rows=rows,
        beside=part * (left - right),
        beside_rows=part * (by_left - by_right),
        underside=integrate_underside(reduced.nodes[under, :2], reduced.modes[under], np.array(footprint)),
    )


def side_weights(weights: np.ndarray, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return weights (n,) of a surface that grow linearly from zero at one side to the right and to the left.

    `weights` are uniform ones, shares of the surface's area, at `nodes` (n, 3), m; the sum of both results is
    twice these. A load shared in unequal parts then has a pressure that changes linearly across the shoe.
    """
    across = nodes[:, 1] - weights @ nodes[:, 1] / weights.sum()
    part = across / np.abs(across[weights != 0.0]).max()
    return weights * (1.0 - part), weights * (1.0 + part)


def weights_a_metre(weights: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Return the change of weights (n,) of a surface load for each metre of shift to the left.

    Parameters are those of `side_weights`.
    """
    right, left = side_weights(weights, nodes)
    apart = left @ nodes[:, 1] / left.sum() - right @ nodes[:, 1] / right.sum()
    return np.asarray((left / left.sum() - right / right.sum()) / apart)
