"""Picture of a recognized shoe from four sides, with each named surface in its colour."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fem.body.mesh import Mesh
from meshes.draw_shoe import LIGHT, draw_surface, named_colors

COLORS = {
    "underside": "#6a8f5a",
    "top": "#e8c48a",
    "roller path": "#d98c3f",
    "bore front right": "#b23a48",
    "bore front left": "#e07a5f",
    "bore rear right": "#2f5d9b",
    "bore rear left": "#7fb3d5",
}
"""Colours of surfaces; a later one covers an earlier one."""
VIEWS = {
    "from the front, above": (28, 35),
    "from the rear, above": (28, 215),
    "from the front, below": (-28, 35),
    "from the rear, below": (-28, 215),
}
"""Elevation and azimuth of the viewer, degrees: x is ahead, y to the left, z up."""
ARROW = 0.07
"""Length of the axes beyond the shoe, fraction of its extent."""
FROM_BELOW = np.array([1.0, 1.0, -1.0])
"""Factors on the light for views from below."""


def draw_recognized(figure: Figure, mesh: Mesh) -> None:
    """Draw a shoe from four sides into an empty figure, with its axes and a legend of its surfaces."""
    figure.set_layout_engine("none")
    shown = {name: color for name, color in COLORS.items() if name in mesh.surfaces}
    colors = named_colors(mesh, shown)
    high = mesh.nodes.max(axis=0)
    tips = np.diag(high + ARROW * float(np.ptp(mesh.nodes, axis=0).max()))
    for place, (title, (elevation, azimuth)) in enumerate(VIEWS.items()):
        corner = (0.5 * (place % 2) - 0.05, 0.48 - 0.44 * (place // 2), 0.6, 0.5)
        light = LIGHT * (FROM_BELOW if elevation < 0 else 1.0)
        empty = figure.add_axes(corner, projection="3d")
        ax = draw_surface(empty, mesh, colors, elevation, azimuth, light)
        ax.set_box_aspect(tuple(np.ptp(mesh.nodes, axis=0)), zoom=1.0)
        ax.set_axis_off()
        ax.set_title(title, y=0.86, fontsize=9)
        for tip, name in zip(tips, ("x ahead", "y left", "z up"), strict=True):
            ax.plot(*np.stack((np.zeros(3), tip)).T, color="#333333", lw=0.8, zorder=9)
            ax.text(*tip, name, fontsize=7, zorder=10)
    handles = [Patch(facecolor=color, label=name) for name, color in shown.items()]
    figure.legend(handles=handles, loc="lower center", ncols=4, fontsize=8, frameon=False)
