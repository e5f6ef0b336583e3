"""Two runs beside each other: by how much their quantities differ over the time that both have."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.contacts import contacts_of, terrain_deformation
from exudyn_crawler.results.history.history import History

OF_BODIES = (
    "position",
    "velocity",
    "acceleration",
    "angles",
    "angular_velocity",
    "joint_force",
    "joint_torque",
    "pin_force",
    "drive_force",
    "drive_torque",
    "shoe_load",
    "unit_heave",
)
OF_CONTACTS = ("normal_force", "friction_force", "penetration", "slip_velocity")
"""Quantities that are compared; those of contacts by shoe, since two runs need not have the same pairs."""
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

MEGA = 1e6

STILL = 1e-7
"""Part of the greatest on all axes below which nothing moves along one: what the solver leaves out of balance
(0.2 N) over the forces."""
ROUNDING = 1e-12
"""Of the greatest value of a quantity over all its axes, below which differences are rounding."""


def compared(history: History, stress: xr.Dataset | None = None) -> xr.Dataset:
    """Quantities of a run that can be compared with another's; the highest stresses, in MPa, if given."""
    dataset = history.dataset
    found = {name: dataset[name] for name in OF_BODIES if name in dataset}
    found |= {name: contacts_of(dataset)[name] for name in OF_CONTACTS}
    found["terrain_deformation"] = terrain_deformation(history)
    if stress is not None:
        highest = stress.highest_von_mises.rename(shoe="stressed_shoe")
        found["highest_von_mises"] = (highest / MEGA).assign_attrs(highest.attrs | {"units": "MPa"})
    return xr.Dataset(found)


def difference_table(first: xr.Dataset, second: xr.Dataset) -> pd.DataFrame:
    """Differences of two runs' quantities, axis by axis.

    Shoes, links and units that both have are compared, over the time that both have; the second is read
    between its stored times, linearly, where the first has others.

    Parameters
    ----------
    first, second : xarray.Dataset
        Of `compared`: A and B.

    Returns
    -------
    pandas.DataFrame
        Greatest magnitude in each over that time and its change, root mean square and greatest magnitude of
        B less A, and which shoe, link or unit that is of and when. Only what differs beyond rounding has a
        row. The column unit says in what; stresses are in MPa, all else in SI units.
    """
    end = min(float(first.time[-1]), float(second.time[-1]))
    time = first.time.values[first.time.values <= end * (1.0 + 1e-9)]
    rows = []
    for name in first.data_vars:
        if name not in second:
            continue
        a, b = xr.align(first[name], second[name], join="inner", exclude=["time"])
        a, b = a.sel(time=time), b.interp(time=np.minimum(time, float(b.time[-1])))
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
