"""Where shoes, side frame and rollers are in instants of a history, and what presses on the shoes."""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from exudyn_crawler.case import Case, Undercarriage
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.scenes.scene import Placement

STRIPS = ("roller", "rail", "strip", "neighbour", "axis")
"""Dimensions of what treads press with."""


def instants(history: History, times: ArrayLike) -> xr.Dataset:
    """States of a history at the stored times nearest to some (s), each once."""
    rows = history.dataset.get_index("time").get_indexer(np.asarray(times), method="nearest")
    return history.dataset.isel(time=np.unique(rows)).load()


def shoe_poses(dataset: xr.Dataset) -> tuple[NDArray, NDArray]:
    """Origins (times, shoes, 3), m, and turns (times, shoes, 3, 3) of all shoes in some instants."""
    dims = ("time", "shoe", "axis")
    turn = rotation_matrices(dataset.angles.transpose(*dims).values)
    return dataset.position.transpose(*dims).values, turn


def shoe_pose(now: xr.Dataset, shoe: int) -> Placement:
    """Place of one shoe in one instant."""
    chosen = now.sel(shoe=shoe)
    return Placement(chosen.position.values, rotation_matrices(chosen.angles.values))


def touching(now: xr.Dataset, shoe: int | None = None) -> tuple[NDArray, NDArray]:
    """Contacts of one shoe, or of all, in one instant.

    Returns
    -------
    points, forces : arrays (contacts, 3)
        Where they act (m) and what acts on the shoe (N), both global. Pairs that are apart are left out.
    """
    meets = now.area.values > 0.0
    if shoe is not None:
        meets &= now.contact_shoe.values == shoe
    forces = (now.normal_force + now.friction_force).transpose("contact", "axis").values
    return now.point.transpose("contact", "axis").values[meets], forces[meets]


def pressing(now: xr.Dataset, shoe: int | None = None) -> tuple[NDArray, NDArray]:
    """Strips of treads that press on one shoe, or on all, in one instant, as of `touching`."""
    forces, points = (now[name].transpose(*STRIPS).values for name in ("tread_force", "tread_foot"))
    meets = forces.any(axis=-1)
    if shoe is not None:
        number = now.roller_shoe.values[:, None] + np.arange(forces.shape[3])
        meets &= (number == shoe)[:, None, None, :]
    return points[meets], forces[meets]


def acting(now: xr.Dataset, shoe: int | None = None) -> tuple[NDArray, NDArray]:
    """Contacts with the ground of one shoe or of all, and the treads that press there, as of `touching`."""
    points, forces = touching(now, shoe)
    if not rolls(now):
        return points, forces
    others = pressing(now, shoe)
    return np.concatenate((points, others[0])), np.concatenate((forces, others[1]))


def shoe_forces(dataset: xr.Dataset) -> tuple[NDArray, NDArray]:
    """Contact of each shoe in some instants.

    Returns
    -------
    centers, forces : arrays (times, shoes, 3)
        Centre of pressure, m, not a number without contact, and force on the shoe, N.
    """
    dims = ("time", "contact", "axis")
    meets = dataset.area.transpose(*dims[:2]).values[..., None] > 0.0
    forces = (dataset.normal_force + dataset.friction_force).transpose(*dims).values
    points = dataset.point.transpose(*dims).values
    own = dataset.shoe.values[:, None] == dataset.contact_shoe.values
    forces = np.where(meets, forces, 0.0)
    total = np.einsum("sc,tca->tsa", own, forces)
    pressed = np.einsum("sc,tc->ts", own, forces[..., 2])[..., None]
    moments = np.einsum("sc,tc,tca->tsa", own, forces[..., 2], np.where(meets, points, 0.0), optimize=True)
    centers = np.full(total.shape, np.nan)
    np.divide(moments, pressed, out=centers, where=pressed > 0.0)
    return centers, total


def greatest_shoe_force(history: History) -> float:
    """Greatest contact force on a shoe over the run, N."""
    total = (history.normal_force + history.friction_force).groupby("contact_shoe").sum()
    return float(np.sqrt((total**2).sum("axis")).max())


def unloaded_level(case: Case) -> float:
    """Heave of units that carry nothing but themselves, m."""
    return case.terrain.unit_mass * case.gravity_vector()[2] / case.terrain.heave_stiffness


def rolls(dataset: xr.Dataset) -> bool:
    """Whether a side frame rolls over the track of a history."""
    return "roller_force" in dataset


def frame_of(case: Case) -> tuple[Undercarriage, tuple[float, float]]:
    """Undercarriage and the lateral places of the rails' middles, m.

    Raises
    ------
    ValueError
        If the case is dragged.
    """
    frame, rails = case.undercarriage, case.shoe.rails
    if frame is None or rails is None:
        raise ValueError(f"the case {case.name!r} must have an undercarriage to show one")
    return frame, rails.middles


def frame_poses(dataset: xr.Dataset) -> tuple[NDArray, NDArray]:
    """Origins (times, 3), m, and turns (times, 3, 3) of the side frame in some instants."""
    return dataset.side_frame_position.values, rotation_matrices(dataset.side_frame_angles.values)


def frame_pose(now: xr.Dataset) -> Placement:
    """Place of the side frame in one instant."""
    return Placement(*frame_poses(now))


def tread_centers(dataset: xr.Dataset, case: Case) -> NDArray:
    """Middles of the treads on the rollers' axes: array (times, rollers, rails, 3), m, global."""
    frame, middles = frame_of(case)
    places = np.array([[(x, y, 0.0) for y in middles] for x in frame.rollers])
    origin, turn = frame_poses(dataset)
    return origin[:, None, None] + np.einsum("tij,rsj->trsi", turn, places)


def rolled_angle(dataset: xr.Dataset, case: Case) -> NDArray:
    """Angles (times,) about the rollers' axes by which they have rolled since t = 0, rad, from z to x."""
    frame, _ = frame_of(case)
    return (dataset.side_frame_position.sel(axis="x").values - frame.start) / frame.radius


def roller_forces(dataset: xr.Dataset) -> tuple[NDArray, NDArray]:
    """Centre of what each roller presses on, array (times, rollers, 3), m, and its force there, N.

    The centre of a roller that presses on nothing is not a number.
    """
    forces, points = (
        dataset[name].transpose("time", *STRIPS).values for name in ("tread_force", "tread_foot")
    )
    size = np.linalg.norm(forces, axis=-1)
    weight = size.sum(axis=(2, 3, 4))[..., None]
    moments = np.einsum("trabn,trabnk->trk", size, points)
    centers = np.full(moments.shape, np.nan)
    np.divide(moments, weight, out=centers, where=weight > 0.0)
    return centers, forces.sum(axis=(2, 3, 4))
