"""Stress by modes and static fields, of all nodes and of one, of the whole run and from its segments."""

import dataclasses
import tracemalloc
import weakref
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import History
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.flexible_shoes import shoe_model, whole_reduction
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.results.loads.actions import OverRectangle, actions
from exudyn_crawler.results.loads.exports import at_instant, shoe_loads
from exudyn_crawler.results.loads.load_map import GROUND, RAILS, loads_by_kind, unit_loads
from exudyn_crawler.results.stress import basis as stress_basis_module, hot_spots
from exudyn_crawler.results.stress.basis import (
    MOST_FIELDS,
    ground_grid,
    rail_stations,
    static_loads,
    stress_basis,
)
from exudyn_crawler.results.stress.recovery import node_stress, node_table, peak_time, recover_stresses
from fem import Partition, field_columns, recover_peaks
from fem.body.element_stress import von_mises
from fem.fatigue import critical_plane, damage
from fem.stress import extremes, low_rank
from tests.rolled import small_flexible_case

SEGMENT = 40
FOLDED = tuple((module, "SEGMENT") for module in (low_rank, damage, critical_plane, extremes))
"""Where the length of a segment stands in what folds stresses."""
NEAR = {"rtol": 1e-6, "atol": 1.0}
"""Sums over segments round otherwise, and so do the static fields that are chosen by them."""


@pytest.fixture(scope="module")
def basis(history):
    return stress_basis(history)


def test_hot_spots_in_spiders_stand_behind_those_that_may_be_used(history, basis):
    whole = basis.shapes
    regions = hot_spots.shoe_regions(whole, history.case.track)
    peaks = recover_peaks(whole.stress_modes, basis.coordinates[13])
    away = np.ones(len(whole.nodes), dtype=bool)
    usable = hot_spots.ranked_nodes(history, basis, 13, peaks, regions, away)
    held = int(whole.spider_nodes[5])
    values = peaks.values.copy()
    values[held] = 2.0 * values.max()
    raised = dataclasses.replace(peaks, values=values)
    table = hot_spots.ranked_nodes(history, basis, 13, raised, regions, away)
    assert (usable["flag"] != "in spider").all()
    pd.testing.assert_frame_equal(table.iloc[:-1], usable)
    last = table.iloc[-1]
    assert (last["rank"], last["node"], last["flag"]) == (len(usable) + 1, held, "in spider")
    assert last["verdict"] == "beside a pin coupling: do not use"


def test_the_highest_stress_over_time_is_of_nodes_outside_of_spiders(history):
    stress = recover_stresses(history).dataset
    assert not stress.in_spider.values[stress.highest_node.values].any()
    usable = stress.peak_von_mises.where(~stress.in_spider).max("node")
    np.testing.assert_allclose(stress.highest_von_mises.max("time"), usable, rtol=1e-9)


def test_static_loads_do_the_work_of_the_modal_loads(history):
    """The ground's grid apart, which holds a pressure's resultants and not its seams."""
    units, static = unit_loads(history.case), static_loads(history.case)
    for shoe in (7, 13):
        loads = sum(loads_by_kind(history, shoe).values())
        expected, found = loads @ units.work, loads @ static.shares @ static.fields.work
        np.testing.assert_allclose(found, expected, atol=0.02 * np.abs(expected).max())
        np.testing.assert_allclose(found[:, :6], expected[:, :6], atol=2e-3 * np.abs(expected).max())


def consistent_nodal(history, shoe):
    """Nodal forces (n, 3) of `shoe_loads` in whose place pressures press on the elements, not on nodes."""
    units = unit_loads(history.case)
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


def test_stress_is_that_of_the_full_static_answer(history, modes_alone, basis):
    case = history.case
    body, interfaces = shoe_model(case.part(FlexibleShoes), case.track)
    partition, alone = Partition(body, interfaces), stress_basis(modes_alone)
    for shoe in (7, 13):
        nodal = consistent_nodal(history, shoe).reshape(-1, 1)
        centers = shoe_loads(history, shoe, history.duration).centers.reshape(-1, 1)
        u = partition.static_response(nodal, centers)
        exact = body.stress(u.reshape(-1, 3, 1))[:, :, 0]
        error, truncated = (
            von_mises(one.shapes.stress(one.coordinates[shoe][-1])[0] - exact).max() / von_mises(exact).max()
            for one in (basis, alone)
        )
        assert error < 0.01
        assert truncated > 4.0 * error


def test_fields_are_few_and_their_bound_is_known(basis, modes_alone):
    modes = len(whole_reduction(modes_alone.case).body.frequencies)
    assert modes < basis.shapes.stress_modes.shape[2] <= (1.0 + MOST_FIELDS) * modes
    assert basis.bound is not None
    assert stress_basis(modes_alone, [7]).bound is None


