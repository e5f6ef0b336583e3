"""Points of the shoes in the axes of the side frame, in which the wheels stand still."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.results.history import catalogue


def points_in_frame(data: xr.Dataset, arm: Sequence[float]) -> np.ndarray:
    """Return a point of every shoe from the side frame's reference point, in the axes of the frame, m.

    Parameters
    ----------
    data : xarray.Dataset
        States of a history; without a time, one state.
    arm : sequence of float
        Point in the axes of a shoe, from its reference point, m.

    Returns
    -------
    ndarray
        Array (times, shoes, 3), of one state (shoes, 3).
    """
    shoe = catalogue.rotation_matrices(_ordered(data.angles, "shoe"))
    frame = catalogue.rotation_matrices(_ordered(data.side_frame_angles))
    place = _ordered(data.position, "shoe") + shoe @ np.asarray(arm, dtype=float)
    points: np.ndarray = (place - _ordered(data.side_frame_position)[..., None, :]) @ frame
    return points


def pins_in_frame(case: Case, data: xr.Dataset) -> np.ndarray:
    """Return the front pins of all shoes, in the chain's plane: as `points_in_frame`."""
    return points_in_frame(data, (case.track.pin_ahead, 0.0, case.track.pin_height))


def _ordered(values: xr.DataArray, *items: str) -> np.ndarray:
    """Return values with the dimensions time (if there is one), items, axis."""
    ordered: np.ndarray = values.transpose(..., *items, "axis").values.astype(float)
    return ordered
