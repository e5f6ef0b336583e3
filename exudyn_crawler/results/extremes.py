"""Least and greatest values of a history: how far everything went, where and when."""

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history import History

COLUMNS = (
    "variable",
    "axis",
    "unit",
    "least",
    "least_of",
    "least_at in s",
    "greatest",
    "greatest_of",
    "greatest_at in s",
)


def extremes(history: History) -> pd.DataFrame:
    """Least and greatest value of every variable over time, axis by axis.

    Returns
    -------
    pandas.DataFrame
        Columns variable, axis, unit; least and greatest, each with the shoe, joint, unit or contact that it
        is of and the time (s) that it is at. Variables without any number have no row.
    """
    rows = []
    for name, values in history.dataset.data_vars.items():
        if "time" not in values.dims or not np.issubdtype(values.dtype, np.number):
            continue
        parts = {"": values}
        if "axis" in values.dims:
            parts = {str(axis): values.sel(axis=axis) for axis in values.axis.values}
        for axis, part in parts.items():
            if bool(part.notnull().any()):
                found = {"variable": name, "axis": axis, "unit": values.attrs.get("units", "")}
                rows.append(found | _extreme(history, part, "least") | _extreme(history, part, "greatest"))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _extreme(history: History, values: xr.DataArray, which: str) -> dict[str, object]:
    """Extreme value, what it is of and when; the first where there are several."""
    flat = values.argmin(...) if which == "least" else values.argmax(...)
    place = {dim: int(index) for dim, index in flat.items()}
    of = ", ".join(_item(history, str(dim), index) for dim, index in place.items() if dim != "time")
    return {
        which: float(values.isel(place)),
        f"{which}_of": of,
        f"{which}_at in s": float(values.time[place["time"]]),
    }


def _item(history: History, dim: str, index: int) -> str:
    """Name of one of the things along a dimension; a contact is named after its shoe and unit."""
    if dim == "contact":
        shoe, unit = (int(history.dataset[f"contact_{name}"][index]) for name in ("shoe", "unit"))
        return f"shoe {shoe} on unit {unit}"
    return f"{dim} {history.dataset[dim].values[index]}"
