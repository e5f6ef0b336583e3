"""Coloured surfaces with arrows, seen in parallel projection, as images.

OpenGL (PyVista) draws them where the machine has it, with or without a display. Where it has not, matplotlib
draws the same scene back to front; it needs no system library, but shades by triangle and may get the order
of large triangles wrong.
"""

import os
import subprocess
import sys
from functools import lru_cache
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.patches import FancyArrowPatch
from numpy.typing import NDArray

from exudyn_crawler.views.colours import CONTACT_FORCE, STRESS_MAP
from exudyn_crawler.views.scene import Body, Scene, View
from fem.interrupts import interrupts_wait

Backend = Literal["opengl", "plain"]

ARROW_WIDTH = 0.014
"""m, diameter of an arrow's shaft."""
FINEST = 0.12
"""m, edges of triangles that the plain backend may draw whole."""
LIGHT = np.array([0.30, 0.15, 0.94])
"""Where light comes from, in the picture's axes: right, up, toward the viewer."""
TRIAL = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(32, 32))
plotter.add_mesh(pyvista.Cube(), color="red")
image = plotter.screenshot(return_img=True)
raise SystemExit(0 if image.std() > 1.0 else 1)
"""
"""What a machine with OpenGL can do; run in a process of its own, since VTK may end its process."""


@lru_cache(maxsize=1)
def opengl_works() -> bool:
    """Whether PyVista can draw on this machine; tried once, in a process of its own."""
    quiet = os.environ | {"VTK_LOGGING_LEVEL": "OFF"}
    try:
        trial = subprocess.run(
            [sys.executable, "-c", TRIAL], capture_output=True, timeout=120, check=False, env=quiet
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return trial.returncode == 0


def usual_backend() -> Backend:
    """OpenGL where it works, else the plain one."""
    return "opengl" if opengl_works() else "plain"


def draw_scene(
    ax: Axes,
    scene: Scene,
    view: View,
    window: tuple[float, float, float, float],
    limits: tuple[float, float],
    backend: Backend,
    dpi: float = 130.0,
) -> Axes:
    """Draw a scene into axes, whose coordinates become those of the picture in m.

    Parameters
    ----------
    window : tuple of float (4)
        Least and greatest coordinate to the right, least and greatest upward, m.
    limits : tuple of float (2)
        Values at the ends of the colours.
    dpi : float
        Resolution of an OpenGL image.
    """
    ax.set(xlim=window[:2], ylim=window[2:], aspect="equal")
    if backend == "opengl":
        box = ax.get_window_extent()
        per_metre = min(box.width / (window[1] - window[0]), box.height / (window[3] - window[2]))
        image = opengl_image(scene, view, window, limits, per_metre * dpi / ax.figure.dpi)
        # a pixel of the image is one of the figure: interpolation would cost half of all and show nothing
        ax.imshow(image, extent=window, aspect="equal", interpolation="nearest", zorder=1)
    else:
        draw_plain(ax, scene, view, limits)
    return ax


@interrupts_wait()
def opengl_image(
    scene: Scene,
    view: View,
    window: tuple[float, float, float, float],
    limits: tuple[float, float],
    pixels_per_metre: float,
) -> NDArray:
    """Image (height, width, 4) of a scene on nothing, uint8 red, green, blue and opacity."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    # VTK tells of every window system that it tries in vain
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    width, height = window[1] - window[0], window[3] - window[2]
    size = (max(2, round(width * pixels_per_metre)), max(2, round(height * pixels_per_metre)))
    plotter = pyvista.Plotter(off_screen=True, window_size=size, lighting="none")
    try:
        plotter.enable_anti_aliasing("msaa", multi_samples=4)
        plotter.add_mesh(
            pyvista.PolyData.from_regular_faces(scene.points, scene.triangles),
            scalars=scene.values,
            clim=limits,
            cmap=STRESS_MAP,
            show_scalar_bar=False,
            smooth_shading=True,
            split_sharp_edges=True,
            feature_angle=30.0,
            ambient=0.45,
            diffuse=0.65,
            render=False,
        )
        along = scene.arrows[:, 1] - scene.arrows[:, 0]
        lengths = np.linalg.norm(along, axis=1)
        shown = np.flatnonzero(lengths > ARROW_WIDTH)
        if len(shown):
            drawn = [_arrow(scene.arrows[k, 0], along[k], float(lengths[k])) for k in shown]
            arrows = drawn[0].append_polydata(*drawn[1:])
            plotter.add_mesh(arrows, color=CONTACT_FORCE, ambient=0.4, render=False)
        for body in scene.bodies:
            mesh = pyvista.PolyData.from_regular_faces(body.points, body.triangles)
            plotter.add_mesh(mesh, color=body.colour, opacity=body.opacity, ambient=0.4, render=False)
        center = 0.5 * (
            (window[0] + window[1]) * view.right + (window[2] + window[3]) * view.up
        ) + view.toward * float((scene.points @ view.toward).mean())
        light = np.column_stack((view.right, view.up, view.toward)) @ LIGHT
        plotter.add_light(pyvista.Light(position=light, focal_point=(0, 0, 0), light_type="scene light"))
        plotter.enable_parallel_projection()
        plotter.camera.focal_point = center
        plotter.camera.position = center + 20.0 * view.toward
        plotter.camera.up = view.up
        plotter.camera.parallel_scale = 0.5 * height
        plotter.reset_camera_clipping_range()
        return np.asarray(plotter.screenshot(return_img=True, transparent_background=True))
    finally:
        plotter.close()


