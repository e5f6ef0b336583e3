"""Static fields: residual flexibility, the static response to loads less that of a reduced body's modes.

A body responds to a load by its modes and by a static field that follows the load at once. The static field
is the static response with inertia relief less that of the modes to the same load. See residual attachment
modes (R. R. Craig, Structural Dynamics, 1981, ch. 15). The loads themselves are the coordinates f of the
static fields. The stress ``X q + S f`` then lacks only the inertia of the truncated modes.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from scipy.sparse import csr_array, kron

from fem.body.elastic_body import ElasticBody
from fem.body.element_stress import DEVIATOR, stress_at_node
from fem.body.interfaces import Interface
from fem.body.mesh import Floats
from fem.body.reduced import ReducedBody
from fem.body.reduction import Partition
from fem.body.shapes import Shapes, SideBySide
from fem.memory import give_back_memory

AT_ONCE = 8
"""Number of fields whose stress is recovered at once."""
MOST_AT_ONCE = 32
"""Greatest number of fields that are solved for, or combined, at once: more save hardly any time."""
BLOCK = 1e7
"""Size of the fields that are solved for at once, bytes; memory holds some copies of them."""
NOISE = 1e-12
"""Strain energy below which a direction is rounding, fraction of the greatest direction's energy."""


class UnitLoads(NamedTuple):
    """Family of k unit loads.

    Attributes
    ----------
    nodal : sparse array (3n, k)
        Nodal forces in N, xyz per node, per unit of a coordinate.
    centers : array (6 i, k)
        Force and moment on each joint centre in N and N m.
    by_mass : bool
        True if `nodal` are accelerations in m/s2; the body's mass then turns them into forces.
    """

    nodal: csr_array
    centers: Floats
    by_mass: bool = False

    @classmethod
    def spread(cls, weights: csr_array | Floats, interfaces: Sequence[Interface]) -> Self:
        """Return forces along x, y, z with nodal weights (n, p): 3 p coordinates, xyz for each weight."""
        nodal = csr_array(kron(csr_array(weights), np.eye(3), format="csr"))
        return cls(nodal, np.zeros((6 * len(interfaces), nodal.shape[1])))

    @classmethod
    def at_centers(cls, nodes: int, interfaces: Sequence[Interface]) -> Self:
        """Return force and moment on every joint centre: 6 i coordinates."""
        count = 6 * len(interfaces)
        return cls(csr_array((3 * nodes, count)), np.eye(count))

    @classmethod
    def of_inertia(cls, modes: Floats, interfaces: Sequence[Interface]) -> Self:
        """Return the momentum of modes (n, 3, m) as nodal forces: m coordinates, kg^0.5 m/s2."""
        rows, count = modes.reshape(-1, modes.shape[2]).shape
        # a conversion would search the array for zeros; it has none
        columns = np.tile(np.arange(count, dtype=np.int32), rows)
        ends = count * np.arange(rows + 1, dtype=np.int32)
        nodal = csr_array((modes.ravel(), columns, ends), shape=(rows, count))
        return cls(nodal, np.zeros((6 * len(interfaces), count)), True)


@dataclass(frozen=True, eq=False)
class StaticFields:
    """Static fields of k unit loads: parts of the static responses that a body's m modes lack.

    Attributes
    ----------
    families : mapping of str to int
        Number of loads of each family, in order.
    displacements : array (n, 3, k)
        In m per unit of a load's coordinate, orthogonal in stiffness to the modes.
    energy : array (k, k)
        Twice the strain energy of the fields: products of forces and displacements.
    work : array (k, m)
        Modal loads of the unit loads.
    """

    families: Mapping[str, int]
    displacements: Floats
    energy: Floats
    work: Floats

    def held(self, frequencies: Floats) -> Floats:
        """Return static coordinates (k, m) under the unit loads of modes with frequencies (m,) in Hz."""
        return self.work / (2.0 * np.pi * frequencies) ** 2

    def stress_at(self, body: ReducedBody, node: int) -> Floats:
        """Return the stress (k, 6) in Pa at a node per unit load, from these fields and the body's modes."""
        about = stress_at_node(body.nodes, body.mesh.elements, body.material, self.displacements, node)
        return self.held(body.frequencies) @ body.stress_modes[node].T + about.T

    def coordinates(self, loads: Mapping[str, Floats]) -> Floats:
        """Return the coordinates (t, k) of loads (t, ...) by family; a family left out does not act.

        Raises
        ------
        ValueError
            If there is no load, or a family is unknown or has another number of loads.
        """
        unknown = sorted(set(loads) - set(self.families))
        if unknown or not loads:
            raise ValueError(
                f"loads must belong to the families {list(self.families)}, got {unknown or 'none'}"
            )
        times = len(next(iter(loads.values())))
        parts = []
        for name, count in self.families.items():
            part = np.reshape(loads[name], (times, -1)) if name in loads else np.zeros((times, count))
            if part.shape[1] != count:
                raise ValueError(f"loads of {name!r} must have {count} coordinates, got {part.shape[1]}")
            parts.append(part)
        return np.concatenate(parts, axis=1)


