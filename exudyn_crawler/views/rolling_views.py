"""Side frame and rollers from the side and from above, on axes of matplotlib."""

from collections.abc import Callable

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.views.colours import ROLLER, ROLLER_EDGE, ROLLER_FORCE, SIDE_FRAME
from exudyn_crawler.views.force_arrows import force_arrows
from exudyn_crawler.views.undercarriage import (
    beam_corners,
    frame_of,
    frame_pose,
    roller_presses,
    roller_turn,
    tread_centers,
)

Lift = Callable[[NDArray], NDArray]
"""Gives at x (n,) how much higher than it is the ground is drawn, (n,), m."""


def beam_box(case: Case, axis: int) -> NDArray:
    """Corners (4, 3) of the drawn beam in the frame's axes, seen along one of them, at its upper side, m."""
    low, high = beam_corners(case)
    low[axis] = high[axis]
    across = 3 - axis
    corners = np.array([low, low, high, high])
    corners[1, 0], corners[3, 0] = high[0], low[0]
    corners[1, across], corners[3, across] = low[across], high[across]
    return corners


class SideRollers:
    """Frame, rollers and what each presses with, seen from the right; `show` brings them to a time.

    Rollers keep their depth in the rails where the ground's displacement is drawn larger; the frame is lifted
    by their mean.

    Parameters
    ----------
    ax : Axes
    case : Case
    force_scale : float
        m that are drawn for 1 N; 0 draws no forces.
    """

    def __init__(self, ax: Axes, case: Case, force_scale: float) -> None:
        frame, _ = frame_of(case)
        self._case, self._force_scale = case, force_scale
        around = np.linspace(0.0, 2.0 * np.pi, 49)[:-1]
        self._rim = frame.radius * np.column_stack((np.cos(around), np.sin(around)))
        self._beam_box = beam_box(case, 1)
        self._beam = PolyCollection(
            [], facecolors=to_rgba(SIDE_FRAME, 0.5), edgecolors=ROLLER_EDGE, linewidths=0.8, zorder=0.9
        )
        self._discs = PolyCollection(
            [],
            facecolors=to_rgba(ROLLER, 0.8),
            edgecolors=ROLLER_EDGE,
            linewidths=0.8,
            zorder=1.1,
            label="rollers",
        )
        self._spokes = LineCollection([], colors=ROLLER_EDGE, linewidths=0.8, zorder=1.2)
        for collection in (self._beam, self._discs, self._spokes):
            ax.add_collection(collection)
        self._forces = force_arrows(ax, len(frame.rollers), ROLLER_FORCE)

    def show(self, now: xr.Dataset, lift: Lift) -> None:
        """Bring everything to one instant of the history."""
        centers = tread_centers(now, self._case).mean(axis=1)
        raised = lift(centers[:, 0])
        hubs = np.column_stack((centers[:, 0], centers[:, 2] + raised))
        self._discs.set_verts(list(hubs[:, None] + self._rim))
        turn = roller_turn(now, self._case)
        spoke = np.array([np.sin(turn), np.cos(turn)]) * np.abs(self._rim).max()
        self._spokes.set_segments(list(np.stack((hubs - spoke, hubs + spoke), axis=1)))
        beam = frame_pose(now).place(self._beam_box)
        self._beam.set_verts([np.column_stack((beam[:, 0], beam[:, 2] + raised.mean()))])
        if self._force_scale > 0.0:
            places, forces = roller_presses(now)
            # a roller that presses on nothing has no place
            x = np.where(np.isfinite(places[:, 0]), places[:, 0], centers[:, 0])
            self._forces.set_offsets(np.column_stack((x, places[:, 2] + lift(x))))
            length = np.where(np.isfinite(places), self._force_scale * forces, np.nan)
            self._forces.set_UVC(length[:, 0], length[:, 2])


class PlanRollers:
    """Frame and treads from above; `show` brings them to a time."""

    def __init__(self, ax: Axes, case: Case) -> None:
        frame, _ = frame_of(case)
        self._case, self._beam_box = case, beam_box(case, 2)
        half = np.array([frame.radius, 0.5 * frame.tread_width, 0.0])
        self._tread = half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        self._beam = PolyCollection(
            [], facecolors=to_rgba(SIDE_FRAME, 0.5), edgecolors=ROLLER_EDGE, linewidths=0.8
        )
        self._treads = PolyCollection(
            [], facecolors=to_rgba(ROLLER, 0.8), edgecolors=ROLLER_EDGE, linewidths=0.6
        )
        ax.add_collection(self._beam)
        ax.add_collection(self._treads)

    def show(self, now: xr.Dataset) -> None:
        """Bring everything to one instant of the history."""
        pose = frame_pose(now)
        centers = tread_centers(now, self._case).reshape(-1, 1, 3)
        self._treads.set_verts(list((centers + pose.turn(self._tread))[..., :2]))
        self._beam.set_verts([pose.place(self._beam_box)[:, :2]])
