"""Forces, sinkage and deformation as the F-paper reports them.

The paper draws shoes 1, 4, 7, 10 and 13 and the links behind them, and takes its least, greatest and mean
values from these; so does every row here about "a shoe", "shoes" or "joints". The paper prints means of
forces and torques as magnitudes, so magnitudes are compared. Its figures 5 to 8 (normal force, friction) show
one contact each and figure 10 (contact force) the sum of a shoe's: extremes of the former are those of one
volume here, too. What it says of shoe 7 on unit 7 is taken while they touch, of one volume.
"""

import math
import re
from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.results.history.history import History
from exudyn_crawler.views.figures import JOINTS, SHOES
from studies.comparison import comparison_table, ends, statistic_of, time_mean
from studies.reported import reported_values

CONTACT = {
    "penetration depth": "penetration",
    "sinkage velocity": "penetration_rate",
    "normal force": "normal_force",
    "slip velocity": "slip_velocity",
    "friction force": "friction_force",
    "friction torque": "friction_torque",
    "contact force": "contact_force",
}
"""Contact quantities of the paper and their variables in `contacts_by_shoe`."""

ONE_VOLUME = ("normal force", "friction force", "friction torque")
"""Of these its figures show one contact each."""

VOLUMES = re.compile(r"shoe (?P<shoe>\d+) on unit (?P<unit>\d+) (?P<words>.+)")

REACTIONS = {"spherical joint reaction": "joint_force", "parallel joint torque": "joint_torque"}


def force_quantity(history: History, contacts: xr.Dataset, quantity: str) -> xr.DataArray:
    """Quantity that the F-paper names, in SI units: over time, and shoe or joint where the words name none.

    `contacts` are as of `history.contacts_by_shoe()`. A ValueError for words that name no such quantity.
    """
    if quantity == "total terrain deformation from equilibrium":
        return history.terrain_deformation
    name, axis, shoe = _words(quantity)
    if name in REACTIONS:
        values = history.dataset[REACTIONS[name]].sel(joint=list(JOINTS))
    elif name in CONTACT:
        values = contacts[CONTACT[name]].sel(shoe=shoe or list(SHOES))
    else:
        raise ValueError(f"{quantity!r} names no quantity of contact, joints or terrain")
    if "axis" not in values.dims:
        return values
    # the friction torque turns about the normal, which is z but for the units' tilt
    return values.sel(axis=axis)


def _words(quantity: str) -> tuple[str, str, int]:
    """Name, axis (z where none is named) and shoe (0 for none) of a quantity in the paper's words."""
    words = re.sub(r" \(crossing two units\)| of a shoe", "", quantity)
    shoe = re.search(r"shoe (\d+)", words)
    words = re.sub(r"(of )?shoe \d+", "", words).strip()
    match = re.fullmatch(r"(?P<name>[a-z ]+?)(?: (?P<axis>[xyz]))?", words)
    return (match["name"], match["axis"] or "z", int(shoe[1]) if shoe else 0) if match else ("", "z", 0)


def greatest_of_one_volume(history: History, quantity: str) -> xr.DataArray:
    """Component of a force of every contact of the shoes that the paper draws: dimensions (time, contact)."""
    name, axis, _ = _words(quantity)
    drawn = np.isin(history.contact_shoe.values, SHOES)
    return history.dataset[CONTACT[name]].isel(contact=drawn).sel(axis=axis)


