"""Map of the ground: planes and memory of its cells, in tiles that are made where a shoe first comes.

Cell (i, j) is the square from (i, j) to (i + 1, j + 1) times its side. A tile is 32 x 32 of them. Only
`gather` reads the memory and only `commit` writes it: a step that is not accepted needs nothing undone.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.cells.kernel import BLOCK, DEEPEST, MOBILIZED, NORMAL, SHEAR, TRACTION, ShoePoints
from exudyn_crawler.ground.cells.law import call_at
from exudyn_crawler.ground.frames import compiled, within
from exudyn_crawler.ground.rotations import FloatArray, IntArray

BITS = 5
SIDE = 1 << BITS
"""Cells along a side of a tile."""
FIELDS = 6
"""Memory of a cell: greatest sinkage (m) and the pressure there (Pa), shear stress along x and y (Pa),
mobilized share of the strength, and the greatest area under load since the contact began (m2), over which the
shear is the mean."""


class Tiles(NamedTuple):
    """The map as arrays; a larger one takes its place where tiles are added."""

    cell: float  # side of a cell, m
    fresh: float  # mobilized share of fresh ground
    forgets: bool  # whether cells that are left forget their sinkage
    corner: IntArray  # (2,): tile of the first entry of the table
    table: IntArray  # (columns, rows): number of a tile, -1 where there is none
    # (tiles, SIDE * SIDE, 4): normals of cells, and distances from the origin along these, m; NaN where there
    # is no height
    planes: FloatArray
    memory: FloatArray  # (tiles * SIDE * SIDE, FIELDS)
    loaded: FloatArray  # (tiles * SIDE * SIDE,): loaded area of a cell, zero between calls


@within
def gather(tiles: Tiles, shoes: ShoePoints) -> None:
    """Write the cells' committed memory beside the points, whose areas `tiles.loaded` has summed.

    Where a cell is covered further than ever since its contact began, the fresh part is unsheared, and the
    shear becomes the mean of both. This is exact for Janosi's curve, whose ``1 - share`` decays alike
    everywhere.
    """
    memory, loaded = tiles.memory, tiles.loaded
    for s in range(shoes.counts.shape[0]):
        points, cells, count = shoes.points[s], shoes.cells[s], shoes.counts[s]
        for a in range(count):
            cell, block, k = cells[a], a // BLOCK, a % BLOCK
            before, now = memory[cell, 5], loaded[cell]
            share = before / now if now > before > 0.0 else 1.0
            x, y = share * memory[cell, 2], share * memory[cell, 3]
            points[block, DEEPEST, k], points[block, DEEPEST + 1, k] = memory[cell, 0], memory[cell, 1]
            points[block, SHEAR, k], points[block, SHEAR + 1, k] = x, y
            rise = points[block, NORMAL, k] * x + points[block, NORMAL + 1, k] * y
            points[block, SHEAR + 2, k] = -rise / points[block, NORMAL + 2, k]
            points[block, MOBILIZED, k] = tiles.fresh + share * (memory[cell, 4] - tiles.fresh)
        call_at(shoes.addresses[0], shoes.constants, count, points)
    for s in range(shoes.counts.shape[0]):
        for a in range(shoes.counts[s]):
            loaded[shoes.cells[s, a]] = 0.0


@compiled
def commit(ground: tuple, values: tuple, held: IntArray) -> IntArray:
    """Write the trial memory into the cells; return the cells in contact now.

    A cell under two shoes keeps the deeper sinkage and the mean shear by area, which loses energy and never
    makes it. A cell that all shoes have left, or without pressure, releases its shear. `ground` and `values`
    are `Tiles` and `ShoePoints` as plain tuples, `held` the cells that were in contact when the last step was
    accepted.
    """
    tiles, shoes = Tiles(*ground), ShoePoints(*values)
    memory, loaded = tiles.memory, tiles.loaded
    now, count = np.empty(shoes.counts.sum(), dtype=np.int64), 0
    for s in range(shoes.counts.shape[0]):
        trial, cells, areas = shoes.trial[s], shoes.cells[s], shoes.areas[s]
        for a in range(shoes.counts[s]):
            cell, area, deepest = cells[a], areas[a], trial[a, 0]
            sticks = trial[a, 2] != 0.0 or trial[a, 3] != 0.0
            meets = sticks or trial[a, TRACTION] > 0.0 or (tiles.forgets and deepest > 0.0)
            total = loaded[cell] + area
            first = meets and total == area
            if deepest > memory[cell, 0] or (first and tiles.forgets):
                memory[cell, 0], memory[cell, 1] = deepest, trial[a, 1]
            if not meets:
                continue
            if first:
                memory[cell, 2], memory[cell, 3], memory[cell, 4] = 0.0, 0.0, 0.0
                now[count] = cell
                count += 1
            for k in range(2, 5):
                memory[cell, k] += (trial[a, k] - memory[cell, k]) * area / total
            loaded[cell] = total
    for cell in held:
        if loaded[cell] == 0.0:
            memory[cell, 2], memory[cell, 3], memory[cell, 4], memory[cell, 5] = 0.0, 0.0, tiles.fresh, 0.0
            if tiles.forgets:
                memory[cell, 0], memory[cell, 1] = 0.0, 0.0
    for cell in now[:count]:
        memory[cell, 5] = max(memory[cell, 5], loaded[cell])
        loaded[cell] = 0.0
    return now[:count]