def static_fields(
    partition: Partition, reduced: ReducedBody, families: Mapping[str, UnitLoads]
) -> StaticFields:
    """Solve for the static fields of families of loads: static responses less those of the modes.

    Parameters
    ----------
    partition : Partition
        Partition of the reduced body, with the same interfaces.
    reduced : ReducedBody
    families : mapping of str to UnitLoads

    Raises
    ------
    ValueError
        If there is no family, or one belongs to another mesh or other interfaces.
    """
    size = reduced.modes.shape[0] * 3
    centers = 6 * len(reduced.interfaces)
    if not families:
        raise ValueError("families must be at least one, got none")
    for name, family in families.items():
        if family.nodal.shape[0] != size or family.centers.shape[0] != centers:
            raise ValueError(
                f"loads of {name!r} must be on {size} displacements and {centers} motions of centres, "
                f"got {family.nodal.shape[0]} and {family.centers.shape[0]}"
            )
    modes = reduced.modes.reshape(size, -1)
    pilots = reduced.pilots.reshape(centers, -1)
    squares = (2.0 * np.pi * reduced.frequencies) ** 2
    count = sum(family.centers.shape[1] for family in families.values())
    rest = np.empty((size, count))
    work = np.empty((count, modes.shape[1]))
    at_once = min(max(int(BLOCK / (8 * size)), 1), MOST_AT_ONCE)
    first = 0
    for forces, at_centers in _in_blocks(partition.body, families.values(), at_once):
        columns = slice(first, first + forces.shape[1])
        work[columns] = forces.T @ modes + at_centers.T @ pilots
        rest[:, columns] = partition.static_response(forces, at_centers)
        rest[:, columns] -= modes @ (work[columns] / squares).T
        first = columns.stop
        # beside factors and fields, the memory freed by each block would make the peak memory of a study
        give_back_memory()
    energy = np.empty((count, count))
    stiffness = partition.body.stiffness
    for first in range(0, count, at_once):
        columns = slice(first, first + at_once)
        energy[:, columns] = rest.T @ (stiffness @ rest[:, columns])
    return StaticFields(
        {name: family.centers.shape[1] for name, family in families.items()},
        rest.reshape(-1, 3, rest.shape[1]),
        energy,
        work,
    )


def _in_blocks(
    body: ElasticBody, families: Iterable[UnitLoads], at_once: int
) -> Iterator[tuple[Floats, Floats]]:
    """Yield nodal forces (3n, k) in N and loads (6 i, k) on centres, some loads of a family at a time."""
    for family in families:
        for first in range(0, family.nodal.shape[1], at_once):
            columns = slice(first, first + at_once)
            forces = family.nodal[:, columns].toarray()
            yield body.mass_matrix @ forces if family.by_mass else forces, family.centers[:, columns]


@dataclass(frozen=True, eq=False)
class FieldColumns:
    """Few fields that replace many for given histories of loads.

    Attributes
    ----------
    turn : array (k, r)
        Matrix from coordinates f of k loads to those of the r fields: ``f @ turn``.
    modes : array (n, 3, r)
        Displacements in m per unit.
    stress_modes : array (n, 6, r)
        Nodal stress in Pa per unit.
    bound : float
        Greatest von Mises stress in Pa of the dropped directions, over all nodes and times.
    """

    turn: Floats
    modes: Floats
    stress_modes: Floats
    bound: float

    def beside(self, body: ReducedBody) -> Shapes:
        """Return a body's modes with these fields beside them; coordinates follow one another likewise."""
        return _Together(body, self)


class _Together(Shapes):
    """Modes of a body and fields beside them; the stress of the modes is recovered at first use."""

    def __init__(self, body: ReducedBody, fields: FieldColumns) -> None:
        self.mesh = body.mesh
        self.material = body.material
        self.interfaces = body.interfaces
        self.modes = SideBySide((body.modes, fields.modes))
        self._body = body
        self._fields = fields

    @cached_property
    def stress_modes(self) -> SideBySide:
        """Nodal stress (n, 6, m) in Pa per unit of a coordinate."""
        return SideBySide((self._body.stress_modes, self._fields.stress_modes))

    def forget_stress_modes(self) -> None:
        """Free the stress of the body's modes; it is recovered again at the next use."""
        self.__dict__.pop("stress_modes", None)
        self._body.forget_stress_modes()


