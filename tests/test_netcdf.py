"""NetCDF files: whole or not at all; altered bits are noticed by checksums."""

import errno
import os
import signal
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler.files import _Disk, write_netcdf, write_netcdf_along


@pytest.fixture
def dataset():
    rng = np.random.default_rng(5)
    values = rng.standard_normal((3000, 3, 20))
    return xr.Dataset(
        {"position": (("time", "axis", "shoe"), values, {"units": "m"}), "mass": ("shoe", values[0, 0])},
        coords={"time": ("time", np.arange(3000) * 0.004, {"units": "s"}), "axis": ["x", "y", "z"]},
        attrs={"title": "a long text"},
    )


@pytest.fixture(params=["whole", "along time"])
def path(request, dataset, tmp_path):
    if request.param == "whole":
        return write_netcdf(dataset, tmp_path / "some.nc")
    parts = (dataset.isel(time=slice(start, start + 1000)) for start in range(0, 3000, 1000))
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
    for place in set(rng.integers(len(content), size=150).tolist()) - unguarded:
        flipped = content[place] ^ 1 << int(rng.integers(8))
        path.write_bytes(content[:place] + bytes([flipped]) + content[place + 1 :])
        try:
            found = xr.load_dataset(path, engine="h5netcdf")
        except (OSError, RuntimeError, KeyError, ValueError, TypeError):
            refused += 1
        else:
            xr.testing.assert_identical(found, dataset)
    assert refused > 100


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
        coords={"time": np.arange(10.0), "axis": ["x", "y", "z"]}
        | {"unit": ("contact", [7, 12]), "shoe": ("apart", np.zeros(0))},
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
            self.failure = OSError(errno.ENOSPC, "No space left on device")
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
