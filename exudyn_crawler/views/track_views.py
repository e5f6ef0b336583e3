"""Track and terrain at one time, from the side and from above, on axes of matplotlib.

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

from exudyn_crawler.case import Case
from exudyn_crawler.results.history import History
from exudyn_crawler.views.placement import Pose, drawn_scale, touching
from exudyn_crawler.views.scenes import ARROW_COLOUR

GROUND_COLOUR = "#e2d3b3"
GROUND_EDGE = "#8a7748"
SHOE_COLOUR = "#9fb1bd"
FLEXIBLE_COLOUR = "#d98c3f"
SHOE_EDGE = "#3c4a54"
DEEPEST = 0.25
"""m that the greatest displacement of the ground is drawn at most."""
DEPTH = 1.0
"""m of ground that is drawn."""
LONGEST = 0.7
"""m, length at which the greatest contact force is drawn."""


def ground_scale(history: History) -> float:
    """Round factor that makes the ground's displacements visible."""
    return max(1.0, drawn_scale(history.unit_heave.values - unloaded_level(history.case), DEEPEST))


def unloaded_level(case: Case) -> float:
    """Heave of units that carry nothing but themselves, m."""
    return -case.terrain.unit_mass * case.gravity / case.terrain.heave_stiffness


def shoe_forces(now: xr.Dataset) -> tuple[NDArray, NDArray]:
    """Contact of each shoe in one instant: centre of pressure (shoes, 3), m, and force (shoes, 3), N.

    The centre of a shoe without contact is not a number.
    """
    found = [touching(now, int(shoe)) for shoe in now.shoe.values]
    centers = np.full((len(found), 3), np.nan)
    for row, (points, forces) in enumerate(found):
        pressed = forces[:, 2].sum()
        if pressed > 0.0:
            centers[row] = forces[:, 2] @ points / pressed
    return centers, np.array([forces.sum(axis=0) for _, forces in found]).reshape(-1, 3)


def greatest_shoe_force(history: History) -> float:
    """Greatest contact force on a shoe over the run, N."""
    total = (history.normal_force + history.friction_force).groupby("contact_shoe").sum()
    return float(np.sqrt((total**2).sum("axis")).max())


def _height(case: Case) -> float:
    return case.shoe.com_height + case.shoe.load_point[2]


def _extent(history: History) -> tuple[float, float]:
    """Least and greatest x that shoes reach, m."""
    x = history.position.sel(axis="x")
    low, high = history.case.shoe.footprint[:2]
    return float(x.min()) + low, float(x.max()) + high


