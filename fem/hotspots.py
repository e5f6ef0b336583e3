"""Hot spots: the places of the greatest stresses, as tidy tables."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from .mesh import Floats, Integers, Mesh
from .recovery import Peaks, recover_peaks
from .reduced import ReducedBody
from .stress import Criterion, stress_jump

Separation = Literal["none", "radius", "regions"]


def _separated(positions: Floats, order: Integers, radius: float, count: int) -> list[int]:
    """Places of the most severe nodes, none within a radius of a more severe one."""
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
    """Places of the most severe node of each connected region above a fraction of the greatest."""
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
    body: ReducedBody,
    times: Floats,
    q: Floats,
    count: int = 5,
    *,
    criterion: Criterion = "von mises",
    separation: Separation = "none",
    radius: float = 0.05,
    fraction: float = 0.5,
    window: tuple[float, float] | None = None,
    nodes: Integers | None = None,
    surface_only: bool = False,
    with_spiders: bool = True,
    peaks: Peaks | None = None,
) -> pd.DataFrame:
    """Table of the most severe nodes of a history.

    Parameters
    ----------
    body : ReducedBody
    times : (t,) in s.
    q : (t, m) modal coordinates.
    count : number of rows at most.
    criterion : one of `stress.CRITERIA`.
    separation : "none" lists the highest nodes as the papers do; "radius" leaves out nodes within
        `radius` (m) of a more severe one; "regions" gives one node a connected region above
        `fraction` of the greatest value.
    window : first and last time in s to look at.
    nodes : numbers of the nodes to look at.
    surface_only : look at the boundary only.
    with_spiders : include nodes inside and beside spiders.
    peaks : of `recover_peaks` over all nodes and the whole history, if they are known.

    Returns
    -------
    pandas.DataFrame
        rank, value (Pa), node, time (s), x, y, z (m, body axes), flag ("in spider",
        "beside spider" or empty) and jump (Pa): by how much the elements around the node disagree
        at that time. A jump of the value's own size means that the mesh makes the peak.

    Raises
    ------
    ValueError
        If an argument is out of range or no node or time remains.
    """
    times = np.asarray(times, dtype=float)
    q = np.atleast_2d(q)
    if len(times) != len(q):
        raise ValueError(f"{len(times)} times and {len(q)} rows of modal coordinates")
    if count < 1:
        raise ValueError(f"count = {count} must be at least 1")
    if separation not in ("none", "radius", "regions"):
        raise ValueError(f"separation = {separation!r} must be 'none', 'radius' or 'regions'")
    if not radius > 0.0 or not 0.0 < fraction < 1.0:
        raise ValueError(f"radius = {radius} must be positive, fraction = {fraction} in (0, 1)")
    rows = np.arange(len(times))
    if window is not None:
        rows = np.flatnonzero((times >= window[0]) & (times <= window[1]))
    chosen = np.arange(len(body.nodes)) if nodes is None else np.unique(nodes)
    if surface_only:
        chosen = np.intersect1d(chosen, body.mesh.surface_nodes)
    inside, beside = body.spider_nodes, body.nodes_beside_spiders
    if not with_spiders:
        chosen = np.setdiff1d(chosen, np.concatenate([inside, beside]))
    if len(rows) == 0 or len(chosen) == 0:
        raise ValueError(f"nothing to look at: {len(rows)} times, {len(chosen)} nodes")

    if peaks is None:
        peaks = recover_peaks(body.stress_modes, q[rows], criterion, chosen)
    elif window is not None or peaks.criterion != criterion or len(peaks.nodes) != len(body.nodes):
        raise ValueError("peaks must be of all nodes, the same criterion and the whole history")
    else:
        peaks = Peaks(criterion, chosen, peaks.values[chosen], peaks.time_indices[chosen])
    if separation == "none":
        places = peaks.order[:count].tolist()
    elif separation == "radius":
        places = _separated(body.nodes[chosen], peaks.order, radius, count)
    else:
        places = _one_a_region(body.mesh, peaks, fraction, count)
    found = peaks.nodes[places]
    at = rows[peaks.time_indices[places]]
    jumps = {
        int(row): stress_jump(body.mesh, body.material, body.displacement(q[row])[0]) for row in np.unique(at)
    }
    flags = np.where(
        np.isin(found, inside), "in spider", np.where(np.isin(found, beside), "beside spider", "")
    )
    return pd.DataFrame(
        {
            "rank": np.arange(1, len(places) + 1),
            "value": peaks.values[places],
            "node": found,
            "time": times[at],
            "x": body.nodes[found, 0],
            "y": body.nodes[found, 1],
            "z": body.nodes[found, 2],
            "flag": flags,
            "jump": [jumps[int(row)][node] for row, node in zip(at, found, strict=True)],
        }
    )
