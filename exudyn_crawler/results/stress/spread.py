"""Spread of stresses between runs that could stand for each other.

A track that sticks and slips takes another path from a start that differs by rounding, and more than one law
of contact could stand for the same ground: what such runs differ by is open of each of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.catalogue import variable
from exudyn_crawler.results.stress.hot_spots import MEGA, hot_spot_table
from exudyn_crawler.results.stress.recovery import StressResults, verdicts
from fem import judged

FIRST = "start 1"
"""Name of the run that is judged."""
OPEN_PARTS = ("spread", "choice")
"""Columns of what is open of a stress by starts and by laws of contact, Pa."""


@dataclass(frozen=True)
class Spread:
    """Stresses of a run with what others differ from it by.

    Attributes
    ----------
    dataset : xarray.Dataset
        What the catalogue of quantities has of spread: dimensions shoe and node as of `StressResults`, and
        run: the names of all runs, that of `peak_von_mises` first. Both spread and choice
        are in `peak_verdict`.
    hot_spots : mapping
        Tables of the first run's shoes as of `StressResults`, with columns spread and choice (Pa) and the
        verdict that follows.
    """

    dataset: xr.Dataset
    hot_spots: Mapping[int, pd.DataFrame]

    def by_shoe(self) -> pd.DataFrame:
        """Highest stress of each shoe in each run (MPa), and its spread and choice in per cent."""
        rows = []
        for shoe, table in self.hot_spots.items():
            top = table.iloc[0]
            peaks = self.dataset.run_peak.sel(shoe=shoe, node=int(top["node"])) / MEGA
            row: dict[str, object] = {"shoe": shoe, "node": int(top["node"])}
            row |= {f"{run} in MPa": float(peaks.sel(run=run)) for run in self.dataset.run.values}
            row |= {f"{name} in %": 100.0 * float(top[name] / abs(top["value"])) for name in OPEN_PARTS}
            rows.append(row | {"verdict": top["verdict"]})
        return pd.DataFrame(rows)

    def hot_spot_tables(self) -> dict[int, pd.DataFrame]:
        """Hot spots of every shoe for reading, in MPa."""
        tables = {}
        for shoe, table in self.hot_spots.items():
            shown = hot_spot_table(table, self.dataset)
            place = shown.columns.get_loc("flag")
            for k, name in enumerate(OPEN_PARTS):
                shown.insert(place + k, f"{name} in MPa", table[name] / MEGA)
            tables[shoe] = shown
        return tables


def spread_of(
    first: StressResults, starts: Mapping[str, xr.DataArray], laws: Mapping[str, xr.DataArray]
) -> Spread:
    """Spread of the stresses of a run that is judged.

    Parameters
    ----------
    starts, laws : mapping of str to DataArray (shoe, node)
        Greatest von Mises stresses in Pa of runs from other starts and with other laws of contact.

    Raises
    ------
    ValueError
        If there is no other run, or one has other shoes or nodes.
    """
    own = first.dataset.peak_von_mises.transpose("shoe", "node")
    others = {**starts, **laws}
    if not others:
        raise ValueError("other runs must be at least one, got none")
    for name, peak in others.items():
        if peak.shape != own.shape or peak.shoe.values.tolist() != own.shoe.values.tolist():
            raise ValueError(f"run {name!r} must have the same shoes and nodes")
    runs = np.stack([own.values, *(peak.transpose("shoe", "node").values for peak in others.values())])
    same = runs[: 1 + len(starts)]
    low, high = same.min(axis=0), same.max(axis=0)
    beyond = np.maximum(runs - high, low - runs).max(axis=0)
    spread = high - low
    parts = {"peak_spread": spread, "peak_choice": beyond, "run_peak": runs}
    dataset = first.dataset[["peak_von_mises", "node_position", "triangle", "in_spider", "truncation"]]
    dataset = dataset.assign({name: variable(name, values) for name, values in parts.items()})
    dataset = dataset.assign(peak_verdict=verdicts(first.dataset, spread + beyond))
    bound, tables = float(first.dataset.truncation), {}
    for row, (shoe, table) in enumerate(first.hot_spots.items()):
        nodes = table["node"].to_numpy()
        wider = table.assign(spread=spread[row, nodes], choice=beyond[row, nodes])
        tables[shoe] = judged(wider, None if np.isnan(bound) else bound, wider["spread"], wider["choice"])
    return Spread(dataset.assign_coords(run=[FIRST, *others]), tables)


def relative_spread(dataset: xr.Dataset) -> xr.DataArray:
    """Spread of each node's greatest stress over itself, from starts and laws together: (shoe, node)."""
    size = np.maximum(dataset.peak_von_mises, np.finfo(float).tiny)
    return ((dataset.peak_spread + dataset.peak_choice) / size).transpose("shoe", "node")
