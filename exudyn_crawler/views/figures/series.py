"""What a run offers to be drawn over time: quantities of shoes, links and track, in units for reading."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import xarray as xr

from exudyn_crawler.results.history.catalogue import QUANTITIES, Quantity, select
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.figures.curves import Panel
from exudyn_crawler.views.style import in_figure_unit

SHOES = (1, 4, 7, 10, 13)
"""Shoes that the papers draw."""
JOINTS = (1, 4, 7, 10, 12)
"""Links that the papers draw, by their rear shoe: those behind these shoes, and 12-13."""
GROUPS = ("stress", "motion", "contact", "rollers", "side frame", "links", "track")
"""Groups of curves, in the order in which they are offered."""
KINEMATICS = {name.replace("_", " "): one for name, one in select(curves="motion").items()}
"""Kinematic quantities that the papers draw."""
CONTACT_VECTORS = [one.label for one in select(curves="contact", curve_axes=False).values() if one.is_vector]
CONTACT_SCALARS = [one.label for one in select(curves="contact").values() if one.label not in CONTACT_VECTORS]
JOINT_VECTORS = [one.label for one in select(curves="links", per="link").values()]
"""Labels of forces and sinkage of shoes, and of forces of links."""
TERRAIN_DEFORMATION = QUANTITIES["terrain_deformation"].label
HIGHEST_STRESS = QUANTITIES["highest_von_mises"].label
ROLLER_FORCE, RAIL_FORCE = QUANTITIES["roller_force"].label, QUANTITIES["rail_force"].label
PULL = QUANTITIES["drive_pull"].label
FRAME_WAY = QUANTITIES["side_frame_way"].label
FRAME_ANGLE = QUANTITIES["side_frame_angles"].label
TURNS = {"x": "roll", "y": "pitch", "z": "yaw"}
"""Components of angles for reading."""


@dataclass(frozen=True)
class Series:
    """One quantity over time.

    Attributes
    ----------
    group, label, unit : str
    values : xarray.DataArray
        Dimensions (time, item, axis); items are named like "shoe 7" or "link 7-8", and without axes the one
        axis is named "".
    """

    group: str
    label: str
    unit: str
    values: xr.DataArray

    @property
    def count(self) -> int:
        """Number of curves."""
        return self.values.sizes["item"] * self.values.sizes["axis"]

    def panels(self, items: Sequence[str] | None = None) -> list[Panel]:
        """Panel for each axis, with a curve for each of some items, or of all."""
        return overlay({"": self}, self.values["item"].values.tolist() if items is None else items)

    def panels_by_item(self) -> list[Panel]:
        """Panel for each item of a quantity without axes."""
        curves = {str(one["item"].values): one.squeeze("axis") for one in self.values.transpose("item", ...)}
        return [Panel(item, self.unit, {item: values}) for item, values in curves.items()]

    def of_side(self, side: str) -> Self:
        """Those of the pins on one side, named after their links."""
        names = [str(item) for item in self.values["item"].values if str(item).endswith(f" {side}")]
        links = [item.removesuffix(f" {side}") for item in names]
        return replace(self, values=self.values.sel(item=names).assign_coords(item=links))


def history_series(history: History, stress: xr.Dataset | None = None) -> dict[str, Series]:
    """Everything over time that a history and its stresses offer to be drawn, by label."""
    rows = [one for group in GROUPS for one in select(curves=group).values() if history.has(one.name, stress)]
    values = history.over_time([one.name for one in rows], stress)
    found = [series for one in rows for series in _series(one, values[one.name])]
    return {series.label: series for series in found}


def motion_series(history: History, quantity: str) -> Series:
    """Kinematic quantity of all shoes, one of `KINEMATICS`."""
    (found,) = _series(KINEMATICS[quantity], history.quantity(KINEMATICS[quantity].name))
    return replace(found, label=quantity)


def overlay(found: Mapping[str, Series], items: Sequence[str]) -> list[Panel]:
    """Panel for each axis of one quantity of some runs by name, with a curve for each of some items.

    Curves are named after what differs, item or run or both.
    """
    first = next(iter(found.values()))
    several = len(items) > 1 or len(found) == 1, len(found) > 1
    names = {
        (item, run): ", ".join(name for name, differs in zip((item, run), several, strict=True) if differs)
        for item in items
        for run in found
    }
    return [
        Panel(
            f"{axis} {first.label}".strip(),
            first.unit,
            {name: found[run].values.sel(item=item, axis=axis) for (item, run), name in names.items()},
        )
        for axis in first.values.axis.values
    ]


def _series(quantity: Quantity, values: xr.DataArray) -> Iterator[Series]:
    """Series of a quantity; forces on rails of both sides together, and of each."""
    values = in_figure_unit(values)
    unit = values.attrs["units"]
    axes = list(quantity.curve_axes)
    if axes:
        # the friction torque turns about the normal, which is z but for the units' tilt
        values = values.sel(axis=axes if len(axes) > 1 else axes[0], drop=True)
    if quantity.name.endswith("angles"):
        values = values.assign_coords(axis=[TURNS[str(axis)] for axis in values.axis.values])
    if "rail" in values.dims:
        yield Series(quantity.curves, quantity.label, unit, _of_items(quantity, values.sum("rail")))
        for side in values.rail.values:
            label = on_rails(str(side))
            yield Series(quantity.curves, label, unit, _of_items(quantity, values.sel(rail=side, drop=True)))
    elif "pin" not in values.dims:
        yield Series(quantity.curves, quantity.label, unit, _of_items(quantity, values))
    elif (pins := _of_pins(values)) is not None:
        yield Series(quantity.curves, quantity.label, unit, pins)


def _of_items(quantity: Quantity, values: xr.DataArray) -> xr.DataArray:
    """Values by the names of the shoes, links or rollers that they are of, or of the one thing."""
    names = {"shoe": shoe_names, "joint": link_names, "roller": roller_names}
    for dim, named in names.items():
        if dim in values.dims:
            return _shaped(values, dim, named(values[dim].values))
    return _shaped(values, "thing", [quantity.per])


def _of_pins(values: xr.DataArray) -> xr.DataArray | None:
    """Values by the names of the pins; None where all links are rigid.

    A rigid link has one joint for both pins, whose force is the link's.
    """
    apart = values.isel(time=0).notnull().all(("pin", "axis")).values
    values = values.isel(joint=apart).stack(place=("joint", "pin"))
    names = [pin_name(int(joint), str(pin)) for joint, pin in values.place.values]
    return _shaped(values.drop_vars(["place", "joint", "pin"]), "place", names) if names else None


def deformation_panels(found: Mapping[str, Series]) -> list[Panel]:
    """Panel of the terrain's deformation, with a label that fits beside it."""
    return replace(found[TERRAIN_DEFORMATION], label="deformation").panels()


