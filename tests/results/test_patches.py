"""Patches of the ground on a flexible shoe: modes feel in a history what they feel in the equations."""

import numpy as np
import pytest

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.results.loads.actions import OverRectangle, actions
from exudyn_crawler.results.loads.modal_coordinates import in_body, stress_basis
from exudyn_crawler.results.loads.patches import patches
from exudyn_crawler.run.solve.run_stages import system_history
from fem.patches import rectangle_loads
from tests.rolled import small_flexible_case

pytestmark = pytest.mark.simulation

TURNS = {
    "level": (0.0, 0.0, 0.0),
    "pitched": (0.0, 0.2, 0.0),
    "rolled": (0.02, -0.1, 0.0),
    "yawed": (0.01, 0.1, 0.1),
}
"""rad, about x, y, z: also such that a part of the underside alone touches the ground."""


def at_rest_but_turned(case, turns):
    """Equations, coordinates in which every shoe is sunk in the ground and turned, and their history."""
    system = compiled_system(case)
    layout, shoes = system.layout, case.track.shoe_count
    q = np.zeros(sum(layout.part(np.zeros((1, layout.size)), "coordinates").shape[1:]))
    places = q[: 6 * shoes].reshape(-1, 6)
    places[:, 2], places[:, 3:] = -0.03, turns
    parts = {f"coordinates{rate}": np.zeros_like(q) for rate in ("", " rate", " acceleration")}
    none = np.zeros(sum(size for _, size in layout.multipliers))
    state = layout.pack(parts | {"coordinates": q, "time": 0.0, "multipliers": none})
    return system, q, system_history(system, state[None])


@pytest.mark.parametrize("turns", TURNS.values(), ids=TURNS)
def test_modes_feel_the_ground_as_in_the_equations(turns):
    system, q, history = at_rest_but_turned(small_flexible_case(), turns)
    contact = system.contact
    forces = contact.forces(q[: contact.size], np.zeros(contact.size))
    flexible = history.case.flexible_shoes().shoes
    modal = forces[-len(flexible) * system.layout.modes :].reshape(len(flexible), -1)
    basis = stress_basis(history)
    for shoe, expected in zip(flexible, modal, strict=True):
        frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
        loads = np.zeros((1, len(basis.whole.frequencies)))
        for action in actions(history, shoe):
            if isinstance(action.entry, OverRectangle) and action.entry.pressed[0]:
                low, high = action.entry.low, action.entry.high
                loads += rectangle_loads(basis.underside, in_body(frames, action.force), low, high)
        assert np.abs(expected).max() > 100.0
        # forces have single precision in a history
        np.testing.assert_allclose(loads[0] @ basis.inside, expected, atol=1e-6 * np.abs(expected).max())


def test_patches_of_a_shoe_on_two_units_lie_side_by_side_and_cover_its_underside(translation):
    """But for half a unit's length times its tilt squared, and what its tilt moves the overlap by."""
    found = patches(translation, 7)
    rear, front = (
        next(patch for index, patch in found.items() if translation.contact_unit.values[index] == unit)
        for unit in (7, 12)
    )
    footprint = translation.case.shoe.footprint
    np.testing.assert_allclose(rear[1][:, 0], front[0][:, 0], atol=0.01)
    np.testing.assert_allclose(rear[0], np.broadcast_to(footprint[[0, 2]], rear[0].shape), atol=0.01)
    np.testing.assert_allclose(front[1], np.broadcast_to(footprint[[1, 3]], front[1].shape), atol=0.01)
