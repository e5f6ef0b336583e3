"""Moving pictures of a track on its deforming terrain."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.views.curves import STYLE
from exudyn_crawler.views.film import GIF, check_film, drawn_image, film_times, write_film
from exudyn_crawler.views.phase_bands import draw_phases
from exudyn_crawler.views.placement import greatest_shoe_force, instant
from exudyn_crawler.views.plan_view import PlanView
from exudyn_crawler.views.scales import ground_scale, shoe_force_scale
from exudyn_crawler.views.side_view import SideView
from exudyn_crawler.views.undercarriage import rolls

DPI = 100
GIF_DPI = 75
VIEW_WIDTH, SPEED_HEIGHT, WRITING_HEIGHT = 10.4, 1.55, 1.9
"""Inches: width of both views, height of the speeds, and height of all writing above and below."""


class TrackPicture:
    """Track from above and from the side, and speeds of its ends or forces of rollers; `show` sets the time.

    Parameters
    ----------
    history : History
    scale : float
        Magnification of the ground's displacements in the side view.
    dpi : float
        Resolution; the picture is 12 inches wide and as high as the track asks for, about 10.

    Attributes
    ----------
    figure : Figure
    """

    def __init__(self, history: History, scale: float, dpi: float = DPI) -> None:
        self._history = history
        with mpl.rc_context(STYLE):
            self.figure = Figure(figsize=(12.0, 10.0), dpi=dpi)
            grid = self.figure.add_gridspec(3, 1)
            above, side, speed = (self.figure.add_subplot(grid[row]) for row in range(3))
            plan = PlanView(above, history)
            self._views = (plan, SideView(side, history, scale, shoe_force_scale(history)))
            self.figure.colorbar(
                plan.ground, ax=[above, side], label="heave of units in mm", fraction=0.02, pad=0.01
            )
            side.set_title(_said(history, scale), fontsize=9, loc="left")
            for axes in (above, side):
                axes.grid(False)
            draw = _draw_rollers if rolls(history.dataset) else _draw_speeds
            self._cursor = draw(speed, history)
            self._title = self.figure.suptitle("", x=0.01, ha="left")
            # both views become as wide as the picture has room for
            metres = np.ptp(above.get_ylim()), np.ptp(side.get_ylim())
            heights = [VIEW_WIDTH * m / np.ptp(side.get_xlim()) for m in metres]
            self.figure.set_size_inches(12.0, round(sum(heights) + SPEED_HEIGHT + WRITING_HEIGHT, 1))
            grid.set_height_ratios([*heights, SPEED_HEIGHT])
            self.show(0.0)
            draw_phases([speed], common_phases(history))
            # places are found once; finding them anew would take most of the time of a picture
            self.figure.draw_without_rendering()
            self.figure.set_layout_engine("none")

    def show(self, time: float) -> Figure:
        """Bring the picture to the stored time nearest to `time` (s)."""
        now = instant(self._history, time)
        for view in self._views:
            view.show(now)
        self._cursor.set_xdata([float(now.time)] * 2)
        self._title.set_text(f"{self._history.case.name}: t = {float(now.time):.2f} s")
        return self.figure

    def image(self, time: float) -> NDArray:
        """Picture at a time as red, green and blue: array (height, width, 3), uint8."""
        return drawn_image(self.show(time))


def _said(history: History, scale: float) -> str:
    """What has to be known about the side view."""
    ground = f"displacement of the ground drawn {scale:g} times larger"
    arrows = (
        f"contact force on each shoe, the greatest of the run {greatest_shoe_force(history) / 1e3:.3g} kN"
    )
    if rolls(history.dataset):
        return f"{ground}; blue arrows: {arrows}; violet: force of each roller"
    return f"{ground}, depth of the shoes in it at true scale; arrows: {arrows}"


def _draw_speeds(ax: Axes, history: History) -> Line2D:
    """Draw the x velocity of both ends over time, and a cursor, which is returned."""
    shoes = history.shoe.values
    for shoe, name in ((shoes[0], "rear"), (shoes[-1], "front")):
        values = history.velocity.sel(shoe=shoe, axis="x")
        ax.plot(values.time, values, label=f"shoe {shoe} ({name})")
    ax.set(xlabel="time in s", ylabel="x velocity in m/s", xlim=(0.0, history.duration))
    ax.legend(loc="upper left", ncols=2)
    return ax.axvline(0.0, color="black", lw=0.8)


def _draw_rollers(ax: Axes, history: History) -> Line2D:
    """Draw what every roller presses with over time, and a cursor, which is returned."""
    pressed = -1e-3 * history.roller_force.sel(axis="z").sum("rail")
    for roller in history.roller.values:
        ax.plot(pressed.time, pressed.sel(roller=roller), label=f"{roller}")
    ax.set(xlabel="time in s", ylabel="force of a\nroller in kN", xlim=(0.0, history.duration))
    ax.set_ylim(0.0, 1.25 * float(pressed.max()))
    ax.legend(loc="upper left", ncols=len(history.roller), title="", columnspacing=1.0, handlelength=1.2)
    return ax.axvline(0.0, color="black", lw=0.8)


def write_animation(
    history: History,
    path: Path,
    overwrite: bool = False,
    scale: float | None = None,
    rate: int = 20,
    speed: float = 1.0,
    start: float = 0.0,
    end: float | None = None,
) -> Path:
    """Write an animation of a run as MP4 or GIF, without a display.

    Parameters
    ----------
    path : Path
        File to write; its suffix, `.mp4` or `.gif`, says which.
    scale : float, optional
        Magnification of the ground's displacements in the side view; a fitting round one if not given.
    rate : int
        Pictures a second of the animation.
    speed : float
        Simulated seconds that a second of the animation shows.
    start, end : float
        s, first and last time that is shown.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    ValueError
        For another suffix, times outside the run, or a scale, rate or speed that is not positive.
    FileExistsError
        If the file exists and `overwrite` is false.
    """
    check_film(path, overwrite)
    times = film_times(history.duration, rate, speed, start, end)
    scale = ground_scale(history) if scale is None else scale
    if not scale > 0.0:
        raise ValueError(f"scale must be positive, got {scale:g}")
    picture = TrackPicture(history, scale, GIF_DPI if path.suffix == GIF else DPI)
    return write_film((picture.image(float(time)) for time in times), path, rate, overwrite)
