"""Moving pictures as files: which times they show, and MP4 or GIF of images."""

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import TypedDict

import imageio_ffmpeg
import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from exudyn_crawler.files import refuse_existing, whole_file
from exudyn_crawler.views.curves import STYLE

GIF = ".gif"
GIF_COLOUR_COUNT = 96


def check_film(path: Path, overwrite: bool) -> None:
    """Refuse a file that cannot become an animation.

    Raises
    ------
    ValueError
        If its suffix is neither `.mp4` nor `.gif`.
    FileExistsError
        If it exists and `overwrite` is false.
    """
    if path.suffix not in (".mp4", GIF):
        raise ValueError(f"an animation is an .mp4 or .gif file, got {path}")
    refuse_existing(path, overwrite)


class Shown(TypedDict, total=False):
    """What an animation shows, and how fast: as of `film_times`."""

    rate: int
    speed: float
    start: float
    end: float | None


RATE = 20
"""Pictures a second of an animation, where no other number is asked for."""


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
        For times outside the run, or a rate or speed that is not positive.
    """
    end = duration if end is None else end
    if not 0.0 <= start < end <= duration + 1e-9:
        raise ValueError(f"start and end must lie in 0..{duration:g} s, got {start:g}..{end:g} s")
    for name, value in (("rate", rate), ("speed", speed)):
        if not value > 0.0:
            raise ValueError(f"{name} must be positive, got {value:g}")
    return np.arange(start, end + 1e-9, speed / rate)


def drawn_image(figure: Figure) -> NDArray:
    """Picture of a figure as red, green and blue: array (height, width, 3), uint8."""
    canvas = FigureCanvasAgg(figure)
    # ticks are chosen when drawn, by the style's size of writing
    with mpl.rc_context(STYLE):
        canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def write_film(images: Iterable[NDArray], path: Path, rate: int, overwrite: bool = False) -> Path:
    """Write images (height, width, 3), uint8, as MP4 or GIF by the suffix, whole or not at all."""
    with whole_file(path, overwrite) as temporary:
        (_write_gif if path.suffix == GIF else _write_mp4)(iter(images), rate, temporary)
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