def volumes_value(history: History, shoe: int, unit: int, words: str) -> float:
    """What the paper says of the volumes of a shoe on a unit; NaN for volumes that a run does not have.

    By the words "one volume" or "three volumes": until when, s; of a component: its mean over the time in
    which they touch, of one volume, as a magnitude.
    """
    here = (history.contact_shoe.values == shoe) & (history.contact_unit.values == unit)
    if not here.any():
        return math.nan
    own = history.dataset.isel(contact=here)
    time = own.time.values
    push = np.linalg.norm(own.normal_force.transpose("time", "contact", "axis").values, axis=-1)
    whole, fingers = push[:, own.contact_finger.values == 0], push[:, own.contact_finger.values > 0]
    if words == "one volume":
        most = np.max(fingers, axis=1, initial=0.0)
        return float(time[np.flatnonzero(np.max(whole, axis=1, initial=0.0) > most)[-1]])
    if words == "three volumes":
        pushed = np.flatnonzero(fingers.any(axis=1))
        return float(time[pushed[-1]]) if len(pushed) else math.nan
    name, axis, _ = _words(words)
    values = own[CONTACT[name]].sel(axis=axis).transpose("time", "contact").values
    touching = push > 0.0
    count = touching.sum(axis=1)
    mean = np.divide((values * touching).sum(axis=1), count, out=np.zeros(len(time)), where=count > 0)
    return float(abs(np.trapezoid(mean, time)) / np.trapezoid((count > 0).astype(float), time))


def force_statistic(values: xr.DataArray, statistic: str) -> float:
    """Statistic as the F-paper takes it: means of magnitudes, greatest and least of shoes' means."""
    if statistic.startswith("mean"):
        means = np.abs(time_mean(values))
        if statistic == "mean least":
            return float(means.min())
        if statistic.startswith("mean greatest"):
            return float(means.max())
        return float(means.mean())
    return statistic_of(values, statistic)


def _force_value(history: History, contacts: xr.Dataset, quantity: str, statistic: str) -> float:
    """Computed value of a row of the F-paper."""
    if match := VOLUMES.fullmatch(quantity):
        return volumes_value(history, int(match["shoe"]), int(match["unit"]), match["words"])
    name, _, shoe = _words(quantity)
    if name in ONE_VOLUME and not shoe and statistic in ("max", "max abs"):
        return statistic_of(greatest_of_one_volume(history, quantity), statistic)
    return force_statistic(force_quantity(history, contacts, quantity), statistic)


def compare_forces(histories: Mapping[str, History]) -> pd.DataFrame:
    """Every row of the F-paper against the runs; columns as of `comparison.comparison_table`."""
    contacts = {case: history.contacts_by_shoe() for case, history in histories.items()}
    reported = reported_values("forces")
    computed = [
        _force_value(histories[row.case], contacts[row.case], row.quantity, row.statistic)
        if row.case in histories
        else math.nan
        for row in reported.itertuples()
    ]
    return comparison_table(reported, computed, ends(histories))


def turning_ratios(translation: History, turning: History, shoe: int = 10, joint: int = 10) -> pd.DataFrame:
    """Turning against translation: extremes and means of every component of both, and their ratios.

    Columns quantity, axis, unit, extreme translation, extreme turning, extreme ratio, mean translation, mean
    turning, mean ratio. Extremes are greatest magnitudes, means are magnitudes of means; a ratio to a
    translation value that is only rounding is left empty.
    """
    rows = []
    pair = [_components(one, shoe, joint) for one in (translation, turning)]
    for (quantity, axis), straight in pair[0].items():
        turned = pair[1][quantity, axis]
        extremes = [float(np.abs(values).max()) for values in (straight, turned)]
        means = [float(np.abs(time_mean(values))) for values in (straight, turned)]
        row = {"quantity": quantity, "axis": axis, "unit": straight.attrs.get("units", "")}
        for kind, (before, after) in (("extreme", extremes), ("mean", means)):
            scale = max(extremes)
            ratio = after / before if before > 1e-6 * scale else math.nan
            row |= {f"{kind} translation": before, f"{kind} turning": after, f"{kind} ratio": ratio}
        rows.append(row)
    return pd.DataFrame(rows)


def _components(history: History, shoe: int, joint: int) -> dict[tuple[str, str], xr.DataArray]:
    contacts = history.contacts_by_shoe().sel(shoe=shoe)
    named = {f"shoe {shoe} {name}": contacts[variable] for name, variable in CONTACT.items()}
    named |= {
        f"joint {joint}-{joint + 1} {name}": history.dataset[variable].sel(joint=joint)
        for name, variable in REACTIONS.items()
    }
    return {
        (name, str(axis)): values.sel(axis=axis) if axis else values
        for name, values in named.items()
        for axis in (values.axis.values if "axis" in values.dims else ("",))
    }
