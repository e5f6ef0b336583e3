"""How the modes of a flexible shoe move its rails under the strips of rollers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, Rails, Undercarriage
from fem import Mesh, ReducedBody
from meshes.rails import station_weights

STATIONS = 9
"""Along a rail, its ends included."""


class RailRows(NamedTuple):
    """Displacements of lines along the rails by m modes, at even stations.

    Attributes
    ----------
    rear, spacing : float
        x of the first station and distance of neighbours, m, in the shoe's frame.
    rows : array (lines, STATIONS + 2, 2, m)
        Along x and z, at the stations and extrapolated evenly by one on either side.
    """

    rear: float
    spacing: float
    rows: NDArray


def strip_lines(frame: Undercarriage, rails: Rails) -> NDArray:
    """Y of the strips of a roller, those of the right tread first: array (2 strips,), m."""
    return np.concatenate([middle + frame.strip_places for middle in rails.middles])


def station_spacing(rails: Rails) -> float:
    """Distance of neighbouring stations, m."""
    return (rails.front - rails.rear) / (STATIONS - 1)


def strip_weights(mesh: Mesh, frame: Undercarriage, rails: Rails) -> tuple[NDArray, NDArray]:
    """Nodes (k,) of the rails, and their shares (lines, STATIONS, k) in a force at a station of a strip."""
    lines, along = strip_lines(frame, rails), np.linspace(rails.rear, rails.front, STATIONS)
    weights = station_weights(mesh, [(x, y) for y in lines for x in along])
    nodes = np.flatnonzero(weights.any(axis=0))
    return nodes, weights[:, nodes].reshape(len(lines), STATIONS, -1)


def extended(rows: NDArray) -> NDArray:
    """Rows (lines, STATIONS, ...) at the stations, extrapolated evenly by one on either side."""
    before, behind = 2.0 * rows[:, :1] - rows[:, 1:2], 2.0 * rows[:, -1:] - rows[:, -2:-1]
    return np.ascontiguousarray(np.concatenate((before, rows, behind), axis=1))


def rail_rows(reduced: ReducedBody | None, case: Case) -> RailRows:
    """Displacements of the rails of a case's flexible shoes under the strips of its rollers.

    Parameters
    ----------
    reduced : ReducedBody, optional
        Modes of the shoes; without them rows have none.
    """
    frame, rails = case.undercarriage, case.shoe.rails
    modes = 0 if reduced is None else len(reduced.frequencies)
    if frame is None or rails is None:
        return RailRows(0.0, 1.0, np.zeros((0, STATIONS + 2, 2, modes)))
    if reduced is None:
        lines = len(strip_lines(frame, rails))
        return RailRows(rails.rear, station_spacing(rails), np.zeros((lines, STATIONS + 2, 2, 0)))
    nodes, weights = strip_weights(reduced.mesh, frame, rails)
    rows = np.einsum("lsn,nck->lsck", weights, reduced.modes[nodes][:, [0, 2]])
    return RailRows(rails.rear, station_spacing(rails), extended(rows))


def cubic_weights(t: NDArray) -> NDArray:
    """Shares (k, STATIONS + 2) of `extended` rows in those at places (k,), in spacings from the rear end.

    By the cubics of `compiled.rollers.rows_at`.
    """
    first = np.minimum(t.astype(int), STATIONS - 2)
    u = t - first
    values = (
        u * (u * (2.0 - u) - 1.0),
        2.0 + u * u * (3.0 * u - 5.0),
        u * (1.0 + u * (4.0 - 3.0 * u)),
        u * u * (u - 1.0),
    )
    weights = np.zeros((len(t), STATIONS + 2))
    for n, value in enumerate(values):
        weights[np.arange(len(t)), first + n] = 0.5 * value
    return weights
