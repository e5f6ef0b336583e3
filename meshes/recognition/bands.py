"""Level parts of a shoe's surface, and the two rails of the roller path among them."""

import numpy as np

from fem.body.mesh import Floats, Integers
from meshes.recognition.triangles import Triangles

LEVEL = np.radians(0.2)
NEARLY = np.radians(2.0)
"""Angles of level faces, and of faces that count as level if there are few: cast, or with few digits."""
LARGE = 0.3
"""Least share of level area in the nearly level area for the level faces to count alone."""
SAME_HEIGHT = 2e-3
"""Height tolerance of parts of one surface, m."""
RAIL_FILL = 0.8
LINK_FILL = 0.4
"""Least area of a rail over its outline. The second value is for rails of links from pin to pin, with front
and rear halves side by side."""
LINK_LENGTH = 0.75
"""Least length of such a rail, fraction of the pitch."""
EQUAL_RAILS = 1e-3
"""Tolerance between the outlines of both rails, m."""


def outline(triangles: Triangles, faces: Integers) -> Floats:
    """Return the least and greatest x, y, z of triangles: array (2, 3)."""
    places = triangles.corners[faces].reshape(-1, 3)
    return np.stack((places.min(axis=0), places.max(axis=0)))


def level_parts(local: Triangles, sign: float) -> list[Integers]:
    """Return the connected level parts that face up (1) or down (-1), the largest first."""
    upward = sign * local.normals[:, 2]
    nearly = upward > np.cos(NEARLY)
    level = upward > np.cos(LEVEL)
    if local.areas[level].sum() < LARGE * local.areas[nearly].sum():
        level = nearly
    return sorted(local.connected_regions(level), key=lambda part: -float(local.areas[part].sum()))


def _is_parted(local: Triangles, parts: list[Integers]) -> bool:
    """Return True if a gap along x separates level parts."""
    ends = np.array(sorted(tuple(outline(local, part)[:, 0]) for part in parts))
    return bool((ends[1:, 0] > np.maximum.accumulate(ends[:-1, 1]) + SAME_HEIGHT).any())


def two_rails(
    local: Triangles, parts: list[Integers], pitch: float, sign: float = 1.0
) -> tuple[Integers | None, str]:
    """Return two equal level bands, one a side, at the greatest height of the parts, or the reason for none.

    `sign` = -1 takes the least height, for a shoe that may lie upside down.
    """
    heights = np.array([sign * local.middles[part, 2].mean() for part in parts])
    highest = [part for part, z in zip(parts, heights, strict=True) if heights.max() - z < SAME_HEIGHT]
    boxes = []
    sides = []
    y = np.array([local.middles[part, 1].mean() for part in highest])
    middle = 0.5 * (y.min() + y.max())
    for side in (y < middle, y >= middle):
        chosen = [part for part, is_in in zip(highest, side, strict=True) if is_in]
        if not chosen:
            return None, "the top is one band"
        sides.append(np.concatenate(chosen))
        boxes.append(outline(local, sides[-1]))
        length, width = np.ptp(boxes[-1], axis=0)[:2]
        is_of_links = length > LINK_LENGTH * pitch
        least = LINK_FILL if is_of_links else RAIL_FILL
        if local.areas[sides[-1]].sum() < least * length * width:
            return None, "the highest level parts are no bands"
        if is_of_links and _is_parted(local, chosen):
            return None, "between the highest level parts in front and behind nothing carries a roller"
    right, left = boxes
    sizes = np.ptp(right, axis=0)[:2] - np.ptp(left, axis=0)[:2]
    if np.abs(sizes).max() > EQUAL_RAILS or np.abs(right[:, 0] - left[:, 0]).max() > EQUAL_RAILS:
        return None, "the highest level parts on the right and on the left are not equal"
    if right[1, 1] >= left[0, 1]:
        return None, "the highest level parts lie over each other"
    return np.concatenate(sides), ""
