"""Results as data: names, units, saving and reading back."""

import signal
import warnings

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import History
from exudyn_crawler.model.state import VERSION
from exudyn_crawler.results.history.files import LAYOUT_VERSION
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
        with pytest.raises(ValueError, match=r"run\.nc does not hold a history"):
            History.load(path)
    # nor is one without a case, or without a valid one
    for dataset in (translation.dataset, translation.dataset.assign_attrs(case='{"name": "half"}')):
        dataset.to_netcdf(path, engine="h5netcdf")
        with pytest.raises(ValueError, match=r"run\.nc does not hold a history"):
            History.load(path)


@pytest.mark.parametrize("version", [VERSION - 1, VERSION + 1])
def test_a_file_of_other_states_is_refused(translation, tmp_path, version):
    other = History(translation.case, translation.dataset.assign_attrs({LAYOUT_VERSION: version}))
    told = rf"other\.nc .*layout version {version}, this program reads {VERSION}$"
    with pytest.raises(ValueError, match=told):
        History.load(other.save(tmp_path / "other.nc"))


def test_every_third_state_of_a_history_in_its_file_is_read_into_memory(translation, tmp_path, monkeypatch):
    path = translation.save(tmp_path / "long.nc")
    monkeypatch.setattr("exudyn_crawler.results.history.history.MOST_IN_MEMORY", 0)
    whole = History.load(path)
    found = whole.every(3)
    assert found.time.equals(translation.time[::3])
    for name in ("position", "unit_heave", "normal_force"):
        np.testing.assert_array_equal(found.dataset[name].values, whole.dataset[name].values[::3])
    assert translation.every(1) is translation


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


@pytest.mark.simulation
def test_a_history_that_other_software_has_written_is_warned_of(translation, tmp_path):
    path, other = translation.save(tmp_path / "history.nc"), tmp_path / "other.nc"
    with warnings.catch_warnings(action="error"):
        assert as_history(str(path)).duration == as_history(translation).duration
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        dataset.drop_encoding().to_netcdf(other, engine="h5netcdf")
    with pytest.warns(UserWarning, match=r"other\.nc has no checksums: other software has written it"):
        History.load(other)
