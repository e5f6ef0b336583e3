"""Stresses of flexible shoes over propel and a loading cycle.

Reproduces the S-paper ("Multibody Dynamic Stress Simulation of Rigid-Flexible Shovel Crawler Shoes",
Minerals 2016, 6(3), 61): six flexible shoes over 15 s of propel and 25 s of digging, swinging and dumping;
the modes of figure 9, motion, contact and joint forces and deformation of figures 11 to 17 and 21, von Mises
stresses at eight instants, and the hot spots of tables 5 and 6.
"""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from exudyn_crawler import Case, CaseFile
from exudyn_crawler.case import Outputs
from exudyn_crawler.case.parameters.flexible import ADAMS_DAMPING
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.model.flexible_shoes import check_shoe
from exudyn_crawler.run.folder.record import quiet
from exudyn_crawler.views.tables import write_table
from studies.defaults import CYCLE_DURATION
from studies.running import study_runs
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
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = quiet,
) -> tuple[CaseRun, pd.DataFrame]:
    """Run a track with flexible shoes, recover their stresses and compare them with the paper.

    Parameters
    ----------
    out : Path, optional
        Folder of the study: the run in a folder named "cycle", and `comparison.csv`; None writes nothing. The
        same call continues a study that was stopped.
    case : Case, optional
        With flexible shoes; `Case.stress()` if left out.
    duration : float
        s.
    overwrite, progress, say
        As of `run_case`.

    Returns
    -------
    run : CaseRun
    comparison : pandas.DataFrame
        As of `stress_comparison.compare_stresses`.

    Raises
    ------
    ValueError
        Before anything runs: no flexible shoes, interfaces that do not meet the pins, modes that do not
        exist, a bad duration, or checkpoints of other parameters.
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError, SimulationStopped
        As of `run_case`.
    """
    case = Case.stress() if case is None else case
    shown = tuple(time for time in PICTURE_TIMES if time <= duration) or None
    case_file = CaseFile(case=case, duration=duration, outputs=Outputs(picture_times=shown))
    check_shoe(case)  # raises for a mesh that does not fit before anything is written
    with study_runs(out, {RUN: case_file}, overwrite=overwrite, progress=progress, say=say) as runs:
        run = runs[RUN]
        table = compare_stresses(run.history, run.recovered())
        if out is not None:
            write_table(table, out / "comparison.csv", overwrite=True)
    return run, table


def open_choices(duration: float = 8.0, mesh: str = "coarse", progress: bool | None = None) -> pd.DataFrame:
    """Effect of the stress study's open choices: rows of the S-paper for some of them.

    Parameters
    ----------
    duration : float
        s; the coarse mesh and part of the propel show the trends.

    Returns
    -------
    pandas.DataFrame
        Columns case, quantity, statistic, unit, paper, then one per choice; rows that the run reaches.
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
