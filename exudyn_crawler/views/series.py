"""What a run offers to be drawn over time: quantities of shoes, links and track, in units for reading."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import xarray as xr

from exudyn_crawler.results.contacts import contacts_of, terrain_deformation
from exudyn_crawler.results.history import History
from exudyn_crawler.views.curves import KINEMATICS, Panel, kinematic_series
from exudyn_crawler.views.scales import MEGA

CONTACT_VECTORS = {
    "normal force": ("normal_force", "N"),
    "slip velocity": ("slip_velocity", "m/s"),
    "friction force": ("friction_force", "N"),
    "contact force": ("contact_force", "N"),
}
CONTACT_SCALARS = {
    "penetration depth": ("penetration", "m"),
    "sinkage velocity": ("penetration_rate", "m/s"),
    "friction torque": ("friction_torque", "N m"),
}
JOINT_VECTORS = {
    "spherical joint reaction": ("joint_force", "N"),
    "parallel joint torque": ("joint_torque", "N m"),
}
PIN_VECTORS = {"pin force": ("pin_force", "N"), "pin torque": ("pin_torque", "N m")}
TERRAIN_DEFORMATION = "total terrain deformation from equilibrium"
TRACK_SCALARS = {
    "force of the drive along x": ("drive_force", "N"),
    "torque of the turn about z": ("drive_torque", "N m"),
    TERRAIN_DEFORMATION: ("terrain_deformation", "m"),
}
HIGHEST_STRESS = "highest von Mises stress"


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
        names = [str(item) for item in self.values["item"].values] if items is None else items
        return [
            Panel(
                f"{axis} {self.label}".strip(),
                self.unit,
                {name: self.values.sel(item=name, axis=axis) for name in names},
            )
            for axis in self.values.axis.values
        ]

    def panels_by_item(self) -> list[Panel]:
        """Panel for each item of a quantity without axes."""
        items = [str(item) for item in self.values["item"].values]
        return [Panel(item, self.unit, {item: self.values.sel(item=item).squeeze("axis")}) for item in items]


def history_series(history: History, stress: xr.Dataset | None = None) -> dict[str, Series]:
    """Everything over time that a history and its stresses offer, by label."""
    dataset = history.dataset.assign(terrain_deformation=terrain_deformation(history))
    return {series.label: series for series in dataset_series(dataset, stress)}


def dataset_series(dataset: xr.Dataset, stress: xr.Dataset | None = None) -> list[Series]:
    """Same from a history's variables, whose terrain deformation is drawn where it is among them."""
    found = [] if stress is None else [_highest(stress)]
    return [*found, *_motion(dataset), *_contact(dataset), *_links(dataset), *_track(dataset)]


def shoe_names(shoes: Iterable[int]) -> list[str]:
    """Items of shoes by their numbers."""
    return [f"shoe {shoe}" for shoe in shoes]


def link_names(joints: Iterable[int]) -> list[str]:
    """Items of links by the number of the shoe behind each."""
    return [f"link {joint}-{joint + 1}" for joint in joints]


def _shaped(values: xr.DataArray, dim: str, items: Sequence[str]) -> xr.DataArray:
    """Series with dimensions (time, item, axis), of which `dim` becomes item."""
    if dim not in values.dims:
        values = values.expand_dims(dim)
    values = values.drop_vars(dim, errors="ignore").rename({dim: "item"}).assign_coords(item=list(items))
    if "axis" not in values.dims:
        values = values.expand_dims({"axis": [""]})
    return values.transpose("time", "item", "axis")


def _highest(stress: xr.Dataset) -> Series:
    highest = stress.highest_von_mises / MEGA
    return Series("stress", HIGHEST_STRESS, "MPa", _of_shoes(highest))


def _of_shoes(values: xr.DataArray) -> xr.DataArray:
    return _shaped(values, "shoe", shoe_names(values.shoe.values))


def _motion(dataset: xr.Dataset) -> Iterator[Series]:
    for quantity, (name, unit, _) in KINEMATICS.items():
        label = f"{quantity} from equilibrium" if name == "position" else quantity
        yield Series("motion", label, unit, _of_shoes(kinematic_series(dataset, quantity)))


def _contact(dataset: xr.Dataset) -> Iterator[Series]:
    contacts = contacts_of(dataset)
    for label, (name, unit) in (CONTACT_VECTORS | CONTACT_SCALARS).items():
        values = contacts[name]
        if label in CONTACT_SCALARS and "axis" in values.dims:
            # the friction torque turns about the normal, which is z but for the units' tilt
            values = values.sel(axis="z", drop=True)
        yield Series("contact", label, unit, _of_shoes(values))


def _links(dataset: xr.Dataset) -> Iterator[Series]:
    for label, (name, unit) in JOINT_VECTORS.items():
        values = dataset[name]
        yield Series("links", label, unit, _shaped(values, "joint", link_names(values.joint.values)))
    for label, (name, unit) in PIN_VECTORS.items():
        if name not in dataset:
            continue
        # a rigid link has one joint for both pins, whose force is the link's
        apart = dataset[name].isel(time=0).notnull().all(("pin", "axis")).values
        values = dataset[name].isel(joint=apart).stack(place=("joint", "pin"))
        places = [pin_name(int(joint), str(pin)) for joint, pin in values.place.values]
        if places:
            values = values.drop_vars(["place", "joint", "pin"])
            yield Series("links", label, unit, _shaped(values, "place", places))


def pin_name(joint: int, side: str) -> str:
    """Item of a flexible link's pin on the right or left."""
    return f"{link_names([joint])[0]} {side}"


def _track(dataset: xr.Dataset) -> Iterator[Series]:
    for label, (name, unit) in TRACK_SCALARS.items():
        if name in dataset:
            yield Series("track", label, unit, _shaped(dataset[name], "track", ["track"]))
    if "shoe_load" in dataset:
        yield Series("track", "machine and dipper load", "N", _of_shoes(dataset.shoe_load))
