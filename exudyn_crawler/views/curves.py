"""Figures of runs. Functions take axes or make a figure and return it; nothing here computes results."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.files import whole_file
from exudyn_crawler.results.history.catalogue import select
from exudyn_crawler.results.history.history import History, RunPhase, common_phases
from exudyn_crawler.views.phase_bands import draw_phases

SHOES = (1, 4, 7, 10, 13)
"""Shoes that the papers draw."""
JOINTS = (1, 4, 7, 10, 12)
"""Links that the papers draw, by their rear shoe: those behind these shoes, and 12-13."""

READ_IN = {
    "Pa": ("MPa", 1e-6),
    "m/s2": ("m/s²", 1.0),
    "rad": ("deg", float(np.degrees(1.0))),
    "rad/s": ("deg/s", float(np.degrees(1.0))),
    "rad/s2": ("deg/s²", float(np.degrees(1.0))),
}
"""Units of figures and factors to them, by those of the catalogue; others are drawn as they are."""
KINEMATICS = {name.replace("_", " "): one for name, one in select(curves="motion").items()}
"""Kinematic quantities that the papers draw."""

STYLE: dict[Any, Any] = {
    "axes.formatter.limits": (-4, 5),
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.constrained_layout.use": True,
    "font.size": 9,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "lines.linewidth": 0.9,
    "savefig.dpi": 130,
}

PANEL_WIDTH, PANEL_HEIGHT, TITLE_HEIGHT, TIME_HEIGHT, LABEL_WIDTH = 8.0, 2.2, 0.38, 0.72, 1.1
"""Inches: width of a figure and height of each of its panels, height of what is written above and below them,
width of what is written at their left."""

AXES = ("x", "y", "z")

NEGLIGIBLE = {"N": 1.0, "N m": 1.0}
"""Half the least range of an axis by its unit: rounding must not look like motion."""
NEGLIGIBLE_MOTION = 1e-6
"""Same for all other units."""


@dataclass(frozen=True)
class Panel:
    """One pair of axes of a figure over time.

    Attributes
    ----------
    label, unit : str
        What is drawn and its unit.
    curves : mapping
        Series over time (dimension time) by their names.
    """

    label: str
    unit: str
    curves: Mapping[str, xr.DataArray]


def draw_panel(ax: Axes, panel: Panel) -> Axes:
    """Draw the curves of a panel over time."""
    for name, values in panel.curves.items():
        ax.plot(values.time, values, label=name)
    ax.set_ylabel(f"{panel.label}\nin {panel.unit}")
    floor = NEGLIGIBLE.get(panel.unit, NEGLIGIBLE_MOTION)
    low, high = ax.get_ylim()
    if high - low < 2.0 * floor:
        ax.set_ylim(-floor, floor)
    return ax


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


def axis_panels(
    label: str, unit: str, curves: Mapping[str, xr.DataArray], axes: Sequence[str] = AXES
) -> list[Panel]:
    """Panel for each component of vector series (dimensions time and axis)."""
    return [
        Panel(f"{axis} {label}", unit, {name: v.sel(axis=axis) for name, v in curves.items()})
        for axis in axes
    ]


def in_figure_unit(values: xr.DataArray) -> xr.DataArray:
    """Values of a quantity in the unit of figures, which stands among their attributes."""
    unit = values.attrs.get("units", "")
    drawn, factor = READ_IN.get(unit, (unit, 1.0))
    return values if drawn == unit else (factor * values).assign_attrs(values.attrs | {"units": drawn})


def kinematic_figure(history: History, quantity: str, shoes: Sequence[int] = SHOES) -> Figure:
    """x, y and z of a kinematic quantity of some shoes."""
    values = in_figure_unit(history.quantity(KINEMATICS[quantity].name))
    curves = {f"shoe {shoe}": values.sel(shoe=shoe) for shoe in shoes}
    panels = axis_panels(quantity, values.attrs["units"], curves)
    return panel_figure(f"{history.case.name}: {quantity}", panels, common_phases(history))


def comparison_figure(histories: Mapping[str, History], quantity: str, shoe: int) -> Figure:
    """x, y and z of a kinematic quantity of one shoe in several cases."""
    name = KINEMATICS[quantity].name
    curves = {case: in_figure_unit(one.quantity(name)).sel(shoe=shoe) for case, one in histories.items()}
    panels = axis_panels(quantity, next(iter(curves.values())).attrs["units"], curves)
    return panel_figure(f"shoe {shoe}: {quantity}", panels, common_phases(*histories.values()))


def save_figure(figure: Figure, path: Path, overwrite: bool = False) -> Path:
    """Write a figure as the file type that its name says, whole or not at all."""
    with mpl.rc_context(STYLE), whole_file(path, overwrite) as temporary:
        figure.savefig(temporary)
    return path
