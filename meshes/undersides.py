"""What of a shoe stands on the ground: the rectangle of its underside, and how much of it there is."""

from typing import NamedTuple

import numpy as np

from fem.body.mesh import Floats, Mesh, triangle_normals

SAME_HEIGHT = 2e-3
"""m above the underside: what of the shoe reaches no higher presses on the ground with it."""
WHOLE = 1e-6
"""Of the rectangle: a part that is missing in rounding alone."""
BESIDE = 1e-4
"""m along x: gap from which on two parts of an underside are two strips."""


class GroundOutline(NamedTuple):
    """Part of a shoe that stands on the ground, in its axes, m.

    Attributes
    ----------
    low, high : array (2,)
        Least and greatest x and y of the underside.
    level : float
        z of most of its area: of a plate, below which grousers at its edges belong to it.
    share : float
        Part of its rectangle that presses on the ground, without holes and gaps; what reaches below the
        underside, such as grousers that are sunk in, presses with it.
    strip_length : float
        Mean length in x of the strips that it consists of, such as tips of grousers; 0 if it is one surface.
    """

    low: Floats
    high: Floats
    level: float
    share: float
    strip_length: float


def ground_outline(mesh: Mesh) -> GroundOutline:
    """Outline of what of a shoe's mesh stands on the ground.

    Raises
    ------
    ValueError
        If the mesh has no surface "underside".
    """
    under = mesh.nodes[mesh.nodes_of("underside")]
    low = under[:, :2].min(axis=0)
    high = under[:, :2].max(axis=0)
    level = _level(mesh.nodes[mesh.surface("underside")[:, :3]])
    corners = mesh.nodes[mesh.boundary[:, :3]]
    downward = -0.5 * triangle_normals(corners)[:, 2]
    middles = corners.mean(axis=1)[:, :2]
    pressing = (corners[..., 2] <= max(level, under[:, 2].max()) + SAME_HEIGHT).all(axis=1)
    pressing &= ((middles >= low) & (middles <= high)).all(axis=1)
    area = float(downward[pressing].sum())
    share = min(area / float(np.prod(high - low)), 1.0)
    strips = _spans(corners[pressing & (downward > 0.0)][..., 0])
    return GroundOutline(
        low,
        high,
        level,
        1.0 if share > 1.0 - WHOLE else share,
        float(np.diff(strips, axis=1).mean()) if len(strips) > 1 else 0.0,
    )


def _level(corners: Floats) -> float:
    """Least z of what of triangles with corners (n, 3, 3) is level with most of their area, m."""
    areas = np.linalg.norm(triangle_normals(corners), axis=1)
    heights = corners[..., 2].min(axis=1)
    order = np.argsort(heights)
    share = np.cumsum(areas[order])
    most = heights[order][np.searchsorted(share, 0.5 * share[-1])]
    return float(heights[heights > most - SAME_HEIGHT].min())


def _spans(x: Floats) -> Floats:
    """Ends (k, 2) of the parts that triangles with corners at x (n, 3) cover without a gap, m."""
    ends = np.stack((x.min(axis=1), x.max(axis=1)), axis=1)
    ends = ends[np.argsort(ends[:, 0])]
    reach = np.maximum.accumulate(ends[:, 1])
    first = np.concatenate(([True], ends[1:, 0] > reach[:-1] + BESIDE))
    last = np.concatenate((first[1:], [True]))
    return np.stack((ends[first, 0], reach[last]), axis=1)
