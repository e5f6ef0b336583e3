"""The library's machines in motion, each straight and on the spot, on the ground of its datasheet."""

from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Unpack

import numpy as np
import pandas as pd

from exudyn_crawler import CaseFile, History, read_case
from exudyn_crawler.machines.case_file import BARE
from exudyn_crawler.results.history.summary import start_ends
from studies.running import Running, save, study_runs

NAMES = ("cat315c", "pc300lc", "d155ax", "d11", "bg28", "cat6060", "ph4100c", "m113", "marder")
"""Machines of the library; those on arms take ten times as long as others."""
DURATION = 2.0  # s
TRAVELS = {"straight": "straight", "turn": "on the spot"}


def case_files(names: Sequence[str] = NAMES) -> dict[str, CaseFile]:
    """Return the cases of some machines by name and travel; `ValueError` for an unknown machine."""
    if unknown := set(names) - set(NAMES):
        raise ValueError(f"machines must be among {', '.join(NAMES)}, got {', '.join(sorted(unknown))}")
    library = files("exudyn_crawler.machines.datasheet") / "library"
    cases = {}
    for name in names:
        for key, travel in TRAVELS.items():
            file = read_case(str(library / f"{name}.toml"), [f'datasheet.travel="{travel}"'])
            cases[f"{name}_{key}"] = file.with_(duration=DURATION, outputs=BARE)
    return cases


def motion(straight: History, turn: History) -> dict[str, float]:
    """Return distance and turn of a machine, each over the commanded one, and its greatest tensions.

    Ways are magnitudes: machines with the sprocket in front travel along -x. Ratios
    "after the start" are of the motion from the end of the drive's start on.
    """
    row = {}
    drives = straight.case.drive.speed, turn.case.drive.turn_rate
    assert drives[1] is not None
    moved = straight.side_frame_displacement.sel(axis="x").values
    turned = np.unwrap(turn.side_frame_angles.sel(axis="z").values)
    for history, profile, way, unit in ((straight, drives[0], moved, "m"), (turn, drives[1], turned, "rad")):
        time = history.time.values
        late = time >= start_ends(history)
        wanted = profile.integral(time)
        what = "distance" if unit == "m" else "turn"
        row[f"{what} in {unit}"] = abs(float(way[-1] - way[0]))
        row[f"commanded {what} in {unit}"] = abs(float(wanted[-1]))
        after, commanded = (np.ptp(values[late][[0, -1]]) for values in (way, wanted))
        row[f"{what} over the commanded after the start"] = float(after / commanded)
        tension = float(history.quantity("link_tension").max()) / 1e3
        row[f"greatest tension in kN, {what}"] = tension
    return row


def study(
    out: Path | None = None, names: Sequence[str] = NAMES, **how: Unpack[Running]
) -> tuple[dict[str, CaseFile], pd.DataFrame]:
    """Run some machines and tabulate their motion, see `motion`; `out` gets their folders and `motion.csv`.

    Errors are those of `case_files` and `study_runs`.
    """
    cases = case_files(names)
    with study_runs(out, cases, **how) as runs:
        rows = [
            {"machine": name} | motion(*(runs[f"{name}_{key}"].history for key in TRAVELS)) for name in names
        ]
        table = pd.DataFrame(rows)
        save(out, motion=table)
    return cases, table
