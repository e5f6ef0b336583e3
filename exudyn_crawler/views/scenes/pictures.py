"""Pictures of one time: the track from the side and from above, and flexible shoes with their stress.

The ground's displacement under the track is millimetres, from where its own weight leaves it, and can be
drawn larger from the side. All that is above is then lifted or lowered with the ground beneath it, so that
shoes keep their true depth in the ground and rollers theirs in the rails. Every stress picture of a study has
the same colours, the same arrow lengths and the same magnification of the elastic displacement.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from exudyn_crawler.case import Case
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import track
from exudyn_crawler.views.scenes.drawing import (
    Backend,
    Window,
    draw_arrows,
    draw_solids,
    paint,
    usual_backend,
)
from exudyn_crawler.views.scenes.scene import Arrows, Placement, Scene, Solid, View, upward
from exudyn_crawler.views.scenes.shoes import Scales, stress_scene

FROM_THE_RIGHT = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
FROM_ABOVE = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
MARGIN = (0.6, 0.4, 1.0)
"""m that are shown beyond the track, beside it and below the ground."""
ABOVE = 0.4
"""m that are shown above what rolls on the track, which magnified ground may lift."""
DEPTH = 0.4
"""m of ground that is shown below its lowest face where it stands still."""
SPREAD = 3.62
"""m that a view of a shoe shows from left to right."""
HEADROOM = 0.02
"""m above a shoe; below it is space for arrows."""
VIEWS = {
    "from behind and above": View.seen_from(azimuth=190.0, elevation=30.0),
    "from ahead and below": View.seen_from(azimuth=10.0, elevation=-30.0),
}
WIDTH, ROW, STRIP, HEAD, FOOT = 14.0, 1.6, 1.9, 1.05, 0.55
"""Inches: width of a stress picture; heights of a shoe, of the track below all, and of what is written."""
PICTURES = "stress_[0-9]*s.png"
"""Pattern of the stress pictures' file names."""


def side_window(history: History) -> Window:
    """What the side view of a run shows at all times, least and greatest x and z, m."""
    (left, right), _, (bottom, top) = track.shown_box(history, MARGIN)
    return left, right, bottom, top + (ABOVE if track.rolls(history.dataset) else 0.0)


def plan_window(history: History) -> Window:
    """Same of the plan view: x and y."""
    (left, right), (low, high), _ = track.shown_box(history, MARGIN)
    return left, right, low, high


