"""Animations of a track on its deforming terrain, as MP4 or GIF."""

from pathlib import Path

import imageio_ffmpeg
import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from exudyn_crawler.files import refuse_existing, whole_file
from exudyn_crawler.results.history import History, as_history, common_phases
from exudyn_crawler.views import figures, style
from exudyn_crawler.views.scenes import pictures, shoes, track

RATE, MOST_PICTURES = 20, 20_000
"""Default number of pictures a second of an animation; greatest number of pictures, 1000 s."""
PALETTE = "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=none"
"""Filter of ffmpeg: a palette for every picture, since one for all would need all pictures in memory."""
FORMATS = {".mp4": ("libx264", "yuv420p", [], 100), ".gif": ("gif", "pal8", ["-vf", PALETTE], 75)}
"""Codec, pixel format, further options of ffmpeg and pixels an inch of a track, by suffix."""
VIEW_WIDTH, SPEED_HEIGHT, WRITING_HEIGHT = 10.4, 1.55, 1.9
"""Inches: width of both views of a track, height of the curves, and height of all text above and below."""
DEEPEST, HEADROOM = 0.25, 0.35
"""Greatest drawn displacement of the ground (m); fraction of the curves' height left free above and below
them for the legend."""


class TrackPicture:
    """Figure of a run at one time: the track from above and from the side, and curves.

    The side view magnifies the ground's displacements by `scale`.
    """

    def __init__(self, history: History, scale: float, dpi: float = 100) -> None:
        if not scale > 0.0:
            raise ValueError(f"scale must be positive, got {scale:g}")
        self.history = history
        self._scale = scale
        self._force_scale = shoes.shoe_force_scale(history)
        # of cells, the heights at the begin and the end of the run
        ends = track.instants(history, [0.0, history.duration])
        (ground,) = track.ground_faces(ends).colourings
        shown = ground.values if "ground_depth" in ends.dataset else history.unit_heave.values / style.MILLI
        self._heave = float(shown.min()), float(shown.max())
        windows = pictures.windows(history)
        # both views fill the width of the picture
        ratios = [
            *(VIEW_WIDTH * (limits[3] - limits[2]) / (limits[1] - limits[0]) for limits in windows),
            SPEED_HEIGHT,
        ]
        with mpl.rc_context(style.STYLE):
            self.figure = Figure(figsize=(12.0, round(sum(ratios) + WRITING_HEIGHT, 1)), dpi=dpi)
            *views, curves = self.figure.subplots(3, 1, height_ratios=ratios)
            self._plan, self._side = views
            for ax, window in zip(views, windows, strict=True):
                ax.set(xlim=window[:2], ylim=window[2:], aspect="equal")
                ax.grid(False)
            self._plan.set_ylabel("y in m")
            self._side.set(xlabel="x in m", ylabel="z in m")
            bar = {"ax": views, "label": ground.title, "fraction": 0.02, "pad": 0.01}
            self.figure.colorbar(style.scale_of(*self._heave, style.HEAVE_MAP), **bar)
            self._side.set_title(self._legend(), fontsize=9, loc="left")
            _curves(history).draw(curves)
            curves.set(xlabel="time in s", xlim=(0.0, history.duration), ymargin=HEADROOM)
            curves.legend(loc="upper left", ncols=len(curves.lines), columnspacing=1.0, handlelength=1.2)
            self._cursor = curves.axvline(0.0, color="black", lw=0.8)
            self._title = self.figure.suptitle("", x=0.01, ha="left", parse_math=False)
            self._drawn: pictures.Drawn = []
            self.show(0.0)
            figures.draw_phases([curves], common_phases(history))
            # the layout is solved once; solving it for each picture would take most of its time
            self.figure.draw_without_rendering()
            self.figure.set_layout_engine("none")

    def _legend(self) -> str:
        """Return the legend of the side view."""
        ground = f"displacement of the ground drawn {self._scale:g} times larger"
        most = track.greatest_shoe_force(self.history) / style.KILO
        greatest = f"contact force on each shoe, the greatest of the run {most:.3g} kN"
        if self.history.has("roller_force"):
            return f"{ground}; blue arrows: {greatest}; violet: force of each roller"
        if self.history.has("wheel_load"):
            kinds = "blue of the ground, violet of wheels, red of teeth"
            return f"{ground}; arrows: forces on each shoe, {kinds}, {most:.4g} kN at most"
        return f"{ground}, depth of the shoes in it at true scale; arrows: {greatest}"

    def show(self, time: float) -> None:
        """Bring the figure to the stored time nearest to `time` (s)."""
        now = track.instants(self.history, [time])
        for artist in self._drawn:
            artist.remove()
        self._drawn = pictures.draw_plan(self._plan, now, self._heave)
        self._drawn += pictures.draw_side(self._side, now, self._scale, self._force_scale)
        instant = float(now.time[0])
        self._cursor.set_xdata([instant] * 2)
        self._title.set_text(f"{self.history.case.name}: t = {instant:.2f} s")

    def image(self, time: float) -> np.ndarray:
        """Return the picture at a time (s) in red, green and blue: array (height, width, 3), uint8."""
        self.show(time)
        canvas = FigureCanvasAgg(self.figure)
        # ticks are chosen while drawing, by the font size of the style
        with mpl.rc_context(style.STYLE):
            canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def ground_scale(history: History) -> float:
    """Return a round magnification that makes the ground's displacements visible."""
    if "ground_depth" in (end := track.instants(history, [history.duration])).dataset:
        moved = end.ground_depth.values
    else:
        moved = history.unit_heave.values - track.unloaded_level(history.case)
    return max(1.0, style.drawn_scale(moved, DEEPEST))


