"""What the stress of a history is the product of: columns of displacement and stress, and coordinates.

The columns are all modes and, where the case asks for them, static fields: what the static answers to the
loads of this history have beyond those of the modes. Their coordinates are products of those of the shoe's
unit loads (`results.loads.load_map`) with what each unit load makes of the columns.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.load_map import loads_by_kind
from exudyn_crawler.results.loads.static_loads import static_loads
from exudyn_crawler.results.loads.unit_loads import unit_loads
from fem import Shapes, field_columns

TOLERANCE = 1e4
"""Pa by which fields that are left out may change a stress, as far as `MOST_FIELDS` allows: 0.01 MPa."""
MOST_FIELDS = 0.4
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
class StressBasis:
    """Columns of displacement and stress with their coordinates.

    Attributes
    ----------
    shapes : Shapes
        Modes, and static fields beside them.
    coordinates : mapping of int to array (times, columns)
        By number of the shoe.
    answers : array (loads, columns)
        Coordinates that a unit of each load of `unit_loads` makes.
    bound : float or None
        Pa by which fields that were left out change the stress of no node at no time; None without fields,
        where the error of truncation is not known.
    """

    shapes: Shapes
    coordinates: Mapping[int, NDArray]
    answers: NDArray
    bound: float | None


def stress_basis(history: History, shoes: Sequence[int] | None = None) -> StressBasis:
    """Columns and coordinates of the stress of flexible shoes, of all of them if not said otherwise.

    Raises
    ------
    ValueError
        If the history has no flexible shoes, or one of the shoes is not among them.
    """
    if history.case.flexible is None:
        raise ValueError("the history has no flexible shoes")
    chosen = list(history.case.flexible.shoes if shoes is None else shoes)
    loads = {shoe: sum(loads_by_kind(history, shoe).values()) for shoe in chosen}
    units, static = unit_loads(history.case), static_loads(history.case)
    if static is None:
        found = {shoe: load @ units.answers for shoe, load in loads.items()}
        return StressBasis(units.whole, found, units.answers, None)
    frequencies = units.whole.frequencies
    histories = [(load @ static.shares).toarray() for load in loads.values()]
    most = int(MOST_FIELDS * len(frequencies))
    columns = field_columns(units.body, static.fields, histories, TOLERANCE, most)
    answers = static.shares @ np.hstack((static.fields.held(frequencies), columns.turn))
    found = {shoe: load @ answers for shoe, load in loads.items()}
    return StressBasis(columns.beside(units.whole), found, answers, columns.bound)


def coordinates_by_load(history: History, basis: StressBasis, shoe: int) -> dict[str, NDArray]:
    """Coordinates of a shoe by what makes them, arrays (times, columns) that add up to all of them.

    By words of `LOADS` for kinds of actions, or those kinds; "inertia" is that of the integrated modes. Loads
    that make nothing are left out.

    Parameters
    ----------
    basis : StressBasis
        Of this history, or of one that this is a part of.
    shoe : int
        One of its shoes.
    """
    found: dict[str, NDArray] = {}
    for kind, loads in loads_by_kind(history, shoe).items():
        load, own = LOADS.get(kind, kind), np.asarray(loads @ basis.answers)
        if own.any():
            found[load] = found[load] + own if load in found else own
    return found


def unit_stress(case: Case, node: int) -> NDArray:
    """Stress (loads, 6) in Pa at a node of a case's flexible shoes by a unit of each load of `unit_loads`.

    With static fields of every load: none is left out.
    """
    units, static = unit_loads(case), static_loads(case)
    if static is None:
        return np.asarray(units.answers @ units.whole.stress_modes[node].T)
    return np.asarray(static.shares @ static.fields.stress_at(units.whole, node))
