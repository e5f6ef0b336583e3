"""Moving pictures as files: which times they show, and MP4 or GIF of pictures."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import TypedDict, Unpack

import imageio_ffmpeg
import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray
from PIL import Image

from exudyn_crawler.files import refuse_existing, whole_file
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.scenes.poses import instants
from exudyn_crawler.views.style import STYLE

GIF, GIF_COLOUR_COUNT = ".gif", 96
RATE = 20
"""Pictures a second of an animation, where no other number is asked for."""
MOST_PICTURES = 20_000
"""Of an animation: 1000 s of it, some hours to draw."""


class Shown(TypedDict, total=False):
    """What an animation shows, and how fast: as of `film_times`."""

    rate: int
    speed: float
    start: float
    end: float | None


class Picture(ABC):
    """Figure that can be brought to a time of a history.

    Attributes
    ----------
    history : History
    figure : Figure
    cursor : Line2D
        Line at the time in curves over it.
    title : Text
    name : str
        What stands in the title before the time.
    """

    history: History
    figure: Figure
    cursor: Line2D
    title: Text
    name: str
    _drawn: tuple[Artist, ...] = ()

    @abstractmethod
    def draw(self, now: xr.Dataset) -> list[Artist]:
        """Draw what changes, of one instant as of `poses.instants`; it is returned."""

    def show(self, time: float) -> Figure:
        """Bring the picture to the stored time nearest to `time` (s)."""
        now = instants(self.history, [time])
        for artist in self._drawn:
            artist.remove()
        self._drawn = tuple(self.draw(now))
        at = float(now.time[0])
        self.cursor.set_xdata([at] * 2)
        self.title.set_text(f"{self.name}: t = {at:.2f} s")
        return self.figure

    def image(self, time: float) -> NDArray:
        """Picture at a time as red, green and blue: array (height, width, 3), uint8."""
        canvas = FigureCanvasAgg(self.show(time))
        # ticks are chosen when drawn, by the style's size of writing
        with mpl.rc_context(STYLE):
            canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def film_times(
    duration: float, rate: int = RATE, speed: float = 1.0, start: float = 0.0, end: float | None = None
) -> NDArray:
    """Times of a run that the pictures of an animation show, s.

    Parameters
    ----------
    duration : float
        Of the run, s.
    rate : int
        Pictures a second of the animation.
    speed : float
        Simulated seconds that a second of the animation shows.
    start, end : float
        s, first and last time that is shown; the run's end if None.

    Raises
    ------
    ValueError
        For times outside the run, a rate or speed that is not positive, or more than `MOST_PICTURES`.
    """
    end = duration if end is None else end
    if not 0.0 <= start < end <= duration + 1e-9:
        raise ValueError(f"start and end must lie in 0..{duration:g} s, got {start:g}..{end:g} s")
    for name, value in (("rate", rate), ("speed", speed)):
        if not value > 0.0:
            raise ValueError(f"{name} must be positive, got {value:g}")
    least = (end - start) * rate / MOST_PICTURES
    if speed < least:
        raise ValueError(
            f"speed must be at least {least:.3g} for {end - start:g} s at {rate} pictures a second: an "
            f"animation has at most {MOST_PICTURES} pictures; got {speed:g}"
        )
    return np.arange(start, end + 1e-9, speed / rate)


def write_film(
    picture: Callable[[NDArray], Picture],
    duration: float,
    path: Path,
    overwrite: bool = False,
    **shown: Unpack[Shown],
) -> Path:
    """Write pictures of a run as MP4 or GIF by the suffix, whole or not at all.

    Parameters
    ----------
    picture : callable
        Makes the picture that can show some times (s).

    Raises
    ------
    ValueError
        For another suffix, or as of `film_times`.
    FileExistsError
        If the file exists and `overwrite` is false.
    """
    if path.suffix not in (".mp4", GIF):
        raise ValueError(f"an animation is an .mp4 or .gif file, got {path}")
    refuse_existing(path, overwrite)
    times = film_times(duration, **shown)
    drawn = picture(times)
    with whole_file(path, overwrite) as temporary:
        images = (drawn.image(float(time)) for time in times)
        (_write_gif if path.suffix == GIF else _write_mp4)(images, shown.get("rate", RATE), temporary)
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
    pictures = (
        Image.fromarray(image).quantize(GIF_COLOUR_COUNT, dither=Image.Dither.NONE) for image in images
    )
    first = next(pictures)
    first.save(path, save_all=True, append_images=pictures, duration=1e3 / rate, loop=0)
