"""Page of a sweep, with the reports of its best and worst runs."""

import os
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from exudyn_crawler.files import note_written, whole_file
from exudyn_crawler.run.folder.record import note_file
from exudyn_crawler.sweep.definition import Sweep
from exudyn_crawler.sweep.results import main_effects, sobol_indices
from exudyn_crawler.sweep.worker import DONE, OUTCOME
from exudyn_crawler.views.pages.report import REPORT, write_report
from exudyn_crawler.views.pages.sweep import Best, SweepView, sweep_page


def write_page(
    sweep: Sweep, table: pd.DataFrame, folder: Path, runs: Path, say: Callable[[str], None]
) -> Path:
    """Write the page of a sweep's results into its folder.

    Parameters
    ----------
    table : pandas.DataFrame
        Of `results_table`.
    runs : Path
        Folder of the folders of runs.
    say : callable
        Gets a line about each report that cannot be written.
    """
    best = best_and_worst(sweep, table)
    for name in dict.fromkeys(one.folder for one in best):
        _report_of(runs / name, say)
    indices, method = sobol_indices(sweep, table)
    view = SweepView(
        title=f"Sweep of {sweep.case.case.name}",
        lead=(_lead(sweep, table),),
        table=table,
        varied=sweep.columns,
        answers=tuple(answer.label for answer in sweep.answers),
        logarithmic=frozenset(one.label for one in sweep.vary if one.scale == "log"),
        is_grid=sweep.design == "grid",
        effects=main_effects(sweep, table),
        indices=indices,
        method=method,
        best=best,
        links={name: _link(folder, runs / name) for name in table["folder"]},
    )
    path = folder / REPORT
    with whole_file(path, overwrite=True) as temporary:
        temporary.write_text(sweep_page(view), encoding="utf-8")
    return path


def best_and_worst(sweep: Sweep, table: pd.DataFrame) -> list[Best]:
    """Best and worst finished run of every answer."""
    done = table[table["status"] == DONE]
    ends_of_all = []
    for answer in sweep.answers:
        values = done[answer.label].dropna()
        if values.empty:
            continue
        ends = [("best", values.idxmin()), ("worst", values.idxmax())]
        if answer.better == "more":
            ends = [("best", values.idxmax()), ("worst", values.idxmin())]
        for which, index in ends:
            row = done.loc[index]
            ends_of_all.append(
                Best(answer.label, which, int(row["run"]), str(row["folder"]), float(values[index]))
            )
    return ends_of_all


def _lead(sweep: Sweep, table: pd.DataFrame) -> str:
    counts = table["status"].value_counts().to_dict()
    by_status = ", ".join(f"{count} {status}" for status, count in counts.items())
    drawn = f", {sweep.runs} points drawn with seed {sweep.seed}" if sweep.runs else ""
    return f"{len(table)} runs of {sweep.case.duration:g} s, design {sweep.design}{drawn}: {by_status}"


def _report_of(run: Path, say: Callable[[str], None]) -> None:
    """Write the report of a run, unless it is there and as new as the run."""
    report = run / REPORT
    outcome = run / OUTCOME
    if report.is_file() and outcome.is_file() and report.stat().st_mtime >= outcome.stat().st_mtime:
        note_written(report)
        return
    try:
        write_report(run, overwrite=True)
        note_file(report)
    # altered bytes make the readers raise all kinds of errors
    except Exception as error:
        say(f"no report of {run}: {' '.join(str(error).split())}")


def _link(folder: Path, run: Path) -> str:
    """Address of a run's report from the page, or of its folder where it has none."""
    there = run / REPORT if (run / REPORT).is_file() else run
    return Path(os.path.relpath(there, folder.resolve())).as_posix()
