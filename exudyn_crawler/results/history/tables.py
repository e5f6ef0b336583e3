"""Tables that a run leaves as CSV: units in the headers, forces in N, stresses in MPa, places by frame."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.history.phases import phases
from exudyn_crawler.results.loads.load_shares import SHARE

MEGA = 1e6


def load_table(history: History) -> pd.DataFrame:
    """Loads on the shoes at the run's begin and at the end of every phase, as far as it goes.

    Returns
    -------
    pandas.DataFrame
        A row a shoe and one of the sums; columns shoe and, in N, one a phase.
    """
    loads = history.case.loads
    columns: dict[str, object] = {"shoe": [*map(str, range(1, loads.shoe_count + 1)), "sum"]}
    instants = [("begin", 0.0)] + [(phase.name, phase.end) for phase in phases(loads, history.duration)]
    for name, time in instants:
        own = loads.loads(time)[0]
        columns[f"{name} ({time:.6g} s) in N"] = [*own, own.sum()]
    return pd.DataFrame(columns)


def highest_by_phase(history: History, stress: xr.Dataset) -> pd.DataFrame:
    """Highest von Mises stress of every flexible shoe in every phase of the load cycle.

    Parameters
    ----------
    stress : xarray.Dataset
        Of `StressResults`.

    Returns
    -------
    pandas.DataFrame
        Columns shoe, phase, begin and end of the phase in s, the stress in MPa, when and at which node it is,
        and the node's place in the shoe's frame in m.
    """
    places = stress.node_position.transpose("node", "axis").values
    rows = []
    for shoe in stress.shoe.values:
        own = stress.sel(shoe=shoe)
        highest = own.highest_von_mises.values
        for phase in phases(history.case.loads, history.duration):
            within = np.flatnonzero(phase.rows(stress.time.values))
            if len(within) == 0:
                continue
            at = within[highest[within].argmax()]
            node = int(own.highest_node.values[at])
            rows.append(
                {
                    "shoe": int(shoe),
                    "phase": phase.name,
                    "begin in s": phase.begin,
                    "end in s": phase.end,
                    "highest von Mises in MPa": highest[at] / MEGA,
                    "time in s": float(stress.time[at]),
                    "node": node,
                    **_place(places[node]),
                }
            )
    return pd.DataFrame(rows)


def hot_spot_table(hot_spots: pd.DataFrame, stress: xr.Dataset) -> pd.DataFrame:
    """Hot spots of a shoe: stresses in MPa, places in the shoe and the track at t = 0, verdicts, causes."""
    places = stress.node_position.transpose("node", "axis").values[hot_spots["node"]]
    table = pd.DataFrame(
        {
            "rank": hot_spots["rank"],
            "region": hot_spots["region"],
            "von Mises in MPa": hot_spots["value"] / MEGA,
            "node": hot_spots["node"],
            "time in s": hot_spots["time"],
        }
    )
    for axis, values in zip("xyz", places.T, strict=True):
        table[f"{axis} in the shoe in m"] = values
    for axis in "xyz":
        table[f"{axis} in the track at t = 0 in m"] = hot_spots[axis]
    for name in ("jump", "error"):
        table[f"{name} in MPa"] = hot_spots[name] / MEGA
    shares = hot_spots.filter(like=SHARE).to_dict("series")
    return table.assign(flag=hot_spots["flag"], verdict=hot_spots["verdict"], **shares)


def region_table(by_region: Mapping[int, pd.DataFrame], stress: xr.Dataset) -> pd.DataFrame:
    """Highest node of every region of all flexible shoes as of `hot_spot_table`, and of which shoe it is.

    A load that nothing on a shoe comes from has the share 0 there.
    """
    tables = [hot_spot_table(table, stress).assign(shoe=shoe) for shoe, table in by_region.items()]
    whole = pd.concat(tables, ignore_index=True)
    shares = whole.filter(like=SHARE).fillna(0.0)
    first = ["shoe", "region"]
    others = [name for name in whole if name not in (*first, "rank", *shares)]
    return pd.concat((whole[[*first, *others]], shares), axis=1)


def _place(place: np.ndarray) -> dict[str, float]:
    return {f"{axis} in the shoe in m": float(value) for axis, value in zip("xyz", place, strict=True)}
