"""What the report's interactive plots and its 3D view draw, thinned and packed for a page.

Arrays go as base64 of little-endian bytes. Long series keep the least and the greatest value of every bin of
time, so that no extreme is lost.
"""

import base64
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.contacts import contacts_of
from exudyn_crawler.results.history import History
from exudyn_crawler.views.curves import JOINTS, KINEMATICS, NEGLIGIBLE, NEGLIGIBLE_MOTION, SHOES
from exudyn_crawler.views.force_figures import CONTACT_SCALARS, CONTACT_VECTORS, JOINT_VECTORS
from exudyn_crawler.views.placement import Pose, instant, touching
from exudyn_crawler.views.stress_pictures import MEGA, Scales

SERIES_BYTES = 4_500_000
"""Size on the page that all series together may have."""
BYTES_A_POINT = 6 * 4 / 3
"""A 16-bit number of the time and a 32-bit value, in base64."""
LEAST_POINTS, MOST_POINTS = 200, 4000
"""Points that a series keeps at least and at most."""


@dataclass(frozen=True)
class Quantity:
    """What can be picked for a plot.

    Attributes
    ----------
    group, label, unit : str
    values : xarray.DataArray
        Dimensions (time, item, axis); without axes, the one axis is named "".
    """

    group: str
    label: str
    unit: str
    values: xr.DataArray

    @property
    def series_count(self) -> int:
        """Number of series over time."""
        return self.values.sizes["item"] * self.values.sizes["axis"]


