"""Track and terrain from above at one time, on axes of matplotlib."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.colours import GROUND_EDGE, HEAVE_MAP
from exudyn_crawler.views.placement import shoe_poses
from exudyn_crawler.views.rolling_views import PlanRollers
from exudyn_crawler.views.scales import shown_length
from exudyn_crawler.views.undercarriage import rolls


class PlanView:
    """Shoes and rollers from above on units coloured by their heave; `show` brings them to a time.

    Parameters
    ----------
    ax : Axes
    history : History

    Attributes
    ----------
    ground : PolyCollection
        The units, for a colour bar of their heave in mm.
    """

    def __init__(self, ax: Axes, history: History) -> None:
        case, terrain = history.case, history.case.terrain
        x0, x1, y0, y1, z = case.shoe.footprint
        self._outline = np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
        half = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
        corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        heave = 1e3 * history.unit_heave.values
        self.ground = PolyCollection(
            list(terrain.middles[:, None] + corners),
            array=heave[0],
            cmap=HEAVE_MAP,
            clim=(heave.min(), heave.max()),
            edgecolors=GROUND_EDGE,
            linewidths=0.4,
        )
        self._shoes = PolyCollection(
            [], facecolors=to_rgba("white", 0.35), edgecolors="black", linewidths=0.9
        )
        ax.add_collection(self.ground)
        ax.add_collection(self._shoes)
        self._numbers = [
            ax.text(0.0, 0.0, str(shoe), ha="center", va="center", fontsize=7) for shoe in case.track.shoes
        ]
        self._rollers = PlanRollers(ax, case) if rolls(history.dataset) else None
        y = history.position.sel(axis="y")
        sideways = 0.5 * case.shoe.width + 0.4
        ax.set(
            xlim=shown_length(history),
            ylim=(float(y.min()) - sideways, float(y.max()) + sideways),
            aspect="equal",
            ylabel="y in m",
        )

    def show(self, now: xr.Dataset) -> None:
        """Bring everything to one instant of the history."""
        poses = shoe_poses(now)
        self._shoes.set_verts([pose.place(self._outline)[:, :2] for pose in poses])
        self.ground.set_array(1e3 * now.unit_heave.values)
        for label, pose in zip(self._numbers, poses, strict=True):
            label.set_position((pose.origin[0], pose.origin[1]))
        if self._rollers is not None:
            self._rollers.show(now)
