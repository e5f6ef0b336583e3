"""Motion, forces and stresses of the flexible shoes as the S-paper reports them.

The paper speaks of its flexible shoes only; so do all rows here. Propel lasts until the drive is switched
off, loading from then on.
"""

import math
import re

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.model.flexible_shoes import whole_reduction
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.stress.recovery import StressResults
from studies.comparison import KINEMATIC, comparison_table, statistic_of
from studies.reported import reported_values

MEGA = 1e6
RANKS = {"1st": 0, "2nd": 1, "3rd": 2, "4th": 3, "5th": 4}
MOTION = re.compile(r"(?:any )?flexible shoe (?P<axis>[xyz]) (?P<kind>[a-z ]+)")
CONTACT = re.compile(r"contact force (?P<axis>[xyz]) on a flexible shoe")
REACTION = re.compile(r"revolute joint reaction (?P<axis>[xyz]) \(one of two\)")
HOT_SPOT = re.compile(r"shoe (?P<shoe>\d+) greatest von Mises")


def flexible_quantity(history: History, quantity: str) -> xr.DataArray:
    """Quantity that the S-paper names, in the paper's unit: over time, and shoe, joint, pin or axis if open.

    A ValueError for words that name no such quantity.
    """
    shoes = list(history.case.flexible_shoes().shoes)
    if quantity == "total terrain deformation from equilibrium":
        return history.terrain_deformation
    if quantity == "revolute joint torque x and z":
        return _revolute(history.pin_torque).sel(axis=["x", "z"])
    if match := REACTION.fullmatch(quantity):
        return _revolute(history.pin_force).sel(axis=match["axis"])
    if match := CONTACT.fullmatch(quantity):
        return history.contacts_by_shoe().contact_force.sel(shoe=shoes, axis=match["axis"])
    if (match := MOTION.fullmatch(quantity)) and match["kind"] in KINEMATIC:
        name, factor = KINEMATIC[match["kind"]]
        return factor * history.quantity(name).sel(shoe=shoes, axis=match["axis"])
    raise ValueError(f"{quantity!r} names no quantity of flexible shoes, joints or terrain")


def _revolute(values: xr.DataArray) -> xr.DataArray:
    """Links that have a revolute joint at either pin: those of a flexible shoe."""
    return values.isel(joint=values.notnull().all(["time", "pin", "axis"]).values)


def stress_value(history: History, results: StressResults, case: str, quantity: str, statistic: str) -> float:
    """Computed value of a row on propel, loading or hot spots; NaN where the run does not reach it."""
    if match := HOT_SPOT.fullmatch(quantity):
        table = results.hot_spots.get(int(match["shoe"]))
        return math.nan if table is None else float(table["value"].iloc[RANKS[statistic]]) / MEGA
    if quantity == "any flexible shoe von Mises":
        values = results.dataset.highest_von_mises / MEGA
    else:
        values = flexible_quantity(history, quantity)
    chosen = in_phase(values, history, case)
    return statistic_of(chosen, statistic) if chosen.sizes["time"] else math.nan


def compare_stresses(history: History, results: StressResults) -> pd.DataFrame:
    """Every row of the S-paper against a run; columns as of `comparison.comparison_table`."""
    reported = reported_values("stress")
    frequencies = whole_reduction(history.case).body.frequencies
    computed = []
    for row in reported.itertuples():
        if row.case == "modal":
            first = row.quantity.startswith("free-free mode 1")
            nearest = 0 if first else int(np.argmin(np.abs(frequencies - row.value)))
            computed.append(float(frequencies[nearest]))
        else:
            computed.append(stress_value(history, results, row.case, row.quantity, row.statistic))
    end = float(history.time[-1])
    return comparison_table(reported, computed, dict.fromkeys(reported["case"], end))


def in_phase(values: xr.DataArray, history: History, phase: str) -> xr.DataArray:
    """Part of a series in the propel or in the loading, else a ValueError; empty where no run reaches it."""
    end = min(history.case.drive.switch_times, default=math.inf)
    if phase == "propel":
        return values.where(values.time <= end, drop=True)
    if phase == "loading":
        return values.where(values.time > end, drop=True)
    raise ValueError(f"phase must be 'propel' or 'loading', got {phase!r}")


def highest_in_propel_and_loading(history: History, stresses: StressResults) -> pd.DataFrame:
    """Highest von Mises stress of every flexible shoe in propel and loading, NaN for a phase not reached.

    Columns shoe, propel and loading (MPa), ratio of loading to propel.
    """
    highest = stresses.dataset.highest_von_mises / MEGA
    rows = []
    for shoe in highest.shoe.values:
        phases = {phase: in_phase(highest.sel(shoe=shoe), history, phase) for phase in ("propel", "loading")}
        peaks = {p: float(v.max()) if v.size else math.nan for p, v in phases.items()}
        rows.append({"shoe": int(shoe)} | peaks | {"ratio": peaks["loading"] / peaks["propel"]})
    return pd.DataFrame(rows)
