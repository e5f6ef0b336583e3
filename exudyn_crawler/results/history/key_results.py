"""The few numbers of a run that are asked for first."""

import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.contacts import contacts_of
from exudyn_crawler.results.history.history import History

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
        *_drive(history),
        ("deepest penetration", contacts.penetration / MILLI, "mm"),
        ("greatest speed", _length(history.velocity), "m/s"),
    ]
    if stress is not None:
        found.insert(0, ("highest von Mises stress", stress.highest_von_mises / MEGA, "MPa"))
    rows = [{"result": name, **_greatest(values), "unit": unit} for name, values, unit in found]
    rows.append({"result": "way", **_way(history), "at": history.duration, "unit": "m"})
    return pd.DataFrame(rows, columns=["result", "value", "unit", "of", "at"])


def _drive(history: History) -> list[tuple[str, xr.DataArray, str]]:
    """Force of a dragged track's drive; of a rolled one its pull and the force of the rollers."""
    if history.case.propel == "dragged":
        return [("greatest force of the drive", abs(history.drive_force) / KILO, "kN")]
    return [
        ("greatest force of a roller on the rails of a side", _length(history.roller_force) / KILO, "kN"),
        ("greatest pull of the drive", history.drive_pull / KILO, "kN"),
    ]


def _way(history: History) -> dict[str, object]:
    """How far the front shoe, or the side frame that rolls over the shoes, has moved."""
    if history.case.propel == "dragged":
        of, place = f"shoe {int(history.shoe[-1])}", history.position.isel(shoe=-1)
    else:
        of, place = "side frame", history.side_frame_position
    return {"value": float(_length(place.isel(time=-1) - place.isel(time=0))), "of": of}


def _length(vectors: xr.DataArray) -> xr.DataArray:
    return ((vectors**2).sum("axis")) ** 0.5


def _greatest(values: xr.DataArray) -> dict[str, object]:
    """Greatest of a series, what it is of and when."""
    at = {str(dim): int(index) for dim, index in values.argmax(...).items()}
    named = {"shoe": "shoe {0}", "joint": "link {0}-{1}", "roller": "roller {0}"}
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
