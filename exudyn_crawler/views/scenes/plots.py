"""Scenes as figures of Plotly, plain tables for a browser: outlines from the right, and 3D views."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from exudyn_crawler.views.scenes.pictures import FROM_THE_RIGHT
from exudyn_crawler.views.scenes.scene import Solid
from exudyn_crawler.views.scenes.start import SECTION
from fem.body.mesh import triangle_normals

DIGITS = 4  # of places in m: a tenth of a millimetre
SHOES, GROUND = "shoes", "ground"
"""Suffix of the names of translucent solids, and name of the solid that only 3D views show."""
SEEN_THROUGH = 0.75  # opacity of shoes
EYE = {"x": 0.7, "y": -1.35, "z": 0.7}
"""Initial position of the viewer: behind and to the right of the machine, above it."""
CONFIG = {"displaylogo": False, "responsive": True, "modeBarButtonsToRemove": ["select2d", "lasso2d"]}
BELOW, ABOVE = 0.35, 0.15
"""Distances (m) that the view from the right shows below and above the machine."""
FAR_SIDE = "left "  # prefix of the names of bodies that the near side hides

Figure = dict[str, Any]


def side_figure(solids: Sequence[Solid]) -> Figure:
    """Return the outlines of solids seen from the right, with the near track alone."""
    near = [solid for solid in solids if not solid.name.startswith((FAR_SIDE, GROUND))]
    traces = [_outlines(solid) for solid in sorted(near, key=lambda solid: solid.name.endswith(SHOES))]
    section = next(solid for solid in solids if solid.name == SECTION)
    traces.insert(0, _outlines(section))
    heights = np.concatenate([solid.at().points[:, 2] for solid in near])
    window = [float(heights.min()) - BELOW, float(heights.max()) + ABOVE]
    axis = {"zeroline": False, "showgrid": True, "gridcolor": "#eef0f2", "linecolor": "#889"}
    layout = {
        "margin": {"l": 50, "r": 8, "t": 8, "b": 38},
        "xaxis": axis | {"title": {"text": "x in m"}, "constrain": "domain"},
        "yaxis": axis | {"title": {"text": "z in m"}, "scaleanchor": "x", "range": window},
        "showlegend": False,
        "hovermode": "closest",
        "plot_bgcolor": "white",
    }
    return {"data": traces, "layout": layout, "config": CONFIG}


def space_figure(solids: Sequence[Solid]) -> Figure:
    """Return solids in 3D, to be turned with the pointer."""
    hidden = {"visible": False}
    scene = {"aspectmode": "data", "camera": {"eye": EYE}}
    scene |= {"xaxis": hidden, "yaxis": hidden, "zaxis": hidden}
    layout = {"margin": {"l": 0, "r": 0, "t": 0, "b": 0}, "scene": scene, "uirevision": "kept"}
    return {
        "data": [mesh_trace(solid) for solid in solids if solid.name != SECTION],
        "layout": layout,
        "config": CONFIG,
    }


def curve_figure(title: str, values: xr.DataArray) -> Figure:
    """Return a curve over time as a figure."""
    trace = {"type": "scatter", "x": values.time.values.tolist(), "y": values.values.tolist()}
    layout = {
        "margin": {"l": 60, "r": 10, "t": 28, "b": 36},
        "title": {"text": f"{title}, {values.units}", "font": {"size": 13}, "x": 0.02},
        "xaxis": {"title": {"text": "time in s"}},
        "yaxis": {"rangemode": "tozero"},
    }
    return {"data": [trace], "layout": layout, "config": CONFIG}


def mesh_trace(solid: Solid) -> Figure:
    """Return all copies of a solid as triangles in 3D."""
    placed = solid.at()
    x, y, z = _rounded(placed.points).T.tolist()
    i, j, k = placed.triangles.T.tolist()
    corners = {"type": "mesh3d", "x": x, "y": y, "z": z, "i": i, "j": j, "k": k}
    look = {"color": solid.colour, "opacity": solid.opacity, "flatshading": True, "name": solid.name}
    return corners | look | {"hoverinfo": "name", "lighting": {"ambient": 0.6, "diffuse": 0.6}}


def _outlines(solid: Solid) -> Figure:
    """Return the faces of a solid turned to the viewer as one line with gaps between them."""
    placed = solid.at()
    points = FROM_THE_RIGHT.project(placed.points)
    parts = []
    for faces in placed.faces:
        corners = points[faces]
        turned = triangle_normals(corners)[:, 2] > 1e-9
        seen = corners[turned][..., :2]
        closed = np.concatenate((seen, seen[:, :1], np.full((len(seen), 1, 2), np.nan)), axis=1)
        parts.append(closed.reshape(-1, 2))
    way = _rounded(np.concatenate(parts))
    x, z = ([None if np.isnan(value) else value for value in column.tolist()] for column in way.T)
    has_edges = solid.edges.startswith("#") and placed.faces[-1].shape[1] > 3
    line = {"color": solid.edges if has_edges else solid.colour, "width": 0.8}
    opacity = SEEN_THROUGH if solid.name.endswith(SHOES) else 1.0
    drawn = {"type": "scatter", "mode": "lines", "x": x, "y": z, "fill": "toself", "line": line}
    return drawn | {"fillcolor": solid.colour, "opacity": opacity, "name": solid.name, "hoverinfo": "name"}


def _rounded(points: np.ndarray) -> np.ndarray:
    return np.round(points, DIGITS)
