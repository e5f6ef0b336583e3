"""Contact, friction and joint forces, sinkage and terrain deformation of a crawler track.

Reproduces the F-paper ("Contact and Joint Forces Modeling and Simulation of Crawler-Formation Interactions")
on the two runs of the K-paper. It compares the stated extremes and means of contact and joint forces,
penetration, slip and terrain deformation. It draws the figures of shoes 1, 4, 7, 10 and 13, and
of shoe 7 as it crosses from unit to unit. It compares shoe 10 and link 10-11 in turn and translation.

The paper takes its least, greatest and mean values from the shoes and links that it draws; so does every row
here about "a shoe", "shoes" or "joints". It prints means of forces and torques as magnitudes, so magnitudes
are compared. Its figures 5 to 8 (normal force, friction) show one contact each, and figure 10 (contact force)
the sum of a shoe's contacts: extremes of the former are those of one volume here, too. Values of shoe 7 on
unit 7 are of one volume, while they touch.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Unpack

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from exudyn_crawler import CaseFile, History
from exudyn_crawler.results.history.catalogue import for_reading
from exudyn_crawler.results.history.history import common_phases
from exudyn_crawler.run.folder.folder import matching_history
from exudyn_crawler.run.folder.record import quiet
from exudyn_crawler.views import figures
from exudyn_crawler.views.style import save_figure
from exudyn_crawler.views.tables import write_table
from studies import DURATION
from studies.comparison import comparison_table, ends, reported_values, statistic_of, time_mean
from studies.kinematics import CASES, case_files
from studies.running import Compared, Running, compare_cases

CONTACT = {"penetration depth": "penetration", "sinkage velocity": "penetration_rate"}
CONTACT |= {name: name.replace(" ", "_") for name in ("normal force", "slip velocity", "friction force")}
CONTACT |= {name: name.replace(" ", "_") for name in ("friction torque", "contact force")}
"""Variables of `contacts_by_shoe` by contact quantity of the paper."""

ONE_VOLUME = ("normal force", "friction force", "friction torque")
"""Contact quantities for which the paper's figures show one contact each."""

VOLUMES = re.compile(r"shoe (?P<shoe>\d+) on unit (?P<unit>\d+) (?P<words>.+)")

REACTIONS = {"spherical joint reaction": "joint_force", "parallel joint torque": "joint_torque"}


def force_quantity(history: History, contacts: xr.Dataset, quantity: str) -> xr.DataArray:
    """Return a quantity that the F-paper names, in SI units; `contacts` is the result of `contacts_by_shoe`.

    Raises `ValueError` for another quantity.
    """
    if quantity == "total terrain deformation from equilibrium":
        return history.terrain_deformation
    name, axis, shoe = _words(quantity)
    if name in REACTIONS:
        values = history.dataset[REACTIONS[name]].sel(joint=list(figures.JOINTS))
    elif name in CONTACT:
        values = contacts[CONTACT[name]].sel(shoe=shoe or list(figures.SHOES))
    else:
        raise ValueError(f"{quantity!r} names no quantity of contact, joints or terrain")
    if "axis" not in values.dims:
        return values
    # the friction torque turns about the normal, which is z up to the units' tilt
    return values.sel(axis=axis)


def _words(quantity: str) -> tuple[str, str, int]:
    """Return name, axis (z if none is named) and shoe (0 for none) of a quantity in the paper's words."""
    words = re.sub(r" \(crossing two units\)| of a shoe", "", quantity)
    shoe = re.search(r"shoe (\d+)", words)
    words = re.sub(r"(of )?shoe \d+", "", words).strip()
    match = re.fullmatch(r"(?P<name>[a-z ]+?)(?: (?P<axis>[xyz]))?", words)
    return (match["name"], match["axis"] or "z", int(shoe[1]) if shoe else 0) if match else ("", "z", 0)


def greatest_of_one_volume(history: History, quantity: str) -> xr.DataArray:
    """Return a force component of each contact of the shoes that the paper draws: (time, contact)."""
    name, axis, _ = _words(quantity)
    drawn = np.isin(history.contact_shoe.values, figures.SHOES)
    return history.dataset[CONTACT[name]].isel(contact=drawn).sel(axis=axis)


def volumes_value(history: History, shoe: int, unit: int, words: str) -> float:
    """Return a computed value for the volumes of a shoe on a unit; NaN for volumes that a run does not have.

    The words "one volume" or "three volumes" ask for the time (s) until which these touch. The words of a
    component ask for the magnitude of its mean in one volume over the time of contact.
    """
    here = (history.contact_shoe.values == shoe) & (history.contact_unit.values == unit)
    if not here.any():
        return math.nan
    data = history.dataset.isel(contact=here)
    time = data.time.values
    push = np.linalg.norm(data.normal_force.transpose("time", "contact", "axis").values, axis=-1)
    whole = push[:, data.contact_finger.values == 0]
    fingers = push[:, data.contact_finger.values > 0]
    if words == "one volume":
        most = np.max(fingers, axis=1, initial=0.0)
        return float(time[np.flatnonzero(np.max(whole, axis=1, initial=0.0) > most)[-1]])
    if words == "three volumes":
        pushed = np.flatnonzero(fingers.any(axis=1))
        return float(time[pushed[-1]]) if len(pushed) else math.nan
    name, axis, _ = _words(words)
    values = data[CONTACT[name]].sel(axis=axis).transpose("time", "contact").values
    touching = push > 0.0
    count = touching.sum(axis=1)
    mean = np.divide((values * touching).sum(axis=1), count, out=np.zeros(len(time)), where=count > 0)
    return float(abs(np.trapezoid(mean, time)) / np.trapezoid((count > 0).astype(float), time))


