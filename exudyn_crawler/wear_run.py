"""Wear of a machine into a folder: work of its duties, residual hours by inspections, tables and a page."""

import math
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from exudyn_crawler import files
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.results.history import History
from exudyn_crawler.results.wear import duty_work
from exudyn_crawler.results.wear.duty_work import DutyWork
from exudyn_crawler.results.wear.forecast import forecast
from exudyn_crawler.results.wear.inspections import read_inspections
from exudyn_crawler.results.wear.plan import WearDuty, WearPlan, WearRun, read_wear
from exudyn_crawler.results.wear.results import WearResults
from exudyn_crawler.results.wear.work import RunWork, run_work
from exudyn_crawler.run.folder import record
from exudyn_crawler.settings.fields import errors_at
from exudyn_crawler.views import style, tables, wear as drawings
from exudyn_crawler.views.pages import signed, wear as pages
from exudyn_crawler.views.tables import ORIGIN_COLUMNS, origin_rows

WEAR_PAGE = "wear.html"
INPUTS = "inputs.csv"
OF_INSPECTIONS = {"due.csv": "table", "readings.csv": "readings"}
OF_DUTIES = {
    "duties.csv": "by_duty",
    "work.csv": "work",
    "regions.csv": "regions",
    "sweeps.csv": "sweeps",
    "growth.csv": "growth",
}
"""Tables of inspections and of duties."""


def wear(
    plan: WearPlan | str | Path,
    out: str | Path | None = None,
    *,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _text: None,
) -> WearResults:
    """Forecast the wear of a machine, or that of its file: work of pairs, residual hours, what is due first.

    Tables, drawings and page go into the folder `out` if it is given; `say` gets a line on each activity.

    Raises before anything is computed: FileNotFoundError if there is no such file or no history of a run;
    FileExistsError if the folder has results and `overwrite` is false; ValueError if the file, its
    inspections or its runs are refused, see `read_wear`, `read_inspections` and `results.wear.work.run_work`.
    """
    sources = [] if isinstance(plan, WearPlan) else [Path(plan)]
    plan = plan if isinstance(plan, WearPlan) else read_wear(plan)
    checks.warn_of(checks.out_of_range(plan))
    folder = None if out is None else Path(out)
    if folder is not None:
        for name in (
            WEAR_PAGE,
            INPUTS,
            signed.STORED,
            *OF_INSPECTIONS,
            *OF_DUTIES,
            *map(drawings.file_name, drawings.DRAWN),
        ):
            files.refuse_existing(folder / name, overwrite)
    paths = {(duty.name, run.name): _history_of(run) for duty in plan.duties for run in duty.runs}
    # before the work: the files may change meanwhile
    sources += [] if plan.inspections is None else [Path(plan.inspections)]
    checksums = signed.input_sums([file for file in (*sources, *paths.values()) if file.is_file()], plan)
    found = None if plan.inspections is None else forecast(plan, read_inspections(plan.inspections))
    duties = []
    for duty in plan.duties:
        say(f"work of {duty.name}")
        runs = {run.name: _work_of(plan, run, paths[duty.name, run.name]) for run in duty.runs}
        _check_machine(duty, runs)
        duties.append(DutyWork(duty, runs))
    results = WearResults(plan, found, tuple(duties))
    if folder is not None:
        write_wear(results, files.writable_folder(folder), overwrite)
        case = results.case
        machine = "" if case is None else case.gear.words(case)
        report = pages.signed_wear(results, machine, checksums, record.program_line())
        there = {
            caption: drawings.file_name(name)
            for caption, name in pages.SIGNED_FIGURES.items()
            if (folder / drawings.file_name(name)).is_file()
        }
        signed.store(report, folder, there, overwrite)
    return results


def _history_of(run: WearRun) -> Path:
    """Return the history of a run; raises `FileNotFoundError` without one."""
    path = run.folder / record.HISTORY if run.folder.is_dir() else run.folder
    if not path.is_file():
        raise FileNotFoundError(f"run {run.name!r}: no history at {path}")
    return path


def _work_of(plan: WearPlan, run: WearRun, path: Path) -> RunWork:
    """Return the work of a run's part."""
    history = History.load(path)
    radius, _ = duty_work.pin_size(plan, history.case)
    with errors_at(f"run {run.name!r}"):
        return run_work(history, radius, math.degrees(plan.sweep), run.begin, run.end)


def _check_machine(duty: WearDuty, runs: dict[str, RunWork]) -> None:
    """Raise ValueError if the runs of a duty have different chains."""
    chains = {name: (work.shoes, work.case.track.pitch) for name, work in runs.items()}
    first, *others = chains
    for name in others:
        if chains[name] != chains[first]:
            words = [f"{shoes} shoes of {pitch:.4g} m of {run!r}" for run, (shoes, pitch) in chains.items()]
            raise ValueError(f"duty {duty.name!r}: its runs must have one chain, got {', '.join(words)}")


def write_wear(found: WearResults, folder: Path, overwrite: bool = False) -> None:
    """Write all tables, drawings and the page of a wear forecast into a folder."""
    if found.forecast is not None:
        for name, table in OF_INSPECTIONS.items():
            tables.write_table(getattr(found.forecast, table), folder / name, overwrite)
    if found.duties:
        for name, table in OF_DUTIES.items():
            tables.write_table(getattr(found, table), folder / name, overwrite)
    inputs = pd.DataFrame(origin_rows(found.inputs), columns=ORIGIN_COLUMNS)
    tables.write_table(inputs, folder / INPUTS, overwrite)
    drawn = drawings.wear_figures(found)
    for name, figure in drawn.items():
        style.save_figure(figure, folder / drawings.file_name(name), overwrite)
    pages.write_wear_page(found, drawn, folder / WEAR_PAGE, overwrite)
