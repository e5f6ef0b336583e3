"""Catalogue of quantities: name, meaning, file and needs of every result, and functions that derive results.

`quantities` has a row for each stored or derived quantity. A new quantity needs a row there, and a variable
of `states` or a function in `DERIVED`. Such a function takes the case, the dataset of a history or a part of
it, and a dataset that begins as the history. It returns values with the quantity's dimensions.
"""

from collections.abc import Callable, Iterable

import numpy as np
import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.files import blocks
from exudyn_crawler.results.history.quantities import QUANTITIES, Quantity

Variable = tuple[tuple[str, ...], np.ndarray, dict[str, str]]
"""Variable as xarray takes it: dimensions, values and attributes."""

CONTACT_KEYS = ("contact_shoe", "contact_unit", "contact_finger")
"""Coordinates of contacts: numbers of shoe, unit and finger; finger 0 is a whole underside."""
LINKS = (
    "link of shoes i and i + 1",
    "link of shoes i and i + 1, the last one of the last shoe and the first",
    "link of shoes i and i + 1, the last one of each of two tracks of its last shoe and its first",
)
"""Long name of the dimension of links, by the number of closed tracks."""
TRACK = "track"
"""Dimension after time of quantities that each of two tracks has; with one track it is absent."""
GEAR = "the case has another gear.kind"
NEEDS: dict[str, tuple[Callable[[Case], bool], str]] = {
    "flexible": (lambda case: case.flexible is not None, "flexible shoes, the case has none"),
    "rolled": (lambda case: "rolled" in case.gear.quantities, f"a side frame on an open track, {GEAR}"),
    "dragged": (lambda case: "dragged" in case.gear.quantities, f"a dragged front shoe, {GEAR}"),
    "frame": (lambda case: "frame" in case.gear.quantities, f"a side frame, {GEAR}"),
    "closed": (lambda case: "closed" in case.gear.quantities, f"a closed track, {GEAR}"),
    "units": (lambda case: case.terrain.model == "units", "a terrain of units, the case has one of cells"),
    "cells": (lambda case: case.terrain.model == "cells", "a terrain of cells, the case has one of units"),
    # the run decides, and a case knows nothing of it
    "chosen": (lambda _case: True, "outputs.ground_times, the run had none"),
}
"""Needs of quantities by word: a test of the case, and the reason to show when it fails.

Any other word is the path of a value that the case must have, such as that of an optional part.
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
"""Units for reading and the factors to them, by the unit of the catalogue; other units stay."""
OF_GROUND = {"ground_pressure": ("kPa", 1e-3), "mean_ground_pressure": ("kPa", 1e-3)}
"""Units for reading and the factors to them, by the name of the quantity."""
LOADED = 0.1
"""Least force on a loaded shoe, fraction of that on the most loaded one. Chosen between the shoes that the
chain lifts at the ends of a track (4100C at rest on a hard floor: 2 and 9.5 %) and all others (18 % and
more)."""


def lacking(quantity: Quantity, case: Case) -> str:
    """Return the needs of a quantity that a case does not meet, as text; empty if it meets all."""
    return " and ".join(filter(None, (_lacking(need, case) for need in quantity.needs)))


def _lacking(need: str, case: Case) -> str:
    """Return the text of one need that a case does not meet; empty if the case meets it."""
    if need in NEEDS:
        has, why = NEEDS[need]
        return "" if has(case) else why
    value: object = case
    for name in need.split("."):
        value = getattr(value, name, None)
    return "" if value else f"{need}, which the case does not have"


def select(**columns: str | bool | tuple[str, ...]) -> dict[str, Quantity]:
    """Return the quantities whose columns equal or contain the given values, in the order of the table.

    An example is ``select(per="pair", files="history")``. True selects columns with a value, False those
    without.
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
    """Return a variable with the dimensions of its quantity, except those in `without`.

    If values have one more axis, their second axis is that of two tracks.
    """
    quantity = QUANTITIES[name]
    dims = [dim for dim in quantity.dimensions if dim not in without]
    if np.ndim(values) > len(dims):
        dims.insert(1, TRACK)
    return tuple(dims), values, quantity.attributes


