"""Shaded surfaces of opaque solids by a depth buffer: the nearest face at four points of every pixel.

matplotlib would paint all faces over each other, which takes several times as long.
"""

from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np

from exudyn_crawler.views import style
from exudyn_crawler.views.scenes.scene import Solid, View
from fem.body.mesh import triangle_normals
from fem.compiling import compiler

LIGHT = np.array([0.30, 0.15, 0.94]) / np.linalg.norm([0.30, 0.15, 0.94])
"""Direction of the light in the picture's axes: right, up, toward the viewer."""
SUPER = 2
"""Points along each side of a pixel."""
LEVELS = 256
"""Number of colours of a scale; one more colour stands for missing values."""


class _SeenTriangles(NamedTuple):
    """Triangles of solids that are turned to the viewer."""

    points: np.ndarray  # (n, 4): right, up and toward the viewer, m, and number of the colour
    triangles: np.ndarray  # (m, 3)
    shades: np.ndarray  # (m,), fraction of the full light
    colours: np.ndarray  # (solids, LEVELS + 1, 3)
    solids: np.ndarray  # (m,), number of each triangle's solid


def shade(normals: np.ndarray) -> np.ndarray:
    """Return the brightness (m,) of faces with unit normals (m, 3), relative to their colour."""
    return 0.45 + 0.65 * np.clip(normals @ LIGHT, 0.0, 1.0)


def turned_to_viewer(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return unit normals (m, 3) of faces with corners (m, 3 or more, 3) in a view, and True if seen."""
    normals = triangle_normals(corners)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return normals, normals[:, 2] > 1e-9


def _surface(solids: list[Solid], view: View) -> _SeenTriangles:
    """Return the surface of solids at their only time in a view."""
    points = []
    triangles = []
    shades = []
    colours = []
    start = 0
    for solid in solids:
        seen = view.project(solid.points)
        numbers = np.zeros(len(seen))
        table = np.tile(mpl.colors.to_rgb(solid.colour), (LEVELS + 1, 1))
        for colouring in solid.colourings[:1]:
            between = mpl.colors.Normalize(colouring.low, colouring.high)
            numbers = LEVELS * np.asarray(between(colouring.values.ravel()), dtype=float)
            places = np.append((np.arange(LEVELS) + 0.5) / LEVELS, np.nan)
            table = style.colour_map(colouring.colours)(places)[:, :3]
        normals, turned = turned_to_viewer(seen[solid.triangles])
        points.append(np.column_stack((seen, numbers)))
        triangles.append(solid.triangles[turned] + start)
        shades.append(shade(normals[turned]))
        colours.append(table)
        start += len(seen)
    return _SeenTriangles(
        np.concatenate(points),
        np.concatenate(triangles),
        np.concatenate(shades),
        np.array(colours),
        np.repeat(np.arange(len(solids)), [len(part) for part in shades]),
    )


@compiler(nogil=True)
def _find_nearest(points, triangles, depth, nearest, numbers):
    """Find the nearest triangle, its depth and its value at the points of a picture (rows, columns)."""
    rows, columns = depth.shape
    for face in range(len(triangles)):
        a = points[triangles[face, 0]]
        b = points[triangles[face, 1]]
        c = points[triangles[face, 2]]
        double = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        if not double > 0.0:
            continue
        left = max(0, int(np.ceil(min(a[0], b[0], c[0]) - 0.5)))
        right = min(columns - 1, int(np.floor(max(a[0], b[0], c[0]) - 0.5)))
        bottom = max(0, int(np.ceil(min(a[1], b[1], c[1]) - 0.5)))
        top = min(rows - 1, int(np.floor(max(a[1], b[1], c[1]) - 0.5)))
        for row in range(bottom, top + 1):
            y = row + 0.5 - a[1]
            for column in range(left, right + 1):
                x = column + 0.5 - a[0]
                u = (x * (c[1] - a[1]) - (c[0] - a[0]) * y) / double
                v = ((b[0] - a[0]) * y - x * (b[1] - a[1])) / double
                # a point on an edge belongs to both of its triangles
                if u < -1e-9 or v < -1e-9 or u + v > 1.0 + 1e-9:
                    continue
                z = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
                if z > depth[row, column]:
                    depth[row, column] = z
                    nearest[row, column] = face
                    numbers[row, column] = a[3] + u * (b[3] - a[3]) + v * (c[3] - a[3])


@compiler(nogil=True)
def _average(nearest, numbers, shades, colours, solids, image):
    """Average the colours of each pixel's points as bytes (rows, columns, 4), opaque as far as hit."""
    levels = colours.shape[1] - 1
    mean = np.zeros(3)
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            hit = 0
            mean[:] = 0.0
            for point in range(SUPER * SUPER):
                i = SUPER * row + point // SUPER
                j = SUPER * column + point % SUPER
                face = nearest[i, j]
                if face < 0:
                    continue
                hit += 1
                number = numbers[i, j]
                level = levels
                if number == number:
                    level = int(min(max(number, 0.0), levels - 1.0))
                for k in range(3):
                    mean[k] += min(colours[solids[face], level, k] * shades[face], 1.0)
            if hit:
                for k in range(3):
                    image[row, column, k] = int(255.0 * mean[k] / hit + 0.5)
                image[row, column, 3] = 255 * hit // (SUPER * SUPER)


def shaded_surface(solids: list[Solid], view: View, **how: Any) -> mpl.collections.Collection:
    """Return opaque surfaces of solids without edges at their only time, m, as an artist for axes."""
    return _Shaded(solids, view, **how)


class _Shaded(mpl.collections.Collection):
    """Surfaces that are rasterized while drawing; see `shaded_surface`."""

    def __init__(self, solids: list[Solid], view: View, **how: Any) -> None:
        super().__init__(**how)
        # axes ask a collection for its paths; an image needs none
        self._paths: list[mpl.path.Path] = []
        self._solids = solids
        self._view = view
        self._drawn: tuple[tuple[Any, ...], np.ndarray] | None = None  # place in the picture, and image

    @mpl.artist.allow_rasterization
    def draw(self, renderer: mpl.backend_bases.RendererBase) -> None:
        """Draw the part within the axes as an image."""
        assert self.axes is not None
        box = self.axes.bbox
        corner = np.floor(box.min).astype(int)
        columns, rows = np.ceil(box.max).astype(int) - corner
        place = self.get_transform().get_affine().get_matrix().tobytes(), *corner, rows, columns
        # the layout engine draws once before the figure itself
        if self._drawn is None or self._drawn[0] != place:
            self._drawn = place, self._image(corner, rows, columns)
        context = renderer.new_gc()
        context.set_clip_rectangle(box)
        renderer.draw_image(context, corner[0], corner[1], self._drawn[1])
        context.restore()
        self.stale = False

    def _image(self, corner: np.ndarray, rows: int, columns: int) -> np.ndarray:
        """Return the image (rows, columns, 4) in bytes, the lowest row first, from a corner in pixels."""
        # not kept: 5 MB a shoe
        surface = _surface(self._solids, self._view)
        points = surface.points
        points[:, :2] = SUPER * (self.get_transform().transform(points[:, :2]) - corner)
        fine = SUPER * rows, SUPER * columns
        depth = np.full(fine, -np.inf, dtype=np.float32)
        nearest = np.full(fine, -1, dtype=np.int32)
        numbers = np.zeros(fine, dtype=np.float32)
        _find_nearest(points, surface.triangles, depth, nearest, numbers)
        image = np.zeros((rows, columns, 4), dtype=np.uint8)
        _average(nearest, numbers, surface.shades, surface.colours, surface.solids, image)
        return image
