"""Solids and arrows of a scene on axes of matplotlib, seen in parallel projection.

Two ways draw the same solids. OpenGL (PyVista) shades smoothly and hides exactly; it is taken for curved
surfaces where the machine has it, with or without a display. Painting by matplotlib, back to front, needs no
system library; it draws flat faces with their edges as they are, but shades by triangle and may get the order
of large triangles wrong.
"""

import os
import subprocess
import sys
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize, to_rgba
from numpy.typing import NDArray

from exudyn_crawler.views.scenes.scene import Arrows, Solid, View
from exudyn_crawler.views.style import colour_map
from fem.interrupts import interrupts_wait

Backend = Literal["opengl", "painted"]
Window = tuple[float, float, float, float]
"""Least and greatest coordinate to the right, least and greatest upward, m."""

ARROW_WIDTH = 0.018
"""Inches, width of an arrow's shaft."""
FINEST = 0.12
"""m, edges of shaded triangles that are painted whole."""
LIGHT = np.array([0.30, 0.15, 0.94])
"""Where light comes from, in the picture's axes: right, up, toward the viewer."""
TRIAL = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(32, 32))
plotter.add_mesh(pyvista.Cube(), color="red")
raise SystemExit(0 if plotter.screenshot(return_img=True).std() > 1.0 else 1)
"""
"""What a machine with OpenGL can do; run in a process of its own, since VTK may end its process."""


@cache
def usual_backend() -> Backend:
    """OpenGL where PyVista can draw with it, which is tried once in a process of its own; else painting."""
    quiet = os.environ | {"VTK_LOGGING_LEVEL": "OFF"}
    try:
        trial = subprocess.run(
            [sys.executable, "-c", TRIAL], capture_output=True, timeout=120, check=False, env=quiet
        )
    except (OSError, subprocess.TimeoutExpired):
        return "painted"
    return "opengl" if trial.returncode == 0 else "painted"


def draw_solids(
    ax: Axes, solids: Sequence[Solid], view: View, window: Window, backend: Backend, dpi: float = 130.0
) -> list[Artist]:
    """Draw solids, as of `Solid.at`, into axes, whose coordinates become those of the picture in m.

    What is drawn is returned; `dpi` is the resolution of an OpenGL image.
    """
    ax.set(xlim=window[:2], ylim=window[2:], aspect="equal")
    if backend == "painted":
        return [paint(ax, solids, view)]
    size = ax.get_window_extent()
    per_metre = min(size.width / (window[1] - window[0]), size.height / (window[3] - window[2]))
    image = opengl_image(solids, view, window, per_metre * dpi / ax.figure.dpi)
    # a pixel of the image is one of the figure: interpolation would cost half of all and show nothing
    return [ax.imshow(image, extent=window, aspect="equal", interpolation="nearest", zorder=1)]


@interrupts_wait()
def opengl_image(solids: Sequence[Solid], view: View, window: Window, pixels_per_metre: float) -> NDArray:
    """Image (height, width, 4) of solids on nothing, uint8 red, green, blue and opacity."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    # VTK tells of every window system that it tries in vain
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    width, height = window[1] - window[0], window[3] - window[2]
    size = (max(2, round(width * pixels_per_metre)), max(2, round(height * pixels_per_metre)))
    plotter = pyvista.Plotter(off_screen=True, window_size=size, lighting="none")
    try:
        plotter.enable_anti_aliasing("msaa", multi_samples=4)
        for one in sorted(solids, key=lambda solid: -solid.opacity):
            mesh = pyvista.PolyData.from_regular_faces(view.project(one.points), one.triangles)
            how: dict[str, Any] = {"color": one.colour, "ambient": 0.4}
            for colouring in one.colourings:
                how = {
                    "scalars": one.values,
                    "clim": (colouring.low, colouring.high),
                    "cmap": colour_map(colouring.colours),
                    "show_scalar_bar": False,
                    "smooth_shading": True,
                    "split_sharp_edges": True,
                    "feature_angle": 30.0,
                    "ambient": 0.45,
                    "diffuse": 0.65,
                }
            plotter.add_mesh(mesh, opacity=one.opacity, render=False, **how)
        middle = 0.5 * (window[0] + window[1]), 0.5 * (window[2] + window[3])
        plotter.add_light(pyvista.Light(position=LIGHT, focal_point=(0, 0, 0), light_type="scene light"))
        plotter.enable_parallel_projection()
        plotter.camera.focal_point = (*middle, 0.0)
        plotter.camera.position = (*middle, 20.0)
        plotter.camera.up = (0.0, 1.0, 0.0)
        plotter.camera.parallel_scale = 0.5 * height
        plotter.reset_camera_clipping_range()
        return np.asarray(plotter.screenshot(return_img=True, transparent_background=True))
    finally:
        plotter.close()


