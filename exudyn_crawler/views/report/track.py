"""What the report's moving view of a whole track draws: shoes as boxes, ground, side frame and rollers."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.colours import FLEXIBLE_SHOE, GROUND, ROLLER, ROLLER_FORCE, SHOE, SIDE_FRAME
from exudyn_crawler.views.placement import shoe_forces_over_time
from exudyn_crawler.views.report.packing import packed
from exudyn_crawler.views.scales import shoe_force_scale, shown_length
from exudyn_crawler.views.undercarriage import (
    beam_corners,
    frame_of,
    highest_place,
    roller_presses,
    rolls,
    tread_surface,
)

INSTANTS = 101
"""Of the run that are shown, evenly spread."""
BELOW, BESIDE = 0.3, 0.4
"""m that are shown below the ground's surface and beside the shoes."""
COLOURS = {
    "shoe": SHOE,
    "flexible": FLEXIBLE_SHOE,
    "ground": GROUND,
    "roller": ROLLER,
    "frame": SIDE_FRAME,
    "pressing": ROLLER_FORCE,
}


def packed_track(history: History) -> dict[str, Any]:
    """Places of shoes, ground and side frame and the forces on shoes in evenly spread instants of a run."""
    case, shown = history.case, _shown(history)
    x0, x1, y0, y1, z0 = case.shoe.footprint
    flexible = () if case.flexible is None else case.flexible.shoes
    centers, forces = shoe_forces_over_time(shown)
    window = _window(history)
    return {
        "times": shown.time.values.tolist(),
        "shoes": case.track.shoes.tolist(),
        "flexible": list(flexible),
        "box": [[x0, y0, z0], [x1, y1, case.shoe.load_point[2]]],
        "origin": packed(shown.position.transpose("time", "shoe", "axis").values, "f4"),
        "turn": packed(rotation_matrices(shown.angles.transpose("time", "shoe", "axis").values), "f4"),
        "points": packed(centers, "f4"),
        "forces": packed(forces, "f4"),
        "force_scale": shoe_force_scale(history),
        "ground": _ground(case, shown, window[0]),
        "window": window,
        "undercarriage": packed_undercarriage(case) | _rolled(shown) if rolls(shown) else None,
        "colours": COLOURS,
    }


def packed_undercarriage(case: Case) -> dict[str, Any]:
    """Shape of the side frame and its rollers in the frame's axes."""
    frame, middles = frame_of(case)
    points, triangles = tread_surface(frame)
    return {
        "rollers": list(frame.rollers),
        "middles": list(middles),
        "tread": packed(points, "f4"),
        "triangle": packed(triangles, "u4"),
        "beam": beam_corners(case).tolist(),
    }


def _shown(history: History) -> xr.Dataset:
    """Instants of a history that are shown."""
    times = np.linspace(0.0, history.duration, INSTANTS)
    rows = history.dataset.get_index("time").get_indexer(times, method="nearest")
    return history.dataset.isel(time=np.unique(rows)).load()


def _rolled(shown: xr.Dataset) -> dict[str, Any]:
    """Places of a side frame over time, and what its rollers press with."""
    presses = [roller_presses(shown.isel(time=row)) for row in range(shown.sizes["time"])]
    points, forces = (np.array(one) for one in zip(*presses, strict=True))
    return {
        "origin": packed(shown.side_frame_position.values, "f4"),
        "turn": packed(rotation_matrices(shown.side_frame_angles.values), "f4"),
        "points": packed(points, "f4"),
        "forces": packed(forces, "f4"),
    }


def _ground(case: Case, shown: xr.Dataset, length: Sequence[float]) -> dict[str, Any]:
    """Corners of the units' faces at rest, and their heave in 16-bit steps of its greatest magnitude.

    Units whose middle lies outside a length (least and greatest x, m) are left out.
    """
    terrain = case.terrain
    near = (terrain.middles[:, 0] >= length[0]) & (terrain.middles[:, 0] <= length[1])
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
    corners = np.zeros((terrain.unit_count, 4, 3))
    offsets = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners[..., :2] = terrain.middles[:, None] + offsets
    corners[..., 2] = terrain.top_heights[:, None] + terrain.slopes[:, None] * offsets[:, 0]
    heave = shown.unit_heave.transpose("time", "unit").values[:, near]
    step = max(float(np.abs(heave).max()), 1e-9) / 32767.0
    return {
        "corners": packed(corners[near], "f4"),
        "heave": packed(np.rint(heave / step), "i2"),
        "step": step,
        "limits": [1e3 * float(heave.min()), 1e3 * float(heave.max())],
    }


def _window(history: History) -> list[list[float]]:
    """Least and greatest x, y and z to be shown, m."""
    shoe = history.case.shoe
    y = history.position.sel(axis="y")
    tops = history.case.terrain.top_heights
    sideways = 0.5 * shoe.width + BESIDE
    top = float(tops.max(initial=0.0)) + 2.0 * (shoe.com_height + shoe.load_point[2])
    if rolls(history.dataset):
        top = max(top, highest_place(history))
    return [
        list(shown_length(history)),
        [float(y.min()) - sideways, float(y.max()) + sideways],
        [float(tops.min(initial=0.0)) - BELOW, top],
    ]
