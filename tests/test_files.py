"""Files appear whole or not at all, and nothing is overwritten unasked."""

import errno
import os
import signal
import tempfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler.files import (
    _Disk,
    clear_partial_files,
    whole_file,
    writable_folder,
    write_netcdf,
    write_netcdf_along,
)


def fail_halfway(path, overwrite=False):
    with whole_file(path, overwrite) as temporary:
        temporary.write_text("half")
        raise RuntimeError("halfway")


def test_a_file_takes_its_place_when_the_block_ends(tmp_path):
    path = tmp_path / "table.csv"
    with whole_file(path) as temporary:
        temporary.write_text("whole")
        assert not path.exists()
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".csv"
    assert path.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_fails_halfway_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError, match="halfway"):
        fail_halfway(tmp_path / "table.csv")
    assert list(tmp_path.iterdir()) == []


def test_overwriting_that_fails_halfway_keeps_the_old_file(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("old")
    with pytest.raises(RuntimeError, match="halfway"):
        fail_halfway(path, overwrite=True)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_an_existing_file_is_refused_before_the_block(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("old")
    reached = False
    with pytest.raises(FileExistsError, match=r"table\.csv exists"), whole_file(path):
        reached = True
    assert not reached
    with whole_file(path, overwrite=True) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"


def test_a_file_that_appears_in_the_meantime_is_kept(tmp_path):
    path = tmp_path / "table.csv"

    def two_write():
        with whole_file(path) as temporary:
            temporary.write_text("mine")
            path.write_text("theirs")

    with pytest.raises(FileExistsError, match="somebody else in the meantime"):
        two_write()
    assert path.read_text() == "theirs"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_a_file_has_the_rights_of_any_new_one(tmp_path, mask):
    before = os.umask(mask)
    try:
        with whole_file(tmp_path / "table.csv") as temporary:
            temporary.write_text("whole")
    finally:
        os.umask(before)
    assert (tmp_path / "table.csv").stat().st_mode & 0o777 == 0o666 & ~mask


def test_a_folder_is_made_with_its_parents(tmp_path):
    path = tmp_path / "a" / "b"
    assert writable_folder(path) == path
    assert list(path.iterdir()) == []


def test_a_file_is_no_folder(tmp_path):
    file = tmp_path / "file"
    file.touch()
    for path in (file, file / "below"):
        with pytest.raises(NotADirectoryError, match=f"output folder {path} is not a folder"):
            writable_folder(path)


def test_a_folder_without_rights_is_refused(tmp_path, monkeypatch):
    # a chmod would not stop a superuser
    def refused(*_args, **_options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    with pytest.raises(PermissionError, match=f"output folder {tmp_path} cannot be written to: .*denied"):
        writable_folder(tmp_path)


def test_netcdf_is_compressed_and_comes_back(tmp_path):
    dataset = xr.Dataset(
        {"stress": ("time", np.zeros(100_000), {"units": "Pa"}), "held": ("node", [True, False])},
        coords={"time": np.arange(100_000.0)},
    )
    path = write_netcdf(dataset, tmp_path / "stress.nc")
    assert path.stat().st_size < dataset.time.nbytes + 0.1 * dataset.stress.nbytes
    xr.testing.assert_identical(xr.load_dataset(path, engine="h5netcdf"), dataset)
    with pytest.raises(FileExistsError, match=r"stress\.nc exists"):
        write_netcdf(dataset, path)


def test_netcdf_that_finds_no_room_is_named_and_leaves_nothing(tmp_path, monkeypatch):
    def full(_path, _content):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match=r"stress\.nc could not be written: No space left"):
        write_netcdf(xr.Dataset({"stress": ("time", np.zeros(3))}), tmp_path / "stress.nc")
    assert list(tmp_path.iterdir()) == []


def test_netcdf_along_a_dimension_is_that_of_the_whole(tmp_path):
    whole = xr.Dataset(
        {
            "force": (("time", "contact", "axis"), np.arange(60.0).reshape(10, 2, 3), {"units": "N"}),
            "none": (("time", "apart"), np.zeros((10, 0))),
            "pair": (("time", "side"), np.ones((10, 2))),
            "mass": ("contact", [1.0, 2.0]),
        },
        coords={
            "time": np.arange(10.0),
            "axis": ["x", "y", "z"],
            "unit": ("contact", [7, 12]),
            "shoe": ("apart", np.zeros(0)),
        },
        attrs={"title": "whole"},
    )
    parts = (whole.isel(time=slice(start, start + 4)) for start in (0, 4, 8))
    path = write_netcdf_along("time", 10, parts, tmp_path / "whole.nc")
    xr.testing.assert_identical(xr.load_dataset(path, engine="h5netcdf"), whole)


def test_netcdf_in_parts_that_finds_no_room_is_named_and_leaves_nothing(tmp_path, monkeypatch):
    part = xr.Dataset({"stress": ("time", np.random.default_rng(1).random(100_000))})
    written = []

    def full(self, content, write=_Disk.write):
        written.append(len(content))
        if len(written) == 10:
            self._failure = OSError(errno.ENOSPC, "No space left on device")
        return write(self, content)

    monkeypatch.setattr(_Disk, "write", full)
    with pytest.raises(OSError, match=r"stress\.nc could not be written: No space left"):
        write_netcdf_along("time", 1_000_000, [part] * 10, tmp_path / "stress.nc")
    assert len(written) >= 10
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="signals of Unix")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_until_hdf5_has_let_go_of_a_file(tmp_path, number):
    part, seen = xr.Dataset({"stress": ("time", np.zeros(10))}), []

    def parts():
        for count in range(100):
            seen.append(count)
            if count == 3:
                signal.raise_signal(number)
            yield part

    before = signal.signal(number, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            write_netcdf_along("time", 1000, parts(), tmp_path / "stress.nc")
        assert signal.getsignal(number) is signal.default_int_handler
    finally:
        signal.signal(number, before)
    assert seen == [0, 1, 2, 3]
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_process_left_half_is_cleared(tmp_path):
    (tmp_path / "below").mkdir()
    for name in (
        ".partial-a1b2c3d4-history.nc",
        "below/.partial-a1b2c3d4-x.csv",
        ".own-a1b2c3d4.csv",
        "a.csv",
    ):
        (tmp_path / name).touch()
    clear_partial_files(tmp_path, below=False)
    assert (tmp_path / "below" / ".partial-a1b2c3d4-x.csv").exists()
    clear_partial_files(tmp_path)
    assert {path.name for path in tmp_path.rglob("*")} == {"below", ".own-a1b2c3d4.csv", "a.csv"}