def paint(ax: Axes, solids: Iterable[Solid], view: View) -> PolyCollection:
    """Draw the faces that are turned to the viewer back to front, each in one colour."""
    faces: list[NDArray] = []
    fills, lines = [], []
    for solid in solids:
        points = np.column_stack((view.project(solid.points), solid.values))
        parts = [points[one] for one in solid.faces] if solid.edges else [_fine(points[solid.triangles])]
        for part in parts:
            corners, values = part[..., :3], part[..., 3]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
            seen = normals[:, 2] > 1e-9
            fill = _fills(solid, values[seen].mean(axis=1), normals[seen])
            faces += list(corners[seen])
            fills.append(fill)
            edged = solid.edges and corners.shape[1] > 3
            lines.append(np.tile(to_rgba(solid.edges), (len(fill), 1)) if edged else fill)
    order = np.argsort([face[:, 2].mean() for face in faces], kind="stable")
    colours, edges = (np.concatenate(one)[order] for one in (fills, lines))
    drawn = PolyCollection(
        [faces[k][:, :2] for k in order], facecolors=colours, edgecolors=edges, linewidths=0.7, zorder=1
    )
    ax.add_collection(drawn, autolim=False)
    return drawn


def _fills(solid: Solid, values: NDArray, normals: NDArray) -> NDArray:
    """Colours (m, 4) of faces by their values (m,), shaded by their normals (m, 3) without edges."""
    colours = np.tile(to_rgba(solid.colour), (len(values), 1))
    for one in solid.colourings:
        colours = colour_map(one.colours)(Normalize(one.low, one.high)(values))
    colours[:, 3] = solid.opacity
    if not solid.edges:
        shade = 0.45 + 0.65 * np.clip(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0.0, 1.0)
        colours[:, :3] = np.clip(colours[:, :3] * shade[:, None], 0.0, 1.0)
    return colours


def draw_arrows(ax: Axes, kinds: Iterable[Arrows], view: View) -> list[Artist]:
    """Draw arrows over all that is there, seen from every side; what is drawn is returned."""
    how: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "units": "inches", "zorder": 4}
    drawn: list[Artist] = []
    for one in kinds:
        tails, heads = view.project(one.at())[..., :2].transpose(1, 2, 0)
        if heads.size:
            ways = (*heads, *(heads - tails))
            drawn.append(ax.quiver(*ways, color=one.colour, pivot="tip", width=ARROW_WIDTH, **how))
    return drawn


def _fine(corners: NDArray) -> NDArray:
    """Corners (m, 3, 4) of triangles, place and value; large ones are split in four until they are small."""
    done: list[NDArray] = []
    while len(corners):
        edges = np.linalg.norm((corners - np.roll(corners, -1, axis=1))[..., :3], axis=2)
        small = edges.max(axis=1) <= FINEST
        done.append(corners[small])
        a, b, c = corners[~small].transpose(1, 0, 2)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        quarters = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        corners = np.concatenate([np.stack(one, axis=1) for one in quarters])
    return np.concatenate(done)
