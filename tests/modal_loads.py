"""Modal loads and coordinates of a flexible shoe, of all modes, by the unit loads of its actions."""

import numpy as np

from exudyn_crawler import Case, History
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.results.loads.actions import actions
from exudyn_crawler.results.loads.kinds import Kind
from exudyn_crawler.results.loads.load_map import coordinates, loads_by_kind, unit_loads
from tests.model.both import residual_of
from tests.states import row_of

GEAR = {Kind.ROLLER, Kind.IDLER, Kind.CARRIER, Kind.TOOTH, Kind.GUIDE}
"""Kinds of actions by which a side frame presses on shoes."""


def modal_loads(history: History, shoe: int) -> np.ndarray:
    """Loads (times, M) of all modes by all that acts on the shoe, N kg^-0.5."""
    acting = loads_by_kind(history, shoe)
    del acting[Kind.INERTIA]
    return sum(acting.values()) @ unit_loads(history.case).work


def whole_coordinates(history: History, shoe: int) -> np.ndarray:
    """Coordinates (times, M) of all modes, kg^0.5 m."""
    return sum(loads_by_kind(history, shoe).values()) @ unit_loads(history.case).answers


def kinds_of_gear_on_modes(case: Case, q: np.ndarray, lifted: np.ndarray) -> set[str]:
    """Kinds of `GEAR` that press on flexible shoes at rest, once modes feel them as the records have it.

    What leaves the equations of the modes as the gear is lifted, from coordinates `q` to `lifted`, has to be
    the modal loads of the records of a history.
    """
    system, still, kinds = compiled_system(case), np.zeros_like(q), set()
    layout, first = system.layout, system.tables.forces.units.first_modal
    history = system_history(system, row_of(layout, {"coordinates": q})[None])
    residual = residual_of(system, q, still) - residual_of(system, lifted, still)
    shoes = layout.flexible_shoes
    modal = residual[first : first + len(shoes) * layout.modes].reshape(len(shoes), -1)
    units = unit_loads(case)
    for shoe, found in zip(shoes, modal, strict=True):
        frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
        gear = [one for one in actions(history, shoe) if one.kind in GEAR]
        loads = sum(coordinates(units, one, frames) @ units.work for one in gear)
        expected = -(loads @ units.integrated.inside)[0] if gear else np.zeros(layout.modes)
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(modal).max())
        kinds |= {one.kind for one in gear}
    return kinds
