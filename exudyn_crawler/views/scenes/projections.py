"""The track from the side and from above at one time, on axes of matplotlib.

The ground's displacement under the track is millimetres, from where its own weight leaves it, and can be
drawn larger from the side. All that is above is then lifted or lowered with the ground beneath it, so that
shoes keep their true depth in the ground and rollers theirs in the rails.
"""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.results.history.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes import poses
from exudyn_crawler.views.scenes.drawing import Window, draw_arrows, paint
from exudyn_crawler.views.scenes.scene import Solid, View, upward
from exudyn_crawler.views.scenes.track import link_pins, shown_box, track_scene, unit_turns

FROM_THE_RIGHT = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
FROM_ABOVE = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
MARGIN = (0.6, 0.4, 1.0)
"""m that are shown beyond the track, beside it and below the ground."""
ABOVE = 0.4
"""m that are shown above the side frame, which magnified ground may lift."""
DEPTH = 0.4
"""m of ground that is shown below its lowest face where it stands still."""


def side_window(history: History) -> Window:
    """What the side view of a run shows at all times, least and greatest x and z, m."""
    (left, right), _, (bottom, top) = shown_box(history, MARGIN)
    return left, right, bottom, top + (ABOVE if poses.rolls(history.dataset) else 0.0)


def plan_window(history: History) -> Window:
    """Same of the plan view: x and y."""
    (left, right), (low, high), _ = shown_box(history, MARGIN)
    return left, right, low, high


def ground_section(case: Case, dataset: xr.Dataset, at_rest: bool = False) -> Solid:
    """Units of the row under the track's middle line, cut along that; as they are or with free springs."""
    terrain = case.terrain
    y = float(poses.shoe_poses(dataset)[0][0, :, 1].mean())
    row = int(np.clip((y - terrain.origin[1]) // terrain.unit_width, 0, terrain.rows - 1))
    units = np.arange(terrain.columns) * terrain.rows + row
    half, deep = 0.5 * terrain.unit_length, 2.0 * MARGIN[2] + float(np.ptp(terrain.top_heights))
    points = np.array([[-half, 0.0, -deep], [half, 0.0, -deep], [half, 0.0, 0.0], [-half, 0.0, 0.0]])
    middle = np.full(len(units), y)
    origin = np.column_stack((terrain.middles[units, 0], middle, terrain.top_heights[units]))[None]
    lift = None if at_rest else dataset.unit_heave.transpose("time", "unit").values[:, units]
    pitching = terrain.tilt == "pitch" and not at_rest
    turn = unit_turns(case, dataset if pitching else None)[:, units]
    faces = (np.array([[0, 1, 2, 3]]),)
    return Solid("units", points, faces, style.GROUND, origin, turn, edges=style.GROUND_EDGE, lift=lift)


def side_solids(
    case: Case, now: xr.Dataset, scale: float = 1.0, force_scale: float = 0.0
) -> tuple[dict[str, Solid], list[tuple[str, NDArray]]]:
    """What is seen from the right in one instant, with the ground's displacement drawn larger.

    Parameters
    ----------
    now : xarray.Dataset
        One instant, as of `poses.instants`.
    scale : float
        Magnification of the ground's displacements.
    force_scale : float
        m that are drawn for 1 N.

    Returns
    -------
    solids : dict of str to Solid
        By name, as of `Solid.at`.
    arrows : list of (str, array (k, 2, 3))
        Colour of each kind of force, and tails and heads, m.
    """
    moved, still = (ground_section(case, now, at_rest).at() for at_rest in (False, True))
    tops = np.array([3, 2]) + 4 * np.arange(len(moved.points) // 4)[:, None]
    x, rise = moved.points[tops, 0], moved.points[tops, 2] - still.points[tops, 2]
    larger = (scale - 1.0) * (rise - poses.unloaded_level(case))
    moved.points[tops, 2] += larger

    def beneath(points: NDArray) -> NDArray:
        return np.interp(points[..., 0], x.ravel(), larger.ravel())

    scene, solids = track_scene(case, now, force_scale), {"units": moved}
    for one in (*scene.solids, link_pins(case, now)):
        if one.name.endswith("shoes"):
            own = one.at()
            solids[one.name] = own.shifted(upward(beneath(own.points)))
        elif one.name != "ground":
            solids[one.name] = replace(one, lift=beneath(one.origin)).at()
    arrows = [(one.colour, one.at()) for one in scene.arrows]
    return solids, [(colour, one + upward(beneath(one[:, 1:]))) for colour, one in arrows]


def draw_side(
    ax: Axes,
    case: Case,
    now: xr.Dataset,
    scale: float = 1.0,
    force_scale: float = 0.0,
    shoe_opacity: float = 0.75,
) -> list[Artist]:
    """Draw shoes, pins, ground, rollers and forces as seen from the right, as of `side_solids`.

    What is drawn is returned; the axes keep their limits.
    """
    solids, arrows = side_solids(case, now, scale, force_scale)
    for name in solids.keys() & {"rigid shoes", "flexible shoes"}:
        solids[name] = replace(solids[name], opacity=shoe_opacity)
    drawn: list[Artist] = [paint(ax, solids.values(), FROM_THE_RIGHT)]
    return drawn + [one for colour, at in arrows for one in draw_arrows(ax, at, colour, FROM_THE_RIGHT)]


def draw_plan(ax: Axes, case: Case, now: xr.Dataset, heave: tuple[float, float]) -> list[Artist]:
    """Draw shoes with their numbers and rollers from above, on units coloured by their heave.

    What is drawn is returned; `heave` are values at the ends of the colours, mm.
    """
    drawn: list[Artist] = [paint(ax, plan_solids(case, now, heave).values(), FROM_ABOVE)]
    for shoe, (x, y, _) in zip(now.shoe.values, poses.shoe_poses(now)[0][0], strict=True):
        drawn.append(ax.text(x, y, str(shoe), ha="center", va="center", fontsize=7, zorder=5, clip_on=True))
    return drawn


def plan_solids(case: Case, now: xr.Dataset, heave: tuple[float, float]) -> dict[str, Solid]:
    """What is seen from above in one instant, by name; as of `draw_plan`."""
    solids = {one.name: one.at() for one in track_scene(case, now, 0.0).solids}
    colouring = replace(solids["ground"].colourings[0], low=heave[0], high=heave[1])
    solids["ground"] = replace(solids["ground"], opacity=1.0, colourings=(colouring,))
    for name in solids.keys() & {"rigid shoes", "flexible shoes"}:
        solids[name] = replace(solids[name], colour="white", opacity=0.35, edges="black")
    return solids


def ground_figure(history: History, time: float) -> Figure:
    """Side view of a run at a time (s), and below it what the ground carries under every shoe."""
    case, now = history.case, poses.instants(history, [time])
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
        draw_carried(carried, moment)
    return figure


def draw_carried(ax: Axes, moment: History) -> Axes:
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
    return ax
