"""Propel and loading: what a run does until its drive is first switched off, and from then on."""

import math

import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.stress.stresses import StressResults

MEGA = 1e6


def in_phase(values: xr.DataArray, history: History, phase: str) -> xr.DataArray:
    """Part of a series in the propel or in the loading; empty where the run does not reach it.

    Raises
    ------
    ValueError
        For any other phase.
    """
    end = min(history.case.drive.switch_times, default=math.inf)
    if phase == "propel":
        return values.where(values.time <= end, drop=True)
    if phase == "loading":
        return values.where(values.time > end, drop=True)
    raise ValueError(f"phase must be 'propel' or 'loading', got {phase!r}")


def highest_in_propel_and_loading(history: History, stresses: StressResults) -> pd.DataFrame:
    """Highest von Mises stress of every flexible shoe in propel and loading.

    Returns
    -------
    pandas.DataFrame
        Columns shoe, propel and loading (MPa), ratio of loading to propel; NaN for a phase not reached.
    """
    highest = stresses.dataset.highest_von_mises / MEGA
    rows = []
    for shoe in highest.shoe.values:
        phases = {phase: in_phase(highest.sel(shoe=shoe), history, phase) for phase in ("propel", "loading")}
        peaks = {p: float(v.max()) if v.size else math.nan for p, v in phases.items()}
        rows.append({"shoe": int(shoe)} | peaks | {"ratio": peaks["loading"] / peaks["propel"]})
    return pd.DataFrame(rows)
