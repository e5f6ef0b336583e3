"""Shoes of known pins for tests: sections of one plane grid, swept along y and put together; mm."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay

STEP = 30.0  # mm, greatest of the grid
LAYER = 60.0  # mm, thickest along y
PIN_Z, PLATE, WEB = 60.0, 20.0, 110.0  # mm, height of the pins, of the plate and of the web

Span = tuple[float, float]
FORK = ((-165.0, -125.0), (-75.0, -35.0), (35.0, 75.0), (125.0, 165.0))
BETWEEN = ((-120.0, -80.0), (80.0, 120.0))


@dataclass(frozen=True)
class SweptShoe:
    """Plate, web with two rails, and square lugs with round bores; `facets` corners around each."""

    front: Sequence[Span] = FORK
    rear: Sequence[Span] = BETWEEN
    half_pitch: float = 125.0
    radii: Span = (18.0, 18.0)  # of front and rear bores
    facets: int = 16
    half_width: float = 350.0
    grouser: bool = False  # one below the plate
    rails: bool = True
    decoy: bool = True  # a hole along y through the web
    standing: bool = False  # lugs that reach the ground
    links: bool = False  # rails on lugs, the front half of each beside its rear one

    @property
    def holes(self) -> list[tuple[float, float, float]]:
        """Bores and the decoy: x, z and radius."""
        pins = [(self.half_pitch, PIN_Z, self.radii[0]), (-self.half_pitch, PIN_Z, self.radii[1])]
        return [*pins, (0.0, 75.0, 15.0)] if self.decoy else pins

    def boxes(self, y: float) -> list[tuple[float, float, float, float]]:
        """Section at y: x and z of boxes."""
        out = [(-115.0, 115.0, 0.0, PLATE)]
        if self.grouser:
            out.append((-15.0, 5.0, -40.0, 0.0))
        if abs(y) < 240.0:
            out.append((-65.0, 65.0, PLATE, WEB))
        if self.links and 80.0 < abs(y) < 120.0:
            out.append((-115.0, 5.0, PLATE, WEB + 10.0))
        if self.links and 125.0 < abs(y) < 165.0:
            out.append((-15.0, 115.0, PLATE, WEB + 10.0))
        if self.rails and 80.0 < abs(y) < 120.0:
            out.append((-65.0, 65.0, WEB, WEB + 10.0))
        tall = (0.0 if self.standing else PIN_Z - 40.0, PIN_Z + 40.0)
        if any(low < y < high for low, high in self.front):
            out.append((65.0, self.half_pitch + 40.0, *tall))
        if any(low < y < high for low, high in self.rear):
            out.append((-self.half_pitch - 40.0, -65.0, *tall))
        return out

    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (n, 3), mm, and linear tetrahedra (m, 4)."""
        flat, triangles = self._plane()
        corners = flat[triangles]
        middles = corners.mean(axis=1)
        ends = {e for span in (*self.front, *self.rear) for e in span} | {
            -240.0,
            240.0,
            80.0,
            -80.0,
            120.0,
            -120.0,
        }
        edges = np.array(sorted(ends | {-self.half_width, self.half_width}))
        counts = np.ceil(np.diff(edges) / LAYER).astype(int)
        levels = np.concatenate(
            [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(edges, edges[1:], counts, strict=False)]
            + [edges[-1:]]
        )
        tets = []
        for k, y in enumerate(0.5 * (levels[1:] + levels[:-1])):
            chosen = np.zeros(len(triangles), dtype=bool)
            for x0, x1, z0, z1 in self.boxes(y):
                chosen |= (np.abs(2 * middles - (x0 + x1, z0 + z1)) < (x1 - x0, z1 - z0)).all(axis=1)
            a, b, c = (np.sort(triangles[chosen], axis=1) + k * len(flat)).T
            d = len(flat)
            of_prisms = ((a, b, c, c + d), (a, b, b + d, c + d), (a, a + d, b + d, c + d))
            tets += [np.column_stack(rows) for rows in of_prisms]
        nodes = np.concatenate([np.insert(flat, 1, y, axis=1) for y in levels])
        elements = np.concatenate(tets)
        used, elements = np.unique(elements, return_inverse=True)
        nodes, elements = nodes[used], elements.reshape(-1, 4)
        corner = nodes[elements]
        turned = np.linalg.det(corner[:, 1:] - corner[:, :1]) < 0.0
        elements[turned] = elements[turned][:, [1, 0, 2, 3]]
        return nodes, elements

    def _plane(self) -> tuple[np.ndarray, np.ndarray]:
        """Points (x, z) of the grid and triangles of them, those inside of holes left out."""
        end = self.half_pitch + 40.0
        x = _filled([-end, -115.0, -65.0, -15.0, 5.0, 65.0, 115.0, end])
        z = _filled([-40.0, 0.0, PLATE, PIN_Z - 40.0, PIN_Z + 40.0, WEB, WEB + 10.0])
        grid = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
        points = [grid]
        for cx, cz, r in self.holes:
            points = [p[np.hypot(*(p - (cx, cz)).T) > 1.5 * r] for p in points]
        angles = 2.0 * np.pi * (np.arange(self.facets) + 0.3) / self.facets
        for cx, cz, r in self.holes:
            points.append(np.column_stack((cx + r * np.cos(angles), cz + r * np.sin(angles))))
        flat = np.concatenate(points)
        triangles = Delaunay(flat).simplices
        middles = flat[triangles].mean(axis=1)
        keep = np.ones(len(triangles), dtype=bool)
        normals = np.array([np.cos(angles + np.pi / self.facets), np.sin(angles + np.pi / self.facets)])
        for cx, cz, r in self.holes:
            # outside of a polygon: farther than one of its sides
            away = (middles - (cx, cz)) @ normals
            keep &= (away > r * np.cos(np.pi / self.facets) - 1e-9).any(axis=1)
        sides = flat[triangles[:, 1:]] - flat[triangles[:, :1]]
        return flat, triangles[keep & (np.abs(np.linalg.det(sides)) > 1e-3)]


def _filled(edges: Sequence[float]) -> np.ndarray:
    """Places at edges, and evenly between those that are farther apart than `STEP`."""
    places = sorted(set(edges))
    parts = [
        np.linspace(a, b, int(np.ceil((b - a) / STEP)), endpoint=False) for a, b in itertools.pairwise(places)
    ]
    return np.concatenate((*parts, places[-1:]))