def force_statistic(values: xr.DataArray, statistic: str) -> float:
    """Return a statistic as defined in the F-paper: means of magnitudes, extremes of shoes' means."""
    if statistic.startswith("mean"):
        means = np.abs(time_mean(values))
        if statistic == "mean least":
            return float(means.min())
        if statistic.startswith("mean greatest"):
            return float(means.max())
        return float(means.mean())
    return statistic_of(values, statistic)


def _force_value(history: History, contacts: xr.Dataset, quantity: str, statistic: str) -> float:
    """Return the computed value of a row of the F-paper."""
    if match := VOLUMES.fullmatch(quantity):
        return volumes_value(history, int(match["shoe"]), int(match["unit"]), match["words"])
    name, _, shoe = _words(quantity)
    if name in ONE_VOLUME and not shoe and statistic in ("max", "max abs"):
        return statistic_of(greatest_of_one_volume(history, quantity), statistic)
    return force_statistic(force_quantity(history, contacts, quantity), statistic)


def compare_forces(histories: Mapping[str, History]) -> pd.DataFrame:
    """Compare every row of the F-paper with the runs; see `comparison.comparison_table` for columns."""
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
    """Compare turning with translation: extremes and means of every component, and their ratios.

    Columns quantity, axis, unit, extreme translation, extreme turning, extreme ratio, mean translation, mean
    turning, mean ratio. Extremes are greatest magnitudes, means are magnitudes of means. A ratio is empty if
    its translation value is only rounding.
    """
    rows = []
    pair = [_components(history, shoe, joint) for history in (translation, turning)]
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


CROSSING_SHOE = 7  # shoe on two units; the F-paper draws its contacts separately
COMPARED_SHOE, COMPARED_JOINT = 10, 10  # shoe and link that the F-paper draws turning against translation


def study(
    out: Path | None = None,
    cases: Sequence[str] = tuple(CASES),
    *,
    duration: float = DURATION,
    reuse: Path | None = None,
    strict: bool = True,
    **how: Unpack[Running],
) -> Compared:
    """Run the cases, or take their histories, and compare their forces with the paper.

    See `kinematics.study`; `out` gets `turning_ratios.csv`, too. Histories in `reuse`, the folder of a study,
    replace runs with the same parameters. If `strict`, a missing history raises `FileNotFoundError`, one of
    other parameters `ValueError`.
    """
    files = case_files(cases, duration)
    sources = {name: _source(file, reuse, strict, how.get("say", quiet)) for name, file in files.items()}
    return compare_cases(files, out, compare_forces, write_results, sources, **how)


def _source(case_file: CaseFile, reuse: Path | None, strict: bool, say: Callable[[str], None]) -> Path | None:
    """Return the folder with a history that replaces a run, if one fits."""
    if reuse is None:
        return None
    try:
        matching_history(reuse, case_file)
    except (FileNotFoundError, ValueError) as error:
        if strict:
            raise
        if not isinstance(error, FileNotFoundError):
            say(f"{case_file.case.name}: running again, since {error}")
        return None
    return reuse


def write_results(histories: Mapping[str, History], out: Path) -> None:
    """Draw the F-paper's additional figures of each run; tabulate turning against translation."""
    drawn = {
        f"{name} shoe {CROSSING_SHOE} crossing": crossing_figure(history)
        for name, history in histories.items()
    }
    if len(histories) > 1:
        drawn |= turning_figures(histories)
        ratios = turning_ratios(histories["translation"], histories["turning"])
        write_table(ratios, out / "turning_ratios.csv", overwrite=True)
    for title, figure in drawn.items():
        save_figure(figure, out / f"{title.replace(' ', '_')}.png", overwrite=True)


def crossing_figure(history: History, shoe: int = CROSSING_SHOE) -> Figure:
    """Draw the contacts of one shoe separately, a curve for each volume with a unit that it meets."""
    shown = {"penetration depth": history.penetration}
    shown["z normal force"] = history.normal_force.sel(axis="z")
    shown["x contact force"] = history.contact_force.sel(axis="x")
    volumes = {}
    for index in np.flatnonzero(history.contact_shoe.values == shoe):
        unit = int(history.contact_unit[index])
        finger = int(history.contact_finger[index])
        volumes[f"unit {unit}, finger {finger}" if finger else f"unit {unit}"] = index
    panels = []
    for label, values in shown.items():
        read = for_reading(values)
        curves = {name: read.isel(contact=index) for name, index in volumes.items()}
        panels.append(figures.Panel(label, read.attrs["units"], curves))
    title = f"{history.case.name}: shoe {shoe} crossing units"
    return figures.panel_figure(title, panels, common_phases(history))


def turning_figures(histories: Mapping[str, History]) -> dict[str, Figure]:
    """Draw cases against each other by file name: contact of one shoe, reactions of one link."""
    by_case = {case: figures.history_series(history) for case, history in histories.items()}
    shoe = f"shoe {COMPARED_SHOE}"
    link = f"link {COMPARED_JOINT}-{COMPARED_JOINT + 1}"

    def against(label: str, item: str) -> list[figures.Panel]:
        return figures.overlay({case: series[label] for case, series in by_case.items()}, [item])

    panels = {f"{shoe} {label}": against(label, shoe) for label in figures.CONTACT_VECTORS}
    panels[f"{shoe} sinkage and friction torque"] = [
        panel for label in figures.CONTACT_SCALARS for panel in against(label, shoe)
    ]
    panels |= {f"link {COMPARED_JOINT} {label}": against(label, link) for label in figures.JOINT_VECTORS}
    phases = common_phases(*histories.values())
    return {name: figures.panel_figure(name, stack, phases) for name, stack in panels.items()}
