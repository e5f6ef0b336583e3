"""Recognized shoe as a figure of Plotly, each named surface in its own colour."""

import numpy as np

from exudyn_crawler.views.scenes.plots import CONFIG, DIGITS, Figure
from fem import Mesh
from meshes.draw_shoe import STEEL_COLOR, face_names
from meshes.recognition.picture import COLORS

REST = "rest of the surface"
WAYS = {"x": "ahead", "y": "left", "z": "up"}


def shoe_figure(mesh: Mesh) -> Figure:
    """Return a shoe in 3D, each named surface in its own colour."""
    names = face_names(mesh, COLORS)
    traces = []
    look: Figure = {"type": "mesh3d", "flatshading": True, "showlegend": True, "hoverinfo": "name"}
    for name in dict.fromkeys(names):
        used, faces = np.unique(mesh.boundary[names == name][:, :3], return_inverse=True)
        columns = [*np.round(mesh.nodes[used], DIGITS).T, *faces.reshape(-1, 3).T]
        shape = {axis: column.tolist() for axis, column in zip("xyzijk", columns, strict=True)}
        traces.append(look | shape | {"name": name or REST, "color": COLORS.get(name, STEEL_COLOR)})
    axes = {f"{axis}axis": {"title": {"text": f"{axis}, {way}"}} for axis, way in WAYS.items()}
    layout = {"margin": {"l": 0, "r": 0, "t": 0, "b": 0}, "scene": {"aspectmode": "data"} | axes}
    layout |= {"legend": {"orientation": "h"}, "uirevision": "kept"}
    return {"data": traces, "layout": layout, "config": CONFIG}
