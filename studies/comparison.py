"""Paper value against computed value.

The tables of the papers name quantities in words (``shoe 13 x displacement``, ``any shoe z velocity``) and
statistics (``max abs``, ``mean over 10 s``). This module parses both, so that a comparison needs nothing but
a row of the reported values.
"""

import math
import re
from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.history import History
from studies.reported import needed_time, reported_values, verdict

KINEMATIC = {
    "displacement": ("displacement", 1.0),
    "displacement from equilibrium": ("displacement", 1.0),
    "velocity": ("velocity", 1.0),
    "acceleration": ("acceleration", 1.0),
    "angular velocity": ("angular_velocity", 180.0 / math.pi),
    "angular acceleration": ("angular_acceleration", 180.0 / math.pi),
}
"""Kinematic quantities of the papers: quantity of the catalogue and factor to the papers' unit."""

SAME_TIME = 1e-9
"""s, below which two times are the same."""

SHOE_QUANTITY = re.compile(r"(?:any shoe|shoe (?P<shoe>\d+)) (?P<axis>[xyz]) (?P<kind>[a-z ]+)")


def time_mean(values: xr.DataArray) -> xr.DataArray:
    """Mean over time, by the trapezoidal rule, for samples that need not be equally spaced."""
    span = float(values.time[-1] - values.time[0])
    return values.integrate("time") / span


def kinematic_quantity(history: History, quantity: str) -> xr.DataArray:
    """Kinematic quantity that a paper names, in the paper's unit: (time, shoe) for any shoe, (time) for one.

    A ValueError for words that name no such quantity.
    """
    match = SHOE_QUANTITY.fullmatch(quantity)
    if match is None or match["kind"] not in KINEMATIC:
        raise ValueError(f"{quantity!r} names no kinematic quantity of a shoe")
    name, factor = KINEMATIC[match["kind"]]
    values = history.quantity(name).sel(axis=match["axis"])
    if match["shoe"]:
        values = values.sel(shoe=int(match["shoe"]))
    return factor * values


def statistic_of(values: xr.DataArray, statistic: str) -> float:
    """Statistic that a paper names over all times and shoes; NaN where the run is too short for it.

    A ValueError for words that name no statistic.
    """
    end = float(values.time[-1])
    if match := re.fullmatch(r"at t=(\d+) s", statistic):
        time = float(match[1])
        if time > end + 1e-9:
            return math.nan
        return float(values.interp(time=min(time, end)))
    if match := re.fullmatch(r"mean over (\d+) s", statistic):
        if end < float(match[1]) - 1e-9:
            return math.nan
        return float(time_mean(values).mean())
    match statistic:
        case "min":
            return float(values.min())
        case "max":
            return float(values.max())
        case "max abs":
            return float(np.abs(values).max())
        case "mean":
            return float(time_mean(values).mean())
        case "value":
            return float(values)
    raise ValueError(f"{statistic!r} names no statistic")


def kinematics_value(histories: Mapping[str, History], case: str, quantity: str, statistic: str) -> float:
    """Computed value of one row of the kinematics tables; NaN where no history is of its case."""
    if case not in histories:
        return math.nan
    values = kinematic_quantity(histories[case], quantity)
    if statistic == "max over its translation value":
        if "translation" not in histories:
            return math.nan
        straight = kinematic_quantity(histories["translation"], quantity)
        return statistic_of(values, "max abs") / statistic_of(straight, "max abs")
    return statistic_of(values, statistic)


def comparison_table(
    reported: pd.DataFrame, computed: list[float], until: Mapping[str, float] | None = None
) -> pd.DataFrame:
    """Reported rows with their computed values, ratios and verdicts.

    Columns study, case, quantity, statistic, unit, paper, computed, ratio, class, within. `within` is yes,
    no, empty if the class has no verdict or nothing was computed, or "not reached" (with an empty ratio) if
    the run is too short: `until` are the ends of those that were made, s, by case; None compares all rows.
    """
    table = reported.drop(columns="source").rename(columns={"value": "paper"})
    table.insert(6, "computed", computed)
    table.insert(7, "ratio", table["computed"] / table["paper"])
    table["within"] = [
        verdict(row.paper, row.computed, kind, row.unit)
        for row, kind in zip(table.itertuples(), table["class"], strict=True)
    ]
    if until is not None:
        short = [
            until.get(row.case, -math.inf) < needed_time(row.study, row.case, row.statistic) - SAME_TIME
            for row in table.itertuples()
        ]
        table.loc[short, "ratio"] = math.nan
        table.loc[short, "within"] = "not reached"
    return table


def ends(histories: Mapping[str, History]) -> dict[str, float]:
    """Last stored times of histories by their case, s."""
    return {case: float(history.time[-1]) for case, history in histories.items()}


def compare_kinematics(histories: Mapping[str, History]) -> pd.DataFrame:
    """Every kinematics row that the papers report against the runs."""
    reported = reported_values("kinematics")
    computed = [
        kinematics_value(histories, row.case, row.quantity, row.statistic) for row in reported.itertuples()
    ]
    return comparison_table(reported, computed, ends(histories))
