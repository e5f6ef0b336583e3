"""Curves over time in panels one below the other, with the phases of a run as light bands behind them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import matplotlib as mpl
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.results.history.history import RunPhase
from exudyn_crawler.views.style import PHASE_BANDS, PHASE_NAME, STYLE, in_figure_unit, negligible

PANEL_WIDTH, PANEL_HEIGHT, TITLE_HEIGHT, TIME_HEIGHT, LABEL_WIDTH = 8.0, 2.2, 0.38, 0.72, 1.1
"""Inches: width of a figure and height of each of its panels, height of what is written above and below them,
width of what is written at their left."""
NAME_SIZE, NAME_INSET = 6.5, 2.0
"""Points: size of a name, and how far it stands to the right of its band's begin and above it."""


@dataclass(frozen=True)
class Panel:
    """One pair of axes of a figure over time: what is drawn, its unit, and series (time,) by their names."""

    label: str
    unit: str
    curves: Mapping[str, xr.DataArray]

    @classmethod
    def of(cls, label: str, curves: Mapping[str, xr.DataArray]) -> Self:
        """Panel of one quantity in the unit for reading; `curves` have the catalogue's attributes."""
        read = {name: in_figure_unit(values) for name, values in curves.items()}
        return cls(label, next(iter(read.values())).attrs["units"], read)


def draw_panel(ax: Axes, panel: Panel) -> None:
    """Draw the curves of a panel over time."""
    for name, values in panel.curves.items():
        ax.plot(values.time, values, label=name)
    ax.set_ylabel(f"{panel.label}\nin {panel.unit}")
    floor = negligible(panel.unit)
    low, high = ax.get_ylim()
    if high - low < 2.0 * floor:
        ax.set_ylim(-floor, floor)


def panel_figure(title: str, panels: Sequence[Panel], phases: Sequence[RunPhase] = ()) -> Figure:
    """Panels one below the other, with one legend; phases of the run stand behind the curves."""
    # places that are searched for would take half of the time of a figure
    with mpl.rc_context(STYLE | {"figure.constrained_layout.use": False}):
        height = TITLE_HEIGHT + PANEL_HEIGHT * len(panels) + TIME_HEIGHT
        figure = Figure(figsize=(PANEL_WIDTH, height))
        axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0].tolist()
        figure.subplots_adjust(
            left=LABEL_WIDTH / PANEL_WIDTH,
            right=0.985,
            top=1.0 - TITLE_HEIGHT / height,
            bottom=TIME_HEIGHT / height,
            hspace=0.12,
        )
        for ax, panel in zip(axes, panels, strict=True):
            draw_panel(ax, panel)
        draw_phases(axes, phases)
        axes[-1].set_xlabel("time in s")
        # a case may have any name, also one that looks like a formula
        figure.suptitle(title, x=0.01, y=1.0 - 0.06 / height, ha="left", parse_math=False)
        figure.align_ylabels(axes)
        handles, labels = axes[0].get_legend_handles_labels()
        if len(labels) > 1:
            close = {"columnspacing": 1.2, "handlelength": 1.4}
            figure.legend(handles, labels, loc="lower center", ncols=len(labels), **close)
    return figure


def draw_phases(axes: Sequence[Axes], phases: Sequence[RunPhase]) -> None:
    """Draw a band a phase behind the curves of some panels of a figure over the same time (s).

    Colours alternate. Names stand above the first panel alone, where no curve can be; one that is wider than
    its band is left out. A run of one phase has no bands.

    Parameters
    ----------
    axes : sequence of Axes
        Panels that have their curves, their place in the figure and their limits.
    phases : sequence of RunPhase
        Of the run; what of them is beyond the limits is not drawn.
    """
    for panel, ax in enumerate(axes):
        low, high = ax.get_xlim()
        for number, phase in enumerate(phases if len(phases) > 1 else ()):
            begin, end = max(phase.begin, low), min(phase.end, high)
            if begin >= end:
                continue
            colour = PHASE_BANDS[number % len(PHASE_BANDS)]
            ax.axvspan(begin, end, facecolor=colour, edgecolor="none", zorder=0.0)
            if panel > 0:
                continue
            text = ax.annotate(
                phase.name,
                (begin, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(NAME_INSET, NAME_INSET),
                textcoords="offset points",
                va="bottom",
                fontsize=NAME_SIZE,
                color=PHASE_NAME,
                # a phase may have any name, also one that looks like a formula
                parse_math=False,
            )
            if text.get_window_extent().x1 > ax.transData.transform((end, 0.0))[0]:
                text.remove()
