"""Histories as files hold them: units' motion by the terrain's coordinates, contacts in single precision.

The units of a terrain in independent coordinates, hundreds of them, move by a few coordinates; a file holds
these and their shapes, and what reads it has the units' motion with the same bits as the run. Contacts are
rounded to 6e-8 of their values, far below what the solver leaves out of balance.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from exudyn_crawler.results.history.quantities import QUANTITIES, Variable, variable

CONTACT_TYPE = np.dtype("f4")
"""Of the contacts in files; in memory their values are these in double precision."""
RATES = ("", "_rate", "_acceleration")
TERRAIN = "terrain_motion"
SHAPES = {"unit_heave": "heave_shape", "unit_tilt": "tilt_shape"}
"""Shapes of the terrain's coordinates, by what they give."""
TERRAIN_COORDINATES = (*SHAPES.values(), *(f"{TERRAIN}{rate}" for rate in RATES))
"""Coordinates of a history's dataset: what the units' motion is made of."""


def unit_motion(shape: NDArray, coordinates: NDArray) -> NDArray:
    """Motion (times, units) by a shape (units, modes) and coordinates (times, modes).

    Each number is the same whatever else is asked for, which a product of matrices does not promise.
    """
    return np.einsum("uk,tk->tu", shape, coordinates)


def motion_variables(heave: NDArray, tilt: NDArray, coordinates: dict[str, NDArray]) -> dict[str, Variable]:
    """Motion of the units of a terrain in independent coordinates.

    Parameters
    ----------
    heave, tilt : array (units, modes)
        m and rad for a unit of each coordinate.
    coordinates : dict
        Coordinates (times, modes) by rate, as of `RATES`.

    Returns
    -------
    dict
        Variables of a history by name, `TERRAIN_COORDINATES` among them.
    """
    shapes = dict(zip(SHAPES.values(), (heave, tilt), strict=True))
    found = shapes | {f"{TERRAIN}{rate}": values for rate, values in coordinates.items()}
    for rate, values in coordinates.items():
        found |= {f"{name}{rate}": unit_motion(shapes[shape], values) for name, shape in SHAPES.items()}
    return {name: variable(name, values) for name, values in found.items()}


def packed(dataset: xr.Dataset) -> xr.Dataset:
    """Dataset of a history as a file holds it."""
    if TERRAIN in dataset.variables:
        dataset = dataset.drop_vars([f"{name}{rate}" for name in SHAPES for rate in RATES])
    return dataset.assign({name: dataset[name].astype(CONTACT_TYPE) for name in _of_contacts(dataset)})


def unpacked(dataset: xr.Dataset, widened: bool = False) -> xr.Dataset:
    """Dataset of a history from that of a file; what a file does not hold is computed when it is asked for.

    Contacts may be `widened` at once. Units are hundreds, of which few are looked at: their motion never is.
    Files of earlier versions hold all of it.
    """
    found: dict[str, xr.Variable] = {}
    for name in _of_contacts(dataset):
        kept = dataset.variables[name]
        if kept.dtype != np.float64:
            wide = _lazy(QUANTITIES[name].dimensions, kept.shape, partial(_widened, kept), kept.attrs)
            found[name] = wide.load() if widened else wide
    if TERRAIN in dataset.variables:
        dataset = dataset.set_coords(list(TERRAIN_COORDINATES))
        for rate in RATES:
            for name, shape in SHAPES.items():
                found[f"{name}{rate}"] = _units(dataset, f"{name}{rate}", shape, f"{TERRAIN}{rate}")
    return dataset.assign(found)


def _of_contacts(dataset: xr.Dataset) -> list[str]:
    return [str(name) for name, one in dataset.data_vars.items() if "contact" in one.dims]


def _units(dataset: xr.Dataset, name: str, shape: str, coordinates: str) -> xr.Variable:
    shapes, motion = dataset.variables[shape].values, dataset.variables[coordinates]
    sizes = (motion.shape[0], len(shapes))
    part = partial(_part_of_motion, shapes, motion)
    return _lazy(QUANTITIES[name].dimensions, sizes, part, QUANTITIES[name].attributes)


def _part_of_motion(shapes: NDArray, motion: xr.Variable, key: tuple) -> NDArray:
    times, units = key
    return unit_motion(shapes[units], motion[times].values)


def _widened(kept: xr.Variable, key: tuple) -> NDArray:
    return kept[key].values.astype(float)


def _lazy(
    dimensions: tuple[str, ...], shape: tuple[int, ...], part: Callable[[tuple], NDArray], attributes: dict
) -> xr.Variable:
    array = indexing.LazilyIndexedArray(_Computed(shape, part))
    return xr.Variable(dimensions, array, attributes)


class _Computed(BackendArray):
    """Array whose parts are computed: `part` takes a slice or numbers (n,) for each dimension."""

    def __init__(self, shape: tuple[int, ...], part: Callable[[tuple], NDArray]) -> None:
        self.shape, self.dtype, self._part = shape, np.dtype(float), part

    def __getitem__(self, key: indexing.ExplicitIndexer) -> NDArray:
        outer = indexing.IndexingSupport.OUTER
        return indexing.explicit_indexing_adapter(key, self.shape, outer, self._outer)

    def _outer(self, key: tuple) -> NDArray:
        """Part at a key whose single numbers drop their dimensions."""
        single = tuple(k for k, one in enumerate(key) if isinstance(one, int | np.integer))
        wide = tuple(slice(int(one), int(one) + 1) if k in single else one for k, one in enumerate(key))
        return self._part(wide).squeeze(single)
