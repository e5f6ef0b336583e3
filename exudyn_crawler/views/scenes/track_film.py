"""Moving pictures of a track on its deforming terrain."""

from pathlib import Path
from typing import Unpack

import matplotlib as mpl
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.views import style
from exudyn_crawler.views.curves import draw_phases
from exudyn_crawler.views.scenes import poses, projections
from exudyn_crawler.views.scenes.film_files import GIF, Picture, Shown, write_film
from exudyn_crawler.views.scenes.shoes import shoe_force_scale

DPI, GIF_DPI = 100, 75
VIEW_WIDTH, SPEED_HEIGHT, WRITING_HEIGHT = 10.4, 1.55, 1.9
"""Inches: width of both views, height of the curves, and height of all writing above and below."""
DEEPEST = 0.25
"""m that the greatest displacement of the ground is drawn at most."""


class TrackPicture(Picture):
    """Track from above and from the side, and speeds of its ends or forces of rollers.

    Parameters
    ----------
    history : History
    scale : float
        Magnification of the ground's displacements in the side view.
    dpi : float
        Resolution; the picture is 12 inches wide and as high as the track asks for, about 10.
    """

    def __init__(self, history: History, scale: float, dpi: float = DPI) -> None:
        if not scale > 0.0:
            raise ValueError(f"scale must be positive, got {scale:g}")
        self.history, self.name, self._scale = history, history.case.name, scale
        self._force_scale = shoe_force_scale(history)
        heave = history.unit_heave.values / style.MILLI
        self._heave = float(heave.min()), float(heave.max())
        windows = projections.plan_window(history), projections.side_window(history)
        # both views become as wide as the picture has room for
        ratios = [*(VIEW_WIDTH * (one[3] - one[2]) / (one[1] - one[0]) for one in windows), SPEED_HEIGHT]
        with mpl.rc_context(style.STYLE):
            self.figure = Figure(figsize=(12.0, round(sum(ratios) + WRITING_HEIGHT, 1)), dpi=dpi)
            *views, curves = self.figure.subplots(3, 1, height_ratios=ratios)
            self._plan, self._side = views
            for ax, window in zip(views, windows, strict=True):
                ax.set(xlim=window[:2], ylim=window[2:], aspect="equal")
                ax.grid(False)
            self._plan.set_ylabel("y in m")
            self._side.set(xlabel="x in m", ylabel="z in m")
            colours = ScalarMappable(Normalize(*self._heave), style.HEAVE_MAP)
            self.figure.colorbar(colours, ax=views, label="heave of units in mm", fraction=0.02, pad=0.01)
            self._side.set_title(_legend(history, scale), fontsize=9, loc="left")
            self.cursor = (_draw_rollers if poses.rolls(history.dataset) else _draw_speeds)(curves, history)
            self.title = self.figure.suptitle("", x=0.01, ha="left", parse_math=False)
            self.show(0.0)
            draw_phases([curves], common_phases(history))
            # places are found once; finding them anew would take most of the time of a picture
            self.figure.draw_without_rendering()
            self.figure.set_layout_engine("none")

    def draw(self, now: xr.Dataset) -> list[Artist]:
        """Both views of one instant."""
        case = self.history.case
        plan = projections.draw_plan(self._plan, case, now, self._heave)
        return plan + projections.draw_side(self._side, case, now, self._scale, self._force_scale)


def ground_scale(history: History) -> float:
    """Round magnification that makes the ground's displacements visible."""
    moved = history.unit_heave.values - poses.unloaded_level(history.case)
    return max(1.0, style.drawn_scale(moved, DEEPEST))


def _legend(history: History, scale: float) -> str:
    """What has to be known about the side view."""
    ground = f"displacement of the ground drawn {scale:g} times larger"
    most = poses.greatest_shoe_force(history) / style.KILO
    greatest = f"contact force on each shoe, the greatest of the run {most:.3g} kN"
    if poses.rolls(history.dataset):
        return f"{ground}; blue arrows: {greatest}; violet: force of each roller"
    return f"{ground}, depth of the shoes in it at true scale; arrows: {greatest}"


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
    pressed = -history.roller_force.sel(axis="z").sum("rail") / style.KILO
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
    **shown: Unpack[Shown],
) -> Path:
    """Write an animation of a run as MP4 or GIF, without a display.

    Parameters
    ----------
    path : Path
        File to write; its suffix, `.mp4` or `.gif`, says which.
    scale : float, optional
        Magnification of the ground's displacements in the side view; a fitting round one if not given.
    **shown
        `rate`, pictures a second of the animation; `speed`, simulated seconds that one of its seconds shows;
        `start` and `end`, s.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    ValueError
        For another suffix, times outside the run, a scale, rate or speed that is not positive, or more than
        20 000 pictures.
    FileExistsError
        If the file exists and `overwrite` is false.
    """
    larger = ground_scale(history) if scale is None else scale
    dpi = GIF_DPI if path.suffix == GIF else DPI
    return write_film(
        lambda _: TrackPicture(history, larger, dpi), history.duration, path, overwrite, **shown
    )
