"""Map of the ground: planes and memory of its cells, in tiles that are made where a shoe first arrives.

Cell (i, j) is the square from (i, j) to (i + 1, j + 1) times its side. A tile is 32 x 32 cells. Only `gather`
reads the memory and only `commit` writes it, so that a rejected step needs no undo. The cells under a shoe,
and the covered area of each, seen from above, are sums over the edges of its outline.
"""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground import columns, packed
from exudyn_crawler.ground.cells.law import call_at
from exudyn_crawler.ground.cells.layouts import BLOCK, POINT, TRIAL, frame_at, triple_of
from exudyn_crawler.ground.cells.pressing import ShoePoints
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.frames import FACING, Frame, along, turned
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Floats3, IntArray, Ints1, Ints2

BITS = 5
SIDE = 1 << BITS
"""Cells along a side of a tile."""
LEAST = 1e-9
"""Smallest covered share of a cell that counts."""
FARTHEST = 100.0
"""Distance (m) along x or y from its earlier position beyond which a shoe meets no ground.

No step is that long: Newton's method went astray, and a map of all tiles up to there would fill the memory.
"""
NO_TILE, NO_HEIGHT = -1, -2
"""Flags instead of a number of points: NO_TILE, a tile must be made first; NO_HEIGHT, a shoe is beyond all
heights."""


class MemoryColumns(NamedTuple):
    """First columns of the memory of a cell."""

    deepest: columns.Number  # greatest sinkage, m
    pressure: columns.Number  # Pa, there
    shear: columns.Pair  # stress along x and y, Pa: the mean over the area
    mobilized: columns.Number  # share of the strength
    area: columns.Number  # greatest one under load since the contact began, m2


MEMORY = columns.columns_of(MemoryColumns)
FIELDS = columns.width_of(MemoryColumns)
"""Number of values in a cell's memory."""


class Tiles(NamedTuple):
    """Map as arrays; a larger one replaces it where tiles are added."""

    cell: float  # side of a cell, m
    fresh: float  # mobilized share of fresh ground
    forgets: bool  # True if cells without contact forget their sinkage
    corner: Ints1  # (2,): tile of the first entry of the table
    table: Ints2  # (columns, rows): number of a tile, -1 where there is none
    # (tiles, SIDE * SIDE, 4): normals of cells, and distances from the origin along these, m; NaN where there
    # is no height
    planes: Floats3
    memory: Floats2  # (tiles * SIDE * SIDE, FIELDS)
    loaded: Floats1  # (tiles * SIDE * SIDE,): loaded area of a cell, zero between calls


class TilesUnderShoes(NamedTuple):
    """Map with the points of the shoes on it."""

    tiles: Tiles
    shoes: ShoePoints


UNDER_SHOES = packed.type_of(TilesUnderShoes)
_read = packed.reader(UNDER_SHOES)


