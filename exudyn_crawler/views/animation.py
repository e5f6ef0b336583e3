"""Moving pictures of a track on its deforming terrain."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import imageio_ffmpeg
import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from exudyn_crawler.files import whole_file
from exudyn_crawler.results.history import History
from exudyn_crawler.views.curves import STYLE
from exudyn_crawler.views.track_views import LONGEST, PlanView, SideView, greatest_shoe_force, ground_scale

DPI = 100
GIF_DPI = 75
COLOURS = 96
"""Colours of a GIF."""


class TrackPicture:
    """Track from above and from the side, and the speed of its ends; `show` brings it to a time.

    Parameters
    ----------
    history : History
    scale : float
        Magnification of the ground's displacements in the side view.
    dpi : float
        Resolution; the picture is 12 by 10 inches.

    Attributes
    ----------
    figure : Figure
    """

    def __init__(self, history: History, scale: float, dpi: float = DPI) -> None:
        self._history = history
        force = greatest_shoe_force(history)
        with mpl.rc_context(STYLE):
            self.figure = Figure(figsize=(12.0, 10.0), dpi=dpi)
            above, side, speed = self.figure.subplots(3, 1, height_ratios=(4.9, 2.2, 1.6))
            plan = PlanView(above, history)
            self._views = (plan, SideView(side, history, scale, LONGEST / force if force > 0.0 else 1.0))
            self.figure.colorbar(
                plan.ground, ax=[above, side], label="heave of units in mm", fraction=0.02, pad=0.01
            )
            side.set_title(
                f"displacement of the ground drawn {scale:g} times larger, depth of the shoes in it at true "
                f"scale; arrows: contact force on each shoe, the greatest of the run {force / 1e3:.3g} kN",
                fontsize=9,
                loc="left",
            )
            for axes in (above, side):
                axes.grid(False)
            shoes = history.shoe.values
            for shoe, name in ((shoes[0], "rear"), (shoes[-1], "front")):
                values = history.velocity.sel(shoe=shoe, axis="x")
                speed.plot(values.time, values, label=f"shoe {shoe} ({name})")
            speed.set(xlabel="time in s", ylabel="x velocity in m/s", xlim=(0.0, history.duration))
            speed.legend(loc="upper left", ncols=2)
            self._cursor = speed.axvline(0.0, color="black", lw=0.8)
            self._title = self.figure.suptitle("", x=0.01, ha="left")
            self.show(0.0)
            # places are found once; finding them anew would take most of the time of a picture
            self.figure.draw_without_rendering()
            self.figure.set_layout_engine("none")

    def show(self, time: float) -> Figure:
        """Bring the picture to the stored time nearest to `time` (s)."""
        now = self._history.dataset.sel(time=time, method="nearest")
        for view in self._views:
            view.show(now)
        self._cursor.set_xdata([float(now.time)] * 2)
        self._title.set_text(f"{self._history.case.name}: t = {float(now.time):.2f} s")
        return self.figure

    def image(self, time: float) -> NDArray:
        """Picture at a time as red, green and blue: array (height, width, 3), uint8."""
        canvas = FigureCanvasAgg(self.show(time))
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()


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
    end = history.duration if end is None else end
    if path.suffix not in (".mp4", ".gif"):
        raise ValueError(f"an animation is an .mp4 or .gif file, got {path}")
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} exists; ask for overwriting to replace it")
    if not 0.0 <= start < end <= history.duration + 1e-9:
        raise ValueError(f"start and end must lie in 0..{history.duration:g} s, got {start:g}..{end:g} s")
    scale = ground_scale(history) if scale is None else scale
    for name, value in (("scale", scale), ("rate", rate), ("speed", speed)):
        if not value > 0.0:
            raise ValueError(f"{name} must be positive, got {value:g}")
    times = np.arange(start, end + 1e-9, speed / rate)
    is_gif = path.suffix == ".gif"
    picture = TrackPicture(history, scale, GIF_DPI if is_gif else DPI)
    images = (picture.image(float(time)) for time in times)
    with whole_file(path, overwrite) as temporary:
        (_write_gif if is_gif else _write_mp4)(images, rate, temporary)
    return path


def _write_mp4(images: Iterator[NDArray], rate: int, path: Path) -> None:
    """H.264 by the ffmpeg that imageio-ffmpeg brings along."""
    first = next(images)
    height, width, _ = first.shape
    # players want even sides and 4:2:0 colours
    writer = imageio_ffmpeg.write_frames(
        str(path), (width, height), fps=rate, codec="libx264", macro_block_size=2, pix_fmt_out="yuv420p"
    )
    writer.send(None)
    try:
        for image in chain([first], images):
            writer.send(np.ascontiguousarray(image))
    finally:
        writer.close()


def _write_gif(images: Iterator[NDArray], rate: int, path: Path) -> None:
    """GIF by pillow, picture for picture, since all of them at once would fill the memory."""
    pictures = (Image.fromarray(image).quantize(COLOURS, dither=Image.Dither.NONE) for image in images)
    first = next(pictures)
    first.save(path, save_all=True, append_images=pictures, duration=1e3 / rate, loop=0)
