"""Catalogue of quantities: what results are called and measure, where they are and what they need.

`quantities` holds them, a row each, stored and derived ones alike. A new quantity is a row there and what
computes it: a variable of `states`, or a function in `DERIVED`. That takes the case, the dataset of a history
or of a part of it, and one that begins as the history does; it gives values with the quantity's dimensions.
"""

from collections.abc import Callable, Iterable

import numpy as np
import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.files import blocks
from exudyn_crawler.results.history.quantities import QUANTITIES, Quantity

Variable = tuple[tuple[str, ...], np.ndarray, dict[str, str]]
"""Dimensions, values and attributes, as xarray takes a variable."""

CONTACT_KEYS = ("contact_shoe", "contact_unit", "contact_finger")
"""Coordinates along the contacts: numbers of shoe and unit, and of a finger, 0 for a whole underside."""
LINKS = (
    "link of shoes i and i + 1",
    "link of shoes i and i + 1, the last one of the last shoe and the first",
    "link of shoes i and i + 1, the last one of each of two tracks of its last shoe and its first",
)
"""What the dimension of the links says of itself, by the number of closed tracks."""
TRACK = "track"
"""Dimension after time of what a machine on two tracks has twice, and a case of one track once."""
GEAR = "the case has another gear.kind"
NEEDS: dict[str, tuple[Callable[[Case], bool], str]] = {
    "flexible": (lambda case: case.flexible is not None, "flexible shoes, the case has none"),
    "rolled": (lambda case: "rolled" in case.gear.quantities, f"a side frame on an open track, {GEAR}"),
    "dragged": (lambda case: "dragged" in case.gear.quantities, f"a dragged front shoe, {GEAR}"),
    "frame": (lambda case: "frame" in case.gear.quantities, f"a side frame, {GEAR}"),
    "closed": (lambda case: "closed" in case.gear.quantities, f"a closed track, {GEAR}"),
    "units": (lambda case: case.terrain.model == "units", "a terrain of units, the case has one of cells"),
    "cells": (lambda case: case.terrain.model == "cells", "a terrain of cells, the case has one of units"),
    # by the run, of which a case says nothing
    "chosen": (lambda _case: True, "outputs.ground_times, the run had none"),
}
"""What a quantity may need: whether a case has it, and why one does not do.

Other words are paths of values that a case must have, such as those of an optional part.
"""
READ_IN = {
    "N": ("kN", 1e-3),
    "N m": ("kN m", 1e-3),
    "Pa": ("MPa", 1e-6),
    "m/s2": ("m/s²", 1.0),
    "rad": ("deg", float(np.degrees(1.0))),
    "rad/s": ("deg/s", float(np.degrees(1.0))),
    "rad/s2": ("deg/s²", float(np.degrees(1.0))),
}
"""Units in which quantities are read, and factors to them, by those of the catalogue; others stay."""
OF_GROUND = {"ground_pressure": ("kPa", 1e-3), "mean_ground_pressure": ("kPa", 1e-3)}
"""Same of quantities, by their names."""
LOADED = 0.1  # of the force on the most loaded shoe, from which on another one counts as loaded


def lacking(quantity: Quantity, case: Case) -> str:
    """Return what a quantity needs and a case does not have; empty if it needs nothing more."""
    return " and ".join(filter(None, (_lacking(need, case) for need in quantity.needs)))


def _lacking(need: str, case: Case) -> str:
    """Say what a word of a quantity's needs asks for and a case does not have; empty if it has it."""
    if need in NEEDS:
        has, why = NEEDS[need]
        return "" if has(case) else why
    value: object = case
    for name in need.split("."):
        value = getattr(value, name, None)
    return "" if value else f"{need}, which the case does not have"


def select(**columns: str | bool | tuple[str, ...]) -> dict[str, Quantity]:
    """Return quantities, in their order, whose columns are equal to, or contain, the values given.

    ``select(per="pair", files="history")``; True and False ask whether a column has a value.
    """

    def fits(value: object, wanted: str | bool | tuple[str, ...]) -> bool:
        if isinstance(wanted, bool):
            return bool(value) is wanted
        return wanted == value or (isinstance(value, tuple) and wanted in value)

    return {
        name: quantity
        for name, quantity in QUANTITIES.items()
        if all(fits(getattr(quantity, column), wanted) for column, wanted in columns.items())
    }


