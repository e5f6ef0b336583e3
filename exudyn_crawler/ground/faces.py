"""Nearest points of a unit's rectangular top face, which the engine makes of two triangles."""

import math
from typing import NamedTuple

from exudyn_crawler.ground.frames import compiled, within

FACE, EDGE, CORNER = 0.0, 1.0, 2.0
"""What a sphere touches."""


class Nearest(NamedTuple):
    """Nearest point of a face in the unit's axes (m), direction of the edge it is on, and what it is."""

    x: float
    y: float
    edge_x: float
    edge_y: float
    kind: float


@within
def _on_segment(x: float, y: float, ax: float, ay: float, bx: float, by: float) -> tuple[float, Nearest]:
    """Squared distance and nearest point of a segment from a to b."""
    dx, dy = bx - ax, by - ay
    s = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)
    kind = EDGE if 0.0 < s < 1.0 else CORNER
    s = min(1.0, max(0.0, s))
    px, py = ax + s * dx, ay + s * dy
    length = math.sqrt(dx * dx + dy * dy)
    return (x - px) ** 2 + (y - py) ** 2, Nearest(px, py, dx / length, dy / length, kind)


@within
def _on_triangle(x: float, y: float, half_x: float, half_y: float, side: float) -> Nearest:
    """Nearest edge point of half a face to a point outside it: `side` 1 the half at +x, -1 that at +y.

    Both halves share the corners (-, -) and (+, +).
    """
    bx, by = side * half_x, -side * half_y
    best, found = _on_segment(x, y, -half_x, -half_y, bx, by)
    distance, other = _on_segment(x, y, bx, by, half_x, half_y)
    if distance < best:
        best, found = distance, other
    distance, other = _on_segment(x, y, half_x, half_y, -half_x, -half_y)
    return other if distance < best else found


@compiled
def nearest_on_face(x: float, y: float, half_x: float, half_y: float) -> tuple[int, Nearest, Nearest]:
    """Nearest points of the two triangles of a rectangle about the origin: how many there are, and which."""
    if abs(x) <= half_x and abs(y) <= half_y:
        face = Nearest(x, y, 0.0, 0.0, FACE)
        return 1, face, face
    first = _on_triangle(x, y, half_x, half_y, 1.0)
    second = _on_triangle(x, y, half_x, half_y, -1.0)
    apart = (first.x - second.x) ** 2 + (first.y - second.y) ** 2
    return 1 if apart < 1e-20 else 2, first, second
