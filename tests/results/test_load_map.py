"""Actions as coordinates of unit loads: modes feel in a history what they feel in the equations of motion."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_crawler import simulate
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.shoe_mesh import cubic_weights, rail_rows, station_spacing
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.results.loads.actions import Action, OnRail, OverRectangle, actions
from exudyn_crawler.results.loads.exports import roller_loads
from exudyn_crawler.results.loads.load_map import GROUND, RAILS, coordinates, loads_by_kind, unit_loads
from exudyn_crawler.results.stress.basis import ground_grid, rail_stations, static_loads
from tests.rolled import small_flexible_case
from tests.states import row_of

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
    return system, q, system_history(system, row_of(layout, {"coordinates": q})[None])


@pytest.mark.simulation
@pytest.mark.parametrize("turns", TURNS.values(), ids=TURNS)
def test_modes_feel_the_ground_as_in_the_equations(turns):
    system, q, history = at_rest_but_turned(small_flexible_case(), turns)
    contact = system.contact
    forces = contact.forces(q[: contact.size], np.zeros(contact.size))
    flexible = history.case.flexible_shoes().shoes
    modal = forces[-len(flexible) * system.layout.modes :].reshape(len(flexible), -1)
    units = unit_loads(history.case)
    for shoe, expected in zip(flexible, modal, strict=True):
        frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
        contacts = [one for one in actions(history, shoe) if isinstance(one.entry, OverRectangle)]
        loads = sum(coordinates(units, one, frames) @ units.work for one in contacts)
        assert np.abs(expected).max() > 100.0
        # forces have single precision in a history
        found = (loads @ units.integrated.inside)[0]
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.simulation
def test_patches_of_a_shoe_cover_its_underside(flexible_run):
    """But for half a unit's length times its tilt squared, and what its tilt moves the overlap by."""
    history = flexible_run[0]
    own = history.patch.isel(contact=history.contact_shoe.values == 7).values
    pressed = own[..., 1] > own[..., 0]
    assert (pressed.sum(axis=1) > 1).all()
    low_x, high_x, low_y, high_y = history.case.shoe.footprint[:4]
    areas = np.where(pressed, np.prod(own[..., 1::2] - own[..., 0::2], axis=-1), 0.0).sum(axis=1)
    np.testing.assert_allclose(areas, (high_x - low_x) * (high_y - low_y), rtol=0.01)
    for part, end, far in ((own[..., 0], low_x, np.inf), (own[..., 3], high_y, -np.inf)):
        ends = np.where(pressed, part, far)
        nearest = ends.min(axis=1) if far > 0.0 else ends.max(axis=1)
        np.testing.assert_allclose(nearest, end, atol=0.01)


def test_a_force_anywhere_on_a_rail_moves_modes_as_in_the_equations():
    """Cubics between the stations of the equations, whose values at thirds are coordinates."""
    case = small_flexible_case()
    units, rails = unit_loads(case), case.shoe.rails
    x = np.linspace(rails.rear, rails.front, 41)
    force = np.random.default_rng(3).standard_normal((41, 3))
    for line, rows in enumerate(rail_rows(units.whole, case.running_gear, rails)):
        at = cubic_weights((x - rails.rear) / station_spacing(rails)) @ rows.reshape(len(rows), -1)
        expected = np.einsum("tc,tcm->tm", force, at.reshape(41, 3, -1))
        action = Action("roller", 5, "", np.zeros((41, 3)), force, np.zeros((41, 3)), OnRail(line, x))
        found = coordinates(units, action, np.tile(np.eye(3), (41, 1, 1))) @ units.work
        np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.slow
def test_static_loads_have_the_forces_and_moments_of_the_unit_loads():
    """Strips press on the middles of their rails: their places across are left out."""
    case = small_flexible_case()
    units, static = unit_loads(case), static_loads(case)
    counts = list(static.fields.families.values())
    starts = dict(zip(static.fields.families, np.cumsum([0, *counts[:-1]]).tolist(), strict=True))
    mesh = units.body.mesh
    places = np.column_stack((np.ones(len(mesh.nodes)), mesh.nodes))
    grid, stations = ground_grid(mesh), rail_stations(mesh)
    rail_weights = np.hstack([one.weights.toarray() for one in stations])
    for name, weights in ((GROUND, grid.weights.toarray()), (RAILS, rail_weights)):
        family, at = units.spread[name], units.families[name]
        # of forces along x alone
        columns = slice(starts[name], starts[name] + 3 * weights.shape[1], 3)
        own = static.shares[at.start : at.stop : 3, columns].toarray()
        found, expected = own @ weights.T @ places, family.weights @ places[family.nodes]
        chosen = [0, 1, 3] if name == RAILS else [0, 1, 2, 3]
        scale = np.abs(expected).max(axis=0)[chosen]
        np.testing.assert_allclose(found[:, chosen] / scale, expected[:, chosen] / scale, atol=1e-3)


@pytest.mark.slow
def test_rollers_are_among_the_loads_of_a_rolled_shoe():
    """What the stations of both rails bear is what the rollers press with."""
    history = simulate(small_flexible_case(), 0.02)
    at = unit_loads(history.case).families[RAILS]
    own = loads_by_kind(history, 5)["roller"][:, at].toarray()
    pressed = roller_loads(history, 5).force.sum(("roller", "rail")).values
    assert np.abs(pressed).max() > 1e5
    np.testing.assert_allclose(own.reshape(len(own), -1, 3).sum(axis=1), pressed, atol=1e-6)


@pytest.mark.simulation
def test_a_unit_that_a_shoe_never_touches_loads_nothing(flexible_run):
    """Of a part of a run, in which the shoe stood on other units before."""
    history = flexible_run[0]
    contact = next(one for one in actions(history, 7) if isinstance(one.entry, OverRectangle))
    never = replace(contact, entry=contact.entry._replace(pressed=np.zeros_like(contact.entry.pressed)))
    units, frames = unit_loads(history.case), rotation_matrices(history.angles.sel(shoe=7).values)
    assert coordinates(units, contact, frames).nnz
    assert coordinates(units, never, frames).nnz == 0
