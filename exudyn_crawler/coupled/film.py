"""Graphics of a track over time for Exudyn's renderer: shoes, wheels, frames and ground as triangles."""

from bisect import bisect_left
from typing import Any

import numpy as np
from matplotlib.colors import to_rgba

from exudyn_crawler.coupled.block import TrackBlock
from exudyn_crawler.coupled.placement import Placement
from exudyn_crawler.model.exudyn import FromPointsAndTrigs, exu
from exudyn_crawler.results.history import states
from exudyn_crawler.views.scenes.gear import gear_solids
from exudyn_crawler.views.scenes.scene import Solid
from exudyn_crawler.views.scenes.track import ground_faces, instants, shoe_boxes

SAME = 1e-9
"""Relative difference of times that count as the same."""


class Film:
    """States of a track at intervals of a run (s), and their graphics."""

    def __init__(self, block: TrackBlock, interval: float) -> None:
        self._block = block
        self._interval = interval
        self.times: list[float] = []
        self._rows: list[np.ndarray] = []
        self._drawn: tuple[int, list[dict[str, Any]]] = (-1, [])

    def store(self, time: float) -> None:
        """Store the last step up to a time (s) if it is due."""
        if self.times and time < (self.times[-1] + self._interval) * (1.0 - SAME):
            return
        self.times.append(time)
        self._rows.append(self._block.system.state())

    def graphics_at_shown_time(self, mbs: "exu.MainSystem", _item: int) -> list[dict[str, Any]]:
        """Return Exudyn's graphics data at the time that its renderer shows."""
        return self.graphics(mbs.systemData.GetTime(exu.ConfigurationType.Visualization))

    def graphics(self, time: float) -> list[dict[str, Any]]:
        """Return Exudyn's graphics data of the stored state nearest to a time (s), in the user's frame."""
        if not self.times:
            return self._graphics_of(self._block.system.state())
        after = min(bisect_left(self.times, time), len(self.times) - 1)
        before = max(after - 1, 0)
        nearest = min(before, after, key=lambda k: abs(self.times[k] - time))
        if self._drawn[0] != nearest:
            self._drawn = nearest, self._graphics_of(self._rows[nearest])
        return self._drawn[1]

    def _graphics_of(self, row: np.ndarray) -> list[dict[str, Any]]:
        history = states.system_history(self._block.system, row[None])
        now = instants(history, history.time.values)
        solids = [ground_faces(now), *shoe_boxes(now), *gear_solids(now)]
        return [graphics_of(solid, self._block.placement) for solid in solids]


def graphics_of(solid: Solid, placement: Placement) -> dict[str, Any]:
    """Return a solid of one time as Exudyn's graphics data, in the user's frame."""
    placed = solid.at()
    points = placed.points @ placement.turn.T + placement.position
    data: dict[str, Any] = FromPointsAndTrigs(
        points, placed.triangles, color=list(to_rgba(solid.colour, solid.opacity))
    )
    return data
