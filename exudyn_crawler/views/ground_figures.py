"""Drawing of shoes on the ground in side view and of what it carries; computes nothing but what it draws."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from exudyn_crawler.results.contacts import contact_force
from exudyn_crawler.results.history import History

SHOE, UNIT = "tab:blue", "tan"


def ground_figure(history: History, time: float) -> Figure:
    """Side view of a run at a time (s), and below it what the ground carries under every shoe."""
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 1)
    side = figure.add_subplot(grid[0])
    carried = figure.add_subplot(grid[1], sharex=side)
    draw_side_view(side, history, time)
    # as high as the side view becomes when it takes the whole width, so that both panels are one as wide
    width, height = np.ptp(side.get_xlim()), np.ptp(side.get_ylim())
    high = 10.5 * height / width
    figure.set_size_inches(11.0, high + 3.2)
    grid.set_height_ratios([high, 2.2])
    side.tick_params(labelbottom=False)
    side.set_xlabel("")
    draw_carried(carried, history, time)
    return figure


def draw_carried(ax: Axes, history: History, time: float) -> Axes:
    """Draw the vertical contact force (kN) on every shoe, summed over the units, over the shoe's x (m).

    At the stored instant nearest to `time` (s); a dashed line shows the mean of loads and weights.
    """
    x = history.position.sel(axis="x").sel(time=time, method="nearest")
    of_contacts = contact_force(history).sel(axis="z").sel(time=time, method="nearest")
    force = np.zeros(len(x))
    np.add.at(force, history.contact_shoe.values - 1, of_contacts.values)
    ax.bar(x, 1e-3 * force, width=0.8 * history.case.shoe.length, color=SHOE, alpha=0.6)
    for place, number in zip(x.values, x["shoe"].values, strict=True):
        ax.annotate(str(number), (place, 0.0), xytext=(0, 3), textcoords="offset points", ha="center")
    ax.axhline(1e-3 * history.case.mean_load, color="k", ls="--", lw=0.8, label="mean load and weight")
    ax.set_ylim(top=1.25e-3 * max(force.max(), history.case.mean_load))
    ax.legend(loc="upper left", fontsize="small", frameon=False)
    ax.set_xlabel("x (m); numbers are those of the shoes")
    ax.set_ylabel("contact force z (kN)")
    return ax


def draw_side_view(ax: Axes, history: History, time: float) -> Axes:
    """Draw shoes, link pins and units at the stored instant nearest to a time.

    Seen along y: x and z in m, both to the same scale. Of the units those are drawn whose row lies below the
    track's middle; shoes that have sunk into a unit overlap it by their penetration.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    history : History
        A run; its case says where units and shoes are at rest.
    time : float
        s.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.
    """
    case, now = history.case, history.dataset.sel(time=time, method="nearest")
    terrain, shoe = case.terrain, case.shoe
    position = now.position.values
    row = int((position[:, 1].mean() - terrain.origin[1]) // terrain.unit_width)
    near = np.arange(terrain.columns) * terrain.rows + row
    half_length, half_height = 0.5 * terrain.unit_length, 0.5 * terrain.unit_height
    for unit in near:
        center = terrain.centers[unit, [0, 2]] + [0.0, float(now.unit_heave[unit])]
        top = half_height + terrain.top_heights[unit]
        box = np.array([[-half_length, -half_height], [half_length, -half_height], [half_length, top]])
        outline = np.vstack((box, [-half_length, top]))
        pitch = float(now.unit_tilt[unit]) if terrain.tilt == "pitch" else 0.0
        ax.add_patch(Polygon(_pitched(outline, pitch) + center, facecolor=UNIT, edgecolor="k", lw=0.6))
    low, high = shoe.footprint[:2]
    outline = np.array(
        [
            [low, -shoe.com_height],
            [high, -shoe.com_height],
            [high, shoe.load_point[2]],
            [low, shoe.load_point[2]],
        ]
    )
    for place, angles in zip(position[:, [0, 2]], now.angles.values, strict=True):
        ax.add_patch(
            Polygon(_pitched(outline, angles[1]) + place, facecolor=SHOE, edgecolor="k", alpha=0.6, lw=0.8)
        )
        pin = _pitched(case.track.front_pin[None, [0, 2]], angles[1])[0] + place
        ax.plot(*pin, "k.", ms=3)
    x = position[[0, -1], 0] + [low - 0.3, high + 0.3]
    tops = terrain.top_heights[near]
    ax.set_xlim(*x)
    ax.set_ylim(min(0.0, tops.min()) - 0.4, position[:, 2].max() + 0.7)
    ax.set_aspect("equal")
    labels = [Patch(color=SHOE, alpha=0.6, label="shoes"), Patch(color=UNIT, label="units")]
    pin_label = Line2D([], [], color="k", marker=".", ls="none", label="link pins")
    ax.legend(handles=[*labels, pin_label], ncols=3, loc="upper left", fontsize="small", frameon=False)
    ax.set_xlabel("x (m)")
    ax.set_ylabel("z (m)")
    ax.set_title(f"{case.name}, t = {float(now.time):.3g} s")
    return ax


def _pitched(points: np.ndarray, angle: float) -> np.ndarray:
    """Points (x, z) turned about y: array (n, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, -s], [s, c]])