def _arrow(tail: NDArray, along: NDArray, length: float) -> Any:
    """Arrow of fixed thickness as a PyVista mesh."""
    import pyvista

    tip = min(5.0 * ARROW_WIDTH, 0.6 * length)
    return pyvista.Arrow(
        start=tail,
        direction=along,
        scale=length,
        tip_length=tip / length,
        tip_radius=1.6 * ARROW_WIDTH / length,
        shaft_radius=0.5 * ARROW_WIDTH / length,
    )


def draw_plain(ax: Axes, scene: Scene, view: View, limits: tuple[float, float]) -> Axes:
    """Draw a scene back to front, each triangle in one shaded colour."""
    corners, values = _fine_triangles(view.project(scene.points)[scene.triangles], scene)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    seen = np.flatnonzero(normals[:, 2] > 0.0)
    order = seen[np.argsort(corners[seen, :, 2].mean(axis=1), kind="stable")]
    colours = mpl.colormaps[STRESS_MAP](Normalize(*limits)(values.mean(axis=1)[order]))
    shade = 0.45 + 0.65 * np.clip(normals[order] @ (LIGHT / np.linalg.norm(LIGHT)), 0.0, 1.0)
    colours[:, :3] = np.clip(colours[:, :3] * shade[:, None], 0.0, 1.0)
    ax.add_collection(
        PolyCollection(
            list(corners[order, :, :2]), facecolors=colours, edgecolors=colours, linewidths=0.3, zorder=1
        ),
        autolim=False,
    )
    for body in scene.bodies:
        _draw_body(ax, body, view)
    for tail, head in scene.arrows:
        ends = view.project(np.stack((tail, head)))[:, :2]
        ax.add_patch(
            FancyArrowPatch(
                ends[0],
                ends[1],
                arrowstyle="-|>",
                mutation_scale=6,
                lw=1.0,
                color=CONTACT_FORCE,
                zorder=2,
                shrinkA=0,
                shrinkB=0,
            )
        )
    return ax


def _draw_body(ax: Axes, body: Body, view: View) -> None:
    """Draw the faces of a body that are turned to the viewer, over all that is there."""
    corners = view.project(body.points)[body.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    seen = list(corners[normals[:, 2] > 0.0, :, :2])
    faces = PolyCollection(seen, facecolors=body.colour, edgecolors="none", alpha=body.opacity, zorder=1.5)
    ax.add_collection(faces, autolim=False)


def _fine_triangles(corners: NDArray, scene: Scene) -> tuple[NDArray, NDArray]:
    """Corners (m, 3, 3) and their values (m, 3), large triangles split into four until they are small."""
    values = scene.values[scene.triangles]
    done: list[tuple[NDArray, NDArray]] = []
    while len(corners):
        edges = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
        small = edges <= FINEST
        done.append((corners[small], values[small]))
        corners, values = _quartered(corners[~small]), _quartered(values[~small])
    return np.concatenate([c for c, _ in done]), np.concatenate([v for _, v in done])


def _quartered(corners: NDArray) -> NDArray:
    """What stands at the corners of triangles (m, 3, ...), of each one's four quarters (4 m, 3, ...)."""
    a, b, c = (corners[:, k] for k in range(3))
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    quarters = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate([np.stack(one, axis=1) for one in quarters])
