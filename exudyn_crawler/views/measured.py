"""Figures of measured data beside the results of a law or a run."""

from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.results.measured.drawbar import HEADS
from exudyn_crawler.results.measured.series import Compared
from exudyn_crawler.results.measured.soil_fit import SoilFit
from exudyn_crawler.results.measured.soil_tests import PlateTests, ShearTests
from exudyn_crawler.results.measured.traction import EvenTrack

DOTS: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 4.0}
BESIDE: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}  # outside the axes
DRAWN = 200  # points of a curve


def draw_soil_fit(fit: SoilFit, figure: Figure) -> None:
    """Draw a fitted law with its measured points: pressure over sinkage by plate, and shear by pressure."""
    panels = figure.subplots(1, 1 if fit.shear is None else 2, squeeze=False)[0]
    _draw_plates(fit, fit.plates, panels[0])
    if fit.shear is not None:
        _draw_shear(fit, fit.shear, panels[1])


def _draw_plates(fit: SoilFit, plates: PlateTests, axes: Axes) -> None:
    """Draw the measured pressure over sinkage, and the law along the deepest test of each plate size."""
    for number, width in enumerate(plates.widths):
        here = plates.of(plates.width == width)
        colour = f"C{number}"
        label = f"{1e3 * width:.4g} mm"
        axes.plot(1e3 * here.sinkage, 1e-3 * here.pressure, color=colour, alpha=0.5, **DOTS)
        longest = max(here.each(), key=lambda points: float(here.sinkage[points].max()))
        path = _finer(np.maximum(here.sinkage[longest], 0.0))
        pressure, _ = fit.law.drive(path, np.zeros_like(path), float(width))
        axes.plot(1e3 * path, 1e-3 * pressure, color=colour, label=label)
    axes.set(xlabel="sinkage, mm", ylabel="pressure, kPa", ylim=(0.0, None))
    axes.legend(title="plate", **BESIDE)


def _finer(sinkage: np.ndarray) -> np.ndarray:
    """Return a sinkage path with points added between its turns, so that the law is drawn as a curve."""
    turns = np.flatnonzero(np.diff(np.sign(np.diff(sinkage))) != 0) + 1
    corners = sinkage[np.unique([0, *turns, len(sinkage) - 1])]
    count = max(2, DRAWN // max(1, len(corners) - 1))
    return np.concatenate(
        [np.zeros(1), *(np.linspace(begin, end, count) for begin, end in pairwise(corners))]
    )


def _draw_shear(fit: SoilFit, shear: ShearTests, axes: Axes) -> None:
    """Draw shear stress over displacement of every test, and the law under its mean pressure."""
    for number, name in enumerate(dict.fromkeys(shear.test.tolist())):
        here = shear.test == name
        pressure = float(shear.pressure[here].mean())
        colour = f"C{number % 10}"
        slip = np.linspace(0.0, float(shear.displacement[here].max()), DRAWN)
        depth = np.full_like(slip, fit.law.sinkage(pressure))
        _, stress = fit.law.drive(depth, slip)
        axes.plot(1e3 * shear.displacement[here], 1e-3 * shear.stress[here], color=colour, alpha=0.5, **DOTS)
        axes.plot(1e3 * slip, 1e-3 * stress, color=colour, label=f"{1e-3 * pressure:.4g} kPa")
    axes.set(xlabel="displacement, mm", ylabel="shear stress, kPa", ylim=(0.0, None))
    axes.legend(title="pressure", **BESIDE)


def draw_compared(series: list[Compared], figure: Figure) -> None:
    """Draw measured series as points over the curves of the run, one panel for each series."""
    panels = figure.subplots(len(series), 1, squeeze=False, sharex=True)[:, 0]
    for axes, beside in zip(panels, series, strict=True):
        axes.plot(beside.run_place, beside.run_values, color="C0", label="run")
        axes.plot(beside.place, beside.measured, color="C1", label="measured", **DOTS)
        axes.set(ylabel=f"{beside.head}\n{beside.unit}")
    panels[0].legend(**BESIDE)
    panels[-1].set(xlabel="time, s" if series[0].over == "time" else "distance, m")


def draw_drawbar(table: pd.DataFrame, track: EvenTrack, figure: Figure) -> None:
    """Draw pull, torque, efficiency and sinkage over slip; the pull beside its closed form."""
    panels = figure.subplots(2, 2, sharex=True).ravel()
    slip = 100.0 * table[HEADS["slip"]].values
    curves = {
        "pull": ("pull, kN", 1e-3),
        "torque": ("torque of the drive, kN m", 1e-3),
        "efficiency": ("efficiency", 1.0),
        "sinkage": ("sinkage, mm", 1e3),
    }
    for axes, (name, (label, size)) in zip(panels, curves.items(), strict=True):
        axes.plot(slip, size * table[HEADS[name]].values, color="C0", marker=".", label="run")
        axes.set(ylabel=label)
    every = np.linspace(0.0, slip.max(), DRAWN)
    for starts, line, label in ((1, "-", "closed form"), (track.rollers, "--", "shear anew at each roller")):
        pulls = 1e-3 * track.pull(0.01 * every, starts)
        panels[0].plot(every, pulls, color="C1", linestyle=line, label=label)
    panels[0].legend(loc="lower right")
    for axes in panels[[0, 1, 3]]:
        axes.set(ylim=(min(0.0, axes.get_ylim()[0]), None))
    panels[2].set(ylim=(0.0, 1.0))
    for axes in panels[2:]:
        axes.set(xlabel="slip, %")


def draw_soil_stress(table: pd.DataFrame, passages: pd.DataFrame, figure: Figure) -> None:
    """Draw the pressure at sensors over the distance; dashes show the mean below the track."""
    axes = figure.subplots()
    travelled = table["distance in m"].to_numpy()
    heads = [*table.columns][2:]
    for number, (head, label) in enumerate(zip(heads, passages["sensor"], strict=True)):
        axes.plot(travelled, 1e-3 * table[head].to_numpy(), color=f"C{number % 10}", label=f"{label} m")
    if "mean in Pa" in passages:
        for number, mean in enumerate(passages["mean in Pa"]):
            axes.axhline(1e-3 * mean, color=f"C{number % 10}", linestyle="--", linewidth=0.8)
    axes.set(xlabel="distance travelled, m", ylabel="normal pressure, kPa", ylim=(0.0, None))
    axes.legend(title="sensor; dashed: mean", **BESIDE)
