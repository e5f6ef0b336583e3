"""Where shoes and contacts are at one time of a history, in global and in shoe's axes."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history import History


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


def round_down(value: float) -> float:
    """Greatest of 1, 2, 5 times a power of ten that is not above a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-12)))


def round_up(value: float) -> float:
    """Least of 1, 1.5, 2, 3, 4, 5, 6, 8, 10 times a power of ten that is not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(power * min(step for step in steps if step * power >= value * (1.0 - 1e-12)))


def drawn_scale(values: ArrayLike, length: float) -> float:
    """Round factor that draws the greatest magnitude of `values` at most `length` long; 1 if all are zero."""
    greatest = float(np.abs(values).max(initial=0.0))
    return round_down(length / greatest) if greatest > 0.0 else 1.0