class SideView:
    """Shoes, units and contact forces seen from the right; `show` brings them to a time.

    Parameters
    ----------
    ax : Axes
    history : History
    scale : float
        Magnification of the ground's displacements.
    force_scale : float
        m that are drawn for 1 N.
    filled : bool
        Fill the shoes; otherwise only their outlines are drawn.
    """

    def __init__(
        self, ax: Axes, history: History, scale: float, force_scale: float, filled: bool = True
    ) -> None:
        case = history.case
        self._case, self._scale, self._force_scale = case, scale, force_scale
        low, high = case.shoe.footprint[:2]
        bottom, top = -case.shoe.com_height, case.shoe.load_point[2]
        self._outline = np.array([[low, 0, bottom], [high, 0, bottom], [high, 0, top], [low, 0, top]])
        self._pins = np.array([case.track.rear_pin, case.track.front_pin]) * [1.0, 0.0, 1.0]
        self._row = self._middle_row(history)
        flexible = () if case.flexible is None else case.flexible.shoes
        colours = [FLEXIBLE_COLOUR if shoe in flexible else SHOE_COLOUR for shoe in case.track.shoes]
        self._ground = PolyCollection(
            [], facecolors=GROUND_COLOUR, edgecolors=GROUND_EDGE, linewidths=0.6, zorder=0
        )
        self._shoes = PolyCollection(
            [],
            facecolors=[to_rgba(colour, 0.75 if filled else 0.0) for colour in colours],
            edgecolors=SHOE_EDGE,
            linewidths=0.8,
            zorder=0.8,
        )
        ax.add_collection(self._ground)
        ax.add_collection(self._shoes)
        (self._pin_marks,) = ax.plot([], [], "o", ms=3.0, mfc="white", mec=SHOE_EDGE, mew=0.8, zorder=3)
        count = case.track.shoe_count
        self._forces = ax.quiver(
            np.zeros(count),
            np.zeros(count),
            np.ones(count),
            np.ones(count),
            color=ARROW_COLOUR,
            angles="xy",
            scale_units="xy",
            scale=1.0,
            pivot="tip",
            width=0.0022,
            zorder=4,
        )
        least, greatest = _extent(history)
        ax.set(
            xlim=(least - 0.6, greatest + 0.6),
            ylim=(-DEPTH, 2.0 * _height(case)),
            aspect="equal",
            xlabel="x in m",
            ylabel="z in m",
        )

    def _middle_row(self, history: History) -> NDArray:
        """Indices of the units in the row under the track's middle line."""
        terrain = self._case.terrain
        y = float(history.position.sel(axis="y").isel(time=0).mean())
        row = int(np.clip((y - terrain.origin[1]) // terrain.unit_width, 0, terrain.rows - 1))
        return np.arange(terrain.columns) * terrain.rows + row

    def _surface(self, now: xr.Dataset) -> tuple[NDArray, NDArray]:
        """Rear and front edges of the units' top faces: x and z, arrays (columns, 2), m."""
        terrain = self._case.terrain
        offset = 0.5 * terrain.unit_length * np.array([-1.0, 1.0])
        # a positive pitch lowers the front edge
        pitch = now.unit_tilt.values[self._row] if terrain.tilt == "pitch" else np.zeros(len(self._row))
        heights = now.unit_heave.values[self._row, None] - pitch[:, None] * offset
        return terrain.centers[self._row, :1] + offset, heights

    def show(self, now: xr.Dataset) -> None:
        """Bring everything to one instant of the history."""
        x, z = self._surface(now)
        larger = (self._scale - 1.0) * (z - unloaded_level(self._case))
        deep = np.full(x.shape, -2.0 * DEPTH)
        self._ground.set_verts(
            list(
                np.stack(
                    (
                        np.concatenate((x, x[:, ::-1]), axis=1),
                        np.concatenate((deep, (z + larger)[:, ::-1]), axis=1),
                    ),
                    axis=-1,
                )
            )
        )

        def drawn(points: NDArray) -> NDArray:
            beneath = np.interp(points[:, 0], x.ravel(), larger.ravel())
            return np.column_stack((points[:, 0], points[:, 2] + beneath))

        poses = [Pose.of(now, int(shoe)) for shoe in now.shoe.values]
        self._shoes.set_verts([drawn(pose.place(self._outline)) for pose in poses])
        pins = drawn(np.concatenate([pose.place(self._pins) for pose in poses]))
        self._pin_marks.set_data(pins[:, 0], pins[:, 1])
        centers, forces = shoe_forces(now)
        met = np.isfinite(centers[:, :1])
        self._forces.set_offsets(np.where(met, drawn(np.where(met, centers, 0.0)), 0.0))
        length = self._force_scale * np.where(met, forces, 0.0)
        self._forces.set_UVC(length[:, 0], length[:, 2])


class PlanView:
    """Shoes from above on units coloured by their heave; `show` brings them to a time.

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
        self._footprint = case.shoe.footprint
        half = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
        corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        heave = 1e3 * history.unit_heave.values
        self.ground = PolyCollection(
            list(terrain.centers[:, None, :2] + corners),
            array=heave[0],
            cmap="cividis",
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
        least, greatest = _extent(history)
        y = history.position.sel(axis="y")
        sideways = 0.5 * case.shoe.width + 0.4
        ax.set(
            xlim=(least - 0.6, greatest + 0.6),
            ylim=(float(y.min()) - sideways, float(y.max()) + sideways),
            aspect="equal",
            ylabel="y in m",
        )

    def show(self, now: xr.Dataset) -> None:
        """Bring everything to one instant of the history."""
        x0, x1, y0, y1, z = self._footprint
        corners = np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
        poses = [Pose.of(now, int(shoe)) for shoe in now.shoe.values]
        self._shoes.set_verts([pose.place(corners)[:, :2] for pose in poses])
        self.ground.set_array(1e3 * now.unit_heave.values)
        for label, pose in zip(self._numbers, poses, strict=True):
            label.set_position((pose.origin[0], pose.origin[1]))
