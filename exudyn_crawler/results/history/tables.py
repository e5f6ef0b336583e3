"""Tables of a run as CSV, and of two runs beside each other."""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.catalogue import select
from exudyn_crawler.results.history.history import History, phases
from exudyn_crawler.results.stress.hot_spots import SHARE

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
        by_shoe = loads.loads(time)[0]
        columns[f"{name} ({time:.6g} s) in N"] = [*by_shoe, by_shoe.sum()]
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
    positions = stress.node_position.transpose("node", "axis").values
    rows = []
    for shoe in stress.shoe.values:
        of_shoe = stress.sel(shoe=shoe)
        highest = of_shoe.highest_von_mises.values
        for phase in phases(history.case.loads, history.duration):
            within = np.flatnonzero(phase.rows(stress.time.values))
            if len(within) == 0:
                continue
            at = within[highest[within].argmax()]
            node = int(of_shoe.highest_node.values[at])
            rows.append(
                {
                    "shoe": int(shoe),
                    "phase": phase.name,
                    "begin in s": phase.begin,
                    "end in s": phase.end,
                    "highest von Mises in MPa": highest[at] / MEGA,
                    "time in s": float(stress.time[at]),
                    "node": node,
                    **_place(positions[node]),
                }
            )
    return pd.DataFrame(rows)


def hot_spot_table(hot_spots: pd.DataFrame, stress: xr.Dataset) -> pd.DataFrame:
    """Hot spots of a shoe: stresses in MPa, positions in shoe and track at t = 0, verdicts, causes."""
    positions = stress.node_position.transpose("node", "axis").values[hot_spots["node"]]
    table = pd.DataFrame(
        {
            "rank": hot_spots["rank"],
            "region": hot_spots["region"],
            "von Mises in MPa": hot_spots["value"] / MEGA,
            "node": hot_spots["node"],
            "time in s": hot_spots["time"],
        }
    )
    for axis, values in zip("xyz", positions.T, strict=True):
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


COLUMNS = (
    "quantity",
    "axis",
    "unit",
    "greatest in A",
    "greatest in B",
    "change in %",
    "rms difference",
    "greatest difference",
    "of",
    "at in s",
)

STILL = 1e-7
"""Part of the greatest on all axes below which nothing moves along one: what the solver leaves out of balance
(0.2 N) over the forces."""
ROUNDING = 1e-12
"""Of the greatest value of a quantity over all its axes, below which differences are rounding."""


def compared(history: History, stress: xr.Dataset | None = None) -> dict[str, xr.DataArray]:
    """Quantities over time of a run that are compared with another's; stresses, if given, in MPa.

    Those of contacts count by shoe, since two runs need not have the same pairs.
    """
    named = [name for name in select(compared=True) if history.has(name, stress)]
    values = history.over_time(named, stress)
    return {name: _in_mega(one) if one.attrs.get("units") == "Pa" else one for name, one in values.items()}


def _in_mega(stress: xr.DataArray) -> xr.DataArray:
    return (stress / MEGA).assign_attrs(stress.attrs | {"units": "MPa"})


def difference_table(first: Mapping[str, xr.DataArray], second: Mapping[str, xr.DataArray]) -> pd.DataFrame:
    """Differences of two runs' quantities, axis by axis.

    Shoes, links and units that both have are compared, over the time that both have; the second is read
    between its stored times, linearly, where the first has others.

    Parameters
    ----------
    first, second : mapping
        Of `compared`: A and B.

    Returns
    -------
    pandas.DataFrame
        Greatest magnitude in each over that time and its change, root mean square and greatest magnitude of
        B less A, and which shoe, link or unit that is of and when. Only what differs beyond rounding has a
        row. The column unit says in what; stresses are in MPa, all else in SI units.
    """
    rows = []
    for name in first:
        if name not in second:
            continue
        time, end = first[name].time.values, float(second[name].time[-1])
        time = time[time <= end * (1.0 + 1e-9)]
        a, b = xr.align(first[name], second[name], join="inner", exclude=["time"])
        a, b = a.sel(time=time), b.interp(time=np.minimum(time, end))
        b = b.assign_coords(time=time)
        greatest = float(abs(a).max()) if a.size else 0.0
        rounding = ROUNDING * max(greatest, ROUNDING)
        for axis in a.axis.values if "axis" in a.dims else [None]:
            pair = (a, b) if axis is None else (a.sel(axis=axis), b.sel(axis=axis))
            if axis is not None and all(bool((abs(one) <= STILL * greatest).all()) for one in pair):
                continue
            rows += [
                {"quantity": str(name), "axis": "" if axis is None else str(axis)} | row
                for row in _rows(*pair, rounding)
            ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _rows(a: xr.DataArray, b: xr.DataArray, rounding: float) -> Iterator[dict[str, object]]:
    """Row of one series with its unit; none where no difference is beyond rounding."""
    difference = b - a
    size = float(abs(a).max()) if a.size else np.nan
    if not bool(difference.notnull().any()):
        return
    magnitude = abs(difference).fillna(0.0)
    at = {str(dim): int(index) for dim, index in magnitude.argmax(...).items()}
    greatest = float(magnitude.isel(at))
    if greatest <= rounding:
        return
    other = float(abs(b).max())
    of = [f"{dim.split('_')[-1]} {difference[dim].values[k]}" for dim, k in at.items() if dim != "time"]
    yield {
        "unit": a.attrs.get("units", ""),
        "greatest in A": size,
        "greatest in B": other,
        "change in %": 100.0 * (other - size) / size if size > 0.0 else np.nan,
        "rms difference": float(np.sqrt((difference**2).mean())),
        "greatest difference": float(difference.isel(at)),
        "of": ", ".join(of),
        "at in s": float(difference.time[at["time"]]),
    }
