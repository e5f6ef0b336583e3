"""Loads on a flat rectangle of a surface: tractions on a grid over it, and forces at stations along it.

The rectangle is level, such as the underside of a shoe or one of its rails. Nodal forces are integrals over
the elements' shape functions: loads need not follow the elements' edges.
"""

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.sparse import csr_array, vstack
from skfem import Basis, ElementTriP1, ElementTriP2, MeshTri

from fem.body.mesh import Floats, Integers, Mesh
from fem.body.surfaces import faces_joined_to

GAUSS = 2
"""Points along each side of a cell of the quadrature."""
QUADRATURE_CELL = 0.02
"""Greatest side of a quadrature cell, m; the elements are several times as large."""
INSIDE = 1e-9
"""Distance of samples from the edges, fraction of the rectangle; rounding may put them outside otherwise."""
AT_ONCE = 1024
"""Number of points whose faces are searched at once: each point is tried on all faces near any of them."""
LEVEL = 1e-6
"""Greatest height difference of a level surface, fraction of the body's extent."""


@dataclass(frozen=True, eq=False)
class FlatRectangle:
    """Level rectangle of a named surface.

    Parameters
    ----------
    mesh : Mesh
    surface : str
        Name of the surface; its faces outside the rectangle do not matter.
    low, high : array (2,)
        Least and greatest x and y in m, body axes.

    Raises
    ------
    KeyError
        If there is no such surface.
    ValueError
        If the rectangle is empty, or the surface is not level there or does not cover it.
    """

    mesh: Mesh
    surface: str
    low: Floats
    high: Floats

    def __post_init__(self) -> None:
        low = np.asarray(self.low, dtype=float)
        high = np.asarray(self.high, dtype=float)
        if low.shape != (2,) or high.shape != (2,) or not (high > low).all():
            raise ValueError(f"low must be below high in x and y, got {self.low} and {self.high}")
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "high", high)
        heights = self.mesh.nodes[self._faces, 2]
        if len(heights) == 0 or np.ptp(heights) > LEVEL * np.ptp(self.mesh.nodes, axis=0).max():
            raise ValueError(
                f"surface {self.surface!r} must be level over x {low[0]:g}..{high[0]:g}, "
                f"y {low[1]:g}..{high[1]:g} m, got {len(heights)} faces"
                + (f" of heights {heights.min():g}..{heights.max():g} m" if len(heights) else "")
            )
        self.samples(*(np.array([a, b]) for a, b in zip(low, high, strict=True)))

    @cached_property
    def _faces(self) -> Integers:
        """Faces (k, 3 or 6) with their centroids inside the rectangle."""
        faces = self.mesh.surface(self.surface)
        middles = self.mesh.nodes[faces[:, :3]].mean(axis=1)[:, :2]
        return faces[((middles > self.low) & (middles < self.high)).all(axis=1)]

    @property
    def height(self) -> float:
        """Height z in m."""
        return float(self.mesh.nodes[self._faces, 2].mean())

    @cached_property
    def _basis(self) -> tuple[Basis, Integers]:
        """Shape functions of the faces in the plane, and the node of each function."""
        faces = self._faces
        corners, triangles = np.unique(faces[:, :3], return_inverse=True)
        plane = MeshTri(
            np.ascontiguousarray(self.mesh.nodes[corners, :2].T),
            np.ascontiguousarray(triangles.reshape(-1, 3).T),
            sort_t=False,
        )
        basis = Basis(plane, ElementTriP1() if faces.shape[1] == 3 else ElementTriP2(), intorder=1)
        nodes = np.empty(basis.N, dtype=np.int64)
        nodes[basis.element_dofs] = faces.T
        return basis, nodes

    def samples(self, x: Floats, y: Floats) -> csr_array:
        """Return the shape functions at points of the rectangle: sparse (p, n) for x (p,) and y (p,) in m.

        Raises
        ------
        ValueError
            If no face of the surface is at a point.
        """
        basis, nodes = self._basis
        margin = INSIDE * (self.high - self.low)
        points = np.clip(np.column_stack((x, y)), self.low + margin, self.high - margin)
        try:
            parts = [points[first : first + AT_ONCE] for first in range(0, len(points), AT_ONCE)]
            probes = vstack([csr_array(basis.probes(part.T)) for part in parts])
        except ValueError as error:
            raise ValueError(
                f"surface {self.surface!r} must cover x {self.low[0]:g}..{self.high[0]:g}, "
                f"y {self.low[1]:g}..{self.high[1]:g} m, got a gap: {error}"
            ) from error
        spread = csr_array(
            (np.ones(len(nodes)), (np.arange(len(nodes)), nodes)), shape=(len(nodes), len(self.mesh.nodes))
        )
        return csr_array(probes @ spread)


