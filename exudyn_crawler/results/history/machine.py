"""Answers on a machine on closed tracks: chain tension, roller loads, drive torque and ground pressure."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.results.history import History
from exudyn_crawler.results.history.summary import start_ends, tension_along_chain

SETTLED = 0.5  # begin of the evaluated part of a run that ends during its start, fraction of the run
SAME = 0.01
"""Relative difference of both sides of a machine below which they share a row."""
KILO = 1e3
Row = tuple[str, float, str, str]


def machine_answers(history: History) -> pd.DataFrame:
    """Return a table of a run after its start, see `evaluated_from`; the static tension alone is of t = 0.

    Columns are result, value, unit and of. The slack run is the point of the loop with the least mean
    tension, the taut run the one with the greatest. ValueError if no track is closed.
    """
    history.case.part(Closed)
    late = History(history.case, history.dataset.isel(time=history.time >= evaluated_from(history)))
    sides = SIDES if history.case.gear.tracks > 1 else ("",)
    rows: list[Row] = []
    for side in sides:
        start = history.of_track(side) if side else history
        rows += _tensions(start, late.of_track(side) if side else late, f"{side} track".strip())
    rows += [*_rollers(late), *_drives(late), *_pressure(late)]
    return pd.DataFrame(rows, columns=["result", "value", "unit", "of"])


def evaluated_from(history: History) -> float:
    """Return the begin of the table's window, s: the end of the start, or half of a run that is all start."""
    return start_ends(history) or SETTLED * history.duration


def together(table: pd.DataFrame) -> pd.DataFrame:
    """Return answers with one row for both sides of the machine if their values agree within `SAME`."""
    rows: list[Row] = []
    for (result, unit), group in table.groupby(["result", "unit"], sort=False):
        values = group["value"]
        if len(group) > 1 and values.max() - values.min() <= SAME * values.abs().max():
            largest = float(values.loc[values.abs().idxmax()])
            rows.append((str(result), largest, str(unit), f"both sides, within {100 * SAME:g} %"))
        else:
            rows += group[["result", "value", "unit", "of"]].itertuples(index=False, name=None)
    return pd.DataFrame(rows, columns=[*table.columns])


def _tensions(whole: History, late: History, of: str) -> Iterator[Row]:
    """Yield the tension of a chain at rest and in travel, and the greatest force of a link."""
    static = whole.quantity("link_tension").isel(time=0)
    yield "static tension, mean", float(static.mean()) / KILO, "kN", of
    along = tension_along_chain(late)
    mean = along.mean_at.values
    for name, value in (("slack run", np.nanmin(mean)), ("taut run", np.nanmax(mean))):
        yield f"tension of the {name}", float(value) / KILO, "kN", of
    yield "pin force, greatest of a link", float(late.quantity("link_tension").max()) / KILO, "kN", of


def _rollers(late: History) -> Iterator[Row]:
    """Yield the loads of the lower rollers: mean, greatest, and their ratio."""
    lower = [label.words for label in late.case.gear.wheel_labels if label.kind == "roller"]
    force = late.dataset.wheel_force.sel(wheel=lower).transpose("time", "wheel", "axis").values
    size = np.linalg.norm(force, axis=-1)
    mean = float(size.mean())
    yield "load of a lower roller, mean", mean / KILO, "kN", f"{len(lower)} rollers"
    greatest = lower[int(size.max(axis=0).argmax())]
    yield "load of a lower roller, greatest", float(size.max()) / KILO, "kN", greatest
    yield "greatest load over the mean", float(size.max()) / mean, "", greatest


def _drives(late: History) -> Iterator[Row]:
    """Yield the mean torque and power of every drive."""
    data = late.dataset
    torque = data.drive_moment.transpose("time", ...).values.reshape(late.time.size, -1)
    speed = data.tumbler_speed.transpose("time", ...).values.reshape(late.time.size, -1)
    for name, moment, turning in zip(late.case.gear.tumblers, torque.T, speed.T, strict=True):
        yield "torque of the drive, mean", float(moment.mean()) / KILO, "kN m", name
        yield "power of the drive, mean", float((moment * turning).mean()) / KILO, "kW", name


def _pressure(late: History) -> Iterator[Row]:
    """Yield the pressure below the shoes, and the greatest sinkage."""
    pressure = late.quantity("ground_pressure").transpose("time", "shoe").values
    mean = float(late.quantity("mean_ground_pressure").mean())
    yield "pressure below loaded shoes, mean", mean / KILO, "kPa", ""
    shoe = late.shoe.values[int(pressure.max(axis=0).argmax())]
    yield "pressure below a shoe, greatest", float(pressure.max()) / KILO, "kPa", f"shoe {shoe}"
    depth = late.contacts_by_shoe().penetration
    yield "sinkage, greatest", KILO * float(depth.max()), "mm", ""