def variable(name: str, values: np.ndarray, without: tuple[str, ...] = ()) -> Variable:
    """Variable of a dataset with its quantity's dimensions, but for those it goes `without`.

    Values with one more axis, their second, are of two tracks.
    """
    quantity = QUANTITIES[name]
    dims = [dim for dim in quantity.dimensions if dim not in without]
    if np.ndim(values) > len(dims):
        dims.insert(1, TRACK)
    return tuple(dims), values, quantity.attributes


def link_name(links: xr.DataArray, link: int) -> str:
    """Name of one of the links of a coordinate, by the shoes that it joins."""
    loops = LINKS.index(links.attrs.get("long_name", LINKS[0]))
    count = int(links.max()) // loops if loops else link + 1
    return f"link {link}-{link + 1 if link % count else link + 1 - count}"


def check_dimensions(dataset: xr.Dataset) -> None:
    """Refuse a dataset of which a variable does not have its quantity's dimensions, by a ValueError."""
    for name, array in dataset.data_vars.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and {*array.dims} - {TRACK} != {*quantity.dimensions}:
            raise ValueError(f"{name} has dimensions {array.dims}, not {quantity.dimensions}")


def rotation_matrices(angles: np.ndarray) -> np.ndarray:
    """As of `ground.rotations`, for which who asks for names alone does not wait until it is compiled."""
    from exudyn_crawler.ground import rotations

    return rotations.rotation_matrices(angles)


