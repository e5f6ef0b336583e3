"""Mean motion of a body's underside over any rectangle of it.

The mode shapes of the underside are integrated once over a fine grid. Their mean over a rectangle then
costs four look-ups, whatever the number of nodes.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

from fem.body.mesh import Floats, Integers
from fem.compiling import compiler

CELL = 0.03
"""Greatest side of a grid cell, m; the underside's elements are several times as large."""
BESIDE = 0.1
"""Greatest fraction of the rectangle without nodes around it, as on undersides that are not rectangles."""
FEWEST = 16
"""Least number of cells along a side: `hat_grid` finds its coarser grid from them, also if narrow."""


@dataclass(frozen=True)
class Underside:
    """Integrated mode shapes of a rectangular underside.

    Attributes
    ----------
    corner : array (2,)
        Least x and y, m, body axes.
    cell : array (2,)
        Sides of a cell, m.
    integral : array (columns + 1, rows + 1, 3, modes)
        Integral of the modes' displacements from the corner to every grid point, m2 times m per unit.
    """

    corner: Floats
    cell: Floats
    integral: Floats

    @property
    def mode_count(self) -> int:
        """Number of modes."""
        return self.integral.shape[-1]

    def rectangle_mean(self, low: Floats, high: Floats) -> tuple[Integers, Floats]:
        """Express means over rectangles as weighted sums over grid points; `mean_rows` gives the same means.

        Parameters
        ----------
        low, high : array (times, 2)
            Least and greatest x and y of the rectangles, m, body axes.

        Returns
        -------
        points : int array (times, 16)
            Numbers of grid points; y runs fastest.
        weights : array (times, 16)
            Weights of the integrals at the points, 1/m2; zero for a rectangle without area on the underside.
        """
        counts = np.array(self.integral.shape[:2]) - 1
        ends = np.stack((high, low), axis=1) - self.corner
        ends = np.clip(ends, 0.0, counts * self.cell)
        first = np.minimum((ends / self.cell).astype(int), counts - 1)
        beyond = ends / self.cell - first
        # the two grid points beside each end, along x and along y: (times, 4)
        points = np.concatenate((first, first + 1), axis=1)
        weights = np.concatenate((1.0 - beyond, beyond), axis=1) * np.array([1, -1, 1, -1])[:, None]
        area = np.prod(ends[:, 0] - ends[:, 1], axis=1)
        inverse = np.divide(1.0, area, out=np.zeros_like(area), where=area > 0.0)
        numbers = points[:, :, None, 0] * (counts[1] + 1) + points[:, None, :, 1]
        products = weights[:, :, None, 0] * weights[:, None, :, 1] * inverse[:, None, None]
        return numbers.reshape(-1, 16), products.reshape(-1, 16)


def hat_grid(underside: Underside, counts: tuple[int, int]) -> tuple[Floats, Floats]:
    """Project the modes of an underside on the hat functions of a coarse grid.

    Bilinear hat functions with the nodal values approximate each mode with the least mean square error. A
    unit force at a node then acts on the modes like a traction spread by hat functions with the same force
    and moment.

    Parameters
    ----------
    counts : tuple of int
        Nodes along x and along y.

    Returns
    -------
    nodes : array (along, across, 2)
        m, body axes.
    rows : array (along, across, 3, modes)
        Displacement of the nodes by the modes.
    """
    columns = np.array(underside.integral.shape[:2]) - 1
    sides = columns * underside.cell
    hats = []
    for k, count in enumerate(counts):
        # position of each cell's middle in meshes of the coarse grid
        place = (np.arange(columns[k]) + 0.5) / columns[k] * (count - 1)
        hats.append(np.maximum(0.0, 1.0 - np.abs(place[:, None] - np.arange(count))))
    modes = np.diff(np.diff(underside.integral, axis=0), axis=1)
    shares = np.einsum("xa,yb,xycm->abcm", hats[0], hats[1], modes, optimize=True)
    mass = np.einsum("xa,xd,yb,ye->abde", hats[0], hats[0], hats[1], hats[1], optimize=True)
    size = counts[0] * counts[1]
    rows = np.linalg.solve(mass.reshape(size, size) * underside.cell.prod(), shares.reshape(size, -1))
    along, across = (np.linspace(0.0, sides[k], counts[k]) + underside.corner[k] for k in range(2))
    nodes = np.stack(np.meshgrid(along, across, indexing="ij"), axis=-1)
    return nodes, np.ascontiguousarray(rows.reshape(shares.shape))


