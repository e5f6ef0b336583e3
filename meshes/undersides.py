"""Ground outline of a shoe: the rectangle of its underside, and the part of it that presses."""

from typing import NamedTuple

import numpy as np

from fem.body.mesh import Floats, Mesh, triangle_normals
from meshes.geometry import JOINT_CENTERS
from meshes.recognition import bores

SAME_HEIGHT = 2e-3
"""Height above the underside, m, up to which parts of the shoe press on the ground with it."""
ROUNDING = 1e-6
"""Tolerance of an underside longer than the pitch, m."""
WHOLE = 1e-6
"""Missing share of the rectangle that counts as rounding."""
BESIDE = 1e-4
"""Least gap along x between two strips of an underside, m."""


class GroundOutline(NamedTuple):
    """Part of a shoe that stands on the ground, in the shoe's axes, m.

    Attributes
    ----------
    low, high : array (2,)
        Least and greatest x and y of the underside. If lugs reach the ground, they interleave with the
        neighbours', and the underside is longer than the pitch. A rectangle of the same width, area and
        middle then replaces it; of strips, it is as long as the pitch.
    level : float
        z of most of the underside's area: the plate; grousers at the plate's edges belong to the underside.
    share : float
        Fraction of the rectangle that presses on the ground, without holes and gaps. Parts below the
        underside, such as sunk grousers, press too.
    strip_length : float
        Mean length in x of the underside's strips, such as grouser tips; 0 if it is one surface.
    """

    low: Floats
    high: Floats
    level: float
    share: float
    strip_length: float


def ground_outline(mesh: Mesh) -> GroundOutline:
    """Return the outline of a shoe mesh's part that stands on the ground.

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
    """Return True if a shoe's underside is longer than its pitch, since lugs reach the ground."""
    under = mesh.nodes[mesh.nodes_of("underside"), :2]
    return _is_longer(under.min(axis=0), under.max(axis=0), pitch_of(mesh))


def _is_longer(low: Floats, high: Floats, pitch: float) -> bool:
    return bool(high[0] - low[0] > pitch + ROUNDING)


def pin_place(mesh: Mesh, end: str) -> Floats:
    """Return the middle of the front or rear pins' axis, fitted to the corners of their bores: (3,), m."""
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
    """Return the least z of triangles with corners (n, 3, 3) level with most of their area, m."""
    areas = np.linalg.norm(triangle_normals(corners), axis=1)
    heights = corners[..., 2].min(axis=1)
    order = np.argsort(heights)
    share = np.cumsum(areas[order])
    most = heights[order][np.searchsorted(share, 0.5 * share[-1])]
    return float(heights[heights > most - SAME_HEIGHT].min())


def _spans(x: Floats) -> Floats:
    """Return the ends (k, 2) of the parts that triangles with corners at x (n, 3) cover without a gap, m."""
    ends = np.stack((x.min(axis=1), x.max(axis=1)), axis=1)
    ends = ends[np.argsort(ends[:, 0])]
    reach = np.maximum.accumulate(ends[:, 1])
    first = np.concatenate(([True], ends[1:, 0] > reach[:-1] + BESIDE))
    last = np.concatenate((first[1:], [True]))
    return np.stack((ends[first, 0], reach[last]), axis=1)