def test_results_and_single_nodes_have_the_same_fields(history, modes_alone, flexible_run):
    _, results, tables = flexible_run
    found = recover_stresses(modes_alone, [0.0, 0.06], peak=False)
    for shoe, table in tables.items():
        top = table.iloc[0]
        whole = node_stress(history, shoe, node=int(top["node"]))
        assert float(whole.von_mises.max()) == pytest.approx(top["value"], rel=1e-4)
        assert float(whole.time[int(whole.von_mises.values.argmax())]) == pytest.approx(top["time"])
        assert whole.attrs["in_spider"] == bool(results.in_spider[int(top["node"])])
        assert whole.attrs["distance_m"] == 0.0
        assert not table["verdict"].str.contains("truncation").any()
        verdicts = found.hot_spots[shoe]["verdict"].str
        assert (verdicts.contains("truncation") == verdicts.startswith("good")).all()
    off = np.abs(found.dataset.peak_von_mises - results.peak_von_mises) / results.peak_von_mises.max("node")
    assert 0.002 < float(off.max()) < 0.5


@pytest.mark.slow
def test_a_force_at_a_station_of_a_rail_has_its_full_static_answer():
    case = small_flexible_case()
    body, interfaces = shoe_model(case.part(FlexibleShoes), case.track)
    whole, static = whole_reduction(case).body, static_loads(case)
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


def test_places_of_loads_cover_a_shoe(history):
    mesh = whole_reduction(history.case).body.mesh
    grid = ground_grid(mesh)
    assert grid.weights.sum() == pytest.approx(np.prod(grid.rectangle.high - grid.rectangle.low))
    right, left = rail_stations(mesh)
    assert right.rectangle.high[1] < 0.0 < left.rectangle.low[1]
    assert np.diff(right.positions).max() < 0.4 * right.reach


def test_coordinates_by_load_add_up(modes_alone, basis):
    for one in (basis, stress_basis(modes_alone, [7])):
        parts = one.by_load(7)
        assert set(parts) == {"pins", "machine load", "ground", "inertia"}
        whole = one.coordinates[7]
        assert sum(parts.values()) == pytest.approx(whole, abs=1e-9 * np.abs(whole).max())


def test_the_peak_is_that_of_the_recovered_stress(history, stress):
    highest = stress.highest_von_mises.sel(shoe=7)
    assert peak_time(history, 7) == pytest.approx(float(highest.time[int(highest.values.argmax())]))


def test_the_nearest_node_is_found_and_its_distance_told(history, stress):
    place = stress.node_position.values[200]
    found = node_stress(history, 7, near=place + np.array([0.0, 1e-4, 0.0]))
    assert found.attrs["node"] == 200
    assert found.attrs["distance_m"] == pytest.approx(1e-4, rel=1e-9)
    assert found.place.values == pytest.approx(place)


def test_principal_stresses_belong_to_the_tensor(history):
    found = node_stress(history, 7, near=(0.0, 0.0, 0.1))
    one, two, three = (found.principal.sel(order=k).values for k in (1, 2, 3))
    assert ((one >= two) & (two >= three)).all()
    trace = found.stress.sel(component=["xx", "yy", "zz"]).sum("component").values
    assert one + two + three == pytest.approx(trace, abs=1.0)
    mises = np.sqrt(0.5 * ((one - two) ** 2 + (two - three) ** 2 + (three - one) ** 2))
    assert mises == pytest.approx(found.von_mises.values, rel=1e-9)
    columns = node_table(found)
    assert columns["von Mises in MPa"].to_numpy() == pytest.approx(mises / 1e6)
    assert columns["principal 3 in MPa"].to_numpy() == pytest.approx(three / 1e6)
    assert list(columns)[:2] == ["time in s", "xx in MPa"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"shoe": 5, "near": (0, 0, 0)}, r"of \[7, 13\], got 5"),
        ({}, "near or node must be given"),
        ({"near": (0, 0)}, "near must be three finite numbers"),
        ({"near": (0, 0, np.nan)}, "near must be three finite numbers"),
        ({"near": (250, -500, 60)}, r"near must be a point of the shoe, in m .*, 560\.5 m from the nearest"),
        ({"node": 10**9}, "node must be in 0"),
        ({"node": -1}, "node must be in 0"),
    ],
)
def test_what_is_no_place_is_refused(history, options, words):
    with pytest.raises(ValueError, match=words):
        node_stress(history, **{"shoe": 7} | options)


