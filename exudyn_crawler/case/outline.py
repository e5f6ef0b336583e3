"""Outline of a track on the ground, its motion with the drive, and the ground that it needs."""

import numpy as np

from exudyn_crawler.case.gear.base import Whole
from exudyn_crawler.settings.parameters import Errors


def outlines(case: Whole, times: np.ndarray) -> np.ndarray:
    """Return the corners of the track on the ground at times (s): array (times, 4, 2), m, global x and y.

    The drive moves and turns the outline; a machine on two tracks follows its heading. A track under a
    rolling side frame stands still.
    """
    corners = corners_of(case.shoe.footprint, case.gear.shoe_reference(case))
    return moved(corners, case.drive.turn(times), case.gear.way(case.drive, times))


def support_errors(case: Whole, times: np.ndarray) -> Errors:
    """Yield an error for each part off the track, and for a track off the terrain, at times (s)."""
    corners_at = outlines(case, times)
    travels = case.drive.travel(times)
    for time, travel, corners in zip(times.tolist(), travels.tolist(), corners_at, strict=True):
        yield from case.gear.reach_errors(case.track, travel, time)
        yield from case.terrain.reach_errors(corners, time)
    yield from case.terrain.map_errors(corners_at)


def corners_of(footprint: np.ndarray, coms: np.ndarray) -> np.ndarray:
    """Return the corners around all shoes, from rear right to rear left: array (4, 2), m, global x and y.

    `footprint` is that of a shoe about its COM: least and greatest x, then y, m. `coms` (shoes, 6) gives the
    places of the COMs.
    """
    rear = coms[:, 0].min() + footprint[0]
    front = coms[:, 0].max() + footprint[1]
    right = coms[:, 1].min() + footprint[2]
    left = coms[:, 1].max() + footprint[3]
    return np.array([[rear, right], [front, right], [front, left], [rear, left]])


def moved(corners: np.ndarray, angles: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Return corners (4, 2), m, turned about their middle by angles (rad) and moved by ways (m).

    `angles` is (times,), `ways` (times, 2), the result (times, 4, 2), m. Seen from above the track is rigid,
    since its hinges only pitch.
    """
    middle = corners.mean(axis=0)
    c = np.cos(angles)
    s = np.sin(angles)
    turns = np.moveaxis(np.array([[c, s], [-s, c]]), 2, 0)
    turned: np.ndarray = middle + (corners - middle) @ turns + ways[:, None]
    return turned
