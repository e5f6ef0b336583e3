"""Which cells lie under a shoe, and how much of each: its outline clipped on them, seen from above."""

import math

import numpy as np

from exudyn_crawler.ground.cells.kernel import (
    AREA,
    BEFORE,
    GROUND,
    NORMAL,
    ShoePoints,
    frame_at,
    prepare_shoes,
)
from exudyn_crawler.ground.cells.tiles import BITS, SIDE, Tiles, gather
from exudyn_crawler.ground.frames import FACING, Frame, along, compiled, turned, within
from exudyn_crawler.ground.rotations import FloatArray, IntArray

LEAST = 1e-9
"""Share of a cell below which a part of it is left out."""
NO_TILE, NO_HEIGHT = -1, -2
"""In place of a number of points: a tile has to be made first; a shoe is beyond all heights."""


@compiled
def cover(ground: tuple, values: tuple, frames: FloatArray, before: FloatArray) -> int:
    """List the points of all shoes, with the memory below; return their number, `NO_TILE` or `NO_HEIGHT`.

    Parameters
    ----------
    ground, values : tuple
        `Tiles` and `ShoePoints` as plain tuples.
    frames : array (shoes, FRAME)
        For the outline: those predicted for the end of the step.
    before : array (shoes, FRAME)
        When the last step was accepted: slip counts from there.
    """
    tiles, shoes = Tiles(*ground), ShoePoints(*values)
    polygons, total, cell = np.empty((3, 12, 2)), 0, tiles.cell
    for s in range(shoes.counts.shape[0]):
        quad, frame, count = polygons[0], frame_at(frames[s]), 0
        if frame.R[2][2] < FACING:
            shoes.counts[s] = 0
            continue
        for a in range(4):
            corner = shoes.corners[a]
            place = along(frame.r, 1.0, turned(frame.R, (corner[0], corner[1], corner[2])))
            quad[a, 0], quad[a, 1] = place[0], place[1]
        low, high = quad[:4, 0].min(), quad[:4, 0].max()
        points, index = shoes.points[s], shoes.cells[s]
        for i in range(int(math.floor(low / cell)), int(math.floor(high / cell)) + 1):
            count = _cover_column(tiles, i, polygons, points, index, count)
            if count < 0:
                return count
        _place_points(points[:count], shoes.corners[0, 2], frame, frame_at(before[s]))
        shoes.counts[s] = count
        total += count
    gather(ground, values)
    prepare_shoes(values)
    return total


@within
def _cover_column(
    tiles: Tiles, i: int, polygons: FloatArray, points: FloatArray, index: IntArray, count: int
) -> int:
    """Add the points of a shoe in one column of cells; return their number as `cover` does.

    The outline is clipped to the column's strip, and this to the cells at its border; `polygons` (3, 12, 2)
    has the outline, and scratch.
    """
    h, scratch, strip, part = tiles.cell, polygons[1], polygons[2], polygons[0, 4:]
    xa, xb = i * h, (i + 1) * h
    m = _clip(polygons[0], 4, scratch, (0, 1.0, xa))
    m = _clip(scratch, m, strip, (0, -1.0, -xb))
    if m < 3:
        return count
    low, high = math.inf, -math.inf
    # the range of y that the strip has along its whole width: cells within are covered fully
    low_a, high_a, low_b, high_b = math.inf, -math.inf, math.inf, -math.inf
    for a in range(m):
        x, y = strip[a, 0], strip[a, 1]
        low, high = min(low, y), max(high, y)
        if x <= xa + 1e-12:
            low_a, high_a = min(low_a, y), max(high_a, y)
        if x >= xb - 1e-12:
            low_b, high_b = min(low_b, y), max(high_b, y)
    full_low, full_high = max(low_a, low_b), min(high_a, high_b)
    column = (i >> BITS) - tiles.corner[0]
    for j in range(int(math.floor(low / h)), int(math.floor(high / h)) + 1):
        ya, yb = j * h, (j + 1) * h
        x, y = 0.5 * (xa + xb), 0.5 * (ya + yb)
        area, cx, cy = h * h, x, y
        if not (ya >= full_low and yb <= full_high):
            k = _clip(strip, m, scratch, (1, 1.0, ya))
            k = _clip(scratch, k, part, (1, -1.0, -yb))
            area, cx, cy = _centroid(part, k, (x, y))
            if area <= LEAST * h * h:
                continue
        tile, row = -1, (j >> BITS) - tiles.corner[1]
        if 0 <= column < tiles.table.shape[0] and 0 <= row < tiles.table.shape[1]:
            tile = tiles.table[column, row]
        if tile < 0:
            return NO_TILE
        of_tile = (i & (SIDE - 1)) * SIDE + (j & (SIDE - 1))
        z, rise_x, rise_y = (
            tiles.heights[tile, of_tile, 0],
            tiles.heights[tile, of_tile, 1],
            tiles.heights[tile, of_tile, 2],
        )
        if math.isnan(z):
            return NO_HEIGHT
        up = 1.0 / math.sqrt(1.0 + rise_x * rise_x + rise_y * rise_y)
        # seen from above until `_place_points`
        points[count, 0], points[count, 1] = cx, cy
        points[count, NORMAL], points[count, NORMAL + 1], points[count, NORMAL + 2] = (
            -rise_x * up,
            -rise_y * up,
            up,
        )
        points[count, GROUND] = up * (z - rise_x * x - rise_y * y)
        points[count, AREA] = area / up
        index[count] = tile * SIDE * SIDE + of_tile
        count += 1
    return count


