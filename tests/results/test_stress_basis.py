"""Static fields beside the modes of a run: against the full static answer to all that acts on a shoe."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import History
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.flexible_shoes import shoe_model, whole_reduction
from exudyn_crawler.results.loads.actions import OverRectangle, actions
from exudyn_crawler.results.loads.exports import at_instant, shoe_loads
from exudyn_crawler.results.loads.load_map import GROUND, RAILS, loads_by_kind, unit_loads
from exudyn_crawler.results.stress.basis import (
    MOST_FIELDS,
    StressBasis,
    ground_grid,
    rail_stations,
    static_loads,
    stress_basis,
)
from exudyn_crawler.results.stress.recovery import node_stress, recover_stresses
from fem import Partition, field_columns
from fem.stress import von_mises
from tests.rolled import small_flexible_case

Run = tuple[History, xr.Dataset, dict[int, pd.DataFrame]]


@pytest.fixture(scope="module")
def with_fields(flexible_run: Run) -> History:
    return flexible_run[0]


@pytest.fixture(scope="module")
def basis(with_fields: History) -> StressBasis:
    return stress_basis(with_fields)


def test_static_loads_do_the_work_of_the_modal_loads(with_fields: History) -> None:
    """The ground's grid apart, which holds a pressure's resultants and not its seams."""
    units, static = unit_loads(with_fields.case), static_loads(with_fields.case)
    assert static is not None
    for shoe in (7, 13):
        loads = sum(loads_by_kind(with_fields, shoe).values())
        expected, found = loads @ units.work, loads @ static.shares @ static.fields.work
        np.testing.assert_allclose(found, expected, atol=0.02 * np.abs(expected).max())
        low = slice(6)
        np.testing.assert_allclose(found[:, low], expected[:, low], atol=2e-3 * np.abs(expected).max())


def consistent_nodal(history: History, shoe: int) -> np.ndarray:
    """Nodal forces (n, 3) of `shoe_loads` in whose place pressures press on the elements, not on nodes."""
    case = history.case
    units = unit_loads(case)
    ground = units.spread[GROUND]
    nodal = shoe_loads(history, shoe, history.duration).nodal.copy()
    rectangle = ground_grid(units.body.mesh).rectangle
    now = at_instant(history, history.duration)
    frame = rotation_matrices(now.angles.sel(shoe=shoe).values)[0]
    middles = (np.arange(60) + 0.5) / 60
    for action in actions(now, shoe):
        if isinstance(action.entry, OverRectangle) and action.entry.pressed[0]:
            low, high = action.entry.low[0], action.entry.high[0]
            x, y = (a + (b - a) * middles for a, b in zip(low, high, strict=True))
            points = np.meshgrid(x, y, indexing="ij")
            share = rectangle.samples(points[0].ravel(), points[1].ravel()).mean(axis=0)
            points, weights = units.underside.rectangle_mean(action.entry.low, action.entry.high)
            share[ground.nodes] -= weights[0] @ ground.weights[points[0]]
            nodal += np.outer(share, action.force[0] @ frame)
    return nodal


def test_stress_is_that_of_the_full_static_answer(
    with_fields: History, modes_alone: History, basis: StressBasis
) -> None:
    case = with_fields.case
    body, interfaces = shoe_model(case.flexible_shoes(), case.track)
    partition = Partition(body, interfaces)
    alone = stress_basis(modes_alone)
    for shoe in (7, 13):
        nodal = consistent_nodal(with_fields, shoe).reshape(-1, 1)
        centers = shoe_loads(with_fields, shoe, with_fields.duration).centers.reshape(-1, 1)
        u = partition.static_response(nodal, centers)
        exact = body.stress(u.reshape(-1, 3, 1))[:, :, 0]
        error, truncated = (
            von_mises(one.shapes.stress(one.coordinates[shoe][-1])[0] - exact).max() / von_mises(exact).max()
            for one in (basis, alone)
        )
        assert error < 0.01
        assert truncated > 4.0 * error


def test_fields_are_few_and_their_bound_is_known(basis: StressBasis, modes_alone: History) -> None:
    modes = len(whole_reduction(modes_alone.case).body.frequencies)
    assert modes < basis.shapes.stress_modes.shape[2] <= (1.0 + MOST_FIELDS) * modes
    assert basis.bound is not None
    assert stress_basis(modes_alone, [7]).bound is None


def test_results_and_single_nodes_have_the_same_fields(
    with_fields: History, modes_alone: History, flexible_run: Run
) -> None:
    _, results, tables = flexible_run
    found = recover_stresses(modes_alone, [0.0, 0.06], peak=False)
    for shoe, table in tables.items():
        top = table.iloc[0]
        whole = node_stress(with_fields, shoe, node=int(top["node"]))
        assert float(whole.von_mises.max()) == pytest.approx(top["value"], rel=1e-4)
        assert not table["verdict"].str.contains("truncation").any()
        verdicts = found.hot_spots[shoe]["verdict"].str
        assert (verdicts.contains("truncation") == verdicts.startswith("good")).all()
    off = np.abs(found.dataset.peak_von_mises - results.peak_von_mises) / results.peak_von_mises.max("node")
    assert 0.002 < float(off.max()) < 0.5


@pytest.mark.slow
def test_a_force_at_a_station_of_a_rail_has_its_full_static_answer() -> None:
    case = small_flexible_case()
    body, interfaces = shoe_model(case.flexible_shoes(), case.track)
    whole, static = whole_reduction(case).body, static_loads(case)
    assert static is not None
    stations = rail_stations(body.mesh)
    force = np.array([[0.1e6, 0.05e6, -1e6]])
    at = stations[1].positions[[5]]
    forces = np.concatenate([np.zeros((1, stations[0].count, 3)), stations[1].coordinates(force, at)], axis=1)
    loads = static.fields.coordinates({RAILS: forces})
    columns = field_columns(body, static.fields, [loads])
    q = loads @ static.fields.held(whole.frequencies)
    found = columns.beside(whole).stress(np.hstack((q, loads @ columns.turn)))[0]
    nodal = np.outer(stations[1].weights_at(at).toarray(), force).reshape(-1, 1)
    u = Partition(body, interfaces).static_response(nodal)
    exact = body.stress(u.reshape(-1, 3, 1))[:, :, 0]
    assert von_mises(found - exact).max() < 1e-6 * von_mises(exact).max()
    assert von_mises(whole.stress(q)[0] - exact).max() > 0.1 * von_mises(exact).max()


def test_places_of_loads_cover_a_shoe(with_fields: History) -> None:
    mesh = whole_reduction(with_fields.case).body.mesh
    grid = ground_grid(mesh)
    area = np.prod(grid.rectangle.high - grid.rectangle.low)
    assert grid.weights.sum() == pytest.approx(area)
    right, left = rail_stations(mesh)
    assert right.rectangle.high[1] < 0.0 < left.rectangle.low[1]
    assert np.diff(right.positions).max() < 0.4 * right.reach


def test_coordinates_by_load_add_up(modes_alone: History, basis: StressBasis) -> None:
    for one in (basis, stress_basis(modes_alone, [7])):
        parts = one.by_load(7)
        assert set(parts) == {"pins", "machine load", "ground", "inertia"}
        whole = one.coordinates[7]
        assert sum(parts.values()) == pytest.approx(whole, abs=1e-9 * np.abs(whole).max())