def shoe_names(shoes: Iterable[int]) -> list[str]:
    """Items of shoes by their numbers."""
    return [f"shoe {shoe}" for shoe in shoes]


def link_names(joints: Iterable[int]) -> list[str]:
    """Items of links by the number of the shoe behind each."""
    return [f"link {joint}-{joint + 1}" for joint in joints]


def roller_names(rollers: Iterable[int]) -> list[str]:
    """Items of rollers by their numbers from the rear."""
    return [f"roller {roller}" for roller in rollers]


def on_rails(side: str) -> str:
    """Label of the rollers' force on the rails of a side."""
    return f"{ROLLER_FORCE} on the {side} rails"


def _shaped(values: xr.DataArray, dim: str, items: Sequence[str]) -> xr.DataArray:
    """Series with dimensions (time, item, axis), of which `dim` becomes item."""
    if dim not in values.dims:
        values = values.expand_dims(dim)
    values = values.drop_vars(dim, errors="ignore").rename({dim: "item"}).assign_coords(item=list(items))
    if "axis" not in values.dims:
        values = values.expand_dims({"axis": [""]})
    return values.transpose("time", "item", "axis")


def pin_name(joint: int, side: str) -> str:
    """Item of a flexible link's pin on the right or left."""
    return f"{link_names([joint])[0]} {side}"
