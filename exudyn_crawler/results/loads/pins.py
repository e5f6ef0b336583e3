"""Forces at the pins of a shoe, in its own axes: what a fatigue check of its lugs takes."""

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.actions import actions


def pin_forces(history: History, shoe: int) -> xr.Dataset:
    """Forces and moments of the pins on a shoe, in its axes.

    Parameters
    ----------
    shoe : int
        Number of the shoe.

    Returns
    -------
    xarray.Dataset
        `force` (N) and `moment` about the joint centre (N m), both (time, pin, axis); pins are "front right",
        "front left", "rear right" and "rear left". NaN where a shoe has no neighbour, and for a link of two
        rigid shoes: its one joint does not tell how its pins share the load.

    Raises
    ------
    ValueError
        If the track has no such shoe.
    """
    track = history.case.track
    track.check_shoe(shoe)
    frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
    names = list(track.joint_centers)
    force = np.full((len(frames), len(names), 3), np.nan)
    moment = np.full_like(force, np.nan)
    found = [one for one in actions(history, shoe) if one.kind == "joint"]
    ends = [one.where.split()[0] for one in found]
    for action, end in zip(found, ends, strict=True):
        if ends.count(end) > 1:
            at = names.index(action.where)
            force[:, at] = np.einsum("tji,tj->ti", frames, action.force)
            moment[:, at] = np.einsum("tji,tj->ti", frames, action.moment)
    dims = ("time", "pin", "axis")
    text = "on the shoe at the joint centre, in the shoe's axes"
    return xr.Dataset(
        {
            "force": (dims, force, {"units": "N", "long_name": f"force {text}"}),
            "moment": (dims, moment, {"units": "N m", "long_name": f"moment {text}"}),
        },
        coords={"time": history.time, "pin": names, "axis": history.axis},
    )


def pin_table(history: History, shoe: int) -> pd.DataFrame:
    """Same as a table: a row a stored time, columns named with pin, axis and unit.

    Raises
    ------
    ValueError
        If the track has no such shoe, or none of its pins has a force of its own.
    """
    found = pin_forces(history, shoe)
    held = [str(pin) for pin in found.pin.values if bool(found.force.sel(pin=pin).notnull().all())]
    if not held:
        raise ValueError(
            f"shoe must be flexible, or beside one that is, to have pin forces, got {shoe}; joint_force has "
            "the whole force of a link of rigid shoes"
        )
    columns = {"time in s": found.time.values}
    for name, letter, unit in (("force", "F", "N"), ("moment", "M", "N m")):
        for pin in held:
            for axis in map(str, found.axis.values):
                columns[f"{pin} {letter}{axis} in {unit}"] = found[name].sel(pin=pin, axis=axis).values
    return pd.DataFrame(columns)
