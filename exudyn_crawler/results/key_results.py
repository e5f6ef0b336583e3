"""The few numbers of a run that are asked for first."""

import pandas as pd
import xarray as xr

from exudyn_crawler.results.contacts import contacts_of
from exudyn_crawler.results.history import History

MEGA, KILO, MILLI = 1e6, 1e3, 1e-3


def key_results(history: History, stress: xr.Dataset | None = None) -> pd.DataFrame:
    """Greatest stress, forces, sinkage and speed of a run, and how far it went.

    Parameters
    ----------
    stress : xarray.Dataset, optional
        Of `StressResults`.

    Returns
    -------
    pandas.DataFrame
        Columns result, value, unit, of (shoe or link, if it is of one) and at (s).
    """
    contacts = contacts_of(history.dataset)
    found = [
        ("greatest contact force on a shoe", _length(contacts.contact_force) / KILO, "kN"),
        ("greatest force of a link", _length(history.joint_force) / KILO, "kN"),
        ("greatest force of the drive", abs(history.drive_force) / KILO, "kN"),
        ("deepest penetration", contacts.penetration / MILLI, "mm"),
        ("greatest speed", _length(history.velocity), "m/s"),
    ]
    if stress is not None:
        found.insert(0, ("highest von Mises stress", stress.highest_von_mises / MEGA, "MPa"))
    rows = [{"result": name, **_greatest(values), "unit": unit} for name, values, unit in found]
    way = history.position.isel(time=-1, shoe=-1) - history.position.isel(time=0, shoe=-1)
    front = f"shoe {int(history.shoe[-1])}"
    rows.append(
        {"result": "way", "value": float(_length(way)), "of": front, "at": history.duration, "unit": "m"}
    )
    return pd.DataFrame(rows, columns=["result", "value", "unit", "of", "at"])


def _length(vectors: xr.DataArray) -> xr.DataArray:
    return ((vectors**2).sum("axis")) ** 0.5


def _greatest(values: xr.DataArray) -> dict[str, object]:
    """Greatest of a series, what it is of and when."""
    at = {str(dim): int(index) for dim, index in values.argmax(...).items()}
    named = {"shoe": "shoe {0}", "joint": "link {0}-{1}"}
    of = [
        named[dim].format(number := int(values[dim][index]), number + 1)
        for dim, index in at.items()
        if dim in named
    ]
    return {
        "value": float(values.isel(at)),
        "of": ", ".join(of),
        "at": float(values.time[at["time"]]),
    }
