"""Files of histories, whole or in chunks along time, with their case.

A file has the coordinates of a terrain and their shapes instead of the motion of hundreds of units; the
reader computes this motion to the same bits. Contacts are in single precision: rounding is 6e-8 of a value,
far below the solver's residual. A run writes one chunk a stage; they are joined in memory or in one file.
"""

import json
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Self

import h5py
import numpy as np
import xarray as xr

from exudyn_crawler import errors, files
from exudyn_crawler.case import Case
from exudyn_crawler.machines import saved_case
from exudyn_crawler.model.state import VERSION
from exudyn_crawler.results.history.catalogue import CONTACT_KEYS, QUANTITIES, select
from fem.files.hdf5 import check_heaps
from fem.interrupts import interrupts_wait

CASE = "case"  # attribute of a file
LAYOUT_VERSION = "layout_version"  # attribute of a file: version of the layout of the history's states
TERRAIN = "terrain_motion"
TERRAIN_COORDINATES = tuple(select(per="terrain coordinate"))
"""Coordinates of a history's dataset from which the units' motion is computed."""
UNIT_MOTION = tuple(select(per="unit"))


@contextmanager
def reading_history(path: Path) -> Iterator[None]:
    """Turn any error of the block into a ValueError that the file does not hold a history.

    FileNotFoundError if there is no such file.
    """
    if not path.is_file():
        folder = f", which is a folder; a run has {path / 'history.nc'}" if path.is_dir() else ""
        raise FileNotFoundError(f"no history at {path}{folder}")
    try:
        check_heaps(path)
        yield
    # altered bytes make the readers raise all kinds of errors
    except Exception as error:
        reason = (
            "; ".join(error.errors) if isinstance(error, errors.ParameterError) else str(error) or repr(error)
        )
        raise ValueError(f"{path} must hold a history: {' '.join(reason.split())}") from error


@interrupts_wait()
def case_in_file(path: Path) -> Case:
    """Return the case of a history's file; raise as `reading_history`, also for another layout version."""
    with reading_history(path), h5py.File(path, "r") as file:
        version = np.asarray(file.attrs.get(LAYOUT_VERSION, 0)).item()
        if version != VERSION:
            raise ValueError(f"its states have layout version {version}, this program reads {VERSION}")
        case = saved_case(file.attrs[CASE])
        has_checksums = bool(file["time"].fletcher32)
    if not has_checksums:
        said = "has no checksums: other software has written it, and its numbers may not be those of the run"
        warnings.warn(f"{path} {said}", stacklevel=2)
    return case


