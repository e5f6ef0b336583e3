"""Loads on any part of a body's surface, and the equilibrium of a body on one-sided springs.

Both integrate over points inside the faces. The points are finer than the faces, so that loads and supports
need not follow the elements' edges.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack
from scipy.spatial import ConvexHull, QhullError

from fem.body.mesh import Floats, Integers, Mesh
from fem.body.reduction import Partition
from fem.body.surfaces import triangle_shapes

CONVERGED, STEPS = 1e-10, 200
"""Greatest residual at equilibrium, fraction of the loads, and the greatest number of steps of the search."""
UPRIGHT = [2, 3, 4]
"""Rigid motions that upward springs resist: along z, about x and about y."""


class SurfacePoints(NamedTuple):
    """Points inside faces: positions (p, 3), m, areas (p,), m2, and shape functions, sparse (p, n)."""

    positions: Floats
    areas: Floats
    shapes: csr_array

    def chosen(self, which: Floats | Integers) -> "SurfacePoints":
        """Select points by numbers or by truth values."""
        return SurfacePoints(self.positions[which], self.areas[which], csr_array(self.shapes[which]))

    def spread(self, force: Floats, density: Floats | None = None) -> Floats:
        """Return nodal forces (n, 3), N, of a total force (3,) spread evenly or by a density (p,)."""
        shares = self.areas if density is None else self.areas * density
        return np.outer(self.shapes.T @ (shares / shares.sum()), force)


def surface_points(mesh: Mesh, faces: Integers, apart: float) -> SurfacePoints:
    """Return points inside faces (k, 3 or 6) with a spacing of at most `apart` (m)."""
    corners = mesh.nodes[faces[:, :3]]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.maximum(1, np.ceil(edges / apart)).astype(int)
    positions = []
    areas = []
    rows = []
    for part in np.unique(parts).tolist():
        i, j = (grid.ravel() for grid in np.meshgrid(np.arange(part), np.arange(part), indexing="ij"))
        first = i + j < part
        second = i + j < part - 1
        a, b = (np.concatenate((k[first] + 1 / 3, k[second] + 2 / 3)) / part for k in (i, j))
        values, slopes = triangle_shapes(np.column_stack((1.0 - a - b, a, b)), faces.shape[1])
        group = faces[parts == part]
        tangents = np.einsum("qas,kac->kqsc", slopes, mesh.nodes[group])
        areas.append(0.5 * np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) / part**2)
        positions.append(np.einsum("qa,kac->kqc", values, mesh.nodes[group]))
        count = len(group) * len(values)
        columns = np.repeat(group, len(values), axis=0)
        place = (
            np.tile(values, (len(group), 1)).ravel(),
            columns.ravel(),
            np.arange(count + 1) * group.shape[1],
        )
        rows.append((place, count))
    shapes = [csr_array(place, shape=(count, len(mesh.nodes))) for place, count in rows]
    joined = csr_array(vstack(shapes))
    return SurfacePoints(
        np.concatenate([position.reshape(-1, 3) for position in positions]),
        np.concatenate([area.ravel() for area in areas]),
        joined,
    )


class Rest(NamedTuple):
    """Equilibrium of a body: upward spring forces (p,), N; z (m) and rotations about x and y (rad)."""

    forces: Floats
    motion: Floats


class OneSidedBed:
    """Upward springs below points of a free body's surface; they push and never pull.

    The body bends on the springs in static responses to tractions, one for each point of a grid. Its response
    to the loads themselves is that of all degrees of freedom.
    """

    def __init__(self, partition: Partition, points: SurfacePoints, counts: tuple[int, int]) -> None:
        low = points.positions[:, :2].min(axis=0)
        high = points.positions[:, :2].max(axis=0)
        hats = [
            np.maximum(0.0, 1.0 - np.abs((x - a) / (b - a) * (n - 1) - np.arange(n)[:, None]))
            for x, a, b, n in zip(points.positions.T[:2], low, high, counts, strict=True)
        ]
        density = np.einsum("ap,bp->abp", *hats).reshape(-1, len(points.areas)) * points.areas
        forces = np.zeros((points.shapes.shape[1], 3, len(density)))
        forces[:, 2] = points.shapes.T @ (density / density.sum(axis=1, keepdims=True)).T
        answers = partition.static_response(forces.reshape(-1, len(density)))
        stiffness = answers.T @ (partition.body.stiffness @ answers)
        values, turn = scipy.linalg.eigh(stiffness)
        there = values > 1e-9 * values[-1]
        # scaled so that each coordinate stores half its square as energy
        self._modes = points.shapes @ (
            answers.reshape(-1, 3, len(density))[:, 2] @ (turn[:, there] / np.sqrt(values[there]))
        )
        self._center = partition.body.center_of_mass[:2]
        x, y = (points.positions[:, :2] - self._center).T
        self._rows = np.hstack((np.column_stack((np.ones_like(x), y, -x)), self._modes))
        self.points = points

    def settle(self, resultant: Floats, shift: Floats, gap: Floats, stiffness: Floats) -> Rest:
        """Find the equilibrium of the body under loads.

        Parameters
        ----------
        resultant : array (6,)
            Force (N) and moment (N m) of the loads about the centre of mass.
        shift : array (p,)
            Displacement z of the points under the loads, with the inertia of the free body, m.
        gap : array (p,)
            Gap from the points down to the springs, m; negative for springs that stand proud.
        stiffness : array (p,)
            N/m3; zero at points without a spring.

        Raises
        ------
        ValueError
            If springs cannot carry the loads: these pull upward or lie outside the support; or if the search
            finds no equilibrium.
        """
        load = np.concatenate((resultant[UPRIGHT], np.zeros(self._modes.shape[1])))
        self._check(load, stiffness > 0.0)
        springs = stiffness * self.points.areas
        elastic = np.r_[np.zeros(3), np.ones(self._modes.shape[1])]
        scale = np.abs(load[:3]).max()

        def forces(q: Floats) -> Floats:
            return springs * np.maximum(-(self._rows @ q + shift) - gap, 0.0)

        def energy(q: Floats) -> float:
            depth = np.maximum(-(self._rows @ q + shift) - gap, 0.0)
            return float(0.5 * springs @ depth**2 + 0.5 * elastic @ q**2 - load @ q)

        q = np.zeros(len(load))
        q[0] = -float((gap + shift)[stiffness > 0.0].min()) + load[0] / springs.sum()
        for _ in range(STEPS):
            pushed = forces(q)
            rest = load + self._rows.T @ pushed - elastic * q
            if np.abs(rest[:3]).max() < CONVERGED * scale and np.abs(
                rest @ np.r_[0, 0, 0, q[3:]]
            ) < CONVERGED * abs(energy(q)):
                return Rest(pushed, q[:3])
            rows = self._rows[pushed > 0.0]
            tangent = rows.T @ (springs[pushed > 0.0, None] * rows) + np.diag(elastic)
            tangent[range(3), range(3)] += 1e-9 * springs.sum()
            step = np.linalg.solve(tangent, rest)
            size = 1.0
            before = energy(q)
            slack = 1e-12 * abs(before)  # due to rounding
            while size > 1e-6 and energy(q + size * step) > before - 1e-4 * size * (rest @ step) + slack:
                size *= 0.5
            q = q + size * step
        raise ValueError(f"the body must come to rest on the springs, got none in {STEPS} steps")

    def _check(self, load: Floats, supported: NDArray[np.bool_]) -> None:
        """Refuse loads that pull upward or whose resultant lies outside the supported points."""
        if load[0] >= 0.0:
            raise ValueError(f"loads on springs must press downward, got {load[0]:.4g} N upward")
        point = self._center + np.array([-load[2], load[1]]) / load[0]
        try:
            edges = ConvexHull(self.points.positions[supported, :2]).equations
        except (QhullError, ValueError):
            edges = np.array([[0.0, 0.0, 1.0]])  # nothing supports
        inside = bool((edges @ np.append(point, 1.0) < 0.0).all())
        if not inside:
            raise ValueError(
                f"the resultant of the loads must lie inside the support of the body, or it tips over, got "
                f"x = {point[0]:.4g} m, y = {point[1]:.4g} m"
            )


class CrossSection(NamedTuple):
    """Section of a body across y: area (m2), z of centroid, bottom and top (m), second moment (m4)."""

    area: float
    middle: float
    bottom: float
    top: float
    second: float


def section(mesh: Mesh, y: float) -> CrossSection:
    """Return the section at a y (m), by Green's theorem along its outline; curved faces count as flat."""
    corners = mesh.nodes[mesh.boundary[:, :3]]
    # no node lies in the plane
    above = corners[:, :, 1] - y - 1e-9 * np.pi > 0.0
    cut = corners[above.any(axis=1) & ~above.all(axis=1)]
    d = cut[:, :, 1] - y - 1e-9 * np.pi
    pairs = np.array([[0, 1], [1, 2], [2, 0]])
    row, side = np.nonzero(d[:, pairs[:, 0]] * d[:, pairs[:, 1]] < 0.0)  # two sides of each face
    first, second = pairs[side].T
    t = (d[row, first] / (d[row, first] - d[row, second]))[:, None]
    points = (1.0 - t) * cut[row, first] + t * cut[row, second]
    p, q = points.reshape(-1, 2, 3)[:, :, [0, 2]].transpose(1, 0, 2)
    normal = np.cross(cut[:, 1] - cut[:, 0], cut[:, 2] - cut[:, 0])[:, [0, 2]]
    turned = ((q[:, 1] - p[:, 1]) * normal[:, 0] - (q[:, 0] - p[:, 0]) * normal[:, 1]) < 0.0
    p, q = np.where(turned[:, None], q, p), np.where(turned[:, None], p, q)
    twice = p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]
    area = 0.5 * float(twice.sum())
    middle = float((twice * (p[:, 1] + q[:, 1])).sum() / 6.0 / area)
    about_zero = float((twice * (p[:, 1] ** 2 + p[:, 1] * q[:, 1] + q[:, 1] ** 2)).sum() / 12.0)
    heights = np.concatenate((p[:, 1], q[:, 1]))
    return CrossSection(
        area, middle, float(heights.min()), float(heights.max()), about_zero - area * middle**2
    )
