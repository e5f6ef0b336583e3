"""Histories in files: half as large, and the same numbers when they are read."""

import pickle

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import History
from exudyn_crawler.netcdf import write_netcdf_along
from exudyn_crawler.results.history.case_in_file import with_case
from exudyn_crawler.results.history.files import (
    SHAPES,
    TERRAIN_COORDINATES,
    packed,
    unit_motion,
    unpacked,
)


def test_a_file_holds_coordinates_of_the_terrain_and_single_contacts(flexible_run, tmp_path):
    history, _, _ = flexible_run
    path = history.save(tmp_path / "history.nc")
    with xr.open_dataset(path, engine="h5netcdf") as file:
        assert set(TERRAIN_COORDINATES) <= set(file.variables)
        assert not [name for name in file.variables if str(name).startswith("unit_")]
        assert file.normal_force.dtype == np.float32
        assert file.position.dtype == float
    whole = with_case(history.dataset.drop_vars(TERRAIN_COORDINATES), history.case)
    old = write_netcdf_along("time", history.time.size, [whole], tmp_path / "old.nc")
    sizes = [
        sum(one.nbytes for one in dataset.variables.values() if "time" in one.dims)
        for dataset in (packed(history.dataset), whole)
    ]
    assert sizes[0] < 0.5 * sizes[1]
    # files of earlier versions have no coordinates of the terrain
    earlier = History.load(old).dataset
    xr.testing.assert_identical(earlier, history.dataset.drop_vars(TERRAIN_COORDINATES))
    assert packed(earlier).unit_heave.dtype == float


def test_a_history_from_a_file_goes_to_other_processes(translation, tmp_path):
    history = History.load(translation.save(tmp_path / "history.nc"))
    again = pickle.loads(pickle.dumps(history))
    xr.testing.assert_identical(again.dataset, history.dataset)
    assert np.array_equal(again.unit_heave.values, translation.unit_heave.values)


def test_units_move_by_the_terrains_coordinates(translation):
    dataset = translation.dataset
    for name, shape in SHAPES.items():
        product = dataset[shape].values @ dataset.terrain_motion_rate.values.T
        rate = dataset[f"{name}_rate"].values
        assert rate == pytest.approx(product.T, abs=1e-12 * np.abs(rate).max())


def test_a_number_is_the_same_whatever_else_is_asked_for(translation):
    shape, motion = translation.heave_shape.values, translation.terrain_motion.values
    whole = unit_motion(shape, motion)
    for times, units in ((slice(3, 4), slice(None)), (slice(7, 150), slice(5, 6)), ([0, 9], [1, 3, 30])):
        assert np.array_equal(unit_motion(shape[units], motion[times]), whole[times][:, units])


@pytest.mark.parametrize(
    "chosen",
    [
        {"time": 3},
        {"unit": 4, "contact": 1},
        {"time": slice(2, 9, 3), "unit": [7, 2]},
        {"time": [5, 1], "axis": 2, "contact": slice(1, 4)},
    ],
)
def test_parts_of_a_file_are_computed_alone(translation, tmp_path, chosen):
    path = translation.save(tmp_path / "history.nc")
    with xr.open_dataset(path, engine="h5netcdf", cache=False) as file:
        part = unpacked(file).isel(chosen)[["unit_tilt_acceleration", "normal_force", "area"]]
        expected = translation.dataset.isel(chosen)[list(part.data_vars)]
        for name in part.data_vars:
            assert np.array_equal(part[name].values, expected[name].values)
