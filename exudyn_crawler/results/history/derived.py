"""Quantities that derive from a history's variables: a function each, named as its row in the catalogue.

Each takes the case and the dataset of a history, or a part of it along time, and gives values with the
quantity's dimensions; `history.History.quantity` adds unit and meaning.
"""

from collections.abc import Callable, Iterable

import numpy as np
import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.catalogue import QUANTITIES, select
from exudyn_crawler.results.history.files import blocks


def displacement(_case: Case, dataset: xr.Dataset) -> xr.DataArray:
    """Motion of the COMs from where they were at first: dimensions (time, shoe, axis), m."""
    return dataset.position - dataset.position.isel(time=0)


def axes(_case: Case, dataset: xr.Dataset) -> xr.DataArray:
    """Rotation matrices of the shoes: dimensions (time, shoe, axis, body_axis).

    ``axes.sel(body_axis="y")`` is the global direction of the shoes' y axis.
    """
    angles = dataset.angles.transpose("time", "shoe", "axis")
    names = {name: dataset[name].values for name in ("time", "shoe", "axis")}
    return xr.DataArray(
        rotation_matrices(angles.values),
        coords=names | {"body_axis": names["axis"]},
        dims=QUANTITIES["axes"].dimensions,
    )


def contact_force(_case: Case, dataset: xr.Dataset) -> xr.DataArray:
    """Normal and friction force on the shoe of every contact: dimensions (time, contact, axis), N."""
    return dataset.normal_force + dataset.friction_force


def terrain_deformation(case: Case, dataset: xr.Dataset) -> xr.DataArray:
    """Sum of all spring deformations from what they were at first, positive upward: dimension time, m.

    Every spring of a unit deforms by the heave and, with opposite signs, by the tilt.
    """
    # of a history that does not fit into memory, the motion of all units does not either
    parts = [part.unit_heave.sum("unit") for part in blocks(dataset[["unit_heave"]])]
    total = case.terrain.springs_per_unit * xr.concat(parts, "time")
    return total - total.isel(time=0)


def side_frame_way(_case: Case, dataset: xr.Dataset) -> xr.DataArray:
    """Motion of the side frame from where it was at first: dimensions (time, axis), m."""
    return dataset.side_frame_position - dataset.side_frame_position.isel(time=0)


def rail_force(_case: Case, dataset: xr.Dataset) -> xr.DataArray:
    """Sum of the rollers' forces on both rails of every shoe: dimensions (time, shoe, axis), N, global."""
    summed = dataset.tread_force.sum(("rail", "strip"))
    force = summed.transpose("time", "roller", "neighbour", "axis").values
    # a tread presses on the shoe behind its roller's axis and on the one ahead of that
    shoe = dataset.roller_shoe.transpose("time", "roller").values[..., None] - 1 + np.arange(force.shape[2])
    total = np.zeros((len(force), dataset.sizes["shoe"], 3))
    row = np.arange(len(force))[:, None, None]
    # ahead of the last shoe is none, and no force
    np.add.at(total, (row, np.minimum(shoe, total.shape[1] - 1)), force)
    dims = QUANTITIES["rail_force"].dimensions
    return xr.DataArray(total, {name: dataset[name] for name in dims}, dims)


DERIVED: dict[str, Callable[[Case, xr.Dataset], xr.DataArray]] = {
    function.__name__: function
    for function in (
        displacement,
        axes,
        contact_force,
        terrain_deformation,
        side_frame_way,
        rail_force,
    )
}
"""What computes each derived quantity of the catalogue."""


def with_meaning(name: str, values: xr.DataArray) -> xr.DataArray:
    """Values with name, unit and meaning of their quantity."""
    return values.rename(name).assign_attrs(QUANTITIES[name].attributes)


def by_shoe(case: Case, dataset: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Quantities of contacts by shoe, over all units that each stands on.

    Forces and torques are summed over the shoe's contacts. Penetration, its rate and the slip velocity are
    those of the contact that penetrates deepest at the time.

    Parameters
    ----------
    names : iterable of str
        Quantities that the catalogue says how to take by shoe.
    """
    wanted = list(names)
    derived = [name for name in wanted if QUANTITIES[name].is_derived]
    stored = dict.fromkeys([one for name in wanted for one in QUANTITIES[name].derived_from or (name,)])
    shoes, of_shoe = dataset.shoe.values, dataset.contact_shoe.values
    contacts = [np.flatnonzero(of_shoe == shoe) for shoe in shoes]
    depth = dataset.penetration.compute()
    deepest = [depth.isel(contact=chosen).argmax("contact") for chosen in contacts]
    columns = {}
    for name in stored:
        # of a history that stays in its file a variable is read once, not once a shoe
        whole = dataset[name].compute()
        parts = [whole.isel(contact=chosen) for chosen in contacts]
        if QUANTITIES[name].by_shoe == "sum":
            parts = [part.sum("contact", keep_attrs=True) for part in parts]
        else:
            parts = [part.isel(contact=one) for part, one in zip(parts, deepest, strict=True)]
        columns[name] = xr.concat(parts, dim="shoe", coords="minimal", compat="override")
    result = xr.Dataset(columns).assign_coords(shoe=shoes)
    result = result.drop_vars(["contact_shoe", "contact_unit"], errors="ignore")
    result = result.assign({name: with_meaning(name, DERIVED[name](case, result)) for name in derived})
    return result[wanted]


BY_SHOE = tuple(select(by_shoe=True))
"""Quantities of contacts that can be taken by shoe."""
