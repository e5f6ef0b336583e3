"""Ground of cells under the shoes of a track: map, points and law together."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from exudyn_crawler.case.parameters.heights import Heights
from exudyn_crawler.errors import LeftMapError
from exudyn_crawler.ground import packed
from exudyn_crawler.ground.cells import pressing, tiles
from exudyn_crawler.ground.cells.law import CellLaw
from exudyn_crawler.ground.cells.tiles import BITS, FIELDS, MEMORY, SIDE, Tiles, commit

COARSE = (3, 9)
"""Nodes along and across an underside at which forces are stored: bending moments err by 2.4 % on sand, by 6
% on two stones."""


class CellGround:
    """Cells with memory under the shoes of a track whose underside is a rectangle.

    `cell` is the side of a cell (m). `corners` are as in `ShoePoints`; the shoes `flexible` bend. The
    equations use the arrays of `shoes`. `tiles` is the map; `cover` replaces it where the shoes reach new
    ground. Only `share` of the rectangle presses on the cells, evenly spread over it. It sinks as a plate of
    width `breadth` (m), by default that of the rectangle.
    """

    def __init__(
        self,
        law: CellLaw,
        heights: Heights,
        cell: float,
        corners: ArrayLike,
        shoes: int,
        flexible: Sequence[int] = (),
        share: float = 1.0,
        breadth: float | None = None,
    ) -> None:
        heights.check_cells(cell)
        self.heights = heights
        underside = np.array(corners, dtype=float)
        sides = np.linalg.norm(np.diff(underside[:3], axis=0), axis=1)
        most = int(1.6 * np.prod(sides / cell + 4.0))
        bending = np.zeros(shoes, dtype=np.int64)
        bending[list(flexible)] = np.arange(1, 1 + len(flexible))
        constants = law.constants(breadth or float(sides.min()))
        self.shoes = pressing.ShoePoints.allocate(law.kernel, constants, underside, most, bending)
        self._share = share
        self._held = np.zeros(0, dtype=np.int64)
        self._names = np.zeros((0, 2), dtype=np.int64)
        self._take(
            Tiles(
                cell=cell,
                fresh=law.kernel.fresh,
                forgets=law.kernel.forgets,
                corner=np.zeros(2, dtype=np.int64),
                table=np.full((0, 0), -1),
                planes=np.zeros((0, SIDE * SIDE, 4)),
                memory=np.zeros((0, FIELDS)),
                loaded=np.zeros(0),
            )
        )

    def cover(self, frames: np.ndarray, before: np.ndarray) -> None:
        """Freeze the cells under the shoes, with their memory, for one step.

        `frames` (shoes, `layouts.FRAME`) are predicted for the end of the step; `before` are those of the
        last accepted step. Raises `LeftMapError` if a shoe leaves the ground with heights.
        """
        missing = tiles.cover(self._block, frames, before)
        if missing == tiles.NO_TILE:
            self._add_tiles(frames, before)
            missing = tiles.cover(self._block, frames, before)
        if missing == tiles.NO_HEIGHT:
            x, y = frames[:, 0], frames[:, 1]
            raise LeftMapError(
                f"a shoe left the measured ground: the track is at x = {x.min():.4g} to {x.max():.4g} m, "
                f"y = {y.min():.4g} to {y.max():.4g} m"
            )
        if self._share != 1.0:
            self.shoes.areas[:] *= self._share

    def press(self, frames: np.ndarray, weights: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
        """Return the wrenches (shoes, 6) on the shoes at their frames, N and N m, global.

        Moments are about the frames' origins. `weights` are those of `pressing.press`, which compiled
        equations call; the tangents are in ``shoes.tangent``.
        """
        pressing.press(self.shoes, frames, np.array(weights, dtype=float))
        return self.shoes.wrench

    def commit(self) -> None:
        """Store the memory of the last `press` in the cells: once, after a step is accepted."""
        if self._share == 1.0:
            self._held = commit(self._block, self._held)
            return
        areas = self.shoes.areas
        pressed = areas.copy()
        # cells remember how far the rectangle covered them
        areas[:] /= self._share
        self._held = commit(self._block, self._held)
        areas[:] = pressed

    def coarse_forces(self, frames: np.ndarray) -> np.ndarray:
        """Return the forces of the last `press` on the grids: ``(shoes, *COARSE, 3)``, N, shoes' axes."""
        out = np.zeros((len(self.shoes.counts), *COARSE, 3))
        pressing.coarse_forces(self.shoes, frames, out)
        return out

    def state(self) -> dict[str, np.ndarray]:
        """Return the committed memory, from which `restore` continues bit for bit.

        ``cells`` (n, 2) are columns and rows of the cells that are not fresh, in their order of storage.
        ``memory`` (n, FIELDS) is theirs, and ``held`` (m,) are those in contact.
        """
        touched = (self.tiles.memory != self._fresh(1)).any(axis=1)
        touched[self._held] = True
        (rows,) = np.nonzero(touched)
        tile, within = np.divmod(rows, SIDE * SIDE)
        cells = SIDE * self._names[tile] + np.column_stack(np.divmod(within, SIDE))
        return {"cells": cells, "memory": self.tiles.memory[rows], "held": np.searchsorted(rows, self._held)}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Restore a state as in `state`, on ground that is fresh otherwise."""
        self.tiles.memory[:] = self._fresh(len(self.tiles.memory))
        cells = state["cells"]
        self._make_tiles(map(tuple, np.unique(cells >> BITS, axis=0).tolist()))
        column, row = (cells >> BITS).T - self.tiles.corner[:, None]
        within = (cells[:, 0] & (SIDE - 1)) * SIDE + (cells[:, 1] & (SIDE - 1))
        rows = self.tiles.table[column, row] * SIDE * SIDE + within
        self.tiles.memory[rows] = state["memory"]
        self._held = rows[state["held"]]

    def press_in(self, earlier: Mapping[str, np.ndarray]) -> None:
        """Set the memory of fresh cells to the ruts of `CellTerrain.earlier`, m and Pa, without shear."""
        cells = np.column_stack((earlier["cell_column"], earlier["cell_row"]))
        nothing = np.zeros(0, np.int64)
        memory = self._fresh(len(cells))
        memory[:, MEMORY.deepest] = earlier["cell_sinkage"]
        memory[:, MEMORY.pressure] = earlier["cell_pressure"]
        self.restore({"cells": cells, "memory": memory, "held": nothing})

    def _add_tiles(self, frames: np.ndarray, before: np.ndarray) -> None:
        """Make the missing tiles below the bounds of the shoes, except for shoes that went astray."""
        rotations = frames[:, 3:12].reshape(-1, 3, 3)
        corners = frames[:, None, :2] + np.einsum("sik,ck->sci", rotations, self.shoes.corners)[..., :2]
        moved = np.abs(corners - before[:, None, :2]).max(axis=(1, 2))
        corners = corners[moved < tiles.FARTHEST]
        side = SIDE * self.tiles.cell
        low = np.floor(corners.min(axis=1) / side).astype(np.int64)
        high = np.floor(corners.max(axis=1) / side).astype(np.int64)
        wanted = {
            (i, j)
            for (i0, j0), (i1, j1) in zip(low.tolist(), high.tolist(), strict=True)
            for i in range(i0, i1 + 1)
            for j in range(j0, j1 + 1)
        }
        self._make_tiles(sorted(wanted))

    def _make_tiles(self, wanted: Iterable[tuple[int, int]]) -> None:
        """Make tiles with fresh memory, unless they exist."""
        there = set(map(tuple, self._names.tolist()))
        names = np.array([tile for tile in wanted if tile not in there], dtype=np.int64)
        if len(names) == 0:
            return
        cell = self.tiles.cell
        middles = (np.arange(SIDE) + 0.5) * cell
        x, y = (SIDE * cell * names[:, k, None] + middles for k in range(2))
        x, y = np.repeat(x, SIDE, axis=1), np.tile(y, SIDE)
        z, rise_x, rise_y = np.moveaxis(self.heights.sample(x, y), -1, 0)
        up = 1.0 / np.sqrt(1.0 + rise_x * rise_x + rise_y * rise_y)
        planes = np.stack((-rise_x * up, -rise_y * up, up, up * (z - rise_x * x - rise_y * y)), axis=-1)
        self._names = np.concatenate((self._names, names))
        memory = np.concatenate((self.tiles.memory, self._fresh(len(names) * SIDE * SIDE)))
        corner = self._names.min(axis=0)
        table = np.full(self._names.max(axis=0) - corner + 1, -1)
        table[tuple((self._names - corner).T)] = np.arange(len(self._names))
        self._take(
            self.tiles._replace(
                corner=corner,
                table=table,
                planes=np.concatenate((self.tiles.planes, planes)),
                memory=memory,
                loaded=np.zeros(len(memory)),
            )
        )

    def _take(self, larger: Tiles) -> None:
        """Replace the map by a larger one, also for compiled functions."""
        self.tiles = larger
        self._block = packed.pack(tiles.TilesUnderShoes(larger, self.shoes), tiles.UNDER_SHOES)

    def _fresh(self, count: int) -> np.ndarray:
        """Return the memory of cells that no shoe has touched."""
        memory = np.zeros((count, FIELDS))
        memory[:, MEMORY.mobilized] = self.tiles.fresh
        return memory
