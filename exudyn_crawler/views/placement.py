"""Where shoes and contacts are at one time of a history, and what contact does to each shoe."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History


@dataclass(frozen=True)
class Pose:
    """Place of a shoe's frame.

    Attributes
    ----------
    origin : array (3,)
        m, global.
    frame : array (3, 3)
        Columns are the shoe's x, y and z axes in global components.
    """

    origin: NDArray
    frame: NDArray

    @classmethod
    def of(cls, now: xr.Dataset, shoe: int) -> Self:
        """Pose of a shoe in one instant of a history (see `instant`)."""
        chosen = now.sel(shoe=shoe)
        return cls(chosen.position.values, rotation_matrices(chosen.angles.values))

    def place(self, points: NDArray) -> NDArray:
        """Points (n, 3) of the shoe's frame in the global one."""
        return points @ self.frame.T + self.origin

    def turn(self, vectors: NDArray) -> NDArray:
        """Vectors (n, 3) in the shoe's axes as global components."""
        return vectors @ self.frame.T

    def inside(self, points: NDArray) -> NDArray:
        """Global points (n, 3) in the shoe's frame."""
        return (points - self.origin) @ self.frame

    def components(self, vectors: NDArray) -> NDArray:
        """Global vectors (n, 3) in the shoe's axes."""
        return vectors @ self.frame


def shoe_poses(now: xr.Dataset) -> list[Pose]:
    """Poses of all shoes in one instant, in their order."""
    return [Pose.of(now, int(shoe)) for shoe in now.shoe.values]


def instant(history: History, time: float) -> xr.Dataset:
    """State of a history at the stored time nearest to `time` (s)."""
    return history.dataset.sel(time=time, method="nearest")


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


def shoe_forces(now: xr.Dataset) -> tuple[NDArray, NDArray]:
    """Contact of each shoe in one instant: centre of pressure (shoes, 3), m, and force (shoes, 3), N.

    The centre of a shoe without contact is not a number.
    """
    centers, forces = shoe_forces_over_time(now.expand_dims("time"))
    return centers[0], forces[0]


def shoe_forces_over_time(dataset: xr.Dataset) -> tuple[NDArray, NDArray]:
    """Same in some instants of a history: arrays (times, shoes, 3)."""
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
