"""Where the side frame and its rollers are at one time of a rolled run, and what the rollers press with.

The frame is drawn as a beam between the rails: its parameters say how long it is, not how high and wide.
"""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case, Undercarriage
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.placement import Pose, touching

BEAM = (0.05, 0.85)
"""m above the rollers' axes that the drawn beam reaches from and to."""
GAP = 0.03
"""m between the beam and the treads beside it."""
SIDES = 32
"""Of the prism that a tread is drawn as."""


def rolls(now: xr.Dataset) -> bool:
    """Whether a side frame rolls over the track of a history's instant."""
    return "roller_force" in now


def frame_of(case: Case) -> tuple[Undercarriage, tuple[float, float]]:
    """Undercarriage and the lateral places of the rails' middles, m.

    Raises
    ------
    ValueError
        If the case is dragged.
    """
    frame, rails = case.undercarriage, case.shoe.rails
    if frame is None or rails is None:
        raise ValueError(f"the case {case.name!r} must have an undercarriage to show one")
    return frame, rails.middles


def frame_pose(now: xr.Dataset) -> Pose:
    """Place of the side frame's origin and axes."""
    return Pose(now.side_frame_position.values, rotation_matrices(now.side_frame_angles.values))


def tread_centers(now: xr.Dataset, case: Case) -> NDArray:
    """Middles of the treads on the rollers' axes: array (rollers, rails, 3), m, global."""
    frame, middles = frame_of(case)
    places = np.array([[(x, y, 0.0) for y in middles] for x in frame.rollers])
    return frame_pose(now).place(places.reshape(-1, 3)).reshape(places.shape)


def roller_turn(now: xr.Dataset, case: Case) -> float:
    """Angle about the rollers' axes by which they have rolled since t = 0, rad, from z to x."""
    frame, _ = frame_of(case)
    return float(now.side_frame_position.values[0] - frame.start) / frame.radius


def beam_corners(case: Case) -> NDArray:
    """Least and greatest coordinates of the drawn beam in the frame's axes: array (2, 3), m."""
    frame, middles = frame_of(case)
    half = 0.5 * (max(middles) - min(middles) - frame.tread_width) - GAP
    return np.array([[frame.ends[0], -half, BEAM[0]], [frame.ends[1], half, BEAM[1]]])


def tread_surface(frame: Undercarriage) -> tuple[NDArray, NDArray]:
    """Points (n, 3) of a tread about its middle, m, and its triangles (m, 3) in outward sense."""
    around = 2.0 * np.pi * np.arange(SIDES) / SIDES
    rim = frame.radius * np.column_stack((np.sin(around), np.zeros(SIDES), np.cos(around)))
    side = np.array([0.0, 0.5 * frame.tread_width, 0.0])
    points = np.concatenate((rim - side, rim + side, [-side, side]))
    right = np.arange(SIDES)
    next_right, left = np.roll(right, -1), right + SIDES
    next_left = next_right + SIDES
    triangles = [
        (right, next_right, next_left),
        (right, next_left, left),
        (np.full(SIDES, 2 * SIDES), next_right, right),
        (np.full(SIDES, 2 * SIDES + 1), left, next_left),
    ]
    return points, np.concatenate([np.stack(one, axis=1) for one in triangles])


def rollers_surface(now: xr.Dataset, case: Case) -> tuple[NDArray, NDArray]:
    """Points (n, 3) of all treads, roller by roller and its right one first, m, global; triangles (m, 3)."""
    frame, _ = frame_of(case)
    points, triangles = tread_surface(frame)
    centers = tread_centers(now, case).reshape(-1, 1, 3)
    placed = centers + frame_pose(now).turn(points)
    starts = len(points) * np.arange(len(centers))[:, None, None]
    return placed.reshape(-1, 3), (triangles + starts).reshape(-1, 3)


def pressing(now: xr.Dataset, shoe: int | None = None) -> tuple[NDArray, NDArray]:
    """Strips of treads that press on one shoe, or on all, in one instant.

    Returns
    -------
    points, forces : arrays (strips, 3)
        Where they press (m) and what acts on the shoe (N), both global.
    """
    dims = ("roller", "rail", "strip", "neighbour", "axis")
    forces, points = (now[name].transpose(*dims).values for name in ("tread_force", "tread_foot"))
    meets = forces.any(axis=-1)
    if shoe is not None:
        number = now.roller_shoe.values[:, None] + np.arange(forces.shape[3])
        meets &= (number == shoe)[:, None, None, :]
    return points[meets], forces[meets]


def acting(now: xr.Dataset, shoe: int | None = None) -> tuple[NDArray, NDArray]:
    """Contacts with the ground of one shoe or of all, and the treads that press there, as of `touching`."""
    points, forces = touching(now, shoe)
    if not rolls(now):
        return points, forces
    others = pressing(now, shoe)
    return np.concatenate((points, others[0])), np.concatenate((forces, others[1]))


def roller_presses(now: xr.Dataset) -> tuple[NDArray, NDArray]:
    """Centre of what each roller presses on, array (rollers, 3), m, and its force, array (rollers, 3), N.

    The centre of a roller that presses on nothing is not a number.
    """
    dims = ("roller", "rail", "strip", "neighbour", "axis")
    forces, points = (now[name].transpose(*dims).values for name in ("tread_force", "tread_foot"))
    size = np.linalg.norm(forces, axis=-1)
    weight = size.sum(axis=(1, 2, 3))
    centers = np.full((len(forces), 3), np.nan)
    moments = np.einsum("rabn,rabnk->rk", size, points)
    np.divide(moments, weight[:, None], out=centers, where=weight[:, None] > 0.0)
    return centers, forces.sum(axis=(1, 2, 3))


def highest_place(history: History) -> float:
    """Height of the drawn beam's upper side at its highest, m."""
    return float(history.side_frame_position.sel(axis="z").max()) + BEAM[1]
