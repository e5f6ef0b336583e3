"""Stress study (S-paper): flexible shoes over propel and loading, von Mises histories and hot spots."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from exudyn_crawler.case import Case
from exudyn_crawler.case.files import CaseFile
from exudyn_crawler.case.flexible import ADAMS_DAMPING
from exudyn_crawler.case.outputs import Outputs
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.files import whole_file
from exudyn_crawler.model.flexible_shoes import shoe_model
from exudyn_crawler.results.history import History
from exudyn_crawler.results.stresses import StressResults, recover_stresses
from exudyn_crawler.run.folder import kept_run
from exudyn_crawler.run.simulation import simulate
from exudyn_crawler.runs import HISTORY, STOPPED_HISTORY, keep_history, kept_checkpoints
from exudyn_crawler.views.curves import save_figure
from exudyn_crawler.views.paraview import write_paraview
from exudyn_crawler.views.stress_figures import stress_figures
from exudyn_crawler.views.stress_pictures import write_stress_pictures
from exudyn_crawler.views.tables import write_table
from fem import write_vtu
from studies.defaults import CYCLE_DURATION
from studies.stress_comparison import compare_stresses, stress_summary


def run_stress(
    case: Case | None = None,
    duration: float = CYCLE_DURATION,
    out: Path | None = None,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = lambda _text: None,
) -> tuple[History, StressResults, pd.DataFrame]:
    """Run a track with flexible shoes, recover their stresses and compare them with the paper.

    Parameters
    ----------
    case : Case, optional
        With flexible shoes; `Case.stress()` if left out.
    duration : float
        s.
    out : Path, optional
        Folder for all results; None writes nothing. Its folder `checkpoints` lets a run that was killed go
        on: the same call takes up where it ended.
    overwrite : bool
        Replace files of an earlier study and start anew.
    say : callable
        Is told, in a line, what is going on.

    Returns
    -------
    history : History
    results : StressResults
    comparison : pandas.DataFrame
        As of `stress_comparison.compare_stresses`.

    Raises
    ------
    ValueError
        Before anything runs: no flexible shoes, interfaces that do not meet the pins, modes that do not
        exist, a bad duration, or checkpoints of other parameters.
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    SimulationStopped
        If the run ends early; its history is saved.
    """
    case = Case.stress() if case is None else case
    flexible = case.flexible_shoes()
    case_file = CaseFile(case=case, duration=duration)
    shoe_model(flexible, case.track)  # refuses a mesh that does not fit while nothing is written yet
    with kept_run(out, {"case": case_file}, overwrite, say) as keeper:
        checkpoints = None if out is None else kept_checkpoints(out, case, overwrite, keeper)
        with keeper.timed("simulate"):
            try:
                history = simulate(case, duration, progress, checkpoints)
            except SimulationStopped as stop:
                if out is not None:
                    keep_history(stop.history, out / STOPPED_HISTORY, overwrite=True)
                raise
        if out is not None:
            keep_history(history, out / HISTORY, overwrite)
        with keeper.timed("recover stresses"):
            results = recover_stresses(history)
            table = compare_stresses(history, results)
        if out is not None:
            with keeper.timed("tables and figures"):
                write_stresses(history, results, out, overwrite)
                write_table(table, out / "comparison.csv", overwrite)
                write_table(case.loads.table(), out / "loads.csv", overwrite)
        if checkpoints is not None:
            checkpoints.remove()
    return history, results, table


def write_stresses(
    history: History,
    results: StressResults,
    out: Path,
    overwrite: bool = False,
    outputs: Outputs = Outputs(),  # noqa: B008 - frozen
) -> None:
    """Write stresses and, if wanted, tables, figures, pictures, fields and the ParaView series."""
    results.save(out / "stress.nc", overwrite)
    if outputs.tables:
        write_table(stress_summary(history, results), out / "highest_stresses.csv", overwrite)
        for shoe, hot_spots in results.hot_spots.items():
            write_table(hot_spots, out / f"hot_spots_shoe_{shoe}.csv", overwrite)
    if not outputs.figures:
        return
    for title, figure in stress_figures(history, results).items():
        name = f"flexible_{title.replace(' ', '_')}.{outputs.figure_format}"
        save_figure(figure, out / name, overwrite)
    _write_fields(results, out, overwrite)
    write_stress_pictures(results.dataset, history, out, overwrite)
    write_paraview(results.dataset, history, out, overwrite)


def _write_fields(results: StressResults, out: Path, overwrite: bool) -> None:
    """Greatest von Mises stress of every node, when it occurs and its range, for ParaView."""
    for shoe in results.dataset.shoe.values:
        own = results.dataset.sel(shoe=shoe)
        fields = {
            "greatest von Mises": own.peak_von_mises.values,
            "time of the greatest": own.peak_time.values,
            "range of von Mises": (own.peak_von_mises - own.least_von_mises).values,
        }
        with whole_file(out / f"fields_shoe_{shoe}.vtu", overwrite) as temporary:
            write_vtu(temporary, results.whole.mesh, fields)


def open_choices(duration: float = 8.0, mesh: str = "coarse", progress: bool | None = None) -> pd.DataFrame:
    """What the stress study's open choices do: rows of the S-paper for some of them.

    Parameters
    ----------
    duration : float
        s; the coarse mesh and part of the propel tell the directions.

    Returns
    -------
    pandas.DataFrame
        Columns case, quantity, statistic, unit, paper, then one a choice; rows that the run reaches.
    """
    case = Case.stress(mesh)
    flexible, contact = case.flexible_shoes(), case.pair_contact()
    choices = {
        "default": case,
        "ADAMS' modal damping": case.with_(flexible=flexible.with_(damping=ADAMS_DAMPING)),
        "one contact law a pair": case.with_(contact=contact.with_(sharing="pair")),
        "contact damping x 10": case.with_(contact=contact.with_(damping=10.0 * contact.damping)),
    }
    columns = {}
    for choice, changed in choices.items():
        _, _, table = run_stress(changed, duration, progress=progress)
        columns[choice] = table["computed"]
    rows = table[["case", "quantity", "statistic", "unit", "paper"]].assign(**columns)
    return rows.dropna().reset_index(drop=True)


if __name__ == "__main__":
    from exudyn_crawler.cli import run_script, stress

    run_script(stress)
