"""Least and greatest values of a history: how far everything went, where and when."""

import operator
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.history.pieces import blocks

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
    rows: dict[tuple[str, str], dict[str, Any]] = {}
    # part by part, since a variable of a long run may be larger than memory
    for part in blocks(history.dataset):
        for name, axis, values in _series(part):
            new = {"variable": name, "axis": axis, "unit": values.attrs.get("units", "")}
            row = rows.setdefault((name, axis), new)
            for which, better in (("least", operator.lt), ("greatest", operator.gt)):
                found = _extreme(history, values, which)
                if which not in row or better(found[which], row[which]):
                    row |= found
    return pd.DataFrame(list(rows.values()), columns=list(COLUMNS))


def _series(part: xr.Dataset) -> Iterator[tuple[str, str, xr.DataArray]]:
    """Every variable over time, axis by axis, with some number: its name, axis and values."""
    for name, values in part.data_vars.items():
        if "time" not in values.dims or not np.issubdtype(values.dtype, np.number):
            continue
        loaded = values.load()
        for axis in loaded.axis.values if "axis" in loaded.dims else ("",):
            one = loaded.sel(axis=axis) if "axis" in loaded.dims else loaded
            if bool(one.notnull().any()):
                yield str(name), str(axis), one


def _extreme(history: History, values: xr.DataArray, which: str) -> dict[str, Any]:
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