def link_name(links: xr.DataArray, link: int) -> str:
    """Return the name of a link of a coordinate, by the two shoes that it joins."""
    loops = LINKS.index(links.attrs.get("long_name", LINKS[0]))
    count = int(links.max()) // loops if loops else link + 1
    return f"link {link}-{link + 1 if link % count else link + 1 - count}"


def check_dimensions(dataset: xr.Dataset) -> None:
    """Raise ValueError if a variable of a dataset does not have the dimensions of its quantity."""
    for name, array in dataset.data_vars.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and {*array.dims} - {TRACK} != {*quantity.dimensions}:
            raise ValueError(f"{name} has dimensions {array.dims}, not {quantity.dimensions}")


def rotation_matrices(angles: np.ndarray) -> np.ndarray:
    """Return the rotation matrices of `ground.rotations`, imported late since its compilation takes time."""
    from exudyn_crawler.ground import rotations

    return rotations.rotation_matrices(angles)


def axes(_case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Return the rotation matrices of the shoes, (time, shoe, axis, body_axis); columns are the body axes."""
    angles = dataset.angles.transpose("time", "shoe", "axis")
    names = {name: dataset[name].values for name in angles.dims} | {"body_axis": dataset.axis.values}
    return xr.DataArray(rotation_matrices(angles.values), names, list(names))


def terrain_deformation(case: Case, dataset: xr.Dataset, begin: xr.Dataset) -> xr.DataArray:
    """Return the sum of the springs' upward deformations since the start, (time,), m; tilts cancel out."""
    # in blocks: the motion of all units may not fit into memory
    parts = [part.unit_heave.sum("unit") for part in blocks(dataset[["unit_heave"]])]
    springs = case.part(Terrain).springs_per_unit
    return springs * xr.concat(parts, "time") - springs * begin.unit_heave.isel(time=0).sum("unit")


def rail_force(_case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Return the sum of the rollers' forces on both rails of every shoe, (time, shoe, axis), N, global."""
    summed = dataset.tread_force.sum(("rail", "strip"))
    force = summed.transpose("time", "roller", "neighbour", "axis").values
    # a tread presses on the shoe behind its roller's axis and on the one ahead of that
    shoe = dataset.roller_shoe.transpose("time", "roller").values[..., None] - 1 + np.arange(force.shape[2])
    total = np.zeros((len(force), dataset.sizes["shoe"], 3))
    row = np.arange(len(force))[:, None, None]
    # no shoe is ahead of the last one, and the force there is zero
    np.add.at(total, (row, np.minimum(shoe, total.shape[1] - 1)), force)
    dims = QUANTITIES["rail_force"].dimensions
    return xr.DataArray(total, {name: dataset[name] for name in dims}, dims)


def link_tension(_case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Return the force of every link without its component along the rear shoe's pins, (time, joint), N."""
    force = dataset.joint_force.transpose("time", "joint", "axis").values
    angles = dataset.angles.transpose("time", "shoe", "axis").values[:, : force.shape[1]]
    across = rotation_matrices(angles)[..., 1]
    along = force - np.sum(force * across, axis=-1, keepdims=True) * across
    dims = QUANTITIES["link_tension"].dimensions
    return xr.DataArray(np.linalg.norm(along, axis=-1), {name: dataset[name] for name in dims}, dims)


def ground_pressure(case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Return the normal force on every shoe over the area of its underside, (time, shoe), Pa."""
    force = dataset.normal_force.transpose("contact", "time", "axis").values
    on_shoes = np.zeros((dataset.sizes["shoe"], *force.shape[1:]))
    row = {shoe: k for k, shoe in enumerate(dataset.shoe.values.tolist())}
    np.add.at(on_shoes, [row[shoe] for shoe in dataset.contact_shoe.values.tolist()], force)
    dims = QUANTITIES["ground_pressure"].dimensions
    pressure = np.linalg.norm(on_shoes, axis=-1).T / case.shoe.ground_area
    return xr.DataArray(pressure, {name: dataset[name] for name in dims}, dims)


def loaded_shoes(load: xr.DataArray) -> xr.DataArray:
    """Return True for shoes that are loaded, by the forces or pressures on all shoes of each time."""
    return (load > 0.0) & (load >= LOADED * load.max("shoe"))


def mean_ground_pressure(case: Case, dataset: xr.Dataset, begin: xr.Dataset) -> xr.DataArray:
    """Return the mean ground pressure below the loaded shoes, (time,), Pa."""
    pressure = ground_pressure(case, dataset, begin)
    is_loaded = loaded_shoes(pressure)
    # no shoe of a track in the air is loaded
    return pressure.where(is_loaded, 0.0).sum("shoe") / np.maximum(is_loaded.sum("shoe"), 1)


def pretension(case: Case, dataset: xr.Dataset, _begin: xr.Dataset) -> xr.DataArray:
    """Return half of each chain's push on its idler, backward along the side frame, N.

    The array is (time,) for one track, (time, track) for two.
    """
    ahead = rotation_matrices(dataset.side_frame_angles.transpose("time", "axis").values)[..., 0]
    idlers = [label.words for label in case.gear.wheel_labels if label.kind == "idler"]
    force = dataset.wheel_force.sel(wheel=idlers).transpose("time", "wheel", "axis").values
    pull = -0.5 * np.einsum("twi,ti->tw", force, ahead)
    if case.gear.tracks == 1:
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
"""Function that computes each derived quantity of the catalogue."""


def with_meaning(name: str, values: xr.DataArray) -> xr.DataArray:
    """Return values with the name, unit and meaning of their quantity."""
    return values.rename(name).assign_attrs(QUANTITIES[name].attributes)


def by_shoe(case: Case, dataset: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Return quantities of contacts by shoe, by the catalogue's rule; see `History.contacts_by_shoe`."""
    wanted = list(names)
    derived = [name for name in wanted if QUANTITIES[name].derived_from]
    stored = dict.fromkeys([source for name in wanted for source in QUANTITIES[name].derived_from or (name,)])
    shoes = dataset.shoe.values
    contacts = [_slice_of(np.flatnonzero(dataset.contact_shoe.values == shoe)) for shoe in shoes]
    depth = dataset.penetration.transpose("time", "contact").values
    # shoes that never touch the ground, such as those of an upper run, have no contact to choose
    deepest = [depth[:, chosen].argmax(axis=1) if depth[:, chosen].size else None for chosen in contacts]

    columns = {}
    for name in stored:
        # a history that stays in its file reads a variable once, not once a shoe
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
    """Return ascending numbers, as a slice if they have no gaps: indexing by a slice makes no copy."""
    if len(numbers) and numbers[-1] - numbers[0] == len(numbers) - 1:
        return slice(int(numbers[0]), int(numbers[-1]) + 1)
    return numbers


BY_SHOE = tuple(select(by_shoe=True))  # quantities of contacts that can be taken by shoe


def reading_unit(name: str, unit: str) -> tuple[str, float]:
    """Return the unit for reading a quantity, and the factor to it."""
    return OF_GROUND.get(name) or READ_IN.get(unit, (unit, 1.0))


def for_reading(values: xr.DataArray) -> xr.DataArray:
    """Return the values of a quantity in the unit for reading, with this unit among their attributes."""
    unit = values.attrs.get("units", "")
    drawn, factor = reading_unit(str(values.name), unit)
    return values if drawn == unit else (factor * values).assign_attrs(values.attrs | {"units": drawn})