def integrate_underside(positions: Floats, modes: Floats, footprint: Floats) -> Underside:
    """Integrate mode shapes over a rectangular underside.

    Parameters
    ----------
    positions : array (nodes, 2)
        x and y of the underside's nodes, m, body axes.
    modes : array (nodes, 3, modes)
        Displacements of these nodes.
    footprint : array (5,)
        Least and greatest x, least and greatest y, z of the underside, m.

    Raises
    ------
    ValueError
        If the nodes leave out more than `BESIDE` of the rectangle; cells left out move with the nearest node.
    """
    low = footprint[[0, 2]]
    high = footprint[[1, 3]]
    counts = np.maximum(np.ceil((high - low) / CELL).astype(int), FEWEST)
    cell = (high - low) / counts
    x, y = (low[k] + (np.arange(counts[k]) + 0.5) * cell[k] for k in range(2))
    columns = modes.reshape(len(positions), -1)
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    values = LinearNDInterpolator(positions, columns)(places)
    is_outside = np.isnan(values).any(axis=2)
    outside = int(is_outside.sum())
    if outside:
        values[is_outside] = NearestNDInterpolator(positions, columns)(places[is_outside])
    values = values.reshape(*counts, *modes.shape[1:])
    if outside > BESIDE * counts.prod():
        raise ValueError(
            f"positions must surround the rectangle {footprint[:4].tolist()} m but for {100.0 * BESIDE:g} % "
            f"of it, got {outside} of its {counts.prod()} cells outside"
        )
    integral = np.zeros((counts[0] + 1, counts[1] + 1, *modes.shape[1:]))
    integral[1:, 1:] = values.cumsum(axis=0).cumsum(axis=1) * cell[0] * cell[1]
    return Underside(corner=low, cell=cell, integral=integral)


@compiler(error_model="numpy")
def mean_rows(corner, cell, integral, rectangle, out):
    """Write the mean displacement rows (3, modes) over a rectangle into `out`.

    `corner`, `cell` and `integral` are those of `Underside`. `rectangle` is least and greatest x, least and
    greatest y, m, body axes.
    """
    out.fill(0.0)
    x0, x1, y0, y1 = rectangle
    columns = integral.shape[0] - 1
    rows = integral.shape[1] - 1
    width_x = columns * cell[0]
    width_y = rows * cell[1]
    x0 = min(max(x0 - corner[0], 0.0), width_x)
    x1 = min(max(x1 - corner[0], 0.0), width_x)
    y0 = min(max(y0 - corner[1], 0.0), width_y)
    y1 = min(max(y1 - corner[1], 0.0), width_y)
    area = (x1 - x0) * (y1 - y0)
    if area <= 0.0:
        return
    for i in range(2):
        x = x1 if i == 0 else x0
        a = min(int(x / cell[0]), columns - 1)
        s = x / cell[0] - a
        for j in range(2):
            y = y1 if j == 0 else y0
            b = min(int(y / cell[1]), rows - 1)
            t = y / cell[1] - b
            sign = (1.0 if i == j else -1.0) / area
            w00 = sign * (1.0 - s) * (1.0 - t)
            w10 = sign * s * (1.0 - t)
            w01 = sign * (1.0 - s) * t
            w11 = sign * s * t
            for c in range(out.shape[0]):
                for k in range(out.shape[1]):
                    out[c, k] += (
                        w00 * integral[a, b, c, k]
                        + w10 * integral[a + 1, b, c, k]
                        + w01 * integral[a, b + 1, c, k]
                        + w11 * integral[a + 1, b + 1, c, k]
                    )
