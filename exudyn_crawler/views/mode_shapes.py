"""Table and figure of the modes of a sliding track, as `run.solve.track_modes` gives them."""

import matplotlib as mpl
import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.case import Case
from exudyn_crawler.views.style import STYLE

SWING = 0.1
"""m, greatest motion drawn."""
PHASES = {"0": 1.0 + 0.0j, "a quarter period later": 1.0j}
"""Instants drawn of a swing, as factors of its shape; it does not grow between them in the figure."""


def mode_table(modes: xr.Dataset, count: int = 10) -> pd.DataFrame:
    """The least stable modes: frequency, damping, growth, and what of the shoes moves most.

    Columns `frequency, Hz`, `growth rate, 1/s`, `damping ratio`, `shoe` (the one that moves most) and the
    greatest motion of all shoes in every coordinate, m and rad.
    """
    few = modes.isel(mode=slice(count))
    size = xr.apply_ufunc(np.abs, few["shape"])
    most = size.sel(coordinate=["x", "y", "z"]).max("coordinate").idxmax("shoe")
    table = {
        "mode": few.mode.values,
        "frequency, Hz": few.frequency.values,
        "growth rate, 1/s": few.growth_rate.values,
        "damping ratio": few.damping_ratio.values,
        "shoe": most.values,
    }
    motion = {str(c.values): size.sel(coordinate=c).max("shoe").values for c in size.coordinate}
    return pd.DataFrame(table | motion)


def draw_mode(ax: Axes, modes: xr.Dataset, case: Case, mode: int = 1) -> Axes:
    """Draw undersides and pins of the shoes from the side in a mode, enlarged, about steady sliding."""
    shape = modes["shape"].sel(mode=mode).values
    place = modes.place.values
    coms = case.track.com_positions(case.shoe.com_height) + place[:, :3]
    foot = case.shoe.footprint
    points = np.array(
        [[foot[0], 0.0, foot[4]], [foot[1], 0.0, foot[4]], case.track.front_pin, case.track.rear_pin]
    )
    still = _seen(coms, place[:, 4], points)
    for underside in still[:, :2]:
        ax.plot(*underside.T, color="0.75")
    for number, (name, factor) in enumerate(PHASES.items()):
        motion = SWING * (factor * shape).real
        moved = _seen(coms + motion[:, :3], place[:, 4] + motion[:, 4], points)
        for k, (underside, pins) in enumerate(zip(moved[:, :2], moved[:, 2:], strict=True)):
            ax.plot(*underside.T, color=f"C{number}", lw=2.0, label=name if k == 0 else None)
            ax.plot(*pins.T, color=f"C{number}", marker="o", ms=2.5, lw=0.6)
    value = modes.sel(mode=mode)
    ax.set_title(
        f"mode {mode}: {float(value.frequency):.2f} Hz, growth rate {float(value.growth_rate):+.2f}/s",
        loc="left",
    )
    ax.set_xlabel("x in m")
    ax.set_ylabel("z in m, motion enlarged")
    ax.legend(ncols=len(PHASES))
    return ax


def _seen(coms: np.ndarray, pitch: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Places (shoes, points, 2), x and z, of points (points, 3) given in the shoes' frames."""
    c, s = np.cos(pitch)[:, None], np.sin(pitch)[:, None]
    x, z = points[:, 0], points[:, 2]
    return np.stack((coms[:, :1] + c * x + s * z, coms[:, 2:] - s * x + c * z), axis=-1)


def mode_figure(modes: xr.Dataset, case: Case, numbers: tuple[int, ...] = (1, 2)) -> Figure:
    """The named modes from the side, one below the other."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 0.6 + 2.6 * len(numbers)))
        axes = figure.subplots(len(numbers), 1, sharex=True, squeeze=False)[:, 0].tolist()
        for ax, number in zip(axes, numbers, strict=True):
            draw_mode(ax, modes, case, number)
        figure.suptitle(
            f"{modes.attrs['title']}, sliding at {modes.attrs['speed']:g} m/s",
            x=0.01,
            ha="left",
            parse_math=False,
        )
    return figure
