"""Long runs: stress and life from segments of a run are those of the whole run, a segment in memory."""

import tracemalloc

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import Duty, FatigueMaterial, History
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.results.stress import basis as stress_basis_module
from exudyn_crawler.results.stress.basis import stress_basis
from exudyn_crawler.results.stress.recovery import recover_stresses
from fem import critical_plane, damage, extremes, rank

SEGMENT = 40
FOLDED = tuple((module, "SEGMENT") for module in (rank, damage, critical_plane, extremes))
"""Where the length of a segment stands in what folds stresses."""
NEAR = {"rtol": 1e-6, "atol": 1.0}
"""Sums over segments round otherwise, and so do the static fields that are chosen by them."""


@pytest.fixture
def in_segments(monkeypatch):
    for module, name in ((stress_basis_module, "LONG"), (stress_basis_module, "PART"), *FOLDED):
        monkeypatch.setattr(module, name, SEGMENT)


def test_stresses_from_segments_are_those_of_the_whole_run(flexible_run, in_segments):
    history, stress, _ = flexible_run
    found = recover_stresses(history)
    for name in ("peak_von_mises", "least_von_mises", "highest_von_mises", "peak_mesh_error"):
        np.testing.assert_allclose(found.dataset[name], stress[name], err_msg=name, **NEAR)
    assert np.mean(found.dataset.highest_node.values == stress.highest_node.values) > 0.99


@pytest.mark.slow
def test_lives_from_segments_are_those_of_the_whole_run(flexible_run, request):
    run = DutyRun(name="propel", folder=".", share=0.1)
    material = FatigueMaterial.a36().with_(fatigue_strength=90e6)
    duty = Duty(runs=(run,), material=material, plane_nodes=0, survivals=(0.9,))
    whole = life_of(duty, [flexible_run[0]])
    request.getfixturevalue("in_segments")
    found = life_of(duty, [flexible_run[0]])
    damage, expected = (one.dataset.damage_an_hour.values for one in (found, whole))
    known = expected > 0.0
    np.testing.assert_allclose(damage[known], expected[known], rtol=1e-3)
    assert found.table["node"].tolist() == whole.table["node"].tolist()
    shares, expected = (one.table.filter(like="share of").to_numpy(dtype=float) for one in (found, whole))
    np.testing.assert_allclose(shares, expected, atol=1e-3)
    error, expected = (one.dataset.stress_error.values for one in (found, whole))
    assert expected == pytest.approx(error, rel=1e-4, nan_ok=True)


def test_a_longer_run_takes_no_more_memory_for_its_coordinates(flexible_run, in_segments):
    """What is in memory of the coordinates of twice the time is not twice as much."""
    history = flexible_run[0]
    passes = [history.dataset, history.dataset.isel(time=slice(1, None))]
    time = passes[1].time + history.duration
    twice = np.concatenate([passes[0].time, time])
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