@inner
def gather(tiles: Tiles, shoes: ShoePoints) -> None:
    """Write the cells' committed memory beside the points; `tiles.loaded` holds the sums of their areas.

    If a cell is covered further than ever since its contact began, the new part is unsheared, and the shear
    becomes the mean of both. This is exact for Janosi's curve, since its ``1 - share`` decays alike
    everywhere.
    """
    memory = tiles.memory
    loaded = tiles.loaded
    for s in range(shoes.counts.shape[0]):
        cells = shoes.cells[s]
        count = shoes.counts[s]
        for a in range(count):
            cell = cells[a]
            points = shoes.points[s, a // BLOCK]
            k = a % BLOCK
            before = memory[cell, MEMORY.area]
            now = loaded[cell]
            share = before / now if now > before > 0.0 else 1.0
            x, y = share * memory[cell, MEMORY.shear], share * memory[cell, MEMORY.shear + 1]
            nx, ny, nz = triple_of(points, POINT.normal, k)
            points[POINT.deepest, k] = memory[cell, MEMORY.deepest]
            points[POINT.pressure, k] = memory[cell, MEMORY.pressure]
            points[POINT.shear, k] = x
            points[POINT.shear + 1, k] = y
            points[POINT.shear + 2, k] = -(nx * x + ny * y) / nz
            points[POINT.mobilized, k] = tiles.fresh + share * (memory[cell, MEMORY.mobilized] - tiles.fresh)
        call_at(shoes.addresses[0], shoes.constants, count, shoes.points[s])
    for s in range(shoes.counts.shape[0]):
        for a in range(shoes.counts[s]):
            loaded[shoes.cells[s, a]] = 0.0


@kernel
def cover(block: IntArray, frames: FloatArray, before: FloatArray) -> int:
    """List the points of all shoes, with the memory below; return their number, `NO_TILE` or `NO_HEIGHT`.

    `block` are packed `TilesUnderShoes`. The outlines are at `frames` (shoes, FRAME); slip counts from
    `before`.
    """
    tiles = _read(block).tiles
    shoes = _read(block).shoes
    outline = np.empty((4, 2))
    total = 0
    for s in range(shoes.counts.shape[0]):
        frame = frame_at(frames[s])
        was = frame_at(before[s])
        meets = frame.R[2][2] >= FACING
        for a in range(4):
            corner = shoes.corners[a]
            place = along(frame.r, 1.0, turned(frame.R, (corner[0], corner[1], corner[2])))
            outline[a, 0] = place[0] / tiles.cell
            outline[a, 1] = place[1] / tiles.cell
            meets = meets and abs(place[0] - was.r[0]) < FARTHEST and abs(place[1] - was.r[1]) < FARTHEST
        count = _cover_shoe(tiles, shoes, s, outline, frame, was) if meets else 0
        if count < 0:
            tiles.loaded.fill(0.0)
            return count
        shoes.counts[s] = count
        total += count
    gather(tiles, shoes)
    return total


@inner(allocates=True)
def _sums(outline: FloatArray, i: int, j: int) -> FloatArray:
    """Return sums over the edges of an outline (4, 2), in cells, for the cells from (i, j) on.

    By Green's theorem an edge is the lower bound of a part of each cell that it passes, and of all cells
    above. Array (columns, rows, 5): in the cell, area and its moments along x and y about the cell's corner;
    in each cell above, area and its moment along x.
    """
    columns = int(math.floor(outline[:, 0].max())) - i + 1
    rows = int(math.floor(outline[:, 1].max())) - j + 1
    sums = np.zeros((columns, rows, 5))
    for a in range(4):
        b = a + 1 if a < 3 else 0
        x, y = outline[a, 0] - i, outline[a, 1] - j
        dx = outline[b, 0] - i - x
        dy = outline[b, 1] - j - y
        column = int(x)
        row = int(y)
        t = 0.0
        while t < 1.0:
            # end of the edge in the cell: rounding never moves it out of the outline's bounds
            at_x = ((column + 1 if dx > 0.0 else column) - x) / dx if dx != 0.0 else math.inf
            at_y = ((row + 1 if dy > 0.0 else row) - y) / dy if dy != 0.0 else math.inf
            ahead = min(at_x, at_y, 1.0)
            width = (ahead - t) * dx
            rise = (ahead - t) * dy
            middle = 0.5 * (ahead + t)
            left = x + middle * dx - column
            under = y + middle * dy - row
            sums[column, row, 0] += width * (1.0 - under)
            sums[column, row, 1] += width * (left * (1.0 - under) - width * rise / 12.0)
            sums[column, row, 2] += 0.5 * width * (1.0 - under * under - rise * rise / 12.0)
            sums[column, row, 3] += width
            sums[column, row, 4] += width * left
            t = ahead
            if at_x <= at_y:
                column += 1 if dx > 0.0 else -1
            else:
                row += 1 if dy > 0.0 else -1
    return sums


@inner(allocates=True)
def _cover_shoe(
    tiles: Tiles, shoes: ShoePoints, s: int, outline: FloatArray, frame: Frame, before: Frame
) -> int:
    """List the points of a shoe, and add their areas to `tiles.loaded`; return their number as in `cover`."""
    points = shoes.points[s]
    areas = shoes.areas[s]
    cells = shoes.cells[s]
    h = tiles.cell
    z = shoes.corners[0, 2]
    R = frame.R
    count = 0
    tile = -1
    x0, y0 = frame.r[0] + R[0][2] * z, frame.r[1] + R[1][2] * z
    scale = 1.0 / (R[0][0] * R[1][1] - R[0][1] * R[1][0])
    first = int(math.floor(outline[:, 0].min())), int(math.floor(outline[:, 1].min()))
    sums = _sums(outline, first[0], first[1])
    for c in range(sums.shape[0]):
        i = first[0] + c
        below = 0.0
        moment = 0.0
        column = (i >> BITS) - tiles.corner[0]
        for k in range(sums.shape[1]):
            j = first[1] + k
            if k == 0 or j & (SIDE - 1) == 0:
                row = (j >> BITS) - tiles.corner[1]
                inside = 0 <= column < tiles.table.shape[0] and 0 <= row < tiles.table.shape[1]
                tile = tiles.table[column, row] if inside else -1
            area = below + sums[c, k, 0]
            x = moment + sums[c, k, 1]
            y = 0.5 * below + sums[c, k, 2]
            below = below + sums[c, k, 3]
            moment = moment + sums[c, k, 4]
            if area <= LEAST:
                continue
            if tile < 0:
                return NO_TILE
            of_tile = (i & (SIDE - 1)) * SIDE + (j & (SIDE - 1))
            if math.isnan(tiles.planes[tile, of_tile, 3]):
                return NO_HEIGHT
            block = points[count // BLOCK]
            slot = count % BLOCK
            for m in range(3):
                block[POINT.normal + m, slot] = tiles.planes[tile, of_tile, m]
            block[POINT.ground, slot] = tiles.planes[tile, of_tile, 3]
            cell = tile * SIDE * SIDE + of_tile
            true = h * h * area / tiles.planes[tile, of_tile, 2]
            cells[count] = cell
            areas[count] = true
            tiles.loaded[cell] += true
            x, y = h * (i + x / area) - x0, h * (j + y / area) - y0
            X, Y = scale * (R[1][1] * x - R[0][1] * y), scale * (R[0][0] * y - R[1][0] * x)
            place = (X, Y, z)
            was = along(before.r, 1.0, turned(before.R, place))
            for m in range(3):
                block[POINT.place + m, slot] = place[m]
                block[POINT.before + m, slot] = was[m]
            count += 1
    return count


@inner
def _touches(point: FloatArray, forgets: bool) -> bool:
    """Return True if a point (TRIAL_WIDTH,) is in contact with its cell.

    Contact lasts while the point presses or shears the cell; on ground that forgets, while it is below the
    first height.
    """
    sticks = point[TRIAL.shear] != 0.0 or point[TRIAL.shear + 1] != 0.0
    return sticks or point[TRIAL.traction] > 0.0 or (forgets and point[TRIAL.deepest] > 0.0)


@inner
def _sink(remembered: FloatArray, point: FloatArray, afresh: bool) -> None:
    """Write a point's sinkage into the memory (FIELDS,) of its cell, unless the stored one is deeper.

    With `afresh` the memory of an earlier contact does not count.
    """
    if afresh or point[TRIAL.deepest] > remembered[MEMORY.deepest]:
        remembered[MEMORY.deepest] = point[TRIAL.deepest]
        remembered[MEMORY.pressure] = point[TRIAL.pressure]


@inner
def _shear(remembered: FloatArray, point: FloatArray, area: float, total: float) -> None:
    """Include a point's `area` (m2) in the mean shear of its cell, over a `total` area with this one."""
    for k in range(2):
        more = point[TRIAL.shear + k] - remembered[MEMORY.shear + k]
        remembered[MEMORY.shear + k] += more * area / total
    more = point[TRIAL.mobilized] - remembered[MEMORY.mobilized]
    remembered[MEMORY.mobilized] += more * area / total


@inner
def _release(remembered: FloatArray, mobilized: float) -> None:
    """Remove the shear from the memory of a cell, and set the mobilized share of its strength."""
    remembered[MEMORY.shear] = 0.0
    remembered[MEMORY.shear + 1] = 0.0
    remembered[MEMORY.mobilized] = mobilized


@inner
def _leave(remembered: FloatArray, fresh: float, forgets: bool) -> None:
    """Reset the parts of a cell's memory that end with its contact."""
    _release(remembered, fresh)
    remembered[MEMORY.area] = 0.0
    if forgets:
        remembered[MEMORY.deepest] = 0.0
        remembered[MEMORY.pressure] = 0.0


@kernel
def commit(block: IntArray, held: IntArray) -> IntArray:
    """Write the trial memory into the cells of packed `TilesUnderShoes`; return the cells in contact now.

    A cell under two shoes keeps the deeper sinkage and the mean shear by area, which loses energy and never
    makes it. A cell without pressure, or left by all shoes, releases its shear. Soil keeps its deepest
    sinkage for good; ground that forgets keeps that of the present contact. `held` are the cells in contact
    when the last step was accepted.
    """
    tiles = _read(block).tiles
    shoes = _read(block).shoes
    memory = tiles.memory
    loaded = tiles.loaded
    now = np.empty(shoes.counts.sum(), dtype=np.int64)
    count = 0
    for s in range(shoes.counts.shape[0]):
        for a in range(shoes.counts[s]):
            cell = shoes.cells[s, a]
            point = shoes.trial[s, a]
            touches = _touches(point, tiles.forgets)
            begins = touches and loaded[cell] == 0.0
            _sink(memory[cell], point, begins and tiles.forgets)
            if not touches:
                continue
            if begins:
                _release(memory[cell], 0.0)
                now[count] = cell
                count += 1
            loaded[cell] += shoes.areas[s, a]
            _shear(memory[cell], point, shoes.areas[s, a], loaded[cell])
    for cell in held:
        if loaded[cell] == 0.0:
            _leave(memory[cell], tiles.fresh, tiles.forgets)
    for cell in now[:count]:
        memory[cell, MEMORY.area] = max(memory[cell, MEMORY.area], loaded[cell])
        loaded[cell] = 0.0
    return now[:count]
