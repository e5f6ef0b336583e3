"""Histories as data and in files: names and units, the same numbers read back, chunks that are the whole."""

import pickle
import signal
import tracemalloc
import warnings

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import History, files as program_files
from exudyn_crawler.case import statics
from exudyn_crawler.files import write_netcdf_along
from exudyn_crawler.model.state import VERSION
from exudyn_crawler.results.history import summary
from exudyn_crawler.results.history.files import (
    CASE,
    LAYOUT_VERSION,
    TERRAIN_COORDINATES,
    Chunk,
    packed,
    save_joined,
    unit_motion,
    unpacked,
)
from exudyn_crawler.results.history.history import as_history


def test_histories_come_back_as_they_were_saved(turning, constrained, tmp_path):
    for history, duration in ((turning, 0.4), (constrained, 0.1)):
        again = History.load(history.save(tmp_path / f"{duration}.nc"))
        assert again.case == history.case
        xr.testing.assert_identical(again.dataset, history.dataset)
        assert again.duration == pytest.approx(duration, rel=1e-12)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["0.1.nc", "0.4.nc"]


def test_an_existing_file_is_kept_unless_asked(translation, turning, tmp_path):
    path = translation.save(tmp_path / "run.nc")
    before = path.read_bytes()
    with pytest.raises(FileExistsError, match=r"run\.nc exists; allow .* in Python overwrite=True"):
        turning.save(path)
    assert path.read_bytes() == before
    turning.save(path, overwrite=True)
    assert History.load(path).case.name == "turning"


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no history at .*nowhere\.nc"):
        History.load(tmp_path / "nowhere.nc")
    with pytest.raises(FileNotFoundError, match=r"which is a folder; a run has .*history\.nc"):
        as_history(str(tmp_path))