def test_a_file_has_the_numbers_of_its_history(history, tmp_path):
    """Those in memory are those of the file: single precision of the contacts included."""
    path = history.save(tmp_path / "history.nc")
    found, expected = (node_stress(one, 13, near=(0.2, -0.3, 0.1)) for one in (path, history))
    np.testing.assert_array_equal(found.time, expected.time)
    np.testing.assert_allclose(found.stress, expected.stress, rtol=1e-12, atol=1e-3)
    assert found.attrs == expected.attrs


def test_large_static_fields_are_on_disk_until_the_stress_is_recovered(history, monkeypatch):
    """A quarter of a GB of a large mesh, which a run does without."""
    fields = static_loads(history.case).fields
    held = weakref.ref(fields)
    size = fields.displacements.nbytes
    del fields
    monkeypatch.setattr(stress_basis_module, "MOST_HELD", size)
    stress_basis_module.store_static_fields(history.case)
    assert held() is not None
    monkeypatch.setattr(stress_basis_module, "MOST_HELD", size - 1)
    stress_basis_module.store_static_fields(history.case)
    assert held() is None
    assert static_loads(history.case).path.is_file()


def test_static_fields_stay_in_memory_where_the_disk_takes_none(history, monkeypatch):
    static = static_loads(history.case)._replace(path=Path("nowhere"))
    monkeypatch.setattr(stress_basis_module, "MOST_HELD", 0)
    monkeypatch.setattr(stress_basis_module, "static_loads", lambda _case: static)
    monkeypatch.setattr(stress_basis_module, "forget_static_fields", lambda: pytest.fail("forgotten"))
    stress_basis_module.store_static_fields(history.case)


def test_without_static_fields_the_modes_alone_answer(modes_alone):
    basis = stress_basis(modes_alone, [13])
    expected = basis.shapes.stress(basis.coordinates[13], np.array([200]))[:, 0]
    np.testing.assert_allclose(node_stress(modes_alone, 13, node=200).stress, expected, rtol=1e-9, atol=1e-3)


def test_a_history_without_its_mesh_is_named(history, tmp_path):
    flexible = history.case.part(FlexibleShoes).with_(mesh=str(tmp_path / "gone.msh"))
    moved = History(history.case.with_(flexible=flexible), history.dataset).save(tmp_path / "moved.nc")
    with pytest.raises(FileNotFoundError, match="no mesh file"):
        node_stress(moved, 13, node=0)


def test_rigid_runs_have_no_stress(translation):
    with pytest.raises(ValueError, match="shoe must be a flexible one of the history, of none, got 13"):
        node_stress(translation, 13, near=(0, 0, 0))


@pytest.fixture
def in_segments(monkeypatch):
    for module, name in ((stress_basis_module, "LONG"), (stress_basis_module, "PART"), *FOLDED):
        monkeypatch.setattr(module, name, SEGMENT)


def test_stresses_from_segments_are_those_of_the_whole_run(history, stress, in_segments):
    found = recover_stresses(history)
    for name in ("peak_von_mises", "least_von_mises", "highest_von_mises", "peak_mesh_error"):
        np.testing.assert_allclose(found.dataset[name], stress[name], err_msg=name, **NEAR)
    assert np.mean(found.dataset.highest_node.values == stress.highest_node.values) > 0.99


@pytest.mark.slow
def test_lives_from_segments_are_those_of_the_whole_run(history, worn, in_segments):
    found = life_of(worn.duty, [history])
    damage, expected = (one.dataset.damage_an_hour.values for one in (found, worn))
    known = expected > 0.0
    np.testing.assert_allclose(damage[known], expected[known], rtol=1e-3)
    assert found.table["node"].tolist() == worn.table["node"].tolist()
    shares, expected = (one.table.filter(like="share of").to_numpy(dtype=float) for one in (found, worn))
    np.testing.assert_allclose(shares, expected, atol=1e-3)
    error, expected = (one.dataset.stress_error.values for one in (found, worn))
    assert expected == pytest.approx(error, rel=1e-4, nan_ok=True)


@pytest.mark.slow
def test_a_longer_run_takes_no_more_memory_for_its_coordinates(history, in_segments):
    """What is in memory of the coordinates of twice the time is not twice as much."""
    passes = [history.dataset, history.dataset.isel(time=slice(1, None))]
    twice = np.concatenate([passes[0].time, passes[1].time + history.duration])
    dataset = xr.concat(passes, dim="time", data_vars="minimal", coords="minimal", compat="override")
    peaks = []
    for one in (history, History(history.case, dataset.assign_coords(time=("time", twice)))):
        stress_basis(one)  # what is cached of the shoe
        tracemalloc.start()
        found = stress_basis(one)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert all(len(q) == one.time.size for q in found.coordinates.values())
    assert peaks[1] < 1.1 * peaks[0]
