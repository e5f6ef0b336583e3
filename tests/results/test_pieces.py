"""Histories in chunks along time: joined in memory or in a file, they are the whole."""

import tracemalloc

import numpy as np
import pytest
import xarray as xr

from exudyn_crawler import History
from exudyn_crawler.results.history.files import Chunk, joined, save_joined


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


def test_a_contact_that_a_chunk_lacks_is_zero_in_its_time(parted):
    whole, parts = parted
    assert joined([Chunk.of(part) for part in parts]).identical(whole)


def test_chunks_in_a_file_are_those_in_memory(translation, parted, tmp_path):
    whole, parts = parted
    path = save_joined(translation.case, [Chunk.of(part) for part in parts], tmp_path / "history.nc")
    assert History.load(path).dataset.identical(whole)
    before = Chunk.of_file(path, float(parts[0].time[-1]))
    again = save_joined(translation.case, [before, Chunk.of(parts[1])], tmp_path / "again.nc")
    assert History.load(again).dataset.identical(whole)


def test_chunks_of_nothing_count_for_nothing(parted):
    whole, parts = parted
    nothing = Chunk.of(parts[0].isel(time=slice(0)))
    assert nothing.times == 0
    assert joined([nothing, *map(Chunk.of, parts)]).identical(whole)


@pytest.mark.slow
def test_writing_takes_no_more_memory_for_more_chunks(translation, tmp_path):
    part = translation.dataset.isel(time=slice(100))

    def chunks(count):
        def later(number):
            time = part.time.values + number
            return lambda: [part.copy(deep=True).assign_coords(time=time)]

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


def test_a_large_history_is_read_when_it_is_asked_for(translation, tmp_path, monkeypatch):
    path = translation.save(tmp_path / "history.nc")
    monkeypatch.setattr("exudyn_crawler.results.history.history.MOST_IN_MEMORY", 0)
    large = History.load(path)
    assert not isinstance(large.dataset.variables["position"]._data, np.ndarray)
    assert large.dataset.identical(translation.dataset)
    xr.testing.assert_identical(large.position.sel(shoe=7), translation.position.sel(shoe=7))
    assert not isinstance(large.dataset.variables["position"]._data, np.ndarray)
