"""Static fields beside the modes of a run: against the full static answer to all that acts on a shoe."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import History
from exudyn_crawler.model.flexible_shoes import shoe_model
from exudyn_crawler.model.load_places import ground_grid, rail_stations, shoe_fields
from exudyn_crawler.results.field_loads import field_loads
from exudyn_crawler.results.modal_coordinates import coordinates_and_momentum, modal_loads, stress_basis
from exudyn_crawler.results.node_stress import node_stress
from exudyn_crawler.results.shoe_loads import shoe_loads
from exudyn_crawler.results.stress_columns import SHARE, StressColumns, stress_columns
from exudyn_crawler.results.stresses import recover_stresses
from fem import Partition
from fem.stress import von_mises

Run = tuple[History, xr.Dataset, dict[int, pd.DataFrame]]


@pytest.fixture(scope="module")
def with_fields(flexible_run: Run) -> History:
    history = flexible_run[0]
    flexible = history.case.flexible_shoes().with_(static_fields=True)
    return History(history.case.with_(flexible=flexible), history.dataset)


@pytest.fixture(scope="module")
def columns(with_fields: History) -> StressColumns:
    return stress_columns(with_fields)


def test_coordinates_do_the_work_of_the_modal_loads(with_fields: History) -> None:
    """The ground's grid apart, which holds a pressure's resultants and not its seams."""
    basis = stress_basis(with_fields)
    fields = shoe_fields(with_fields.case)
    for shoe in (7, 13):
        _, momentum = coordinates_and_momentum(with_fields, basis, shoe)
        loads = field_loads(with_fields, fields, basis.whole, momentum, shoe)
        expected = modal_loads(with_fields, basis, shoe) + momentum @ basis.inside.T
        np.testing.assert_allclose(loads @ fields.work, expected, atol=0.02 * np.abs(expected).max())
        low = slice(6)
        np.testing.assert_allclose(
            (loads @ fields.work)[:, low], expected[:, low], atol=2e-3 * np.abs(expected).max()
        )


@pytest.mark.parametrize("shoe", [7, 13])
def test_stress_is_that_of_the_full_static_answer(
    with_fields: History, flexible_run: Run, columns: StressColumns, shoe: int
) -> None:
    case = with_fields.case
    body, interfaces = shoe_model(case.flexible_shoes(), case.track)
    loads = shoe_loads(with_fields, shoe, 0.06)
    u = Partition(body, interfaces).static_response(loads.nodal.reshape(-1, 1), loads.centers.reshape(-1, 1))
    exact = body.stress(u.reshape(-1, 3, 1))[:, :, 0]
    # the deck's forces on single nodes of the underside and of the drive are felt by their elements
    loaded = np.isin(body.mesh.elements, body.mesh.nodes_of("underside")).any(axis=1)
    loaded |= recovered_at_load(with_fields, shoe)[body.mesh.elements].any(axis=1)
    away = np.setdiff1d(np.arange(len(exact)), np.unique(body.mesh.elements[loaded]))
    peak = von_mises(exact)[away].max()
    own = columns.shapes.stress(columns.coordinates[shoe][-1])[0]
    alone = stress_columns(flexible_run[0], [shoe])
    modes = alone.shapes.stress(alone.coordinates[shoe][-1])[0]
    error = von_mises(own - exact)[away].max() / peak
    truncated = von_mises(modes - exact)[away].max() / peak
    print("ERR", shoe, error, truncated, columns.bound, peak, columns.shapes.stress_modes.shape)
    assert error < 0.01
    assert truncated > 5.0 * error


def recovered_at_load(history: History, shoe: int) -> np.ndarray:
    """Whether each node is beside the node that the drive pulls."""
    return recover_stresses(history, [0.0], peak=False).dataset.at_load.sel(shoe=shoe).values


def test_fields_are_few_and_their_bound_is_known(columns: StressColumns, flexible_run: Run) -> None:
    modes = len(stress_basis(flexible_run[0]).whole.frequencies)
    assert modes < columns.shapes.stress_modes.shape[2] <= (1.0 + SHARE) * modes
    assert columns.bound is not None
    assert stress_columns(flexible_run[0], [7]).bound is None


def test_results_and_single_nodes_have_the_same_fields(with_fields: History, flexible_run: Run) -> None:
    found = recover_stresses(with_fields, [0.0, 0.06], peak=False)
    _, plain, tables = flexible_run
    for shoe, table in found.hot_spots.items():
        top = table.iloc[0]
        whole = node_stress(with_fields, shoe, node=int(top["node"]))
        assert float(whole.von_mises.max()) == pytest.approx(top["value"], rel=1e-4)
        assert not table["verdict"].str.contains("truncation").any()
        good = tables[shoe]["verdict"].str.startswith("good")
        assert (tables[shoe]["verdict"].str.contains("truncation") == good).all()
    off = np.abs(found.dataset.peak_von_mises - plain.peak_von_mises) / plain.peak_von_mises.max("node")
    assert 0.002 < float(off.max()) < 0.5


def test_places_of_loads_cover_a_shoe(with_fields: History) -> None:
    mesh = stress_basis(with_fields).whole.mesh
    grid = ground_grid(mesh)
    area = np.prod(grid.rectangle.high - grid.rectangle.low)
    assert grid.weights.sum() == pytest.approx(area)
    right, left = rail_stations(mesh)
    assert right.rectangle.high[1] < 0.0 < left.rectangle.low[1]
    assert np.diff(right.positions).max() < 0.4 * right.reach