def unit_motion(shape: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Return the motion (times, units) of a shape (units, modes) under coordinates (times, modes).

    Each number has the same bits in any selection of times and units; a matrix product would not ensure that.
    """
    return np.einsum("uk,tk->tu", shape, coordinates)


def packed(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset of a history in the form of a file."""
    if TERRAIN in dataset.variables:
        dataset = dataset.drop_vars(UNIT_MOTION, errors="ignore")
    return dataset.assign({name: dataset[name].astype(QUANTITIES[name].dtype) for name in _single(dataset)})


def unpacked(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset of a history from that of a file, with the units' motion computed on demand.

    There are hundreds of units, and a reader looks at few of them.
    """
    stored = {name: dataset.variables[name] for name in _single(dataset)}
    computed = {
        name: _lazy(name, variable.shape, partial(_doubled, variable)) for name, variable in stored.items()
    }
    whole = with_motion_of_units(dataset.assign(computed))
    whole.attrs.pop(CASE, None)
    return whole


def with_motion_of_units(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset of a history with the motion of its units, computed on demand.

    The dataset already has this motion if the terrain has no independent coordinates.
    """
    if TERRAIN not in dataset.variables:
        return dataset
    computed = {}
    for name in UNIT_MOTION:
        # such as unit_tilt_rate of tilt_shape and terrain_motion_rate
        _, shape, *rate = name.split("_")
        shapes = dataset.variables[f"{shape}_shape"].values
        motion = dataset.variables["_".join((TERRAIN, *rate))]
        part = partial(_part_of_motion, shapes, motion)
        sizes = (motion.shape[0], len(shapes))
        computed[name] = _lazy(name, sizes, part)
    return dataset.set_coords(list(TERRAIN_COORDINATES)).assign(computed)


def _single(dataset: xr.Dataset) -> list[str]:
    """Return the names of the variables that files hold in single precision."""
    return [name for name in select(numbers="single") if name in dataset.data_vars]


def _part_of_motion(shapes: np.ndarray, motion: xr.Variable, key: tuple) -> np.ndarray:
    modes = shapes[key[1]]
    rows = motion[key[0]].values
    part = unit_motion(np.atleast_2d(modes), np.atleast_2d(rows))
    return part.reshape(rows.shape[:-1] + modes.shape[:-1])


def _doubled(stored: xr.Variable, key: tuple) -> np.ndarray:
    return np.asarray(stored[key].values, dtype=float)


def _lazy(name: str, shape: tuple[int, ...], part: Callable[[tuple], np.ndarray]) -> xr.Variable:
    array = xr.core.indexing.LazilyIndexedArray(_Computed(shape, part))
    return xr.Variable(QUANTITIES[name].dimensions, array, QUANTITIES[name].attributes)


class _Computed(xr.backends.BackendArray):
    """Array computed by parts; `part` takes a number, a slice or numbers (n,) for each dimension."""

    def __init__(self, shape: tuple[int, ...], part: Callable[[tuple], np.ndarray]) -> None:
        self.shape, self.dtype, self._part = shape, np.dtype(float), part

    def __getitem__(self, key: xr.core.indexing.ExplicitIndexer) -> np.ndarray:
        outer = xr.core.indexing.IndexingSupport.OUTER
        return xr.core.indexing.explicit_indexing_adapter(key, self.shape, outer, self._part)


@dataclass(frozen=True)
class Chunk:
    """Part of a history along time, read on demand."""

    times: int  # number of stored times
    pairs: np.ndarray  # (contacts, 3), shoe, unit and finger of each contact
    read: Callable[[], xr.Dataset]

    @classmethod
    def of(cls, dataset: xr.Dataset, read: Callable[[], xr.Dataset] | None = None) -> Self:
        """Return the chunk of a dataset; memory holds the dataset unless `read` returns it again."""
        return cls(dataset.sizes["time"], _pairs(dataset), read or (lambda: dataset))

    @classmethod
    def of_file(cls, path: Path, end: float) -> Self:
        """Return the chunk of a saved history up to the time `end`, s."""

        @interrupts_wait()
        def read() -> xr.Dataset:
            stored = xr.open_dataset(path, engine="h5netcdf", cache=False)
            times = np.count_nonzero(stored.time.values <= end + 1e-9 * max(1.0, end))
            return stored.isel(time=slice(int(times)))

        return cls.of(read(), read)


def contact_coordinates(pairs: np.ndarray) -> dict[str, tuple[str, np.ndarray]]:
    """Return the coordinates of contacts from their shoe, unit and finger (contacts, 3)."""
    return {name: ("contact", column) for name, column in zip(CONTACT_KEYS, pairs.T, strict=True)}


def _pairs(dataset: xr.Dataset) -> np.ndarray:
    return np.column_stack([dataset[name].values for name in CONTACT_KEYS])


def save_joined(
    case: Case, chunks: Sequence[Chunk], path: Path, overwrite: bool = False, end: xr.Dataset | None = None
) -> Path:
    """Write the history of a case from its chunks, a part at a time; raise as `whole_file`.

    `end` holds the cells of the ground at the history's end; they replace those of the chunks.
    """
    # ASCII, so that the text has a checksum
    text = json.dumps(case.model_dump(mode="json"))
    filled = [chunk for chunk in chunks if chunk.times]
    pairs = np.unique(np.concatenate([chunk.pairs for chunk in filled]), axis=0)

    def whole(part: xr.Dataset) -> xr.Dataset:
        if end is not None:
            part = part.drop_dims(("cell", "ground_time"), errors="ignore").assign(end)
        return packed(_with_contacts(part, pairs)).assign_attrs({CASE: text})

    parts = (whole(part) for chunk in filled for part in files.blocks(chunk.read()))
    return files.write_netcdf_along("time", sum(chunk.times for chunk in filled), parts, path, overwrite)


def _with_contacts(dataset: xr.Dataset, pairs: np.ndarray) -> xr.Dataset:
    """Return a dataset with a contact for each of the sorted pairs (contacts, 3), which include its own."""
    met = _pairs(dataset)
    if np.array_equal(met, pairs):
        return dataset
    column = {tuple(pair): k for k, pair in enumerate(pairs.tolist())}
    columns = np.array([column[tuple(pair)] for pair in met.tolist()], dtype=int)
    wider = dataset.assign_coords(contact=columns).reindex(contact=np.arange(len(pairs)), fill_value=0.0)
    return wider.drop_vars("contact").assign_coords(contact_coordinates(pairs))
