"""What a run offers to be drawn over time: quantities of shoes, links and track, in units for reading."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from exudyn_crawler.results.history.catalogue import QUANTITIES
from exudyn_crawler.results.history.derived import contacts_of, rail_force, terrain_deformation
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.curves import KINEMATICS, Panel, kinematic_series
from exudyn_crawler.views.scales import MEGA


def _labelled(*names: str) -> dict[str, tuple[str, str]]:
    """Variables and their units by label, as the catalogue has them."""
    return {QUANTITIES[name].label: (name, QUANTITIES[name].unit) for name in names}


CONTACT_VECTORS = _labelled("normal_force", "slip_velocity", "friction_force", "contact_force")
CONTACT_SCALARS = _labelled("penetration", "penetration_rate", "friction_torque")
JOINT_VECTORS = _labelled("joint_force", "joint_torque")
PIN_VECTORS = _labelled("pin_force", "pin_torque")
TERRAIN_DEFORMATION = QUANTITIES["terrain_deformation"].long_name
HIGHEST_STRESS = QUANTITIES["highest_von_mises"].label
ROLLER_FORCE, RAIL_FORCE = QUANTITIES["roller_force"].label, QUANTITIES["rail_force"].label
PULL = QUANTITIES["drive_pull"].label
FRAME_WAY = "way of the side frame"
FRAME_ANGLE = QUANTITIES["side_frame_angles"].label


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
    rolled = "roller_force" in dataset
    rolling = [*_rollers(dataset), *_side_frame(dataset)] if rolled else []
    # drive and loads are those of the side frame where one rolls over the track
    track = _deformation(dataset) if rolled else _track(dataset)
    return [*found, *_motion(dataset), *_contact(dataset), *rolling, *_links(dataset), *track]


def deformation_panels(found: Mapping[str, Series]) -> list[Panel]:
    """Panel of the terrain's deformation, with a label that fits beside it."""
    label = QUANTITIES["terrain_deformation"].label
    return replace(found[TERRAIN_DEFORMATION], label=label).panels()


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


def _rollers(dataset: xr.Dataset) -> Iterator[Series]:
    """Forces on both rails together and apart, and on every shoe."""
    force, names = dataset.roller_force, roller_names(dataset.roller.values)
    forces = {ROLLER_FORCE: force.sum("rail")}
    forces |= {on_rails(str(side)): force.sel(rail=side, drop=True) for side in dataset.rail.values}
    for label, values in forces.items():
        yield Series("rollers", label, "N", _shaped(values, "roller", names))
    yield Series("rollers", RAIL_FORCE, "N", _of_shoes(rail_force(dataset)))


def _side_frame(dataset: xr.Dataset) -> Iterator[Series]:
    """Way, angles and pull; y and yaw are held and not drawn."""
    place = dataset.side_frame_position.sel(axis=["x", "z"])
    angles = dataset.side_frame_angles.sel(axis=["x", "y"]).assign_coords(axis=["roll", "pitch"])
    drawn = (
        (PULL, "N", dataset.drive_pull),
        (FRAME_WAY, "m", place - place.isel(time=0)),
        (FRAME_ANGLE, "deg", np.degrees(angles)),
    )
    for label, unit, values in drawn:
        yield Series("side frame", label, unit, _shaped(values, "frame", ["side frame"]))


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


def _deformation(dataset: xr.Dataset) -> Iterator[Series]:
    if "terrain_deformation" in dataset:
        values = _shaped(dataset.terrain_deformation, "track", ["track"])
        yield Series("track", TERRAIN_DEFORMATION, QUANTITIES["terrain_deformation"].unit, values)


def _track(dataset: xr.Dataset) -> Iterator[Series]:
    for label, (name, unit) in _labelled("drive_force", "drive_torque").items():
        if name in dataset:
            yield Series("track", label, unit, _shaped(dataset[name], "track", ["track"]))
    yield from _deformation(dataset)
    for label, (name, unit) in _labelled("shoe_load").items():
        if name in dataset:
            yield Series("track", label, unit, _of_shoes(dataset[name]))