@within
def _clip(source: FloatArray, m: int, target: FloatArray, side: tuple[int, float, float]) -> int:
    """Clip a polygon of m vertices to ``sign x[axis] >= limit``; return the number of vertices left."""
    axis, sign, limit = side
    k = 0
    for a in range(m):
        b = a + 1 if a + 1 < m else 0
        da, db = sign * source[a, axis] - limit, sign * source[b, axis] - limit
        if da >= 0.0:
            target[k, 0], target[k, 1] = source[a, 0], source[a, 1]
            k += 1
        if (da >= 0.0) != (db >= 0.0):
            t = da / (da - db)
            target[k, 0] = source[a, 0] + t * (source[b, 0] - source[a, 0])
            target[k, 1] = source[a, 1] + t * (source[b, 1] - source[a, 1])
            target[k, axis] = sign * limit
            k += 1
    return k


@within
def _centroid(polygon: FloatArray, m: int, about: tuple[float, float]) -> tuple[float, float, float]:
    """Area and centroid of a polygon, summed about a place near it."""
    total, sx, sy = 0.0, 0.0, 0.0
    for a in range(m):
        b = a + 1 if a + 1 < m else 0
        xa, ya = polygon[a, 0] - about[0], polygon[a, 1] - about[1]
        xb, yb = polygon[b, 0] - about[0], polygon[b, 1] - about[1]
        c = xa * yb - xb * ya
        total, sx, sy = total + c, sx + c * (xa + xb), sy + c * (ya + yb)
    if total == 0.0:
        return 0.0, about[0], about[1]
    return 0.5 * abs(total), about[0] + sx / (3.0 * total), about[1] + sy / (3.0 * total)


@within
def _place_points(points: FloatArray, z: float, frame: Frame, before: Frame) -> None:
    """Turn the places of a shoe's points, seen from above, into those in its frame, and where these were."""
    R = frame.R
    x0, y0 = frame.r[0] + R[0][2] * z, frame.r[1] + R[1][2] * z
    scale = 1.0 / (R[0][0] * R[1][1] - R[0][1] * R[1][0])
    for a in range(points.shape[0]):
        x, y = points[a, 0] - x0, points[a, 1] - y0
        X, Y = scale * (R[1][1] * x - R[0][1] * y), scale * (R[0][0] * y - R[1][0] * x)
        points[a, 0], points[a, 1], points[a, 2] = X, Y, z
        place = along(before.r, 1.0, turned(before.R, (X, Y, z)))
        points[a, BEFORE], points[a, BEFORE + 1], points[a, BEFORE + 2] = place[0], place[1], place[2]
