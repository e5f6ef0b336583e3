"""Figures of runs. Functions take axes, draw on them and return them; nothing here computes results."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.files import whole_file
from exudyn_crawler.history import History

SHOES = (1, 4, 7, 10, 13)
"""Shoes that the papers draw."""

QUANTITIES = {
    "displacement": ("position", "displacement", "m", 1.0),
    "velocity": ("velocity", "velocity", "m/s", 1.0),
    "acceleration": ("acceleration", "acceleration", "m/s²", 1.0),
    "angular velocity": ("angular_velocity", "angular velocity", "deg/s", np.degrees(1.0)),
    "angular acceleration": (
        "angular_acceleration",
        "angular acceleration",
        "deg/s²",
        np.degrees(1.0),
    ),
}
"""Kinematic quantities: variable, label, unit of the figure and factor to it."""

STYLE: dict[Any, Any] = {
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

AXES = ("x", "y", "z")

NEGLIGIBLE = 1e-6
"""Half the least range of an axis, in its unit: rounding must not look like motion."""


def draw_kinematic(ax: Axes, history: History, quantity: str, axis: str, shoes: Sequence[int]) -> Axes:
    """One component of a kinematic quantity of some shoes over time."""
    name, _, _, factor = QUANTITIES[quantity]
    values = history.dataset[name].sel(axis=axis)
    if name == "position":
        values = values - values.isel(time=0)
    for shoe in shoes:
        ax.plot(history.time, factor * values.sel(shoe=shoe), label=f"shoe {shoe}")
    return ax


def kinematic_figure(history: History, quantity: str, shoes: Sequence[int] = SHOES) -> Figure:
    """x, y and z of a kinematic quantity of some shoes, one below the other."""
    figure, axes = rows_of_axes(3)
    for ax, axis in zip(axes, AXES, strict=True):
        draw_kinematic(ax, history, quantity, axis, shoes)
        _label(ax, quantity, axis)
    return titled(figure, axes, f"{history.case.name}: {quantity}")


def comparison_figure(histories: Mapping[str, History], quantity: str, shoe: int) -> Figure:
    """x, y and z of a kinematic quantity of one shoe in several cases."""
    figure, axes = rows_of_axes(3)
    for ax, axis in zip(axes, AXES, strict=True):
        for case, history in histories.items():
            draw_kinematic(ax, history, quantity, axis, [shoe])
            ax.lines[-1].set_label(case)
        _label(ax, quantity, axis)
    return titled(figure, axes, f"shoe {shoe}: {quantity}")


def rows_of_axes(count: int) -> tuple[Figure, Sequence[Axes]]:
    """Figure with axes over time, one below the other."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 2.3 * count))
        axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0].tolist()
    axes[-1].set_xlabel("time in s")
    return figure, axes


def titled(figure: Figure, axes: Sequence[Axes], title: str) -> Figure:
    """Give a figure its title and the legend of its first axes; show noise as the zero that it is."""
    for ax in axes:
        low, high = ax.get_ylim()
        if high - low < 2.0 * NEGLIGIBLE:
            ax.set_ylim(-NEGLIGIBLE, NEGLIGIBLE)
    figure.suptitle(title, x=0.01, ha="left")
    handles, labels = axes[0].get_legend_handles_labels()
    with mpl.rc_context(STYLE):
        figure.legend(handles, labels, loc="outside upper right", ncols=len(labels))
    return figure


def _label(ax: Axes, quantity: str, axis: str) -> None:
    _, label, unit, _ = QUANTITIES[quantity]
    ax.set_ylabel(f"{axis} {label}\nin {unit}")


def save_figure(figure: Figure, path: Path, overwrite: bool = False) -> Path:
    """Write a figure as the file type that its name says, whole or not at all."""
    with mpl.rc_context(STYLE), whole_file(path, overwrite) as temporary:
        figure.savefig(temporary)
    return path