def axes(_case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Rotation matrices of the shoes: (time, shoe, axis, body_axis), for each body axis its direction."""
    angles = dataset.angles.transpose("time", "shoe", "axis")
    names = {name: dataset[name].values for name in angles.dims} | {"body_axis": dataset.axis.values}
    return xr.DataArray(rotation_matrices(angles.values), names, list(names))


def terrain_deformation(case: Case, dataset: xr.Dataset, begin: xr.Dataset) -> xr.DataArray:
    """Sum of the springs' deformations since the start, upward, (time,), m; those by tilts cancel out."""
    # of a history that does not fit into memory, the motion of all units does not either
    parts = [part.unit_heave.sum("unit") for part in blocks(dataset[["unit_heave"]])]
    springs = case.unit_terrain().springs_per_unit
    return springs * xr.concat(parts, "time") - springs * begin.unit_heave.isel(time=0).sum("unit")


def rail_force(_case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
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


def link_tension(_case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Force of every link without its part along the rear shoe's pins: (time, joint), N."""
    force = dataset.joint_force.transpose("time", "joint", "axis").values
    angles = dataset.angles.transpose("time", "shoe", "axis").values[:, : force.shape[1]]
    across = rotation_matrices(angles)[..., 1]
    along = force - np.sum(force * across, axis=-1, keepdims=True) * across
    dims = QUANTITIES["link_tension"].dimensions
    return xr.DataArray(np.linalg.norm(along, axis=-1), {name: dataset[name] for name in dims}, dims)


def ground_pressure(case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Normal force on every shoe over the area of its underside: (time, shoe), Pa."""
    force = dataset.normal_force.transpose("contact", "time", "axis").values
    on_shoes = np.zeros((dataset.sizes["shoe"], *force.shape[1:]))
    row = {shoe: k for k, shoe in enumerate(dataset.shoe.values.tolist())}
    np.add.at(on_shoes, [row[shoe] for shoe in dataset.contact_shoe.values.tolist()], force)
    dims = QUANTITIES["ground_pressure"].dimensions
    pressure = np.linalg.norm(on_shoes, axis=-1).T / case.shoe.ground_area
    return xr.DataArray(pressure, {name: dataset[name] for name in dims}, dims)


def mean_ground_pressure(case: Case, dataset: xr.Dataset, begin: xr.Dataset) -> xr.DataArray:
    """Mean ground pressure below the loaded shoes: (time,), Pa."""
    pressure = ground_pressure(case, dataset, begin)
    is_loaded = (pressure > 0.0) & (pressure >= LOADED * pressure.max("shoe"))
    # of a track that is in the air no shoe is loaded
    return pressure.where(is_loaded, 0.0).sum("shoe") / np.maximum(is_loaded.sum("shoe"), 1)


def pretension(case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Half of the push of every chain on its idler, backwards along the side frame: (time,), N.

    Of two tracks (time, track).
    """
    ahead = rotation_matrices(dataset.side_frame_angles.transpose("time", "axis").values)[..., 0]
    idlers = [label.words for label in case.gear.wheel_labels if label.kind == "idler"]
    force = dataset.wheel_force.sel(wheel=idlers).transpose("time", "wheel", "axis").values
    pull = -0.5 * np.einsum("twi,ti->tw", force, ahead)
    if case.tracks == 1:
        return xr.DataArray(pull[:, 0], {"time": dataset.time}, ["time"])
    return xr.DataArray(pull, {"time": dataset.time, TRACK: dataset[TRACK]}, ["time", TRACK])


DERIVED: dict[str, Callable[[Case, xr.Dataset, xr.Dataset], xr.DataArray]] = {
    "displacement": lambda _, data, begin: data.position - begin.position.isel(time=0),
    "axes": axes,
    "contact_force": lambda _, data, _begin: data.normal_force + data.friction_force,
    "terrain_deformation": terrain_deformation,
    "side_frame_displacement": lambda _, data, begin: (
        data.side_frame_position - begin.side_frame_position.isel(time=0)
    ),
    "rail_force": rail_force,
    "link_tension": link_tension,
    "ground_pressure": ground_pressure,
    "mean_ground_pressure": mean_ground_pressure,
    "pretension": pretension,
}
"""What computes each derived quantity of the catalogue."""


def with_meaning(name: str, values: xr.DataArray) -> xr.DataArray:
    """Values with the name, unit and meaning of their quantity."""
    return values.rename(name).assign_attrs(QUANTITIES[name].attributes)


def by_shoe(case: Case, dataset: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Quantities of contacts by shoe as the catalogue says, and as in `History.contacts_by_shoe`."""
    wanted = list(names)
    derived = [name for name in wanted if QUANTITIES[name].derived_from]
    stored = dict.fromkeys([source for name in wanted for source in QUANTITIES[name].derived_from or (name,)])
    shoes = dataset.shoe.values
    contacts = [_slice_of(np.flatnonzero(dataset.contact_shoe.values == shoe)) for shoe in shoes]
    depth = dataset.penetration.transpose("time", "contact").values
    # shoes that never touch the ground, as those above in a closed track, have nothing to choose of
    deepest = [depth[:, chosen].argmax(axis=1) if depth[:, chosen].size else None for chosen in contacts]

    columns = {}
    for name in stored:
        # of a history that stays in its file a variable is read once, not once a shoe
        whole = dataset[name].compute().transpose("time", "contact", ...)
        coordinates = {key: of for key, of in whole.coords.items() if "contact" not in of.dims}
        parts = []
        for chosen, place in zip(contacts, deepest, strict=True):
            of_shoe = whole.values[:, chosen]
            if QUANTITIES[name].by_shoe == "sum" or place is None:
                parts.append(of_shoe.sum(axis=1))
            else:
                parts.append(of_shoe[np.arange(len(of_shoe)), place])
        dims = ["shoe", "time", *whole.dims[2:]]
        columns[name] = xr.DataArray(np.stack(parts), coordinates, dims, attrs=whole.attrs)
    result = xr.Dataset(columns).assign_coords(shoe=shoes)
    result = result.assign(
        {name: with_meaning(name, DERIVED[name](case, result, result)) for name in derived}
    )
    return result[wanted]


def _slice_of(numbers: np.ndarray) -> slice | np.ndarray:
    """Slice of ascending numbers where they are successive: what it takes of an array is no copy."""
    if len(numbers) and numbers[-1] - numbers[0] == len(numbers) - 1:
        return slice(int(numbers[0]), int(numbers[-1]) + 1)
    return numbers


BY_SHOE = tuple(select(by_shoe=True))  # quantities of contacts that can be taken by shoe


def reading_unit(name: str, unit: str) -> tuple[str, float]:
    """Unit in which a quantity is read, and the factor to it."""
    return OF_GROUND.get(name) or READ_IN.get(unit, (unit, 1.0))


def for_reading(values: xr.DataArray) -> xr.DataArray:
    """Values of a quantity in the unit for reading, which stands among their attributes."""
    unit = values.attrs.get("units", "")
    drawn, factor = reading_unit(str(values.name), unit)
    return values if drawn == unit else (factor * values).assign_attrs(values.attrs | {"units": drawn})
