"""Quantities that derive from a history's variables."""

import numpy as np
import xarray as xr

from exudyn_crawler.results.history.catalogue import QUANTITIES, variable
from exudyn_crawler.results.history.files import blocks
from exudyn_crawler.results.history.history import History

PER_CONTACT = ("normal_force", "friction_force", "friction_torque")
LEADING = ("penetration", "penetration_rate", "slip_velocity")


def contact_force(history: History) -> xr.DataArray:
    """Normal and friction force on the shoe of every contact: dimensions (time, contact, axis), N."""
    force = history.normal_force + history.friction_force
    return force.assign_attrs(QUANTITIES["contact_force"].attributes)


def pair(history: History, shoe: int, unit: int) -> int:
    """Index along the contact dimension of a pair of a shoe and a unit (numbers from 1).

    Raises
    ------
    ValueError
        If the two never met.
    """
    met = (history.contact_shoe == shoe) & (history.contact_unit == unit)
    found = np.flatnonzero(met.values)
    if not len(found):
        units = history.contact_unit.values[history.contact_shoe.values == shoe].tolist()
        raise ValueError(f"shoe {shoe} never met unit {unit}; it met units {units}")
    return int(found[0])


def contacts_by_shoe(history: History) -> xr.Dataset:
    """Contact of every shoe, over all units it stands on.

    Forces and torques are summed over the shoe's contacts. Penetration, its rate and the slip velocity
    are those of the contact that penetrates deepest at the time.

    Returns
    -------
    xarray.Dataset
        Dimensions time, shoe, axis: normal_force, friction_force, contact_force (N), friction_torque
        (N m), penetration (m), penetration_rate and slip_velocity (m/s).
    """
    return contacts_of(history.dataset)


def contacts_of(dataset: xr.Dataset) -> xr.Dataset:
    """Same from a history's variables alone."""
    shoes, of_shoe = dataset.shoe.values, dataset.contact_shoe.values
    own = [np.flatnonzero(of_shoe == shoe) for shoe in shoes]
    depth = dataset.penetration.compute()
    deepest = [depth.isel(contact=chosen).argmax("contact") for chosen in own]
    found: dict[str, list[xr.DataArray]] = {}
    for name in (*PER_CONTACT, *LEADING):
        # of a history that stays in its file a variable is read once, not once a shoe
        whole = dataset[name].compute()
        parts = [whole.isel(contact=chosen) for chosen in own]
        if name in PER_CONTACT:
            found[name] = [part.sum("contact", keep_attrs=True) for part in parts]
        else:
            found[name] = [part.isel(contact=one) for part, one in zip(parts, deepest, strict=True)]
    result = xr.Dataset(
        {
            name: xr.concat(values, dim="shoe", coords="minimal", compat="override")
            for name, values in found.items()
        }
    ).assign_coords(shoe=shoes)
    result = result.drop_vars(["contact_shoe", "contact_unit"], errors="ignore")
    force = result.normal_force + result.friction_force
    return result.assign(contact_force=force.assign_attrs(QUANTITIES["contact_force"].attributes))


def terrain_deformation(history: History) -> xr.DataArray:
    """Sum of all spring deformations relative to equilibrium, positive upward: dimension time, m.

    Every spring of a unit deforms by the heave and, with opposite signs, by the tilt.
    """
    springs = history.case.terrain.springs_per_unit
    # of a history that does not fit into memory, the motion of all units does not either
    parts = [part.unit_heave.sum("unit") for part in blocks(history.dataset[["unit_heave"]])]
    total = springs * xr.concat(parts, "time")
    change = total - total.isel(time=0)
    return change.assign_attrs(QUANTITIES["terrain_deformation"].attributes)


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
