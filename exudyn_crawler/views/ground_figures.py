"""The track on uneven ground at one time: from the side, and what the ground carries under every shoe."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.colours import SHOE
from exudyn_crawler.views.placement import instant
from exudyn_crawler.views.side_view import SideView

DEPTH = 0.4
"""m of ground that is drawn below its lowest face."""


def ground_figure(history: History, time: float) -> Figure:
    """Side view of a run at a time (s), and below it what the ground carries under every shoe."""
    moment = History(history.case, history.dataset.sel(time=[time], method="nearest"))
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 1)
    side = figure.add_subplot(grid[0])
    carried = figure.add_subplot(grid[1], sharex=side)
    SideView(side, moment).show(instant(moment, time))
    side.set_ylim(bottom=min(0.0, float(history.case.terrain.top_heights.min())) - DEPTH)
    side.set_title(f"{history.case.name}, t = {moment.duration:.3g} s")
    side.legend(ncols=3, loc="upper left", fontsize="small", frameon=False)
    draw_carried(carried, moment, time)
    # as high as the side view becomes when it takes the whole width, so that both panels are one as wide
    width, height = np.ptp(side.get_xlim()), np.ptp(side.get_ylim())
    high = 10.5 * height / width
    figure.set_size_inches(11.0, high + 3.2)
    grid.set_height_ratios([high, 2.2])
    side.tick_params(labelbottom=False)
    side.set_xlabel("")
    return figure


def draw_carried(ax: Axes, history: History, time: float) -> Axes:
    """Draw the vertical contact force (kN) on every shoe, summed over the units, over the shoe's x (m).

    At the stored instant nearest to `time` (s); a dashed line shows the mean of loads and weights.
    """
    x = history.position.sel(axis="x").sel(time=time, method="nearest")
    force = history.contacts_by_shoe().contact_force.sel(axis="z").sel(time=time, method="nearest")
    ax.bar(x, 1e-3 * force, width=0.8 * history.case.shoe.length, color=SHOE)
    for place, number in zip(x.values, x["shoe"].values, strict=True):
        ax.annotate(str(number), (place, 0.0), xytext=(0, 3), textcoords="offset points", ha="center")
    mean = history.case.mean_load
    ax.axhline(1e-3 * mean, color="k", ls="--", lw=0.8, label="mean load and weight")
    ax.set_ylim(top=1.25e-3 * max(float(force.max()), mean))
    ax.legend(loc="upper left", fontsize="small", frameon=False)
    ax.set_xlabel("x in m; numbers are those of the shoes")
    ax.set_ylabel("contact force z in kN")
    return ax
