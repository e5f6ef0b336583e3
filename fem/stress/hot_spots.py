"""Hot spots: nodes with the greatest stresses, as tidy tables."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from fem.body.element_stress import Criterion
from fem.body.mesh import Floats, Integers, Mesh
from fem.body.shapes import Shapes
from fem.stress.recovery import Peaks, recover_peaks
from fem.stress.trust import IN_SPIDER, resolution_at, with_bores


@dataclass(frozen=True)
class Apart:
    """Rule: no hot spot lies within a radius of a more severe one.

    Parameters
    ----------
    radius : float
        In m, positive.

    Raises
    ------
    ValueError
        If the radius is not positive.
    """

    radius: float = 0.05

    def __post_init__(self) -> None:
        if not self.radius > 0.0:
            raise ValueError(f"radius must be positive, got {self.radius}")

    def choose(self, mesh: Mesh, peaks: Peaks, count: int) -> list[int]:
        """Return the positions in the peaks of at most `count` hot spots, the most severe first."""
        return _separated(mesh.nodes[peaks.nodes], peaks.order, self.radius, count)


@dataclass(frozen=True)
class OneARegion:
    """Rule: one hot spot per connected region with a stress above a fraction of the greatest.

    Parameters
    ----------
    fraction : float
        Inside (0, 1).

    Raises
    ------
    ValueError
        If the fraction is out of its range.
    """

    fraction: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 < self.fraction < 1.0:
            raise ValueError(f"fraction must lie inside (0, 1), got {self.fraction}")

    def choose(self, mesh: Mesh, peaks: Peaks, count: int) -> list[int]:
        """Return the positions in the peaks of at most `count` hot spots, the most severe first."""
        return _one_a_region(mesh, peaks, self.fraction, count)


@dataclass(frozen=True, eq=False)
class OneOfEach:
    """Rule: the most severe hot spot of each named part of a body.

    Parameters
    ----------
    parts : array (n,)
        Name of each node's part of the body.
    """

    parts: np.ndarray

    def choose(self, mesh: Mesh, peaks: Peaks, count: int) -> list[int]:
        """Return the positions in the peaks of at most `count` hot spots, the most severe first."""
        _, first = np.unique(self.parts[peaks.nodes[peaks.order]].astype(str), return_index=True)
        return peaks.order[np.sort(first)][:count].tolist()


Separation = Apart | OneARegion | OneOfEach
"""Rules that separate hot spots."""


def _separated(positions: Floats, order: Integers, radius: float, count: int) -> list[int]:
    """Return the positions of the most severe nodes, none within a radius of a more severe one."""
    tree = cKDTree(positions)
    open_ = np.ones(len(positions), dtype=bool)
    chosen: list[int] = []
    for place in order:
        if open_[place]:
            chosen.append(int(place))
            open_[tree.query_ball_point(positions[place], radius)] = False
            if len(chosen) == count:
                break
    return chosen


def _one_a_region(mesh: Mesh, peaks: Peaks, fraction: float, count: int) -> list[int]:
    """Return the positions of the most severe node of each region above a fraction of the greatest."""
    order = peaks.order
    size = np.abs(peaks.values)
    above = size >= fraction * size[order[0]]
    marked = np.zeros(len(mesh.nodes), dtype=bool)
    marked[peaks.nodes[above]] = True
    width = mesh.elements.shape[1]
    pairs = np.concatenate([mesh.elements[:, [i, j]] for i in range(width) for j in range(i)])
    pairs = pairs[marked[pairs].all(axis=1)]
    n = len(mesh.nodes)
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    _, label = connected_components(links, directed=False)
    seen: set[int] = set()
    chosen: list[int] = []
    for place in order:
        region = int(label[peaks.nodes[place]])
        if above[place] and region not in seen:
            seen.add(region)
            chosen.append(int(place))
            if len(chosen) == count:
                break
    return chosen


def hot_spots(
    body: Shapes,
    times: Floats,
    q: Floats,
    count: int = 5,
    *,
    criterion: Criterion = "von mises",
    separation: Separation | None = None,
    nodes: Integers | None = None,
    peaks: Peaks | None = None,
) -> pd.DataFrame:
    """Tabulate the most severe nodes of a history.

    Parameters
    ----------
    body : Shapes
    times : array (t,)
        In s.
    q : array (t, m)
        Coordinates of the body's columns.
    count : int
        Greatest number of rows.
    criterion : str
        One of `element_stress.CRITERIA`.
    separation : Apart, OneARegion or OneOfEach, optional
        Rule that separates hot spots; if left out, the highest nodes are listed, as in the papers.
    nodes : int array, optional
        Numbers of the candidate nodes, such as `body.nodes_away_from_spiders` or
        `body.mesh.surface_nodes`; all if left out.
    peaks : Peaks, optional
        Result of `recover_peaks` over all nodes and the whole history, if already computed.

    Returns
    -------
    pandas.DataFrame
        rank, value (Pa), node, time (s), x, y, z (m, body axes), flag ("in spider", "beside spider" or
        empty), jump (Pa) and error (Pa). The jump is the disagreement of the elements around the node at
        that time. The error is the estimated error of the von Mises stress from the mesh, see
        `trust.mesh_error`. A jump as large as the value means that the peak comes from the mesh;
        `trust.judged` combines all this into one verdict.

    Raises
    ------
    ValueError
        If an argument is out of range, or there is no node or time.
    """
    times = np.asarray(times, dtype=float)
    q = np.atleast_2d(q)
    if len(times) != len(q):
        raise ValueError(f"times must be as many as the rows of q, got {len(times)} and {len(q)}")
    if count < 1:
        raise ValueError(f"count must be at least 1, got {count}")
    chosen = np.arange(len(body.nodes)) if nodes is None else np.unique(nodes)
    if len(times) == 0 or len(chosen) == 0:
        raise ValueError(
            f"times and nodes must be at least one each, got {len(times)} times and {len(chosen)} nodes"
        )
    if peaks is None:
        peaks = recover_peaks(body.stress_modes, q, criterion, chosen)
    elif peaks.criterion != criterion or len(peaks.nodes) != len(body.nodes):
        raise ValueError(
            f"peaks must be those of {criterion!r} at all {len(body.nodes)} nodes, "
            f"got {peaks.criterion!r} at {len(peaks.nodes)}"
        )
    else:
        peaks = Peaks(criterion, chosen, peaks.values[chosen], peaks.time_indices[chosen])
    places = (
        peaks.order[:count].tolist() if separation is None else separation.choose(body.mesh, peaks, count)
    )
    return _table(body, times, q, peaks, places)


def _table(body: Shapes, times: Floats, q: Floats, peaks: Peaks, places: list[int]) -> pd.DataFrame:
    """Tabulate chosen positions in the peaks for `hot_spots`."""
    nodes = peaks.nodes[places]
    rows = peaks.time_indices[places]
    resolved = resolution_at(body, q[rows], nodes)
    flags = np.where(
        np.isin(nodes, body.held_nodes),
        IN_SPIDER,
        np.where(np.isin(nodes, body.nodes_beside_spiders), "beside spider", ""),
    )
    return pd.DataFrame(
        {
            "rank": np.arange(1, len(places) + 1),
            "value": peaks.values[places],
            "node": nodes,
            "time": times[rows],
            "x": body.nodes[nodes, 0],
            "y": body.nodes[nodes, 1],
            "z": body.nodes[nodes, 2],
            "flag": flags,
            "jump": np.sqrt(resolved.jump),
            "error": with_bores(resolved.error, body, nodes) * np.sqrt(resolved.size),
        }
    )
