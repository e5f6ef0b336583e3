"""Track and terrain from the side at one time, on axes of matplotlib.

The ground's displacement under the track is millimetres, from where its own weight leaves it, and can be
drawn larger. Shoes are then lifted or lowered with the ground beneath them, so that their depth in it keeps
its true scale.
"""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.colours import CONTACT_FORCE, FLEXIBLE_SHOE, GROUND, GROUND_EDGE, SHOE, SHOE_EDGE
from exudyn_crawler.views.force_arrows import force_arrows
from exudyn_crawler.views.placement import shoe_forces, shoe_poses, unloaded_level
from exudyn_crawler.views.rolling_views import SideRollers
from exudyn_crawler.views.scales import shown_length
from exudyn_crawler.views.undercarriage import highest_place, rolls

DEPTH = 1.0
"""m of ground that is drawn."""
ABOVE = 0.4
"""m that are drawn above the side frame, which magnified ground may lift."""


class SideView:
    """Shoes, pins, units, contact forces and rollers seen from the right; `show` brings them to a time.

    Units are those of the row below the track's middle; shoes overlap them by their penetration.

    Parameters
    ----------
    ax : Axes
        Its limits become those of the whole run, x and z in m to the same scale. What is drawn is labelled
        for a legend.
    history : History
    scale : float
        Magnification of the ground's displacements.
    force_scale : float
        m that are drawn for 1 N; 0 draws no forces.
    filled : bool
        Fill the shoes; otherwise only their outlines are drawn.
    """

    def __init__(
        self,
        ax: Axes,
        history: History,
        scale: float = 1.0,
        force_scale: float = 0.0,
        filled: bool = True,
    ) -> None:
        shoe, track = history.case.shoe, history.case.track
        self._case, self._scale, self._force_scale = history.case, scale, force_scale
        low, high = shoe.footprint[:2]
        bottom, top = -shoe.com_height, shoe.load_point[2]
        self._outline = np.array([[low, 0, bottom], [high, 0, bottom], [high, 0, top], [low, 0, top]])
        self._pins = np.array([track.rear_pin, track.front_pin]) * [1.0, 0.0, 1.0]
        self._row = self._middle_row(history)
        self._tops = history.case.terrain.top_heights[self._row]
        self._ground = PolyCollection(
            [], facecolors=GROUND, edgecolors=GROUND_EDGE, linewidths=0.6, zorder=0, label="units"
        )
        self._shoes = PolyCollection(
            [],
            facecolors=[to_rgba(colour, 0.75 if filled else 0.0) for colour in self._shoe_colours()],
            edgecolors=SHOE_EDGE,
            linewidths=0.8,
            zorder=0.8,
            label="shoes",
        )
        ax.add_collection(self._ground)
        ax.add_collection(self._shoes)
        (self._pin_marks,) = ax.plot(
            [], [], "o", ms=3.0, mfc="white", mec=SHOE_EDGE, mew=0.8, zorder=3, label="link pins"
        )
        self._forces = force_arrows(ax, track.shoe_count, CONTACT_FORCE)
        self._rollers = SideRollers(ax, self._case, force_scale) if rolls(history.dataset) else None
        self._set_window(ax, history)

    def _shoe_colours(self) -> list[str]:
        flexible = () if self._case.flexible is None else self._case.flexible.shoes
        return [FLEXIBLE_SHOE if shoe in flexible else SHOE for shoe in self._case.track.shoes]

    def _middle_row(self, history: History) -> NDArray:
        """Indices of the units in the row under the track's middle line."""
        terrain = self._case.terrain
        y = float(history.position.sel(axis="y").isel(time=0).mean())
        row = int(np.clip((y - terrain.origin[1]) // terrain.unit_width, 0, terrain.rows - 1))
        return np.arange(terrain.columns) * terrain.rows + row

    def _set_window(self, ax: Axes, history: History) -> None:
        """Make the axes show the length that the run covers, and the ground and the track there."""
        x = shown_length(history)
        terrain, shoe = self._case.terrain, self._case.shoe
        away = np.abs(terrain.middles[self._row, 0] - np.mean(x))
        tops = self._tops[away < 0.5 * (np.ptp(x) + terrain.unit_length)]
        top = tops.max(initial=0.0) + 2.0 * (shoe.com_height + shoe.load_point[2])
        if self._rollers is not None:
            top = max(top, highest_place(history) + ABOVE)
        ax.set(
            xlim=x,
            ylim=(tops.min(initial=0.0) - DEPTH, top),
            aspect="equal",
            xlabel="x in m",
            ylabel="z in m",
        )

    def _surface(self, now: xr.Dataset) -> tuple[NDArray, NDArray]:
        """Rear and front edges of the units' top faces: x and displacement in z, arrays (columns, 2), m."""
        terrain = self._case.terrain
        offset = 0.5 * terrain.unit_length * np.array([-1.0, 1.0])
        # a positive pitch lowers the front edge
        pitch = now.unit_tilt.values[self._row] if terrain.tilt == "pitch" else np.zeros(len(self._row))
        displacement = now.unit_heave.values[self._row, None] - pitch[:, None] * offset
        return terrain.middles[self._row, :1] + offset, displacement

    def show(self, now: xr.Dataset) -> None:
        """Bring everything to one instant of the history."""
        x, displacement = self._surface(now)
        larger = (self._scale - 1.0) * (displacement - unloaded_level(self._case))
        rise = self._case.terrain.slopes[self._row, None] * (x - x.mean(axis=1, keepdims=True))
        top = self._tops[:, None] + rise + displacement + larger
        deep = np.full(x.shape, self._tops.min() - 2.0 * DEPTH)
        outline_x = np.concatenate((x, x[:, ::-1]), axis=1)
        outline_z = np.concatenate((deep, top[:, ::-1]), axis=1)
        self._ground.set_verts(list(np.stack((outline_x, outline_z), axis=-1)))

        def beneath(places: NDArray) -> NDArray:
            return np.interp(places, x.ravel(), larger.ravel())

        def drawn(points: NDArray) -> NDArray:
            return np.column_stack((points[:, 0], points[:, 2] + beneath(points[:, 0])))

        poses = shoe_poses(now)
        self._shoes.set_verts([drawn(pose.place(self._outline)) for pose in poses])
        pins = drawn(np.concatenate([pose.place(self._pins) for pose in poses]))
        self._pin_marks.set_data(pins[:, 0], pins[:, 1])
        if self._force_scale > 0.0:
            centers, forces = shoe_forces(now)
            met = np.isfinite(centers[:, :1])
            self._forces.set_offsets(drawn(centers))
            length = np.where(met, self._force_scale * forces, np.nan)
            self._forces.set_UVC(length[:, 0], length[:, 2])
        if self._rollers is not None:
            self._rollers.show(now, beneath)
