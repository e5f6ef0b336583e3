"""Outline of a track on the ground, and its motion with the drive."""

import numpy as np


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
