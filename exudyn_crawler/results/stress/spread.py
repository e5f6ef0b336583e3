"""Spread of stresses between runs that could stand for each other.

A track that sticks and slips takes another path from a start that differs by rounding, and more than one law
of contact could stand for the same ground: what such runs differ by is open of each of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.history.catalogue import Variable, variable
from exudyn_crawler.results.stress.hot_spots import MEGA, hot_spot_table
from exudyn_crawler.results.stress.recovery import StressResults
from fem import judged
from fem.trust import verdict_numbers

FIRST = "start 1"
"""Name of the run that is judged."""


@dataclass(frozen=True)
class Spread:
    """Stresses of a run with what others differ from it by.

    Attributes
    ----------
    dataset : xarray.Dataset
        Dimensions shoe and node as of `StressResults`, and run: the names of all runs. Variables, in Pa:

        - run_peak (run, shoe, node), the greatest von Mises stress in each run; that of the first is
          peak_von_mises (shoe, node)
        - peak_spread (shoe, node), its range over the starts, and peak_choice (shoe, node), by how much those
          with other laws of contact are beyond that range
        - peak_verdict (shoe, node), a number of `fem.trust.VERDICTS` with all of this in it
        - node_position, triangle and in_spider
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
            own = self.dataset.sel(shoe=shoe, node=int(top["node"]))
            runs = {
                f"{run} in MPa": float(own.run_peak.sel(run=run)) / MEGA for run in self.dataset.run.values
            }
            relative = {
                f"{name} in %": 100.0 * float(top[name] / abs(top["value"])) for name in ("spread", "choice")
            }
            rows.append(
                {"shoe": shoe, "node": int(top["node"])} | runs | relative | {"verdict": top["verdict"]}
            )
        return pd.DataFrame(rows)

    def hot_spot_tables(self) -> dict[int, pd.DataFrame]:
        """Hot spots of every shoe for reading, in MPa."""
        tables = {}
        for shoe, table in self.hot_spots.items():
            shown = hot_spot_table(table, self.dataset)
            parts = {f"{name} in MPa": table[name] / MEGA for name in ("spread", "choice")}
            place = shown.columns.get_loc("flag")
            tables[shoe] = pd.concat(
                (shown.iloc[:, :place], pd.DataFrame(parts), shown.iloc[:, place:]), axis=1
            )
        return tables


def spread_of(
    first: StressResults, starts: Mapping[str, xr.DataArray], laws: Mapping[str, xr.DataArray]
) -> Spread:
    """Spread between a run and others.

    Parameters
    ----------
    first : StressResults
        Of the run that is judged.
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
    parts = {"peak_spread": high - low, "peak_choice": beyond, "run_peak": runs}
    dataset = first.dataset[["peak_von_mises", "node_position", "triangle", "in_spider", "truncation"]]
    verdicts = {"peak_verdict": _verdicts(first.dataset, high - low + beyond)}
    dataset = dataset.assign({name: variable(name, values) for name, values in parts.items()} | verdicts)
    dataset = dataset.assign_coords(run=[FIRST, *others])
    tables = {}
    for row, (shoe, table) in enumerate(first.hot_spots.items()):
        nodes = table["node"].to_numpy()
        wider = table.assign(spread=(high - low)[row, nodes], choice=beyond[row, nodes])
        left_out = float(first.dataset.truncation)
        tables[shoe] = judged(
            wider, None if np.isnan(left_out) else left_out, wider["spread"], wider["choice"]
        )
    return Spread(dataset, tables)


def _verdicts(stress: xr.Dataset, more: NDArray) -> Variable:
    """Verdicts on the greatest stresses of a run with more (shoe, node), in Pa, open of them."""
    ordered = stress.transpose("shoe", ...)
    size = np.maximum(ordered.peak_von_mises.values, np.finfo(float).tiny)
    part = ordered.peak_mesh_error.values + (np.nan_to_num(float(stress.truncation)) + more) / size
    part = np.where(ordered.at_load.values, np.nan, part)
    held = np.broadcast_to(stress.in_spider.values, part.shape)
    numbers = verdict_numbers(part, ordered.peak_mesh_error.values, ordered.peak_jump.values, held)
    return variable("peak_verdict", numbers)


def relative_spread(dataset: xr.Dataset) -> xr.DataArray:
    """Spread of each node's greatest stress over itself, from starts and laws together: (shoe, node)."""
    size = np.maximum(dataset.peak_von_mises, np.finfo(float).tiny)
    return ((dataset.peak_spread + dataset.peak_choice) / size).transpose("shoe", "node")