def ground_section(case: Case, dataset: xr.Dataset, at_rest: bool = False) -> Solid:
    """Units of the row under the track's middle line, cut along that; as they are or with free springs."""
    terrain = case.terrain
    y = float(track.shoe_poses(dataset)[0][0, :, 1].mean())
    row = int(np.clip((y - terrain.origin[1]) // terrain.unit_width, 0, terrain.rows - 1))
    units = np.arange(terrain.columns) * terrain.rows + row
    half, deep = 0.5 * terrain.unit_length, 2.0 * MARGIN[2] + float(np.ptp(terrain.top_heights))
    points = np.array([[-half, 0.0, -deep], [half, 0.0, -deep], [half, 0.0, 0.0], [-half, 0.0, 0.0]])
    middle = np.full(len(units), y)
    origin = np.column_stack((terrain.middles[units, 0], middle, terrain.top_heights[units]))[None]
    lift = None if at_rest else dataset.unit_heave.transpose("time", "unit").values[:, units]
    pitching = terrain.tilt == "pitch" and not at_rest
    turn = track.unit_turns(case, dataset if pitching else None)[:, units]
    faces = (np.array([[0, 1, 2, 3]]),)
    return Solid("units", points, faces, style.GROUND, origin, turn, edges=style.GROUND_EDGE, lift=lift)


def side_scene(case: Case, now: xr.Dataset, scale: float = 1.0, force_scale: float = 0.0) -> Scene:
    """What is seen from the right in one instant, as of `track.instants`.

    The ground's displacement is drawn `scale` times larger, forces `force_scale` m long for 1 N.
    """
    moved, still = (ground_section(case, now, at_rest).at() for at_rest in (False, True))
    tops = np.array([3, 2]) + 4 * np.arange(len(moved.points) // 4)[:, None]
    x, rise = moved.points[tops, 0], moved.points[tops, 2] - still.points[tops, 2]
    larger = (scale - 1.0) * (rise - track.unloaded_level(case))
    moved.points[tops, 2] += larger

    def beneath(points: np.ndarray) -> np.ndarray:
        return np.interp(points[..., 0], x.ravel(), larger.ravel())

    scene, solids = track.track_scene(case, now, force_scale), [moved]
    for one in (*scene.solids, track.link_pins(case, now)):
        if one.name.endswith("shoes"):
            own = one.at()
            solids.append(replace(own, points=own.points + upward(beneath(own.points))))
        elif one.name != "ground":
            solids.append(replace(one, lift=beneath(one.origin)).at())
    arrows = [replace(one, heads=one.heads + upward(beneath(one.heads))) for one in scene.arrows]
    return Scene(scene.titles, tuple(solids), tuple(arrows))


def draw_side(
    ax: Axes,
    case: Case,
    now: xr.Dataset,
    scale: float = 1.0,
    force_scale: float = 0.0,
    shoe_opacity: float = 0.75,
) -> list[Artist]:
    """Draw shoes, pins, ground, rollers and forces as seen from the right, as of `side_scene`.

    What is drawn is returned; the axes keep their limits.
    """
    scene = side_scene(case, now, scale, force_scale)
    shown = [
        replace(one, opacity=shoe_opacity) if one.name.endswith("shoes") else one for one in scene.solids
    ]
    return [paint(ax, shown, FROM_THE_RIGHT), *draw_arrows(ax, scene.arrows, FROM_THE_RIGHT)]


def draw_plan(ax: Axes, case: Case, now: xr.Dataset, heave: tuple[float, float]) -> list[Artist]:
    """Draw shoes with their numbers and rollers from above, on units coloured by their heave.

    What is drawn is returned; `heave` are values at the ends of the colours, mm.
    """
    drawn: list[Artist] = [paint(ax, plan_solids(case, now, heave), FROM_ABOVE)]
    for shoe, (x, y, _) in zip(now.shoe.values, track.shoe_poses(now)[0][0], strict=True):
        drawn.append(ax.text(x, y, str(shoe), ha="center", va="center", fontsize=7, zorder=5, clip_on=True))
    return drawn


def plan_solids(case: Case, now: xr.Dataset, heave: tuple[float, float]) -> list[Solid]:
    """What is seen from above in one instant; as of `draw_plan`."""
    shown = []
    for one in (solid.at() for solid in track.track_scene(case, now, 0.0).solids):
        if one.name == "ground":
            colouring = replace(one.colourings[0], low=heave[0], high=heave[1])
            one = replace(one, opacity=1.0, colourings=(colouring,))
        elif one.name.endswith("shoes"):
            one = replace(one, colour="white", opacity=0.35, edges="black")
        shown.append(one)
    return shown


def ground_figure(history: History, time: float) -> Figure:
    """Side view of a run at a time (s), and below it what the ground carries under every shoe."""
    case, now = history.case, track.instants(history, [time])
    moment = History(case, now)
    left, right, _, top = side_window(moment)
    bottom = min(0.0, float(case.terrain.top_heights.min())) - DEPTH
    # as high as the side view becomes when it takes the whole width, so that both panels are one as wide
    high = 10.5 * (top - bottom) / (right - left)
    with mpl.rc_context(style.STYLE):
        figure = Figure(figsize=(11.0, high + 3.2))
        side, carried = figure.subplots(2, 1, sharex=True, height_ratios=[high, 2.2])
        side.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", ylabel="z in m")
        side.grid(False)
        draw_side(side, case, now)
        side.set_title(f"{case.name}, t = {float(now.time[0]):.3g} s", parse_math=False)
        named = (("units", style.GROUND), ("shoes", style.SHOE), ("link pins", "white"))
        keys = [Patch(facecolor=colour, edgecolor=style.SHOE_EDGE, label=name) for name, colour in named]
        side.legend(handles=keys, ncols=3, loc="upper left", fontsize="small")
        _draw_carried(carried, moment)
    return figure


def _draw_carried(ax: Axes, moment: History) -> None:
    """Draw the vertical contact force (kN) on every shoe of one instant, over the shoe's x (m).

    A dashed line shows the mean of loads and weights.
    """
    x = moment.position.sel(axis="x").isel(time=0)
    force = moment.contacts_by_shoe().contact_force.sel(axis="z").isel(time=0) / style.KILO
    ax.bar(x, force, width=0.8 * moment.case.shoe.length, color=style.SHOE)
    for place, number in zip(x.values, x["shoe"].values, strict=True):
        ax.annotate(str(number), (place, 0.0), xytext=(0, 3), textcoords="offset points", ha="center")
    mean = moment.case.mean_load / style.KILO
    ax.axhline(mean, color="k", ls="--", lw=0.8, label="mean load and weight")
    ax.set_ylim(top=1.25 * max(float(force.max()), mean))
    ax.legend(loc="upper left", fontsize="small")
    ax.set(xlabel="x in m; numbers are those of the shoes", ylabel="z contact force\nin kN")


def stress_picture(
    stress: xr.Dataset,
    history: History,
    frame: float,
    scales: Scales | None = None,
    backend: Backend | None = None,
) -> Figure:
    """All flexible shoes at one of the chosen times, `frame` (s): each from two sides, and all in place.

    The scales are those of all chosen times and the backend is the usual one of this machine, if not given.

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
    count = stress.sizes["shoe"]
    tall = HEAD + ROW * count + STRIP + FOOT
    with mpl.rc_context(style.STYLE | {"axes.grid": False, "figure.constrained_layout.use": False}):
        figure = Figure(figsize=(WIDTH, tall))
        shoes = figure.add_gridspec(
            count, 2, left=0.08, right=0.93, top=1.0 - HEAD / tall, bottom=(STRIP + FOOT) / tall,
            wspace=0.02, hspace=0.0,
        )  # fmt: skip
        bent = [one for one in scene.solids if one.colourings]
        for row, one in enumerate(bent):
            (origin,), (turn,) = one.placed()
            forces = [arrows for arrows in scene.arrows if arrows.solid == one.name]
            for column, (title, view) in enumerate(VIEWS.items()):
                ax = figure.add_subplot(shoes[row, column])
                _draw_shoe(ax, one.at(), forces, view.on(Placement(origin, turn)), backend)
                if row == 0:
                    ax.set_title(title, fontsize=9.5, loc="left")
            place = figure.axes[-2].get_position()
            y = 0.5 * (place.y0 + place.y1)
            figure.text(0.011, y, one.name, fontsize=11, va="bottom")
            figure.text(0.011, y, one.notes[0], fontsize=9, va="top")
        ax = figure.add_axes((0.08, FOOT / tall, 0.85, (STRIP - 0.3) / tall))
        now = track.instants(history, [frame])
        draw_side(ax, history.case, now, 1.0, scales.shoe_force, shoe_opacity=0.0)
        draw_solids(ax, [one.at() for one in bent], FROM_THE_RIGHT, side_window(history), backend)
        ax.set(xlabel="x in m", ylabel="z in m")
        ax.set_title("in place, seen from the right", fontsize=9.5, loc="left")
        bottom = (STRIP + FOOT + 0.3) / tall
        stress_bar(figure, (0.945, bottom, 0.013, 1.0 - HEAD / tall - bottom), scales)
        title = f"{history.case.name}: von Mises stress at t = {frame:g} s"
        figure.text(0.011, 1.0 - 0.1 / tall, title, va="top", fontsize=13, parse_math=False)
        said = _legend(scales, track.rolls(history.dataset))
        figure.text(0.011, 1.0 - 0.4 / tall, said, va="top", fontsize=8.5, color="#444444")
    return figure


def _draw_shoe(ax: Axes, solid: Solid, arrows: Sequence[Arrows], view: View, backend: Backend) -> None:
    """Draw a shoe, as of `Solid.at`, with the forces on it and its highest place, if that is seen."""
    seen = view.project(solid.points)
    middle, top = 0.5 * (seen[:, 0].min() + seen[:, 0].max()), seen[:, 1].max() + HEADROOM
    place = ax.get_window_extent()
    window = (middle - 0.5 * SPREAD, middle + 0.5 * SPREAD, top - SPREAD * place.height / place.width, top)
    draw_solids(ax, [solid], view, window, backend)
    draw_arrows(ax, arrows, view)
    highest = int(solid.values.argmax())
    if solid.shows(highest, view):
        ax.plot(*seen[highest, :2], "o", ms=9, mfc="none", mec="black", mew=0.9, zorder=5)
    ax.set_axis_off()


def stress_bar(figure: Figure, place: tuple[float, float, float, float], scales: Scales) -> None:
    """Draw the scale of stress at a place of a figure: left, bottom, width and height over its own."""
    colours = ScalarMappable(Normalize(0.0, scales.stress / style.MEGA), style.STRESS_MAP)
    figure.colorbar(colours, cax=figure.add_axes(place), label="von Mises stress in MPa")


def _legend(scales: Scales, rolled: bool) -> str:
    """What has to be known about a stress picture."""
    acts = "forces of ground and rollers" if rolled else "contact forces"
    return (
        f"elastic displacement drawn {scales.displacement:g} times larger; circle: highest stress on the "
        f"shoe's surface, where it is seen\nblue arrows: {acts} on the shoe, {1e5 * scales.pair_force:.2f} m "
        f"long for 100 kN in single contacts and {1e5 * scales.shoe_force:.2f} m for the sum below"
    )


def picture_name(frame: float) -> str:
    """File name of the stress picture at a time (s); names sort as times do."""
    return f"stress_{frame:08.4f}s.png"


def picture_time(path: Path) -> float:
    """Time (s) that a stress picture's file name says."""
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