def flat_parts(mesh: Mesh, surface: str) -> list[FlatRectangle]:
    """Return the rectangles that the parts of a surface fill, such as two rails, in order of y and then x.

    See `FlatRectangle` for errors.
    """
    open_ = mesh.surface(surface)
    parts = []
    while len(open_):
        part = faces_joined_to(open_, open_[:1])
        corners = mesh.nodes[part.ravel(), :2]
        parts.append(FlatRectangle(mesh, surface, corners.min(axis=0), corners.max(axis=0)))
        open_ = open_[~np.isin(open_[:, 0], part)]
    return sorted(parts, key=lambda part: (part.low[1], part.low[0]))


def _points(edges: Floats) -> tuple[Floats, Floats]:
    """Return Gauss points and weights of intervals between edges (k,), each cut into cells."""
    cells = [
        np.linspace(a, b, 1 + int(np.ceil((b - a) / QUADRATURE_CELL))) for a, b in itertools.pairwise(edges)
    ]
    low = np.concatenate([cell[:-1] for cell in cells])
    width = np.concatenate([np.diff(cell) for cell in cells])
    xi, weights = np.polynomial.legendre.leggauss(GAUSS)
    return (low[:, None] + 0.5 * width[:, None] * (1.0 + xi)).ravel(), np.outer(width, 0.5 * weights).ravel()


@dataclass(frozen=True, eq=False)
class PressureGrid:
    """Tractions over a rectangle, bilinear between the points of a grid.

    A coordinate is the traction at a grid point in Pa, along any direction.

    Parameters
    ----------
    rectangle : FlatRectangle
    counts : tuple of int
        Points along x and along y, at least two each, points on the edges included.

    Raises
    ------
    ValueError
        If there are fewer points.
    """

    rectangle: FlatRectangle
    counts: tuple[int, int]

    def __post_init__(self) -> None:
        if min(self.counts) < 2:
            raise ValueError(f"counts must be at least 2 along x and along y, got {self.counts}")

    @cached_property
    def _hats(self) -> tuple[BSpline, BSpline]:
        """Hat functions (p,) of x and of y: 1 at one grid point and 0 at the others."""
        sides = zip(self.rectangle.low, self.rectangle.high, self.counts, strict=True)
        grids = [np.linspace(low, high, count) for low, high, count in sides]
        along_x, along_y = (BSpline(np.r_[grid[0], grid, grid[-1]], np.eye(len(grid)), 1) for grid in grids)
        return along_x, along_y

    @cached_property
    def weights(self) -> csr_array:
        """Nodal forces (n, p) in N of a unit traction at each point; y runs fastest."""
        (x, wx), (y, wy) = (_points(hats.t[1:-1]) for hats in self._hats)
        grid = np.meshgrid(x, y, indexing="ij")
        shapes = self.rectangle.samples(grid[0].ravel(), grid[1].ravel())
        along_x, along_y = self._hats
        tractions = np.kron(wx[:, None] * along_x(x), wy[:, None] * along_y(y))
        return csr_array(shapes.T @ csr_array(tractions))

    def coordinates(self, forces: Floats, low: Floats, high: Floats) -> Floats:
        """Project forces that are spread evenly over rectangles on the grid, by least squares.

        The tractions of the grid have the same resultant force and moments.

        Parameters
        ----------
        forces : array (t, 3)
            In N, body axes.
        low, high : array (t, 2)
            Least and greatest x and y of the rectangles in m. Parts beyond the grid's edges are cut off. A
            rectangle left without width is a line along the edge.

        Returns
        -------
        array (t, p, 3)
            In Pa.
        """
        shares = []
        for axis, hats in enumerate(self._hats):
            first = self.rectangle.low[axis]
            last = self.rectangle.high[axis]
            a, b = np.clip(low[:, axis], first, last), np.clip(high[:, axis], first, last)
            whole = hats.antiderivative()
            width = (b - a)[:, None]
            line = width <= INSIDE * (last - first)
            means = np.where(line, hats(a), (whole(b) - whole(a)) / np.where(line, 1.0, width))
            x, weights = _points(hats.t[1:-1])
            products = hats(x).T @ (weights[:, None] * hats(x))
            shares.append(np.linalg.solve(products, means.T).T)
        spread = np.einsum("ti,tj->tij", *shares)[..., None] * forces[:, None, None]
        return spread.reshape(len(forces), math.prod(spread.shape[1:3]), 3)