def test_a_broken_file_is_no_history(translation, tmp_path):
    path = translation.save(tmp_path / "run.nc")
    whole = path.read_bytes()
    for content in (b"", b"no netcdf at all", whole[: len(whole) // 2]):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"run\.nc must hold a history"):
            History.load(path)
    # nor is one without a case, or without a valid one
    for dataset in (translation.dataset, translation.dataset.assign_attrs(case='{"name": "half"}')):
        dataset.to_netcdf(path, engine="h5netcdf")
        with pytest.raises(ValueError, match=r"run\.nc must hold a history"):
            History.load(path)


@pytest.mark.parametrize("version", [VERSION - 1, VERSION + 1])
def test_a_file_of_other_states_is_refused(translation, tmp_path, version):
    other = History(translation.case, translation.dataset.assign_attrs({LAYOUT_VERSION: version}))
    told = rf"other\.nc .*layout version {version}, this program reads {VERSION}$"
    with pytest.raises(ValueError, match=told):
        History.load(other.save(tmp_path / "other.nc"))


def test_dimensions_are_those_of_the_papers(translation):
    sizes = dict(translation.dataset.sizes)
    assert sizes.pop("contact") == 14  # shoe 7 on two units
    # 10 + 5 coordinates carry the terrain of 10 x 5 units
    assert sizes.pop("terrain_mode") == 15
    assert sizes == {"time": 201, "shoe": 13, "joint": 12, "unit": 50, "axis": 3}
    assert np.diff(translation.time) == pytest.approx(np.full(200, 2e-3), rel=1e-9)
    assert float(translation.position.sel(shoe=13, axis="x")[0]) == pytest.approx(17.998, abs=1e-4)


def test_unknown_names_are_refused_with_those_there_are(translation):
    with pytest.raises(AttributeError, match=r"a history has no 'speed'; it has .*'velocity'"):
        _ = translation.speed


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_waits_until_a_history_is_read(translation, tmp_path, monkeypatch):
    path, read = translation.save(tmp_path / "history.nc"), []

    def interrupted(*arguments, open_dataset=xr.open_dataset, **options):
        signal.raise_signal(signal.SIGINT)
        return open_dataset(*arguments, **options)

    monkeypatch.setattr(xr, "open_dataset", interrupted)
    monkeypatch.setattr("exudyn_crawler.results.history.history._check", lambda *given: read.append(given))
    with pytest.raises(KeyboardInterrupt):
        History.load(path)
    assert len(read) == 1


def test_a_history_that_other_software_has_written_is_warned_of(translation, tmp_path):
    path, other = translation.save(tmp_path / "history.nc"), tmp_path / "other.nc"
    with warnings.catch_warnings(action="error"):
        assert as_history(str(path)).duration == as_history(translation).duration
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        dataset.drop_encoding().to_netcdf(other, engine="h5netcdf")
    with pytest.warns(UserWarning, match=r"other\.nc has no checksums: other software has written it"):
        History.load(other)


def test_a_file_holds_coordinates_of_the_terrain_and_single_contacts(history, tmp_path):
    path = history.save(tmp_path / "history.nc")
    with xr.open_dataset(path, engine="h5netcdf") as file:
        assert set(TERRAIN_COORDINATES) <= set(file.variables)
        assert not [name for name in file.variables if str(name).startswith("unit_")]
        assert file.normal_force.dtype == np.float32
        assert file.position.dtype == float
    case = history.case.model_dump_json()
    whole = history.dataset.drop_vars(TERRAIN_COORDINATES).assign_attrs({CASE: case})
    old = write_netcdf_along("time", history.time.size, [whole], tmp_path / "old.nc")
    both = [packed(history.dataset).variables.values(), whole.variables.values()]
    sizes = [sum(values.nbytes for values in one if "time" in values.dims) for one in both]
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
    for name, shape in (("unit_heave", "heave_shape"), ("unit_tilt", "tilt_shape")):
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


@pytest.fixture(scope="module")
def parted(translation):
    """History of which the last contact comes in its second half, and both halves, the first without it."""
    dataset = translation.dataset.copy(deep=True)
    middle = dataset.sizes["time"] // 2
    for values in dataset.data_vars.values():
        if "contact" in values.dims:
            values[{"time": slice(middle), "contact": -1}] = 0.0
    first = dataset.isel(time=slice(middle), contact=slice(-1))
    return dataset, [first, dataset.isel(time=slice(middle, None))]


def test_a_contact_that_a_chunk_lacks_is_zero_in_its_time_and_chunks_of_nothing_count_for_nothing(
    translation, parted, tmp_path
):
    whole, parts = parted
    path = save_joined(translation.case, [Chunk.of(part) for part in parts], tmp_path / "history.nc")
    before = Chunk.of_file(path, float(parts[0].time[-1]))
    again = save_joined(translation.case, [before, Chunk.of(parts[1])], tmp_path / "again.nc")
    nothing = Chunk.of(parts[0].isel(time=slice(0)))
    assert nothing.times == 0
    third = save_joined(translation.case, [nothing, *map(Chunk.of, parts)], tmp_path / "third.nc")
    for joined in (path, again, third):
        assert History.load(joined).dataset.identical(whole)


@pytest.mark.slow
def test_writing_takes_no_more_memory_for_more_chunks(translation, tmp_path):
    part = translation.dataset.isel(time=slice(100))

    def chunks(count):
        def later(number):
            time = part.time.values + number
            return lambda: part.copy(deep=True).assign_coords(time=time)

        return [Chunk(100, Chunk.of(part).pairs, later(number)) for number in range(count)]

    peaks = []
    for count in (4, 4, 16):
        tracemalloc.start()
        save_joined(translation.case, chunks(count), tmp_path / "history.nc", overwrite=True)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] > part.nbytes
    assert peaks[2] < 1.5 * peaks[1]
    assert History.load(tmp_path / "history.nc").dataset.sizes["time"] == 1600


def test_extremes_are_those_of_all_parts(translation, monkeypatch):
    """The first of several in time, of what is a number."""
    history = History(translation.case, translation.dataset.copy(deep=True))
    torque = history.dataset.joint_torque
    torque[:] = 0.0
    torque[7, 3, 1] = torque[40, 2, 1] = 5.0
    torque[12, 4, 1] = np.nan
    history.dataset.drive_torque[:] = np.nan
    monkeypatch.setattr(program_files, "TIMES_AT_ONCE", 16)
    table = summary.extremes(history).set_index(["variable", "axis"])
    about_y = table.loc["joint_torque", "y"]
    assert about_y[["greatest", "greatest_of", "greatest_at in s"]].tolist() == [
        5.0,
        "link 4-5",
        history.time[7],
    ]
    assert about_y[["least", "least_at in s"]].tolist() == [0.0, 0.0]
    assert "drive_torque" not in table.index.get_level_values("variable")
    speed = history.velocity.sel(axis="x").values
    time, shoe = np.unravel_index(speed.argmax(), speed.shape)
    fastest = table.loc["velocity", "x"]
    assert fastest[["greatest", "greatest_of"]].tolist() == [speed.max(), f"shoe {shoe + 1}"]
    assert fastest["greatest_at in s"] == history.time[time]


def test_a_large_history_is_read_when_it_is_asked_for(translation, tmp_path, monkeypatch):
    path = translation.save(tmp_path / "history.nc")
    monkeypatch.setattr("exudyn_crawler.results.history.history.MOST_IN_MEMORY", 0)
    large = History.load(path)
    assert not isinstance(large.dataset.variables["position"]._data, np.ndarray)
    assert not large.in_memory
    assert large.dataset.identical(translation.dataset)
    xr.testing.assert_identical(large.position.sel(shoe=7), translation.position.sel(shoe=7))
    assert not isinstance(large.dataset.variables["position"]._data, np.ndarray)
    # every third state of it is read into memory
    found = large.every(3)
    assert found.time.equals(translation.time[::3])
    for name in ("position", "unit_heave", "normal_force"):
        np.testing.assert_array_equal(found.dataset[name].values, large.dataset[name].values[::3])
    assert found.in_memory
    assert translation.every(1) is translation
    monkeypatch.undo()
    assert History.load(path).in_memory


def test_ground_pressure_is_the_normal_force_over_the_underside(translation):
    case, area = translation.case, translation.case.shoe.length * translation.case.shoe.width
    carried = area * translation.ground_pressure.isel(time=0).sum().item()
    weight = case.track.shoe_count * statics.mean_load(case)
    assert carried == pytest.approx(weight, rel=1e-4)
    # all shoes of this track are loaded
    mean = translation.mean_ground_pressure.isel(time=0).item()
    assert mean == pytest.approx(weight / (case.track.shoe_count * area), rel=1e-4)


def test_mean_ground_pressure_is_that_of_loaded_shoes(translation):
    force = translation.normal_force.copy(deep=True)
    on_first = translation.contact_shoe.values <= 4
    lightly = force.where(xr.DataArray(on_first, dims="contact"), 0.05 * force)
    history = History(translation.case, translation.dataset.assign(normal_force=lightly))
    pressure = history.ground_pressure.isel(time=0)
    mean = history.mean_ground_pressure.isel(time=0).item()
    assert mean == pytest.approx(pressure.sel(shoe=slice(1, 4)).mean().item(), rel=1e-12)
    assert (pressure.sel(shoe=slice(5, None)) < 0.1 * mean).all()
