"""Stresses of flexible shoes over propel and a loading cycle.

Reproduces the S-paper ("Multibody Dynamic Stress Simulation of Rigid-Flexible Shovel Crawler Shoes",
Minerals 2016, 6(3), 61): six flexible shoes over 15 s of propel and 25 s of digging, swinging and dumping. It
has the modes of figure 9, motion, contact and joint forces and deformation of figures 11 to 17 and 21. It
also has von Mises stresses at eight instants, and the hot spots of tables 5 and 6. The paper covers only its
flexible shoes; so do all rows here. Propel lasts until the drive is switched off; then loading begins.
"""

import math
import re
from pathlib import Path
from typing import Unpack

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler import Case, CaseFile, FlexibleShoes
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.case.parameters.track import ADAMS_DAMPING
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.machines import Outputs
from exudyn_crawler.model.flexible_shoes import check_shoe, whole_reduction
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.stress.recovery import StressResults
from studies import CYCLE_DURATION
from studies.comparison import KINEMATIC, comparison_table, reported_values, statistic_of
from studies.running import Running, save, study_runs

MEGA = 1e6
RANKS = {"1st": 0, "2nd": 1, "3rd": 2, "4th": 3, "5th": 4}
MOTION = re.compile(r"(?:any )?flexible shoe (?P<axis>[xyz]) (?P<kind>[a-z ]+)")
CONTACT = re.compile(r"contact force (?P<axis>[xyz]) on a flexible shoe")
REACTION = re.compile(r"revolute joint reaction (?P<axis>[xyz]) \(one of two\)")
SHOWN_DIGITS = 20  # digits of a wrong mode number that a message shows
HOT_SPOT = re.compile(r"shoe (?P<shoe>\d+) greatest von Mises")


def flexible_quantity(history: History, quantity: str) -> xr.DataArray:
    """Return a quantity that the S-paper names, in its unit: over time and all dimensions that are not named.

    Raises `ValueError` for another quantity.
    """
    shoes = list(history.case.part(FlexibleShoes).shoes)
    if quantity == "total terrain deformation from equilibrium":
        return history.terrain_deformation
    if quantity == "revolute joint torque x and z":
        return _revolute(history.pin_torque).sel(axis=["x", "z"])
    if match := REACTION.fullmatch(quantity):
        return _revolute(history.pin_force).sel(axis=match["axis"])
    if match := CONTACT.fullmatch(quantity):
        force = history.over_time(["contact_force"])["contact_force"]
        return force.sel(shoe=shoes, axis=match["axis"])
    if (match := MOTION.fullmatch(quantity)) and match["kind"] in KINEMATIC:
        name, factor = KINEMATIC[match["kind"]]
        return factor * history.quantity(name).sel(shoe=shoes, axis=match["axis"])
    raise ValueError(f"{quantity!r} names no quantity of flexible shoes, joints or terrain")


def _revolute(values: xr.DataArray) -> xr.DataArray:
    """Select the links with a revolute joint at both pins: those of a flexible shoe."""
    return values.isel(joint=values.notnull().all(["time", "pin", "axis"]).values)


def stress_value(history: History, results: StressResults, case: str, quantity: str, statistic: str) -> float:
    """Return the computed value of a row on propel, loading or hot spots; NaN if the run is too short."""
    if match := HOT_SPOT.fullmatch(quantity):
        table = results.hot_spots.get(int(match["shoe"]))
        return math.nan if table is None else float(table["value"].iloc[RANKS[statistic]]) / MEGA
    if quantity == "any flexible shoe von Mises":
        values = results.dataset.highest_von_mises / MEGA
    else:
        values = flexible_quantity(history, quantity)
    chosen = in_phase(values, history, case)
    return statistic_of(chosen, statistic) if chosen.sizes["time"] else math.nan


def compare_stresses(history: History, results: StressResults) -> pd.DataFrame:
    """Compare every row of the S-paper with a run; see `comparison.comparison_table` for columns."""
    reported = reported_values("stress")
    frequencies = whole_reduction(history.case).body.frequencies
    computed = []
    for row in reported.itertuples():
        if row.case == "modal":
            first = row.quantity.startswith("free-free mode 1")
            nearest = 0 if first else int(np.argmin(np.abs(frequencies - row.value)))
            computed.append(float(frequencies[nearest]))
        else:
            computed.append(stress_value(history, results, row.case, row.quantity, row.statistic))
    end = float(history.time[-1])
    return comparison_table(reported, computed, dict.fromkeys(reported["case"], end))


def in_phase(values: xr.DataArray, history: History, phase: str) -> xr.DataArray:
    """Return the part of a series in propel or loading; empty if the run does not reach it.

    Raises `ValueError` for another phase.
    """
    end = min(history.case.drive.switch_times, default=math.inf)
    if phase == "propel":
        return values.where(values.time <= end, drop=True)
    if phase == "loading":
        return values.where(values.time > end, drop=True)
    raise ValueError(f"phase must be 'propel' or 'loading', got {phase!r}")