@dataclass(frozen=True, eq=False)
class Stations:
    """Forces at stations along a rectangle, each spread around its station.

    A coordinate is a force in N. Its traction is even across the rectangle and a raised cosine along it. The
    cosine is cut off at an end, and the rest is inclined so that the force acts at its station.

    Parameters
    ----------
    rectangle : FlatRectangle
        Along x.
    count : int
        Stations from end to end, at least two.
    reach : float
        Half the length in m over which a force is spread, up to half the rectangle's length. Stations spaced
        by half the reach give an error of 4 % of the stress between them, by a third 1 % (`python -m
        benchmarks.static_fields`).

    Raises
    ------
    ValueError
        If there are fewer stations or the reach is out of its range.
    """

    rectangle: FlatRectangle
    count: int
    reach: float

    def __post_init__(self) -> None:
        if self.count < 2:
            raise ValueError(f"count must be at least 2, got {self.count}")
        half = 0.5 * (self.rectangle.high[0] - self.rectangle.low[0])
        if not 0.0 < self.reach <= half:
            raise ValueError(f"reach must lie in (0, {half:g}] m, half the rectangle, got {self.reach}")

    @property
    def positions(self) -> Floats:
        """Positions (count,) of the stations along x in m."""
        return np.linspace(self.rectangle.low[0], self.rectangle.high[0], self.count)

    @cached_property
    def weights(self) -> csr_array:
        """Nodal forces (n, count) of a unit force at each station."""
        return self.weights_at(self.positions)

    def weights_at(self, x: Floats) -> csr_array:
        """Return the nodal forces (n, k) of unit forces spread in the same way around any x (k,) in m.

        Raises
        ------
        ValueError
            If an x lies beyond the ends.
        """
        low = self.rectangle.low
        high = self.rectangle.high
        x = np.atleast_1d(np.asarray(x, dtype=float))
        if not ((x >= low[0]) & (x <= high[0])).all():
            raise ValueError(f"x must lie in {low[0]:g}..{high[0]:g} m, got {x.min():g}..{x.max():g}")
        along, lengths = _points(np.array([low[0], high[0]]))
        y, across = _points(np.array([low[1], high[1]]))
        grid = np.meshgrid(along, y, indexing="ij")
        shapes = self.rectangle.samples(grid[0].ravel(), grid[1].ravel())
        offsets = along[:, None] - x
        spread = np.where(np.abs(offsets) < self.reach, 1.0 + np.cos(np.pi * offsets / self.reach), 0.0)
        spread *= lengths[:, None]
        moments = [np.einsum("pk,pk->k", spread, offsets**power) for power in range(3)]
        steepness = moments[0] * moments[2] - moments[1] ** 2
        spread *= (moments[2] - moments[1] * offsets) / steepness
        return csr_array(shapes.T @ csr_array(np.kron(spread, across[:, None] / across.sum())))

    def coordinates(self, forces: Floats, x: Floats) -> Floats:
        """Replace forces between the stations by forces at them, with splines of third degree at most.

        The forces at the stations have the same resultant force and moments.

        Parameters
        ----------
        forces : array (t, 3)
            In N, body axes.
        x : array (t,)
            In m; beyond the ends only where the force is zero.

        Returns
        -------
        array (t, count, 3)
            In N.

        Raises
        ------
        ValueError
            If a force acts beyond the ends.
        """
        first = self.rectangle.low[0]
        last = self.rectangle.high[0]
        acting = np.asarray(forces).any(axis=1)
        beyond = acting & ~((x >= first) & (x <= last))
        if beyond.any():
            raise ValueError(
                f"x must lie in {first:g}..{last:g} m at which a force acts, got {x[beyond][0]:g}"
            )
        shares = make_interp_spline(self.positions, np.eye(self.count), min(3, self.count - 1))
        return shares(np.clip(x, first, last))[:, :, None] * forces[:, None]
