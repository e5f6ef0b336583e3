"""Where the work of a run's drive goes: pins, teeth, rollers, ground, height, inertia."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.case import Case
from exudyn_crawler.results import balance
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.history.machine import evaluated_from

DRIVE, LOAD, MISSED = "drive", "load on the machine or the shoes", "not accounted for"
PLACES = {
    "pins": ("pin_losses",),
    "teeth": ("tooth_losses", "teeth"),
    "rollers": ("rolling_resistance", "tread_damping", "roller"),
    "idler": ("idler",),
    "carriers": ("upper_run",),
    "ground, pressed": ("pressure", "elastic_contact", "contact_damping", "terrain_damping", "springs"),
    "ground, slip": ("shear", "friction"),
    "drawbar": ("drawbar",),
    "height": ("gravitational", "frame_gravitational"),
    "inertia": ("kinetic", "frame_kinetic"),
    "springs and dampers": (
        "tensioners",
        "tensioner_damping",
        "arm_springs",
        "arm_damping",
        "pin_springs",
        "elastic",
        "modal_damping",
    ),
}
"""Names of `balance.energies`, `balance.powers` and `balance.wheel_powers` by the place where work goes.

Contacts of pins, teeth, wheels and ground have their springs with them; an open track's treads have theirs
with the rollers.
"""
WORK, SHARE = "work in kJ", "share in %"
STEADY, POWER = "after the start in kJ", "mean power after the start in kW"
TIMES_AT_ONCE = 2**12
"""Stored times whose powers are in memory together."""


def has_works(history: History) -> bool:
    """Return True if a run has moved by its drive, and its history has what `drive_work` needs."""
    case = history.case
    commands = (case.drive.speed, case.drive.turn_rate)
    moves = any(np.any(command.values) for command in commands if command is not None)
    return moves and history.time.size > 2 and balance.lacking(case) is None


def drive_work(history: History) -> pd.DataFrame:
    """Return where the work of drive and load has gone, over the run and after its start.

    Columns are where, `WORK`, `SHARE` of what drive and load gave, `STEADY` and `POWER`. The first two rows
    are the work of drive and load, the last one is what integration over the stored times misses; the rows
    between take. A run that is all start counts from its half, as in `machine_answers`.

    Raises
    ------
    ValueError
        If the history of such a case has no powers, see `balance.lacking`.
    """
    begin = evaluated_from(history)
    time = history.time.values
    middle = int(np.searchsorted(time, begin * (1.0 - 1e-9)))
    middle = min(max(middle, 1), len(time) - 2)
    start, steady = (_works(history, *rows) for rows in ((0, middle), (middle, len(time) - 1)))
    whole = {name: start[name] + steady[name] for name in steady}
    given = whole[DRIVE] + whole[LOAD]
    rows = [
        {
            "where": name,
            WORK: 1e-3 * whole[name],
            SHARE: 100.0 * whole[name] / given if given > 0.0 else np.nan,
            STEADY: 1e-3 * steady[name],
            POWER: 1e-3 * steady[name] / float(time[-1] - time[middle]),
        }
        for name in whole
    ]
    return pd.DataFrame(rows)


def upper_run_of(case: Case) -> str:
    """Return the name of what carries the upper run of a closed track."""
    kinds = {label.kind for label in case.gear.wheel_labels}
    return next((f"{kind}s" for kind in ("carrier", "slide") if kind in kinds), "upper run on rollers")


def _works(history: History, first: int, last: int) -> dict[str, float]:
    """Return the work (J) by place between two stored times, by their numbers."""
    sums: dict[str, float] = {}
    for start in range(first, last, TIMES_AT_ONCE):
        rows = slice(start, min(start + TIMES_AT_ONCE, last) + 1)
        for name, work in _work_of(History(history.case, history.dataset.isel(time=rows).load())):
            sums[name] = sums.get(name, 0.0) + work
    given = {DRIVE: sums.pop("drive"), LOAD: sums.pop("machine_load")}
    taken = {}
    for place, names in PLACES.items():
        if found := [sums.pop(name) for name in names if name in sums]:
            shown = upper_run_of(history.case) if place == "carriers" else place
            taken[shown] = sum(found)
    if sums:
        raise KeyError(f"no place takes {sorted(sums)}")
    return given | taken | {MISSED: sum(given.values()) - sum(taken.values())}


def _work_of(part: History) -> Iterator[tuple[str, float]]:
    """Yield the work over a part of a history by names of the balance; wheels are by kind."""
    stored = balance.energies(part)
    change = stored.isel(time=-1) - stored.isel(time=0)
    powers = balance.powers(part)
    if "wheel_losses" in powers:
        # with the energy of their contacts
        powers = xr.merge((powers.drop_vars("wheel_losses"), balance.wheel_powers(part)))
        change = change.drop_vars("treads")
    elif "treads" in change:
        change = change.rename(treads="roller")
    works = powers.integrate("time")
    for found in (change, works):
        yield from ((str(name), float(value)) for name, value in found.data_vars.items())
