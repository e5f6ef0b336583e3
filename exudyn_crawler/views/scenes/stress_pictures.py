"""Pictures of the flexible shoes' von Mises stress at single times, with the forces on them as arrows.

Every picture of a study has the same colours, the same arrow lengths and the same magnification of the
elastic displacement. `stress` is everywhere the dataset that the stress study leaves; `docs/report.md` lists
what it holds.
"""

from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import poses
from exudyn_crawler.views.scenes.drawing import Backend, draw_arrows, draw_solids, usual_backend
from exudyn_crawler.views.scenes.projections import FROM_THE_RIGHT, draw_side, side_window
from exudyn_crawler.views.scenes.scene import Placement, Scene, View
from exudyn_crawler.views.scenes.shoes import Scales, stress_scene

SPREAD = 3.62
"""m that a view of a shoe shows from left to right."""
ROOM = 0.02
"""m above a shoe; below it is room for arrows."""
VIEWS = {
    "from behind and above": View.seen_from(azimuth=190.0, elevation=30.0),
    "from ahead and below": View.seen_from(azimuth=10.0, elevation=-30.0),
}
WIDTH, ROW, STRIP, HEAD, FOOT = 14.0, 1.6, 1.9, 1.05, 0.55
"""Inches: width of a picture; heights of a shoe, of the track below all, and of what is written."""
PICTURES = "stress_[0-9]*s.png"
"""Pattern of the pictures' file names."""


def stress_picture(
    stress: xr.Dataset,
    history: History,
    frame: float,
    scales: Scales | None = None,
    backend: Backend | None = None,
) -> Figure:
    """All flexible shoes at one chosen time: each from two sides, and all in place.

    Parameters
    ----------
    frame : float
        s, one of the chosen times.
    scales : Scales, optional
        Those of all chosen times, if not given.
    backend : {"opengl", "painted"}, optional
        What draws the surfaces; the usual one of this machine if not given.

    Raises
    ------
    ValueError
        If `frame` is none of the chosen times.
    """
    if not np.isclose(stress.frame.values, frame, rtol=0.0, atol=1e-6).any():
        raise ValueError(
            f"frame must be one of the chosen times {stress.frame.values.tolist()}, got {frame:g}"
        )
    frame = float(stress.frame.sel(frame=frame, method="nearest"))
    scales, backend = scales or Scales.of(stress, history), backend or usual_backend()
    scene = stress_scene(stress.sel(frame=[frame]), history, scales)
    apart = shoes_apart(scene)
    tall = HEAD + ROW * len(apart) + STRIP + FOOT
    with mpl.rc_context(style.STYLE | {"axes.grid": False, "figure.constrained_layout.use": False}):
        figure = Figure(figsize=(WIDTH, tall))
        shoes = figure.add_gridspec(
            len(apart), 2, left=0.08, right=0.93, top=1.0 - HEAD / tall, bottom=(STRIP + FOOT) / tall,
            wspace=0.02, hspace=0.0,
        )  # fmt: skip
        for row, one in enumerate(apart):
            for column, (title, view) in enumerate(VIEWS.items()):
                ax = figure.add_subplot(shoes[row, column])
                draw_shoe(ax, one, view, backend)
                if row == 0:
                    ax.set_title(title, fontsize=9.5, loc="left")
            place = figure.axes[-2].get_position()
            y = 0.5 * (place.y0 + place.y1)
            figure.text(0.011, y, one.solids[0].name, fontsize=11, va="bottom")
            figure.text(0.011, y, one.solids[0].notes[0], fontsize=9, va="top")
        track = figure.add_axes((0.08, FOOT / tall, 0.85, (STRIP - 0.3) / tall))
        draw_in_place(track, scene, history, frame, scales, backend)
        _write(figure, history, frame, scales)
    return figure


def shoes_apart(scene: Scene) -> list[Scene]:
    """Each shoe of a scene of one time in its own axes, with its forces."""
    apart = []
    for shoe in (one for one in scene.solids if one.labels == (one.name,)):
        origin, turn = shoe.placed(0)
        arrows = tuple(one for one in scene.arrows if one.solid == shoe.name)
        apart.append(Scene(scene.titles, (shoe,), arrows).seen_in(Placement(origin[0], turn[0])))
    return apart