def highest_in_propel_and_loading(history: History, stresses: StressResults) -> pd.DataFrame:
    """Tabulate the highest von Mises stress of each flexible shoe in propel and loading; NaN if not reached.

    Columns shoe, propel and loading (MPa), ratio of loading to propel.
    """
    highest = stresses.dataset.highest_von_mises / MEGA
    rows = []
    for shoe in highest.shoe.values:
        phases = {phase: in_phase(highest.sel(shoe=shoe), history, phase) for phase in ("propel", "loading")}
        peaks = {p: float(v.max()) if v.size else math.nan for p, v in phases.items()}
        rows.append({"shoe": int(shoe)} | peaks | {"ratio": peaks["loading"] / peaks["propel"]})
    return pd.DataFrame(rows)


RUN = "cycle"  # folder of the run in the folder of the study
PICTURE_TIMES = (0.0, 5.0, 10.0, 15.0, 22.5, 30.0, 33.5, 40.0)
"""Instants of the S-paper's pictures of the stressed shoes, s."""


def study(
    out: Path | None = None,
    case: Case | None = None,
    *,
    duration: float = CYCLE_DURATION,
    **how: Unpack[Running],
) -> tuple[CaseRun, pd.DataFrame]:
    """Run a track with flexible shoes, `Case.stress()` if none is given, and compare it with the paper.

    `out` gets the run in its folder "cycle", and `comparison.csv`, see `compare_stresses`. Raises
    `ValueError` before anything runs: for no flexible shoes, interfaces off the pins, unknown modes, a bad
    duration (s), or checkpoints of other parameters. Other errors are those of `study_runs`.
    """
    case = Case.stress() if case is None else case
    shown = tuple(time for time in PICTURE_TIMES if time <= duration) or None
    case_file = CaseFile(case=case, duration=duration, outputs=Outputs(picture_times=shown))
    check_shoe(case)  # raises for a mesh that does not fit before anything is written
    with study_runs(out, {RUN: case_file}, **how) as runs:
        run = runs[RUN]
        table = compare_stresses(run.history, run.recovered())
        save(out, comparison=table)
    return run, table


def open_choices(duration: float = 8.0, mesh: str = "coarse", progress: bool | None = None) -> pd.DataFrame:
    """Compare rows of the S-paper that runs of a duration (s) reach, with a column for each open choice.

    Columns case, quantity, statistic, unit, paper, and the choices. Part of the propel suffices for trends.
    """
    case = Case.stress(mesh)
    flexible = case.part(FlexibleShoes)
    contact = case.part(PairContact)
    choices = {
        "default": case,
        "ADAMS' modal damping": case.with_(flexible=flexible.with_(damping=ADAMS_DAMPING)),
        "contact law shared by area": case.with_(contact=contact.with_(sharing="area")),
        "contact damping x 10": case.with_(contact=contact.with_(damping=10.0 * contact.damping)),
    }
    columns = {}
    for choice, changed in choices.items():
        _, table = study(case=changed, duration=duration, progress=progress)
        columns[choice] = table["computed"]
    rows = table[["case", "quantity", "statistic", "unit", "paper"]].assign(**columns)
    return rows.dropna().reset_index(drop=True)


def with_modes(flexible: FlexibleShoes, choice: str) -> FlexibleShoes:
    """Return the shoes with the modes of a choice integrated; the others follow their loads without inertia.

    "all" is the whole basis of the stress, "1200Hz" its modes up to a frequency, "1-20,25" the modes with
    these numbers in order of frequency. "10 fixed" is the constraint modes and the 10 lowest fixed-interface
    modes. Raises `ValueError` for anything else, or modes that do not exist.
    """
    text = choice.strip().lower()
    whole = flexible.with_(fixed_modes=flexible.recovered_modes, highest_frequency=None, modes=None)
    if text == "all":
        return whole
    if match := re.fullmatch(r"(\d+) *fixed", text):
        return whole.with_(fixed_modes=int(match[1]))
    if match := re.fullmatch(r"(\d+(?:\.\d+)?) *hz", text):
        return whole.with_(highest_frequency=float(match[1]))
    if re.fullmatch(r"\d+(-\d+)?(, *\d+(-\d+)?)*", text):
        numbers: set[int] = set()
        # the end is checked first, so that no range becomes longer than the number of modes
        most = whole.mode_count
        for part in text.split(","):
            first, _, last = part.strip().partition("-")
            greatest = last or first
            if len(greatest.lstrip("0")) > len(str(most)) or int(greatest) > most:
                raise ValueError(f"modes must be in 1..{most}, got {greatest[:SHOWN_DIGITS]}")
            numbers |= set(range(int(first), int(greatest) + 1))
        return whole.with_(modes=tuple(sorted(numbers)))
    raise ValueError(f'modes must be like "all", "1200Hz", "1-20,25" or "10 fixed", got {choice!r}')
