"""Drawings of wear: percent worn over hours, work round the loop and by part, take-up over growth."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.results.wear import closed_form
from exudyn_crawler.results.wear.duty_work import DutyWork, mean_by_place, work_table
from exudyn_crawler.results.wear.forecast import PartForecast, WearForecast
from exudyn_crawler.results.wear.laws import WORN_OUT
from exudyn_crawler.results.wear.results import WearResults
from exudyn_crawler.views import style

LIMIT = "#c0271d"
ACROSS = 3
"""Panels beside each other."""
BEYOND = 1.1
"""Drawn hours, fraction of those at the end of the life."""
FARTHEST = 4.0
"""Greatest drawn hours, fraction of those now: a band without an end is cut."""
POINTS = 120  # points of a curve
DRAWN = ("percent worn", "loop", "work by part", "take-up")
"""Names of all drawings."""
LOOPS = {"pin": "pins", "bush": "bushes on teeth", "rail": "rails under wheels"}
"""Pairs drawn round the loop."""
MOST_GROWTH = 1.2
"""Drawn growth, fraction of the greatest limit."""


def file_name(drawing: str) -> str:
    """Return the name of the file of a drawing."""
    return f"{drawing.replace(' ', '_').replace('-', '_')}.png"


def wear_figures(found: WearResults) -> dict[str, Figure]:
    """Return all drawings of a wear forecast by name."""
    drawn = {}
    if found.forecast is not None:
        drawn["percent worn"] = forecast_figure(found.forecast)
    if found.duties:
        drawn["loop"] = loop_figure(found.duties[0])
        drawn["work by part"] = parts_figure(found.duties[0])
        drawn["take-up"] = take_up_figure(found)
    return drawn


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
        hours = np.linspace(0.0, high, POINTS)
        ax.plot(hours, part.fit.percent(hours), color="C0", label=part.fit.law.words)
        if np.isfinite(part.fit.low):
            slow = np.zeros(POINTS) if np.isinf(part.fit.high) else part.fit.percent(hours, part.fit.high)
            ax.fill_between(hours, slow, part.fit.percent(hours, part.fit.low), color="C0", alpha=0.15, lw=0)
    ax.plot(part.used, part.percent, linestyle="none", marker="o", markersize=3.5, color="C1", label="read")
    ax.axhline(WORN_OUT, color=LIMIT, lw=1.0)
    ax.axvline(part.now, color=style.PHASE_NAME, lw=0.8, ls=":")
    ax.set(xlim=(0.0, high), ylim=(min(0.0, float(part.percent.min())), 1.3 * WORN_OUT))
    ax.set_title(part.name, loc="left", fontsize=9)
    ax.set(xlabel=f"{part.basis}", ylabel="worn, %")
    ax.legend(loc="upper left", fontsize=7)


def loop_figure(duty: DutyWork) -> Figure:
    """Draw the loop of the chain, coloured by the work a metre of travel at each place."""
    work = next(iter(duty.runs.values()))
    closed = work.case.part(Closed)
    ends = np.roll(work.places, 1, axis=0)
    title = f"Work of wear a metre of travel by place, {duty.duty.name}: rear and tumbler on the left"
    with style.titled_figure(title, 8.0, 0.5 + 2.2 * len(LOOPS)) as figure:
        for ax, (pair, words) in zip(figure.subplots(len(LOOPS), 1), LOOPS.items(), strict=True):
            values = mean_by_place(duty, pair)
            (x, z), radius = closed.tumbler.place, closed.tumbler.radius(work.case.track.pitch)
            wheels = [(x, z, radius), *closed.wheels(work.take_up).tolist()]
            for x, z, radius in wheels:
                ax.add_patch(mpl.patches.Circle((x, z), radius, color=style.BEAM, lw=0))
            high = style.round_up(float(values.max())) if values.max() > 0.0 else 1.0
            scale = style.scale_of(0.0, high, style.STRESS_MAP)
            # a pin lies at an end of the segments, a shoe between its pins
            middles = np.stack((ends, work.places), axis=1)
            if pair == "pin":
                ahead = np.roll(work.places, -1, axis=0)
                halves = 0.5 * (ends + work.places), 0.5 * (work.places + ahead)
                middles = np.stack((halves[0], work.places, halves[1]), axis=1)
            ax.add_collection(LineCollection([*middles], colors=scale.to_rgba(values), linewidths=5.0))
            ax.set_aspect("equal")
            ax.autoscale_view()
            ax.set_axis_off()
            ax.set_title(words, loc="left", fontsize=9)
            figure.colorbar(scale, ax=ax, label="J/m", fraction=0.03)
    return figure


def parts_figure(duty: DutyWork) -> Figure:
    """Draw the work a metre of travel of each part as bars, one for each run of a duty."""
    table = work_table(duty)
    # rollers and carriers as their means
    kinds = table["pair"].str.replace(r"^(roller|carrier|slide).*", r"\1s, mean", regex=True)
    means = (
        table.assign(pair=kinds).groupby(["pair", "run"], sort=False)["work a metre in J"].mean().unstack()
    )
    width = 0.8 / means.shape[1]
    with style.titled_figure(
        "Work of wear a metre of travel, of one link, shoe or wheel", 8.0, 4.5
    ) as figure:
        ax = figure.subplots()
        rows = np.arange(len(means))
        for number, run in enumerate(means.columns):
            place = rows + width * (number - 0.5 * (means.shape[1] - 1))
            ax.barh(place, means[run].to_numpy(), width, label=str(run))
        ax.set_yticks(rows, means.index)
        ax.invert_yaxis()
        ax.set_xscale("log")
        ax.set_xlabel("J/m")
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def take_up_figure(found: WearResults) -> Figure:
    """Draw the take-up over the growth of the pitch, with the adjuster's range and the limits of growth."""
    work = next(iter(found.duties[0].runs.values()))
    closed = work.case.part(Closed)
    limits = found.growth
    now = 100.0 * closed.pitch_growth
    growth = np.linspace(now, MOST_GROWTH * float(limits["growth in %"].max()), POINTS)
    added = closed_form.take_up_of(1.0, work.shoes, work.case.track.pitch) * 0.01 * (growth - now)
    with style.titled_figure("Take-up over the growth of the pitch, N p g / 2", 8.0, 3.4) as figure:
        ax = figure.subplots()
        ax.plot(growth, 1e3 * (work.take_up + added), label="take-up at the same sag")
        ax.axhline(1e3 * closed.idler.range[1], color=LIMIT, lw=1.0, label="end of the adjuster")
        for number, row in enumerate(limits.itertuples(index=False)):
            ax.axvline(row[1], color=f"C{number + 1}", lw=1.0, ls="--", label=f"{row[0]}: {row[1]:.3g} %")
        ax.set(xlabel="growth of the pitch, %", ylabel="take-up, mm", xlim=(growth[0], growth[-1]))
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)
    return figure
