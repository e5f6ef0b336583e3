"""How the modes of a flexible shoe move its rails under the strips of rollers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case, Rails, Undercarriage
from fem import ReducedBody
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
    lines, spacing = strip_lines(frame, rails), (rails.front - rails.rear) / (STATIONS - 1)
    if reduced is None:
        return RailRows(rails.rear, spacing, np.zeros((len(lines), STATIONS + 2, 2, 0)))
    along = np.linspace(rails.rear, rails.front, STATIONS)
    weights = station_weights(reduced.mesh, [(x, y) for y in lines for x in along])
    nodes = np.flatnonzero(weights.any(axis=0))
    rows = np.einsum("pn,nck->pck", weights[:, nodes], reduced.modes[nodes][:, [0, 2]])
    rows = rows.reshape(len(lines), STATIONS, 2, -1)
    before, behind = 2.0 * rows[:, :1] - rows[:, 1:2], 2.0 * rows[:, -1:] - rows[:, -2:-1]
    return RailRows(rails.rear, spacing, np.ascontiguousarray(np.concatenate((before, rows, behind), axis=1)))


def rows_along(rails: RailRows, line: int, x: NDArray) -> NDArray:
    """Displacement along x and z of a line at places along it (times,), m: array (times, 2, m).

    By the cubics of `compiled.rollers.rows_at`.
    """
    t = np.clip((x - rails.rear) / rails.spacing, 0.0, STATIONS - 1.0)
    first = np.minimum(t.astype(int), STATIONS - 2)
    u = t - first
    weights = 0.5 * np.stack(
        (
            u * (u * (2.0 - u) - 1.0),
            2.0 + u * u * (3.0 * u - 5.0),
            u * (1.0 + u * (4.0 - 3.0 * u)),
            u * u * (u - 1.0),
        )
    )
    return sum(one[:, None, None] * rails.rows[line, first + n] for n, one in enumerate(weights))
