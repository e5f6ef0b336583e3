"""Histories in pieces along time, such as the stages of a run leave, joined in memory or in one file."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.netcdf import open_netcdf, write_netcdf_along
from exudyn_crawler.results.history.case_in_file import with_case, without_case
from exudyn_crawler.results.history.compact import packed, unpacked
from fem.interrupts import interrupts_wait


@dataclass(frozen=True)
class Piece:
    """Part of a history, read when it is needed.

    Attributes
    ----------
    times : int
        Number of its stored times.
    pairs : array (contacts, 2)
        Shoe and unit of each of its contacts.
    parts : callable
        Gives its datasets, one after the other.
    """

    times: int
    pairs: NDArray
    parts: Callable[[], Iterable[xr.Dataset]]

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Self:
        """A whole dataset of a history."""
        return cls(dataset.sizes["time"], _pairs(dataset), lambda: blocks(dataset))

    @classmethod
    def of_file(cls, path: Path, end: float) -> Self:
        """What a saved history holds up to a time, s."""
        with interrupts_wait(), open_netcdf(path) as dataset:
            times = int(np.count_nonzero(dataset.time.values <= end + 1e-9 * max(1.0, end)))
            pairs = _pairs(dataset)

        def parts() -> Iterator[xr.Dataset]:
            with xr.open_dataset(path, engine="h5netcdf", cache=False) as dataset:
                yield from blocks(without_case(unpacked(dataset)).isel(time=slice(times)))

        return cls(times, pairs, parts)


TIMES_AT_ONCE = 1000
"""Stored times of a file that are held in memory together."""


def blocks(dataset: xr.Dataset) -> Iterator[xr.Dataset]:
    """Consecutive parts of a dataset with a time, each of which fits into memory."""
    for start in range(0, max(1, dataset.sizes["time"]), TIMES_AT_ONCE):
        yield dataset.isel(time=slice(start, start + TIMES_AT_ONCE))


def _pairs(dataset: xr.Dataset) -> NDArray:
    return np.column_stack((dataset.contact_shoe.values, dataset.contact_unit.values))


def joined(pieces: Sequence[Piece]) -> xr.Dataset:
    """Dataset of all pieces together; a contact that a piece lacks is zero in its time."""
    parts = list(_parts(pieces))
    if len(parts) == 1:
        return parts[0]
    return xr.concat(
        parts, dim="time", data_vars="minimal", coords="minimal", compat="override", join="override"
    )


def save_joined(case: Case, pieces: Sequence[Piece], path: Path, overwrite: bool = False) -> Path:
    """Write the history of a case that the pieces make, holding a part of it at a time.

    Raises
    ------
    FileExistsError, OSError
        As of `files.whole_file`.
    """
    whole = (with_case(packed(part), case) for part in _parts(pieces))
    times = sum(piece.times for piece in pieces)
    return write_netcdf_along("time", times, whole, path, overwrite)


def _parts(pieces: Sequence[Piece]) -> Iterator[xr.Dataset]:
    """Datasets of all pieces that have a time, with the contacts of all of them."""
    kept = [piece for piece in pieces if piece.times]
    pairs = np.unique(np.concatenate([piece.pairs for piece in kept]), axis=0)
    for piece in kept:
        for part in piece.parts():
            yield _widened(part, pairs)


def _widened(dataset: xr.Dataset, pairs: NDArray) -> xr.Dataset:
    """Dataset with a contact for each of the sorted pairs (contacts, 2), its own among them."""
    own = _pairs(dataset)
    if np.array_equal(own, pairs):
        return dataset
    column = {tuple(pair): k for k, pair in enumerate(pairs.tolist())}
    places = [column[tuple(pair)] for pair in own.tolist()]
    wider = {}
    for name, variable in dataset.data_vars.items():
        if "contact" in variable.dims:
            axis = variable.get_axis_num("contact")
            values = np.zeros((*variable.shape[:axis], len(pairs), *variable.shape[axis + 1 :]))
            values[(slice(None),) * axis + (places,)] = variable.values
            wider[name] = (variable.dims, values, variable.attrs)
    coordinates = {"contact_shoe": ("contact", pairs[:, 0]), "contact_unit": ("contact", pairs[:, 1])}
    return dataset.drop_dims("contact").assign(wider).assign_coords(coordinates)
