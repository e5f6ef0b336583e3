"""What all rollers together press on every shoe with, from a history's variables."""

import numpy as np
import xarray as xr

from exudyn_crawler.results.history.quantities import variable


def rail_force(dataset: xr.Dataset) -> xr.DataArray:
    """Sum of the rollers' forces on both rails of every shoe.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a history of a rolled track, or a part of it.

    Returns
    -------
    xarray.DataArray
        Dimensions (time, shoe, axis), N, global.
    """
    summed = dataset.tread_force.sum(("rail", "strip"))
    force = summed.transpose("time", "roller", "neighbour", "axis").values
    # a tread presses on the shoe behind its roller's axis and on the one ahead of that
    place = dataset.roller_shoe.transpose("time", "roller").values[..., None] - 1 + np.arange(force.shape[2])
    total = np.zeros((len(force), dataset.sizes["shoe"], 3))
    row = np.arange(len(force))[:, None, None]
    # ahead of the last shoe is none, and no force
    np.add.at(total, (row, np.minimum(place, total.shape[1] - 1)), force)
    dims, values, attributes = variable("rail_force", total)
    return xr.DataArray(values, {name: dataset[name] for name in dims}, dims, attrs=attributes)
