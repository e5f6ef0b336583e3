"""Drawings of wear: percent worn over hours with readings, law, band and limit."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.results.wear.forecast import PartForecast, WearForecast
from exudyn_crawler.results.wear.laws import WORN_OUT
from exudyn_crawler.views import style

LIMIT = "#c0271d"
ACROSS = 3
"""Panels beside each other."""
BEYOND = 1.1
"""Drawn hours, fraction of those at the end of the life."""
FARTHEST = 4.0
"""Greatest drawn hours, fraction of those now: a band without an end is cut."""
DRAWN = 120  # points of a curve


def forecast_figure(found: WearForecast) -> Figure:
    """Draw percent worn over hours for all parts, the next one due first."""
    count = len(found.parts)
    rows = -(-count // ACROSS)
    across = min(count, ACROSS)
    title = f"Percent worn over {found.inspections.basis} since new: readings, law and 90 % band"
    with style.titled_figure(title, 1.2 + 3.4 * across, 0.8 + 2.5 * rows) as figure:
        panels = figure.subplots(rows, across, squeeze=False).ravel()
        for ax, part in zip(panels, found.parts, strict=False):
            _draw_part(ax, part)
        for ax in panels[count:]:
            ax.set_axis_off()
    return figure


def _draw_part(ax: Axes, part: PartForecast) -> None:
    """Draw one part."""
    high = float(max(part.now, part.used.max()))
    if part.fit is not None:
        ends = [part.fit.life, part.fit.high if np.isfinite(part.fit.high) else part.fit.life]
        high = max(high, min(BEYOND * max(ends), FARTHEST * high))
        hours = np.linspace(0.0, high, DRAWN)
        ax.plot(hours, part.fit.percent(hours), color="C0", label=part.fit.law.words)
        if np.isfinite(part.fit.low):
            slow = np.zeros(DRAWN) if np.isinf(part.fit.high) else part.fit.percent(hours, part.fit.high)
            ax.fill_between(hours, slow, part.fit.percent(hours, part.fit.low), color="C0", alpha=0.15, lw=0)
    ax.plot(part.used, part.percent, linestyle="none", marker="o", markersize=3.5, color="C1", label="read")
    ax.axhline(WORN_OUT, color=LIMIT, lw=1.0)
    ax.axvline(part.now, color=style.PHASE_NAME, lw=0.8, ls=":")
    ax.set(xlim=(0.0, high), ylim=(min(0.0, float(part.percent.min())), 1.3 * WORN_OUT))
    ax.set_title(part.name, loc="left", fontsize=9)
    ax.set(xlabel=f"{part.basis}", ylabel="worn, %")
    ax.legend(loc="upper left", fontsize=7)
