"""NetCDF files: a bit that is altered is noticed, by their seal or by checksums within."""

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler.netcdf import SEALED, check_seal, open_netcdf, write_netcdf, write_netcdf_along


@pytest.fixture
def dataset():
    rng = np.random.default_rng(5)
    values = rng.standard_normal((3000, 3, 20))
    return xr.Dataset(
        {"position": (("time", "axis", "shoe"), values, {"units": "m"}), "mass": ("shoe", values[0, 0])},
        coords={"time": ("time", np.arange(3000) * 0.004, {"units": "s"}), "axis": ["x", "y", "z"]},
    )


@pytest.fixture(params=["whole", "along time"])
def path(request, dataset, tmp_path):
    if request.param == "whole":
        return write_netcdf(dataset, tmp_path / "some.nc")
    parts = (dataset.isel(time=slice(start, start + 1000)) for start in range(0, 3000, 1000))
    return write_netcdf_along("time", 3000, parts, tmp_path / "some.nc")


def altered(content, place, bit):
    return content[:place] + bytes([content[place] ^ 1 << bit]) + content[place + 1 :]


def test_any_altered_bit_is_refused(path, dataset):
    with open_netcdf(path) as found:
        xr.testing.assert_identical(found.load(), dataset)
    content = path.read_bytes()
    rng = np.random.default_rng(6)
    for place in rng.integers(len(content) - SEALED, size=200):
        path.write_bytes(altered(content, place, int(rng.integers(8))))
        with pytest.raises(ValueError, match="its bytes were altered"):
            check_seal(path)


def test_a_file_without_a_seal_is_read_and_one_too_large_is_not_proved(path, dataset, monkeypatch):
    content = path.read_bytes()
    path.write_bytes(content[:-SEALED])
    with open_netcdf(path) as found:
        assert found.position.equals(dataset.position)
    path.write_bytes(altered(content, len(content) // 2, 3))
    monkeypatch.setattr("exudyn_crawler.netcdf.MOST_PROVED", 1000)
    check_seal(path)


def test_indices_of_chunks_have_checksums(path, dataset):
    """What a file beyond `MOST_PROVED` still has."""
    content = path.read_bytes()[:-SEALED]
    index = next(at for at in (content.find(mark) for mark in (b"FADB", b"EADB", b"FAHD", b"EAHD")) if at > 0)
    for place in range(index + 6, index + 22):
        path.write_bytes(altered(content, place, 0))
        with pytest.raises((OSError, RuntimeError)), open_netcdf(path) as found:
            found.load()
