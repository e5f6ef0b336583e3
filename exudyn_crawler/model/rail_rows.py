"""How the modes of a flexible shoe move its rails under the strips of rollers."""

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Rails, Undercarriage
from fem import ReducedBody
from meshes.rails import station_weights

STATIONS = 9
"""Along a rail, its ends included."""


def strip_lines(frame: Undercarriage, rails: Rails) -> NDArray:
    """Y of the strips of a roller, those of the right tread first: array (2 strips,), m."""
    return np.concatenate([middle + frame.strip_places for middle in rails.middles])


def stations(rails: Rails) -> NDArray:
    """X of the stations, m."""
    return np.linspace(rails.rear, rails.front, STATIONS)


def rail_rows(reduced: ReducedBody, frame: Undercarriage, rails: Rails) -> NDArray:
    """Displacement along x and z of the rails by each mode: array (2 strips, STATIONS + 2, 2, m).

    At the stations, and extrapolated evenly by one on either side.
    """
    lines = strip_lines(frame, rails)
    places = np.array([(x, y) for y in lines for x in stations(rails)])
    weights = station_weights(reduced.mesh, places)
    nodes = np.flatnonzero(weights.any(axis=0))
    rows = np.einsum("pn,nck->pck", weights[:, nodes], reduced.modes[nodes][:, [0, 2]])
    rows = rows.reshape(len(lines), STATIONS, 2, -1)
    before, behind = 2.0 * rows[:, :1] - rows[:, 1:2], 2.0 * rows[:, -1:] - rows[:, -2:-1]
    return np.ascontiguousarray(np.concatenate((before, rows, behind), axis=1))