def field_columns(
    body: ElasticBody,
    fields: StaticFields,
    histories: Sequence[Floats],
    tolerance: float = 0.0,
    most: int | None = None,
) -> FieldColumns:
    """Find fields along the directions of histories of loads, by a singular value decomposition.

    Loads are weighted by the strain energy of their fields; the directions are orthogonal in that energy.

    Parameters
    ----------
    body : ElasticBody
    fields : StaticFields
    histories : sequence of array (t, k)
        Coordinates of the loads; each history is one position of the body.
    tolerance : float
        Bound of the dropped directions in Pa, if `most` allows.
    most : int, optional
        Greatest number of directions, whatever the tolerance.

    Raises
    ------
    ValueError
        If there is no history, or one is not finite or has another number of loads.
    """
    count = len(fields.energy)
    if not histories:
        raise ValueError("histories must be at least one, got none")
    moved = np.zeros((count, count))
    for history in histories:
        if history.ndim != 2 or history.shape[1] != count:
            raise ValueError(f"histories must be (times, {count}), got {history.shape}")
        if not np.isfinite(history).all():
            raise ValueError("histories must be finite, got other numbers")
        moved += history.T @ history
    into, out = _energy_root(fields.energy)
    values, directions = np.linalg.eigh(into @ moved @ into.T)
    directions = directions[:, ::-1][:, values[::-1] > NOISE * values[-1]]
    turn = into.T @ directions
    back = out @ directions
    greatest = np.zeros(directions.shape[1])
    for history in histories:
        amplitudes = history @ turn
        for extreme in (amplitudes.max(axis=0, initial=0.0), -amplitudes.min(axis=0, initial=0.0)):
            np.maximum(greatest, extreme, out=greatest)
    del amplitudes
    give_back_memory()
    fewest = back.shape[1] if most is None else min(most, back.shape[1])
    nodes = len(fields.displacements)
    flat = fields.displacements.reshape(3 * nodes, count)
    modes = np.empty((nodes, 3, fewest))
    stress = np.empty((nodes, 6, fewest))
    tail = np.zeros(nodes)
    bounds = np.zeros(back.shape[1] + 1)
    # memory holds a block of directions at a time, from the last to the first
    for columns, block in _products_from_last(flat, back):
        shapes = block.reshape(nodes, 3, -1)
        of_shapes = body.stress(shapes)
        lengths = np.linalg.norm(DEVIATOR @ of_shapes, axis=1) * greatest[columns]
        tails = tail[:, None] + np.cumsum(lengths[:, ::-1], axis=1)
        bounds[columns] = tails.max(axis=0)[::-1]
        tail = tails[:, -1]
        wanted = max(fewest - columns.start, 0)
        modes[:, :, columns] = shapes[:, :, :wanted]
        stress[:, :, columns] = of_shapes[:, :, :wanted]
    rank = min(int(np.flatnonzero(bounds <= tolerance)[0]), fewest)
    # one copy after the other
    modes = np.ascontiguousarray(modes[:, :, :rank])
    stress = np.ascontiguousarray(stress[:, :, :rank])
    return FieldColumns(turn[:, :rank], modes, stress, float(bounds[rank]))


def _products_from_last(flat: Floats, back: Floats) -> Iterator[tuple[slice, Floats]]:
    """Yield columns of ``flat @ back`` with their slices, `AT_ONCE` at a time, from the last to the first.

    Each product makes `MOST_AT_ONCE` columns, since it reads all of `flat`.
    """
    for first in reversed(range(0, back.shape[1], MOST_AT_ONCE)):
        products = flat @ back[:, first : first + MOST_AT_ONCE]
        for start in reversed(range(0, products.shape[1], AT_ONCE)):
            block = products[:, start : start + AT_ONCE]
            yield slice(first + start, first + start + block.shape[1]), block


def _energy_root(energy: Floats) -> tuple[Floats, Floats]:
    """Return matrices (r, k), (k, r): loads to coordinates of unit energy, and fields to their shapes."""
    scale = np.sqrt(np.maximum(np.diag(energy), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(energy / np.outer(scale, scale))
    mask = values > NOISE * values[-1]
    values = values[mask]
    vectors = vectors[:, mask]
    return np.sqrt(values)[:, None] * (vectors * scale[:, None]).T, vectors / scale[:, None] / np.sqrt(values)
