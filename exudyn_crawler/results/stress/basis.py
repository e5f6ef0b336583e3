"""What the stress of a history is the product of: columns of displacement and stress, and coordinates.

The columns are all modes and, where the case asks for them, static fields: what the static answers to the
loads of this history have beyond those of the modes. Their coordinates are products of those of the shoe's
unit loads (`results.loads.load_map`) with what each unit load makes of the columns.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

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
    loads : mapping of int to mapping of str to csr_array (times, loads)
        All that acts on each shoe, by number of the shoe: coordinates of its `unit_loads` by kind of action,
        as of `loads_by_kind`.
    answers : array (loads, columns)
        Coordinates of the columns that a unit of each load makes.
    coordinates : mapping of int to array (times, columns)
        By number of the shoe: products of the two, all kinds together.
    bound : float or None
        Pa by which fields that were left out change the stress of no node at no time; None without fields,
        where the error of truncation is not known.
    """

    shapes: Shapes
    loads: Mapping[int, Mapping[str, csr_array]]
    answers: NDArray
    coordinates: Mapping[int, NDArray]
    bound: float | None

    def by_load(self, shoe: int, rows: NDArray | slice = slice(None)) -> dict[str, NDArray]:
        """Coordinates of a shoe at stored times by what makes them: arrays (times, columns).

        They add up to those of all. By words of `LOADS` for kinds of actions, or those kinds; "inertia" is
        that of the integrated modes. Loads that make nothing are left out.

        Parameters
        ----------
        rows : int array (times,), optional
            Indices of stored times; all of them by default.
        """
        found: dict[str, NDArray] = {}
        for kind, loads in self.loads[shoe].items():
            load, own = LOADS.get(kind, kind), np.asarray(loads[rows] @ self.answers)
            if own.any():
                found[load] = found[load] + own if load in found else own
        return found


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
    by_kind = {shoe: loads_by_kind(history, shoe) for shoe in chosen}
    loads = {shoe: sum(kinds.values()) for shoe, kinds in by_kind.items()}
    units, static = unit_loads(history.case), static_loads(history.case)
    if static is None:
        found = {shoe: load @ units.answers for shoe, load in loads.items()}
        return StressBasis(units.whole, by_kind, units.answers, found, None)
    frequencies = units.whole.frequencies
    histories = [(load @ static.shares).toarray() for load in loads.values()]
    most = int(MOST_FIELDS * len(frequencies))
    columns = field_columns(units.body, static.fields, histories, TOLERANCE, most)
    answers = static.shares @ np.hstack((static.fields.held(frequencies), columns.turn))
    found = {shoe: load @ answers for shoe, load in loads.items()}
    return StressBasis(columns.beside(units.whole), by_kind, answers, found, columns.bound)


def unit_stress(case: Case, node: int) -> NDArray:
    """Stress (loads, 6) in Pa at a node of a case's flexible shoes by a unit of each load of `unit_loads`.

    With static fields of every load: none is left out.
    """
    units, static = unit_loads(case), static_loads(case)
    if static is None:
        return np.asarray(units.answers @ units.whole.stress_modes[node].T)
    return np.asarray(static.shares @ static.fields.stress_at(units.whole, node))
