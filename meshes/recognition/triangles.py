"""Triangles of a closed boundary: neighbours, bends between them, volume and centre."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fem.body.mesh import Floats, Integers, sorted_rows, triangle_normals

SAME_PLACE = 1e-6
"""Distance below which corners count as one, fraction of the size; STL repeats corners."""
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangles of a boundary, corners in outward sense.

    Attributes
    ----------
    points : array (n, 3)
        Corners in any unit and axes.
    faces : int array (k, 3)
    """

    points: Floats
    faces: Integers

    @classmethod
    def welded(cls, points: Floats, faces: Integers) -> Self:
        """Return triangles with equal corners merged; those without area and duplicates are left out."""
        step = SAME_PLACE * np.ptp(points, axis=0).max()
        _, first, number = np.unique(np.round(points / step), axis=0, return_index=True, return_inverse=True)
        joined = number.ravel()[faces]
        joined = joined[(joined != np.roll(joined, 1, axis=1)).all(axis=1)]
        _, rows = np.unique(np.sort(joined, axis=1), axis=0, return_index=True)
        return cls(points[first], joined[np.sort(rows)])

    @cached_property
    def corners(self) -> Floats:
        """Positions of the corners: array (k, 3, 3)."""
        return self.points[self.faces]

    @cached_property
    def middles(self) -> Floats:
        """Centroids: array (k, 3)."""
        return self.corners.mean(axis=1)

    @cached_property
    def _crosses(self) -> Floats:
        return triangle_normals(self.corners)

    @cached_property
    def areas(self) -> Floats:
        """Areas: array (k,)."""
        return np.asarray(0.5 * np.linalg.norm(self._crosses, axis=1))

    @cached_property
    def normals(self) -> Floats:
        """Outward normals of unit length: array (k, 3)."""
        return self._crosses / np.maximum(2.0 * self.areas, TINY)[:, None]

    @cached_property
    def _sides(self) -> tuple[Integers, Integers, Integers, float]:
        """Neighbours (p, 2), opposite corners of the second ones, a corner of each edge, bad edges' share."""
        edges = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        owner = np.repeat(np.arange(len(self.faces)), 3)
        far = self.faces[:, [2, 0, 1]].ravel()
        keys = np.sort(edges, axis=1)
        order, is_same = sorted_rows(keys)
        same = np.flatnonzero(is_same)
        _, counts = np.unique(keys, axis=0, return_counts=True)
        first = order[same]
        second = order[same + 1]
        pairs = np.column_stack((owner[first], owner[second]))
        return pairs, far[second], edges[first, 0], float((counts != 2).mean())

    @property
    def pairs(self) -> Integers:
        """Numbers of the triangles on either side of every edge: int array (p, 2)."""
        return self._sides[0]

    @property
    def open_share(self) -> float:
        """Share of edges without exactly two triangles; zero for a closed boundary."""
        return self._sides[3]

    @cached_property
    def bends(self) -> Floats:
        """Angles between neighbours: array (p,), rad, negative for inward bends."""
        pairs, far, start, _ = self._sides
        first = self.normals[pairs[:, 0]]
        second = self.normals[pairs[:, 1]]
        angle = np.arccos(np.clip(np.einsum("pc,pc->p", first, second), -1.0, 1.0))
        # a neighbour that bends inwards has its opposite corner on the outer side of the face
        beyond = np.einsum("pc,pc->p", first, self.points[far] - self.points[start])
        return np.asarray(np.where(beyond > 0.0, -angle, angle))

    def labels(self, linked: np.ndarray) -> Integers:
        """Return the number of each triangle's connected region, (k,), linked by the chosen pairs (p,)."""
        pairs = self.pairs[linked]
        count = len(self.faces)
        ones = np.ones(len(pairs), dtype=np.int8)
        links = coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
        return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)

    def connected_regions(self, chosen: np.ndarray) -> list[Integers]:
        """Return the triangle numbers of each connected part of the `chosen` ones: booleans (k,)."""
        label = self.labels(np.asarray(chosen[self.pairs].all(axis=1)))
        numbers = np.flatnonzero(chosen)
        order = numbers[np.argsort(label[numbers], kind="stable")]
        ends = np.flatnonzero(np.diff(label[order])) + 1
        return [part for part in np.split(order, ends) if len(part)]

    @cached_property
    def volume(self) -> float:
        """Volume inside; negative if all triangles face inwards."""
        return float(self._cones.sum())

    @cached_property
    def center(self) -> Floats:
        """Centroid of the volume: array (3,)."""
        origin = self.points.mean(axis=0)
        moments = self._cones[:, None] * (self.corners.sum(axis=1) - 3.0 * origin) / 4.0
        return np.asarray(origin + moments.sum(axis=0) / self.volume)

    @cached_property
    def _cones(self) -> Floats:
        """Volumes of the tetrahedra from the mean of all points to each triangle."""
        a, b, c = np.moveaxis(self.corners - self.points.mean(axis=0), 1, 0)
        return np.asarray(np.einsum("kc,kc->k", a, np.cross(b, c)) / 6.0)

    def outward(self) -> "Triangles":
        """Return the triangles, reversed if their volume is negative."""
        return self if self.volume > 0.0 else Triangles(self.points, self.faces[:, ::-1])

    def moved(self, origin: Floats, axes: Floats, scale: float) -> "Triangles":
        """Return the triangles in axes (3, 3), one per row, about an origin (3,), times a scale."""
        return Triangles((self.points - origin) @ axes.T * scale, self.faces)
