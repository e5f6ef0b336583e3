"""Comparison of paper values with computed values, and the tolerance for a sound model.

The tables of the papers name quantities in words (``shoe 13 x displacement``, ``any shoe z velocity``) and
statistics (``max abs``, ``mean over 10 s``). This module parses both, so that a comparison needs only a row
of the reported values: `reported.csv` has one number per row, each with its source. The class of a row
names the cause of its value, which determines the tolerance:

============  ======================================  ==========================
class         cause of the value                      within
============  ======================================  ==========================
exact         algebra of the equations                0.01 %
prescribed    the drive                               1 %
statics       equilibrium and the friction law        10 %
structural    the shoe's geometry, not published      25 %, frequencies 10 %
              in full
fluctuation   bouncing, step size, solver damping     a factor of 2
lateral       asymmetry and noise in their contact    no verdict
prediction    a measurement: soil and machine are     no verdict: the deviation
              the source's, no number the row's       is the result
fit           a measurement that a law is fitted to   no verdict
============  ======================================  ==========================

`evidence.csv` has, for each row of the papers' studies, in how many variants of the model it stays within
this limit, and its median, least and greatest value over starts that differ by rounding (`studies.variants`).
"""

import math
import re
from collections.abc import Mapping
from importlib.resources import files
from typing import Literal

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.history import History

Verdict = Literal["yes", "no", "not reached", ""]

ENDS = {name: {"translation": 10.0, "turning": 10.0} for name in ("kinematics", "forces")}
ENDS["stress"] = {"modal": 0.0, "propel": 15.0, "loading": 40.0, "hot spots": 40.0}
"""Ends of the papers' runs by study and case, s."""

RELATIVE = {"exact": 1e-4, "prescribed": 0.01, "statics": 0.10, "structural": 0.25}
FREQUENCY = 0.10
OPEN = {"lateral", "prediction", "fit"}  # classes without a verdict
FACTOR = 2.0


def reported_values(study: str) -> pd.DataFrame:
    """Read the rows of one study: kinematics, forces, stress, verification or measured.

    Columns: study, case, quantity, statistic, unit, value, class, source. Other names raise `ValueError`.
    """
    with files("studies").joinpath("reported.csv").open() as file:
        table = pd.read_csv(file)
    chosen = table[table["study"] == study]
    if chosen.empty:
        raise ValueError(f"study must be one of {sorted(table['study'].unique())}, got {study!r}")
    return chosen.reset_index(drop=True)


def needed_time(study: str, case: str, statistic: str) -> float:
    """Return the time (s) that a run has to reach before it can be compared with a row."""
    named = re.fullmatch(r"(?:at t=|mean over )(\d+) s", statistic)
    return float(named[1]) if named else ENDS[study][case]


def verdict(paper: float, computed: float, kind: str, unit: str) -> Verdict:
    """Return the verdict on a computed value by the tolerance of its class: yes, no, or no verdict."""
    if kind in OPEN or computed != computed:
        return ""
    ratio = computed / paper
    if kind == "fluctuation":
        return "yes" if 1.0 / FACTOR <= ratio <= FACTOR else "no"
    allowed = FREQUENCY if kind == "structural" and unit == "Hz" else RELATIVE[kind]
    return "yes" if abs(ratio - 1.0) <= allowed else "no"


_RATES = ("velocity", "acceleration")
KINEMATIC = {name: (name, 1.0) for name in ("displacement", *_RATES)}
KINEMATIC |= {f"angular {name}": (f"angular_{name}", 180.0 / math.pi) for name in _RATES}
KINEMATIC["displacement from equilibrium"] = KINEMATIC["displacement"]
"""Quantity of the catalogue, and factor to the papers' unit, by kinematic quantity of the papers."""

SAME_TIME = 1e-9  # s, difference below which two times are the same

SHOE_QUANTITY = re.compile(r"(?:any shoe|shoe (?P<shoe>\d+)) (?P<axis>[xyz]) (?P<kind>[a-z ]+)")


def time_mean(values: xr.DataArray) -> xr.DataArray:
    """Return the mean over time by the trapezoidal rule; samples need not be equally spaced."""
    span = float(values.time[-1] - values.time[0])
    return values.integrate("time") / span


def kinematic_quantity(history: History, quantity: str) -> xr.DataArray:
    """Return a quantity that a paper names, in its unit: (time, shoe), or (time) for one shoe.

    Raises `ValueError` for another quantity.
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
    """Return a statistic that a paper names over times and shoes; NaN if the run is too short.

    Raises `ValueError` for another statistic.
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
    """Return the computed value of a row of the kinematics tables; NaN without a history of its case."""
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
    """Return the reported rows with their computed values, ratios and verdicts.

    Columns study, case, quantity, statistic, unit, paper, computed, ratio, class, within, and those of
    `with_evidence`. `within` is yes or no. It is empty if the class has no verdict or nothing was computed.
    It is "not reached" (with an empty ratio) if the run is too short. `until` has the ends of the runs by
    case, s; None compares all rows.
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
    return with_evidence(table)


ROW = ["study", "case", "quantity", "statistic", "paper"]
"""Columns that tell a reported row from all others."""


def with_evidence(table: pd.DataFrame) -> pd.DataFrame:
    """Add what variants and other starts of the papers' cases say about each row of a comparison.

    Columns variants, the number of variants in which the row is within its limit, such as "9 of 13", and
    median, least and greatest over starts that differ by rounding. All are empty for rows without variants.
    """
    with files("studies").joinpath("evidence.csv").open() as file:
        known = pd.read_csv(file)
    counted = known["within"].astype(str) + " of " + known["variants"].astype(str)
    known = known.assign(variants=counted).drop(columns=["within", "outside", "starts"])
    return table.merge(known, on=ROW, how="left", validate="many_to_one").fillna({"variants": ""})


def ends(histories: Mapping[str, History]) -> dict[str, float]:
    """Return the last stored times of histories by their case, s."""
    return {case: float(history.time[-1]) for case, history in histories.items()}


def compare_kinematics(histories: Mapping[str, History]) -> pd.DataFrame:
    """Compare every kinematics row that the papers report with the runs."""
    reported = reported_values("kinematics")
    computed = [
        kinematics_value(histories, row.case, row.quantity, row.statistic) for row in reported.itertuples()
    ]
    return comparison_table(reported, computed, ends(histories))
