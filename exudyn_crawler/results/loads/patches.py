"""Where units of the terrain press on the underside of a shoe: the rectangles of the equations of motion.

A contact bends a flexible shoe over the rectangle about its overlap (`ground.pair_track`); records of a
history have the same one, also where a tilted shoe touches a unit with a part of itself.
"""

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.frames import compiled
from exudyn_crawler.ground.overlap import overlap_workspace
from exudyn_crawler.ground.pairs import Footprint, pair_overlap
from exudyn_crawler.ground.rotations import rotation_matrices, shoe_at, unit_at
from exudyn_crawler.results.history.history import History


def patches(history: History, shoe: int) -> dict[int, tuple[NDArray, NDArray]]:
    """Least and greatest x and y, m in the shoe's frame, of the patches of a shoe: arrays (times, 2).

    By the index of the contact, whose patch is of no size while it is open.
    """
    case = history.case
    own = np.flatnonzero(history.contact_shoe.values == shoe)
    # each variable is read once, for histories larger than memory
    position, angles = (history.dataset[name].sel(shoe=shoe).values for name in ("position", "angles"))
    heights = history.point.isel(contact=own, axis=2).values
    places = _unit_places(history, history.contact_unit.values[own])
    frames = rotation_matrices(angles)
    found = {}
    for index, units, height in zip(own.tolist(), places, heights.T, strict=True):
        bounds = _overlaps(position, angles, units, case)
        middle = units[:, :2] + 0.5 * (bounds[:, 0::2] + bounds[:, 1::2])
        half = 0.5 * (bounds[:, 1::2] - bounds[:, 0::2])
        place = np.column_stack((middle, height)) - position
        center = np.einsum("tji,tj->ti", frames, place)[:, :2]
        reach = np.einsum("tji,tj->ti", np.abs(frames[:, :2, :2]), half)
        found[index] = (center - reach, center + reach)
    return found


def _unit_places(history: History, units: NDArray) -> NDArray:
    """Position (m) and tilt (rad) of units by their numbers: array (units, times, 4)."""
    terrain = history.case.terrain
    still = np.column_stack((terrain.centers, terrain.tilts))[units - 1]
    places = np.tile(still[:, None], (1, history.time.size, 1))
    places[:, :, 2] += history.unit_heave.sel(unit=units).values.T
    places[:, :, 3] += history.unit_tilt.sel(unit=units).values.T
    return places


def _overlaps(position: NDArray, angles: NDArray, units: NDArray, case: Case) -> NDArray:
    """Bounds of the overlaps in the unit's axes, m: array (times, 4), least and greatest xi, then eta."""
    terrain = case.terrain
    half = (0.5 * terrain.unit_length, 0.5 * terrain.unit_width, 0.5 * terrain.unit_height)
    bounds = np.zeros((len(units), 4))
    shoes = np.hstack((position, angles))
    footprint = Footprint(*case.shoe.footprint.tolist())
    _bounds(shoes, units, terrain.tilt_axis, footprint, half, overlap_workspace(), bounds)
    return bounds


@compiled
def _bounds(shoes, units, axis, footprint, half, work, out):
    """Write the bounds of overlaps of a shoe (times, 6) with a unit (times, 4) into `out` (times, 4)."""
    still = np.zeros(6)
    for t in range(len(shoes)):
        part = pair_overlap(shoe_at(shoes[t], still), unit_at(units[t], still, axis), footprint, half, work)
        out[t, 0], out[t, 1], out[t, 2], out[t, 3] = part.low_xi, part.high_xi, part.low_eta, part.high_eta