def draw_shoe(ax: Axes, scene: Scene, view: View, backend: Backend) -> Axes:
    """Draw a shoe in its own axes, with the forces on it and its highest place, if that is seen."""
    solid = scene.solids[0].at()
    seen = view.project(solid.points)
    middle, top = 0.5 * (seen[:, 0].min() + seen[:, 0].max()), seen[:, 1].max() + ROOM
    place = ax.get_window_extent()
    window = (middle - 0.5 * SPREAD, middle + 0.5 * SPREAD, top - SPREAD * place.height / place.width, top)
    draw_solids(ax, [solid], view, window, backend)
    for force in scene.arrows:
        draw_arrows(ax, force.at(), force.colour, view)
    highest = int(solid.values.argmax())
    if solid.shows(highest, view):
        ax.plot(*seen[highest, :2], "o", ms=9, mfc="none", mec="black", mew=0.9, zorder=5)
    ax.set_axis_off()
    return ax


def draw_in_place(
    ax: Axes, scene: Scene, history: History, frame: float, scales: Scales, backend: Backend
) -> Axes:
    """Draw the whole track from the right, with the contact force of each shoe and the flexible shoes."""
    draw_side(ax, history.case, poses.instants(history, [frame]), 1.0, scales.shoe_force, shoe_opacity=0.0)
    solids = [one.at() for one in scene.solids if one.colourings]
    draw_solids(ax, solids, FROM_THE_RIGHT, side_window(history), backend)
    ax.set(xlabel="x in m", ylabel="z in m")
    ax.set_title("in place, seen from the right", fontsize=9.5, loc="left")
    return ax


def _write(figure: Figure, history: History, frame: float, scales: Scales) -> None:
    """Title of a picture, what has to be known about it, and its scale of colours."""
    tall = figure.get_figheight()
    colours = ScalarMappable(Normalize(0.0, scales.stress / style.MEGA), style.STRESS_MAP)
    bottom = (STRIP + FOOT + 0.3) / tall
    bar = figure.add_axes((0.945, bottom, 0.013, 1.0 - HEAD / tall - bottom))
    figure.colorbar(colours, cax=bar, label="von Mises stress in MPa")
    title = f"{history.case.name}: von Mises stress at t = {frame:g} s"
    figure.text(0.011, 1.0 - 0.1 / tall, title, va="top", fontsize=13, parse_math=False)
    acts = "forces of ground and rollers" if poses.rolls(history.dataset) else "contact forces"
    said = (
        f"elastic displacement drawn {scales.displacement:g} times larger; circle: highest stress on the "
        f"shoe's surface, where it is seen\nblue arrows: {acts} on the shoe, {1e5 * scales.pair_force:.2f} m "
        f"long for 100 kN in single contacts and {1e5 * scales.shoe_force:.2f} m for the sum below"
    )
    figure.text(0.011, 1.0 - 0.4 / tall, said, va="top", fontsize=8.5, color="#444444")


def picture_name(frame: float) -> str:
    """File name of the picture at a time (s); names sort as times do."""
    return f"stress_{frame:08.4f}s.png"


def picture_time(path: Path) -> float:
    """Time (s) that a picture's file name says."""
    return float(path.stem.removeprefix("stress_").removesuffix("s"))


def write_stress_pictures(
    stress: xr.Dataset,
    history: History,
    folder: Path,
    overwrite: bool = False,
    backend: Backend | None = None,
) -> list[Path]:
    """Write a picture of every chosen time into a folder; paths in order of time.

    Raises
    ------
    FileExistsError
        If a file exists and `overwrite` is false.
    """
    scales, written = Scales.of(stress, history), []
    for frame in stress.frame.values.tolist():
        figure = stress_picture(stress, history, frame, scales, backend)
        written.append(style.save_figure(figure, folder / picture_name(frame), overwrite))
    return written
