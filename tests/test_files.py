"""Files appear whole or not at all, nothing is overwritten unasked, altered bits of NetCDF are noticed."""

import errno
import os
import signal
import tempfile
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler.files import (
    clear_partial_files,
    whole_file,
    writable_folder,
    write_netcdf,
    write_netcdf_along,
)
from fem.files.hdf5 import Disk

FULL = OSError(errno.ENOSPC, "No space left on device")


def test_a_file_takes_its_place_when_the_block_ends(tmp_path):
    path = tmp_path / "table.csv"
    with whole_file(path) as temporary:
        temporary.write_text("whole")
        assert not path.exists()
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".csv"
    assert path.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("old", [None, "old"])
def test_a_file_that_fails_halfway_leaves_nothing_but_the_old_one(tmp_path, old):
    path = tmp_path / "table.csv"
    if old:
        path.write_text(old)

    def fail_halfway():
        with whole_file(path, overwrite=bool(old)) as temporary:
            temporary.write_text("half")
            raise RuntimeError("halfway")

    with pytest.raises(RuntimeError, match="halfway"):
        fail_halfway()
    assert {one.name: one.read_text() for one in tmp_path.iterdir()} == ({"table.csv": old} if old else {})


def test_an_existing_file_is_refused_before_the_block(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("old")
    with pytest.raises(FileExistsError, match=r"table\.csv exists"), whole_file(path):
        pytest.fail("the block was reached")
    with whole_file(path, overwrite=True) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"


def test_a_file_that_appears_in_the_meantime_is_kept(tmp_path):
    path = tmp_path / "table.csv"

    def two_write():
        with whole_file(path) as temporary:
            temporary.write_text("mine")
            path.write_text("theirs")

    with pytest.raises(FileExistsError, match="another program in the meantime"):
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


def test_a_folder_is_made_with_its_parents_and_not_below_a_file(tmp_path):
    path, file = tmp_path / "a" / "b", tmp_path / "file"
    assert writable_folder(path) == path
    assert list(path.iterdir()) == []
    file.touch()
    for wrong in (file, file / "below"):
        with pytest.raises(NotADirectoryError, match=f"output folder {wrong} is not a folder"):
            writable_folder(wrong)


def test_a_folder_without_rights_is_refused(tmp_path, monkeypatch):
    # a chmod would not stop a superuser
    monkeypatch.setattr(tempfile, "TemporaryFile", Mock(side_effect=PermissionError(13, "Permission denied")))
    with pytest.raises(PermissionError, match=f"output folder {tmp_path} cannot be written to: .*denied"):
        writable_folder(tmp_path)


def test_what_a_killed_process_left_half_is_cleared(tmp_path):
    (tmp_path / "below").mkdir()
    below = "below/.partial-a1b2c3d4-x.csv"
    for name in (".partial-a1b2c3d4-history.nc", below, ".own-a1b2c3d4.csv", "a.csv"):
        (tmp_path / name).touch()
    clear_partial_files(tmp_path, below=False)
    assert (tmp_path / below).exists()
    clear_partial_files(tmp_path)
    assert {path.name for path in tmp_path.rglob("*")} == {"below", ".own-a1b2c3d4.csv", "a.csv"}


@pytest.fixture
def dataset():
    rng = np.random.default_rng(5)
    values = rng.standard_normal((3000, 3, 20))
    return xr.Dataset(
        {
            "position": (("time", "axis", "shoe"), values, {"units": "m"}),
            "mass": ("shoe", values[0, 0]),
            "none": (("time", "apart"), np.zeros((3000, 0))),
            "pair": (("time", "side"), np.ones((3000, 2))),
        },
        coords={"time": ("time", np.arange(3000) * 0.004, {"units": "s"}), "axis": ["x", "y", "z"]}
        | {"unit": ("shoe", range(7, 27)), "apart_shoe": ("apart", np.zeros(0))},
        attrs={"title": "a long text"},
    )


@pytest.fixture(params=["whole", "along time"])
def path(request, dataset, tmp_path):
    if request.param == "whole":
        return write_netcdf(dataset, tmp_path / "some.nc")
    parts = (dataset.isel(time=slice(start, start + 1400)) for start in (0, 1400, 2800))
    return write_netcdf_along("time", 3000, parts, tmp_path / "some.nc")


def heaps(content):
    """Places of what has no checksum in HDF5: the heaps with the names of dimensions."""
    starts = [at for at in range(len(content)) if content.startswith(b"GCOL", at)]
    sizes = [int.from_bytes(content[at + 8 : at + 16], "little") for at in starts]
    return {place for at, size in zip(starts, sizes, strict=True) for place in range(at, at + size)}


def test_an_altered_bit_is_refused_or_changes_nothing(path, dataset):
    xr.testing.assert_identical(xr.load_dataset(path, engine="h5netcdf"), dataset)
    content = path.read_bytes()
    unguarded = heaps(content)
    assert len(unguarded) < 10_000
    # texts have checksums
    at = content.find(b"a long text")
    assert at > 0
    assert at not in unguarded
    rng, refused = np.random.default_rng(6), 0
    for place in set(rng.integers(len(content), size=50).tolist()) - unguarded:
        flipped = content[place] ^ 1 << int(rng.integers(8))
        path.write_bytes(content[:place] + bytes([flipped]) + content[place + 1 :])
        try:
            found = xr.load_dataset(path, engine="h5netcdf")
        except (OSError, RuntimeError, KeyError, ValueError, TypeError):
            refused += 1
        else:
            xr.testing.assert_identical(found, dataset)
    assert refused > 30


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
    monkeypatch.setattr(Path, "write_bytes", Mock(side_effect=FULL))
    with pytest.raises(OSError, match=r"stress\.nc could not be written: No space left"):
        write_netcdf(xr.Dataset({"stress": ("time", np.zeros(3))}), tmp_path / "stress.nc")
    assert list(tmp_path.iterdir()) == []


def test_netcdf_in_parts_that_finds_no_room_is_named_and_leaves_nothing(tmp_path, monkeypatch):
    part = xr.Dataset({"stress": ("time", np.random.default_rng(1).random(100_000))})
    written = []

    def full(self, content, write=Disk.write):
        written.append(len(content))
        if len(written) == 10:
            self.failure = FULL
        return write(self, content)

    monkeypatch.setattr(Disk, "write", full)
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
