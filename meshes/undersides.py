"""What of a shoe stands on the ground: the rectangle of its underside, and how much of it there is."""

from typing import NamedTuple

import numpy as np

from fem.body.mesh import Floats, Mesh, triangle_normals
from meshes.geometry import JOINT_CENTERS
from meshes.recognition import bores

SAME_HEIGHT = 2e-3
"""m above the underside: what of the shoe reaches no higher presses on the ground with it."""
ROUNDING = 1e-6
"""m, by which an underside may be longer than the pitch."""
WHOLE = 1e-6
"""Of the rectangle: a part that is missing in rounding alone."""
BESIDE = 1e-4
"""m along x: gap from which on two parts of an underside are two strips."""


class GroundOutline(NamedTuple):
    """Part of a shoe that stands on the ground, in its axes, m.

    Attributes
    ----------
    low, high : array (2,)
        Least and greatest x and y of the underside; where it is longer than the pitch, since lugs reach the
        ground and interleave with those of the neighbours, those of a rectangle as wide, of the same area and
        about the same middle, or as long as the pitch where the underside consists of strips.
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
    strips = _spans(corners[pressing & (downward > 0.0)][..., 0])
    pitch = pitch_of(mesh)
    if _is_longer(low, high, pitch):
        length = pitch - ROUNDING
        if len(strips) == 1:
            length = min(area / float(high[1] - low[1]), length)
        middle = float(downward[pressing] @ middles[pressing, 0]) / area
        low = np.array([middle - 0.5 * length, low[1]])
        high = np.array([middle + 0.5 * length, high[1]])
    share = min(area / float(np.prod(high - low)), 1.0)
    return GroundOutline(
        low,
        high,
        level,
        1.0 if share > 1.0 - WHOLE else share,
        float(np.diff(strips, axis=1).mean()) if len(strips) > 1 else 0.0,
    )


def is_interleaved(mesh: Mesh) -> bool:
    """Return whether a shoe's underside is longer than its pitch, as where lugs reach the ground."""
    under = mesh.nodes[mesh.nodes_of("underside"), :2]
    return _is_longer(under.min(axis=0), under.max(axis=0), pitch_of(mesh))


def _is_longer(low: Floats, high: Floats, pitch: float) -> bool:
    return bool(high[0] - low[0] > pitch + ROUNDING)


def pin_place(mesh: Mesh, end: str) -> Floats:
    """Return the middle of the front or rear pins' axis by a fit to the corners of their bores: (3,), m."""
    joints = [joint for joint in JOINT_CENTERS if joint.startswith(end)]
    corners = [mesh.nodes[np.unique(mesh.surface(f"bore {joint}")[:, :3])] for joint in joints]
    axis, point, _, _ = bores.fit_axis(corners, np.array([0.0, 1.0, 0.0]))
    middle = np.mean([0.5 * (places[:, 1].min() + places[:, 1].max()) for places in corners])
    return np.asarray(point + (middle - point[1]) / axis[1] * axis)


def pitch_of(mesh: Mesh) -> float:
    """Return the distance of front and rear pins along x, m; infinite if their bores have no names."""
    if not {f"bore {joint}" for joint in JOINT_CENTERS} <= set(mesh.surfaces):
        return np.inf
    return float(pin_place(mesh, "front")[0] - pin_place(mesh, "rear")[0])


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