def packed(array: NDArray, kind: str) -> str:
    """Base64 of an array as little-endian numbers of a kind such as "f4" or "u2"."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=f"<{kind}").tobytes()).decode("ascii")


def quantities(dataset: xr.Dataset, stress: xr.Dataset | None = None) -> list[Quantity]:
    """Everything over time that a history's variables and a stress dataset offer, in the page's units."""
    found = list(_stress(stress)) if stress is not None else []
    return [*found, *_motion(dataset), *_contact(dataset), *_links(dataset), *_track(dataset)]


def _shaped(values: xr.DataArray, dim: str | None, name: str) -> xr.DataArray:
    """Series with dimensions (time, item, axis); items are named after `name` and their numbers."""
    if dim is None:
        values = values.expand_dims(item=[name])
    else:
        numbers = [str(number) for number in values[dim].values]
        values = values.rename({dim: "item"}).assign_coords(item=[f"{name} {n}" for n in numbers])
    if "axis" not in values.dims:
        values = values.expand_dims({"axis": [""]})
    return values.transpose("time", "item", "axis")


def _stress(stress: xr.Dataset) -> Iterator[Quantity]:
    highest = stress.highest_von_mises.transpose("time", "shoe") / MEGA
    yield Quantity("stress", "highest von Mises stress", "MPa", _shaped(highest, "shoe", "shoe"))


def _motion(dataset: xr.Dataset) -> Iterator[Quantity]:
    for label, (name, unit, factor) in KINEMATICS.items():
        values = dataset[name]
        if name == "position":
            values, label = values - values.isel(time=0), f"{label} from equilibrium"
        yield Quantity("motion", label, unit, _shaped(factor * values, "shoe", "shoe"))


def _contact(dataset: xr.Dataset) -> Iterator[Quantity]:
    contacts = contacts_of(dataset)
    for label, (name, unit) in (CONTACT_VECTORS | CONTACT_SCALARS).items():
        values = contacts[name]
        if label == "friction torque":
            values = values.sel(axis="z", drop=True)
        yield Quantity("contact", label, unit, _shaped(values, "shoe", "shoe"))


def _links(dataset: xr.Dataset) -> Iterator[Quantity]:
    links = [f"{number}-{number + 1}" for number in dataset.joint.values]
    for label, (name, unit) in JOINT_VECTORS.items():
        values = dataset[name].assign_coords(joint=links)
        yield Quantity("links", label, unit, _shaped(values, "joint", "link"))
    for label, name, unit in (("pin force", "pin_force", "N"), ("pin torque", "pin_torque", "N m")):
        if name not in dataset:
            continue
        # a rigid link has one joint for both pins, whose force is the link's
        apart = dataset[name].isel(time=0).notnull().all(("pin", "axis")).values
        values = dataset[name].assign_coords(joint=links).isel(joint=apart).stack(place=("joint", "pin"))
        places = [f"{joint} {pin}" for joint, pin in values.place.values]
        values = values.drop_vars(["place", "joint", "pin"]).assign_coords(place=places)
        if places:
            yield Quantity("links", label, unit, _shaped(values, "place", "link"))


def _track(dataset: xr.Dataset) -> Iterator[Quantity]:
    for label, name, unit in (
        ("force of the drive along x", "drive_force", "N"),
        ("torque of the turn about z", "drive_torque", "N m"),
        ("total terrain deformation from equilibrium", "terrain_deformation", "m"),
    ):
        if name in dataset:
            yield Quantity("track", label, unit, _shaped(dataset[name], None, "track"))
    if "shoe_load" in dataset:
        yield Quantity("track", "machine and dipper load", "N", _shaped(dataset.shoe_load, "shoe", "shoe"))


def thinned(values: NDArray, points: int) -> NDArray:
    """Indices to keep of a series (n,): ends, and the least and greatest of bins; at most about `points`."""
    n = len(values)
    if n <= points:
        return np.arange(n)
    bins = max(1, points // 2 - 1)
    width = -(-n // bins)
    padded = np.concatenate((values, np.full(-n % width, values[-1]))).reshape(-1, width)
    starts = width * np.arange(len(padded))
    kept = np.concatenate(([0, n - 1], starts + padded.argmin(axis=1), starts + padded.argmax(axis=1)))
    return np.unique(np.minimum(kept, n - 1))


def points_a_series(cases: dict[str, list[Quantity]]) -> int:
    """Points that each series may keep, for all of them to fit on a page."""
    count = sum(quantity.series_count for found in cases.values() for quantity in found)
    return int(np.clip(SERIES_BYTES / BYTES_A_POINT / max(count, 1), LEAST_POINTS, MOST_POINTS))


def packed_quantity(quantity: Quantity, points: int) -> dict[str, Any]:
    """Quantity for the page: names, and for every item and axis packed indices of time and values."""
    kind = "u2" if quantity.values.sizes["time"] < 2**16 else "u4"
    series = []
    for item in quantity.values.transpose("item", "axis", "time").values:
        row = []
        for values in item:
            kept = thinned(values, points)
            row.append([packed(kept, kind), packed(values[kept], "f4")])
        series.append(row)
    return {
        "group": quantity.group,
        "label": quantity.label,
        "unit": quantity.unit,
        "floor": NEGLIGIBLE.get(quantity.unit, NEGLIGIBLE_MOTION),
        "items": [str(item) for item in quantity.values["item"].values],
        "axes": [str(axis) for axis in quantity.values.axis.values],
        "index": kind,
        "drawn": JOINTS if quantity.group == "links" else SHOES,
        "series": series,
    }


def packed_case(found: list[Quantity], points: int) -> dict[str, Any]:
    """All quantities of a case; they share their stored times where they have the same."""
    times: list[NDArray] = []
    packed_quantities = []
    for quantity in found:
        time = quantity.values.time.values
        same = [k for k, one in enumerate(times) if np.array_equal(one, time)]
        if not same:
            times.append(time)
        packed_quantities.append(
            packed_quantity(quantity, points) | {"time": same[0] if same else len(times) - 1}
        )
    return {"times": [packed(time, "f4") for time in times], "quantities": packed_quantities}


def packed_shoes(stress: xr.Dataset, history: History) -> dict[str, Any]:
    """Surface, places, elastic displacement, von Mises stress and contact forces at the chosen times.

    Displacements and stresses are 16-bit steps of their greatest magnitude, which is coarser than nothing
    that can be seen.
    """
    scales = Scales.of(stress, history)
    used, corners = np.unique(stress.triangle.transpose("face", "corner").values, return_inverse=True)
    bend = stress.frame_displacement.transpose("frame", "shoe", "node", "axis").values[:, :, used]
    mises = stress.frame_von_mises.transpose("frame", "shoe", "node").values[:, :, used] / MEGA
    bend_step = max(float(np.abs(bend).max()), 1e-12) / 32767.0
    mises_step = max(float(mises.max()), 1e-12) / 65535.0
    shoes = [int(shoe) for shoe in stress.shoe.values]
    frames = []
    for number, time in enumerate(stress.frame.values):
        now = instant(history, float(time))
        poses = [Pose.of(now, shoe) for shoe in shoes]
        contacts = [touching(now, shoe) for shoe in shoes]
        frames.append(
            {
                "time": float(time),
                "origin": [pose.origin.tolist() for pose in poses],
                "frame": [pose.frame.ravel().tolist() for pose in poses],
                "bend": [packed(np.rint(one / bend_step), "i2") for one in bend[number]],
                "mises": [packed(np.rint(one / mises_step), "u2") for one in mises[number]],
                "highest": (stress.frame_von_mises.isel(frame=number).max("node") / MEGA).values.tolist(),
                "points": [packed(points, "f4") for points, _ in contacts],
                "forces": [packed(forces, "f4") for _, forces in contacts],
            }
        )
    return {
        "shoes": shoes,
        "position": packed(stress.node_position.transpose("node", "axis").values[used], "f4"),
        "triangle": packed(corners.reshape(-1, 3), "u4"),
        "bend_step": bend_step,
        "mises_step": mises_step,
        "limit": scales.stress / MEGA,
        "magnification": scales.displacement,
        "force_scale": scales.pair_force,
        "frames": frames,
    }