def _curves(history: History) -> figures.Panel:
    """Return the curves of a run: tension of a closed chain, roller forces, or speed of both end shoes."""
    if history.has("link_tension"):
        tension = history.over_time(["link_tension"])["link_tension"] / style.KILO
        most = tension.max("joint")
        least = tension.min("joint")
        curves = {"greatest": most, "mean": tension.mean("joint"), "least": least}
        return figures.Panel("tension of links", "kN", curves)
    if history.has("roller_force"):
        pressed = -history.roller_force.sel(axis="z").sum("rail") / style.KILO
        of_rollers = {str(roller): pressed.sel(roller=roller) for roller in history.roller.values}
        return figures.Panel("roller force", "kN", of_rollers)
    ends = {
        f"shoe {history.shoe.values[index]} ({name})": index for index, name in ((0, "rear"), (-1, "front"))
    }
    speed = history.velocity.sel(axis="x")
    return figures.Panel("x velocity", "m/s", {name: speed.isel(shoe=end) for name, end in ends.items()})


def film_times(
    duration: float, rate: int = RATE, speed: float = 1.0, start: float = 0.0, end: float | None = None
) -> np.ndarray:
    """Return the times (s) of a run in an animation; arguments and errors are those of `write_animation`."""
    end = duration if end is None else end
    if not 0.0 <= start < end <= duration + 1e-9:
        raise ValueError(f"start and end must lie in 0..{duration:g} s, got {start:g}..{end:g} s")
    for name, value in (("rate", rate), ("speed", speed)):
        if not value > 0.0:
            raise ValueError(f"{name} must be positive, got {value:g}")
    least = (end - start) * rate / MOST_PICTURES
    if speed < least:
        many = f"{end - start:g} s at {rate} a second and at most {MOST_PICTURES} pictures"
        raise ValueError(f"speed must be at least {least:.3g} for {many}; got {speed:g}")
    return np.arange(start, end + 1e-9, speed / rate)


def write_animation(
    history: History | str | Path,
    path: str | Path,
    overwrite: bool = False,
    scale: float | None = None,
    *,
    rate: int = RATE,
    speed: float = 1.0,
    start: float = 0.0,
    end: float | None = None,
) -> Path:
    """Write an animation of a run as MP4 or GIF, by the suffix of the path, without a display; return it.

    `scale` magnifies the ground's displacements in the side view, by a fitting round number if not given. A
    second shows `rate` pictures of `speed` simulated seconds, from `start` to `end` (s; the run's end if
    None).

    Raises ValueError for another suffix, times outside the run, a scale, rate or speed that is not positive,
    or more than 20 000 pictures; FileExistsError if the file exists and `overwrite` is false.
    """
    path = Path(path)
    if path.suffix not in FORMATS:
        raise ValueError(f"an animation is an .mp4 or .gif file, got {path}")
    refuse_existing(path, overwrite)
    history = as_history(history)
    times = film_times(history.duration, rate, speed, start, end)
    codec, colours, options, dpi = FORMATS[path.suffix]
    picture = TrackPicture(history, ground_scale(history) if scale is None else scale, dpi)
    with whole_file(path, overwrite) as temporary:
        # the ffmpeg of imageio-ffmpeg; players of H.264 need even widths and heights
        size = picture.figure.canvas.get_width_height(physical=True)
        how = {"codec": codec, "pix_fmt_out": colours, "output_params": options, "ffmpeg_log_level": "error"}
        writer = imageio_ffmpeg.write_frames(str(temporary), size, fps=rate, macro_block_size=2, **how)
        writer.send(None)
        try:
            for time in times:
                writer.send(picture.image(float(time)))
        finally:
            writer.close()
    return path
