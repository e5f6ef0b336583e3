"""Stresses of flexible shoes over propel and a loading cycle.

Reproduces the S-paper ("Multibody Dynamic Stress Simulation of Rigid-Flexible Shovel Crawler Shoes",
Minerals 2016, 6(3), 61): six flexible shoes over 15 s of propel and 25 s of digging, swinging and dumping;
the modes of figure 9, motion, contact and joint forces and deformation of figures 11 to 17 and 21, von Mises
stresses at eight instants, and the hot spots of tables 5 and 6.
"""

from pathlib import Path
from typing import Unpack

import pandas as pd

from exudyn_crawler import Case, CaseFile
from exudyn_crawler.case import Outputs
from exudyn_crawler.case.parameters.flexible import ADAMS_DAMPING
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.model.flexible_shoes import check_shoe
from studies.defaults import CYCLE_DURATION
from studies.running import Running, save, study_runs
from studies.stress_comparison import compare_stresses

RUN = "cycle"
"""Folder of the run in the folder of the study."""
PICTURE_TIMES = (0.0, 5.0, 10.0, 15.0, 22.5, 30.0, 33.5, 40.0)
"""s, instants at which the S-paper shows the stressed shoes."""


def study(
    out: Path | None = None,
    case: Case | None = None,
    *,
    duration: float = CYCLE_DURATION,
    **how: Unpack[Running],
) -> tuple[CaseRun, pd.DataFrame]:
    """Run a track with flexible shoes, `Case.stress()` if none is given, and compare it with the paper.

    With `out` it gets the run in its folder "cycle", and `comparison.csv`, as of `compare_stresses`. A
    ValueError before anything runs for no flexible shoes, interfaces that do not meet the pins, modes that do
    not exist, a bad duration (s), or checkpoints of other parameters; others are those of `study_runs`.
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
    """Rows of the S-paper that runs of a duration (s) reach, with a column for each open choice of the study.

    Columns case, quantity, statistic, unit, paper, and the choices; part of the propel shows the trends.
    """
    case = Case.stress(mesh)
    flexible, contact = case.flexible_shoes(), case.pair_contact()
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


if __name__ == "__main__":
    from exudyn_crawler.cli import run_script

    run_script("studies.commands:stress")
