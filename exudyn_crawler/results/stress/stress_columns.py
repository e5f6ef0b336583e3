"""What the stress of a history is the product of: columns of stress and their coordinates over time.

The columns are the whole modal basis and, where the case asks for them, static fields: what the static
answers to the loads of this history have beyond those of the modes. Modes and fields then answer the same
loads, those of the fields.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.model.flexible_shoes import shoe_model
from exudyn_crawler.model.load_places import shoe_fields
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.actions import actions
from exudyn_crawler.results.loads.field_loads import field_loads, loads_by_kind
from exudyn_crawler.results.loads.modal_coordinates import (
    StressBasis,
    coordinates_and_momentum,
    coordinates_by_load,
    stress_basis,
)
from fem import KeptFields, Shapes, StaticFields, field_columns

TOLERANCE = 1e4
"""Pa by which fields that are left out may change a stress, as far as `SHARE` allows: 0.01 MPa."""
SHARE = 0.4
"""Greatest number of fields over that of modes."""
LOADS = {
    "joint": "pins",
    "load": "machine load",
    "contact": "ground",
    "roller": "rollers",
    "chain": "drive",
}
"""Words for kinds of actions; others are their own. The chain pulls for the drive and at its ends."""


@dataclass(frozen=True)
class StressColumns:
    """Columns of displacement and stress with their coordinates.

    Attributes
    ----------
    basis : StressBasis
        Modes of the history's shoes.
    shapes : Shapes
        Modes, and static fields beside them.
    coordinates : mapping of int to array (times, columns)
        By number of the shoe.
    bound : float or None
        Pa by which fields that were left out change the stress of no node at no time; None without fields,
        where the error of truncation is not known.
    answers : array (loads, columns) or None
        Coordinates that a unit of each load of the static fields has; None without fields.
    """

    basis: StressBasis
    shapes: Shapes
    coordinates: Mapping[int, NDArray]
    bound: float | None
    answers: NDArray | None = None


def stress_columns(history: History, shoes: Sequence[int] | None = None) -> StressColumns:
    """Columns and coordinates of flexible shoes, of all of them if not said otherwise.

    Raises
    ------
    ValueError
        If the history has no flexible shoes, or one of the shoes is not among them.
    """
    basis = stress_basis(history)
    flexible = history.case.flexible_shoes()
    chosen = list(flexible.shoes if shoes is None else shoes)
    kept = fields_of(history.case)
    if kept is None:
        found = {shoe: coordinates_and_momentum(history, basis, shoe)[0] for shoe in chosen}
        return StressColumns(basis, basis.whole, found, None)
    body, _ = shoe_model(flexible, history.case.track)
    fields = kept.fields
    loads = {shoe: field_loads(fields, _loads_on(history, basis, fields, shoe)) for shoe in chosen}
    frequencies = basis.whole.frequencies
    columns = field_columns(body, fields, list(loads.values()), TOLERANCE, int(SHARE * len(frequencies)))
    both = np.hstack((fields.held(frequencies), columns.turn))
    coordinates = {shoe: load @ both for shoe, load in loads.items()}
    return StressColumns(basis, columns.beside(basis.whole), coordinates, columns.bound, both)


def acting_loads(history: History, shoe: int) -> NDArray:
    """Loads on a flexible shoe, array (times, k), for `StaticFields.stress_at` of the fields of `fields_of`.

    Without static fields they are the coordinates of the modes. Their stress is that of `stress_columns`, but
    of every load itself: no field is left out.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history.
    """
    basis = stress_basis(history)
    kept = fields_of(history.case)
    if kept is None:
        return coordinates_and_momentum(history, basis, shoe)[0]
    return field_loads(kept.fields, _loads_on(history, basis, kept.fields, shoe))


def _loads_on(
    history: History, basis: StressBasis, fields: StaticFields, shoe: int
) -> dict[str, Mapping[str, NDArray]]:
    """Loads on a flexible shoe, as of `loads_by_kind`."""
    acting = actions(history, shoe)
    _, momentum = coordinates_and_momentum(history, basis, shoe, acting)
    return loads_by_kind(history, fields, basis.whole, momentum, shoe, acting)


def fields_of(case: Case) -> KeptFields | None:
    """Static fields of the loads that a case's flexible shoes bear; None where it asks for none.

    Raises
    ------
    ValueError
        If the case has no flexible shoes.
    """
    if not case.flexible_shoes().static_fields:
        return None
    return shoe_fields(case, rails=case.undercarriage is not None)


def columns_by_load(history: History, columns: StressColumns, shoe: int) -> dict[str, NDArray]:
    """Coordinates of a shoe by what makes them, arrays (times, columns) that add up to all of them.

    By words of `LOADS` for kinds of actions, or those kinds; "inertia" is that of the integrated modes. Loads
    that make nothing are left out.

    Parameters
    ----------
    columns : StressColumns
        Of this history.
    shoe : int
        One of its shoes.
    """
    basis = columns.basis
    kept = fields_of(history.case)
    if columns.answers is None or kept is None:
        return _in_words(coordinates_by_load(history, basis, shoe))
    fields = kept.fields
    kinds = _loads_on(history, basis, fields, shoe)
    return _in_words({kind: fields.coordinates(own) @ columns.answers for kind, own in kinds.items()})


def _in_words(by_kind: Mapping[str, NDArray]) -> dict[str, NDArray]:
    """Coordinates by load of those by kind of action."""
    found: dict[str, NDArray] = {}
    for kind, own in by_kind.items():
        load = LOADS.get(kind, kind)
        if own.any():
            found[load] = found[load] + own if load in found else own
    return found
