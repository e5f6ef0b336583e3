"""The commands that run a case many times: sweeps, and scatter over what is drawn from distributions."""

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from exudyn_crawler.cli.application import RESULTS
from exudyn_crawler.cli.commands import command
from exudyn_crawler.views.tables import print_rows, print_table

if TYPE_CHECKING:
    import pandas as pd

    from exudyn_crawler.sweep.running import SweepRun
    from exudyn_crawler.sweep.scatter import AnySweep

NEEDED = ("distributed", "SALib", "pyarrow")
"""Modules of the extra `sweep`."""
SHOWN = 60
"""Rows of the table of runs that are printed."""


SweepFile = Annotated[Path, typer.Argument(help="sweep file", metavar="SWEEP.toml")]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="show the runs, their number and the time they take; run none")
]
SweepFolder = Annotated[
    Path | None, typer.Option("--out", help=f"folder of the sweep; {RESULTS}/SWEEP, if not given")
]
Scheduler = Annotated[
    str | None,
    typer.Option(help="Dask scheduler: tcp://host:8786 or a scheduler file; this machine, if not given"),
]
Workers = Annotated[
    int | None, typer.Option(help="processes on this machine; one a core, if not given", min=1)
]
Storage = Annotated[str | None, typer.Option(help="folder of the runs instead, which all workers share")]
Retry = Annotated[bool, typer.Option("--retry", help="run those anew that have failed")]


@command
def sweep(
    file: SweepFile,
    dry_run: DryRun = False,
    out: SweepFolder = None,
    scheduler: Scheduler = None,
    workers: Workers = None,
    storage: Storage = None,
    retry: Retry = False,
) -> None:
    """Run a case with some of its values varied, on all cores or a cluster; the same command goes on.

    Example: exudyn-crawler sweep soils.toml --dry-run
    """
    how = {"scheduler": scheduler, "workers": workers, "storage": storage, "retry": retry}
    run = _swept(_planned(file), out or RESULTS / file.stem, dry_run, how)
    if run is None:
        return
    from exudyn_crawler.results.history.catalogue import READ_IN
    from exudyn_crawler.sweep.results import best_and_worst

    units, columns = run.table.attrs["units"], ("answer", "which", "run", "value", "unit", "folder")
    rows = best_and_worst(run.sweep, run.table)
    read = [READ_IN.get(units[one.answer], (units[one.answer], 1.0)) for one in rows]
    best = [
        (*one[:3], factor * one.value, unit, one.folder)
        for one, (unit, factor) in zip(rows, read, strict=True)
    ]
    print_rows(columns, best, "Best and worst runs", ("run", "value"))
    typer.echo(_end_of(run))


@command
def scatter(
    file: SweepFile,
    dry_run: DryRun = False,
    out: SweepFolder = None,
    scheduler: Scheduler = None,
    workers: Workers = None,
    storage: Storage = None,
    retry: Retry = False,
) -> None:
    """Run a case, or count a duty, with values drawn: quantiles of answers, shoes that crack in a fleet.

    Example: exudyn-crawler scatter studies/duty_scatter.toml
    """
    plan = _planned(file)
    if not plan.is_sampled:
        raise ValueError(f"{file}: design must draw a sample, such as 'latin_hypercube', got {plan.design!r}")
    how = {"scheduler": scheduler, "workers": workers, "storage": storage, "retry": retry}
    run = _swept(plan, out or RESULTS / file.stem, dry_run, how)
    if run is None:
        return
    from exudyn_crawler.sweep.results import scatter_tables

    tables = scatter_tables(run.sweep, run.table)
    titles = {"quantiles": "Quantiles over the runs", "failures": "Shoes that crack"}
    for name in (one for one in titles if one in tables and len(tables[one])):
        print_table(_for_reading(tables[name]), titles[name])
    typer.echo(_end_of(run))


def _for_reading(table: "pd.DataFrame") -> "pd.DataFrame":
    """Table with a unit a row, if it has one, with its other numbers in units for reading."""
    from exudyn_crawler.results.history.catalogue import READ_IN
    from exudyn_crawler.views.pages.sweep import QUANTILES

    made = table.copy()
    for row, unit in table.get("unit", {}).items():
        made.loc[row, "unit"], factor = READ_IN.get(unit, (unit, 1.0))
        made.loc[row, QUANTILES] *= factor
    return made


def _planned(file: Path) -> "AnySweep":
    """Sweep, or scatter over a duty, of a file; ValueError if what these need is not installed."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise ValueError(f"sweeps need {', '.join(missing)}: pip install 'exudyn-crawler[sweep]'")
    from exudyn_crawler.sweep.scatter import read_scatter

    return read_scatter(file)


def _swept(plan: "AnySweep", out: Path, dry_run: bool, how: dict[str, Any]) -> "SweepRun | None":
    """Sweep that was run; None where its runs are only to be shown."""
    if how["scheduler"] is not None and how["workers"] is not None:
        raise ValueError("--workers must be left out with --scheduler, which has workers of its own")
    from exudyn_crawler.sweep.definition import Sweep
    from exudyn_crawler.sweep.running import folder_state, run_duty_scatter, run_sweep

    if not dry_run:
        if not isinstance(plan, Sweep):
            return run_duty_scatter(plan, out, typer.echo)
        return run_sweep(plan, out, say=typer.echo, **how)
    from exudyn_crawler.case.parameters.fields import value_text

    table, units = plan.table(), plan.units()
    shown = f", the first {SHOWN}" if len(table) > SHOWN else ""
    read = {name: [value_text(one, units[name]) for one in table[name].head(SHOWN)] for name in plan.columns}
    title = f"{len(table)} runs{shown}; {', '.join(plan.columns)}"
    print_table(table.head(SHOWN).assign(**read), title)
    del how["scheduler"]
    if isinstance(plan, Sweep):
        typer.echo(folder_state(plan, out, **how))
    return None


def _end_of(run: "SweepRun") -> str:
    """Where the results of a sweep are, and how many runs failed."""
    failed = int((run.table["status"] != "done").sum())
    more = f"; {failed} runs have failed, results.csv says why, --retry runs them again" if failed else ""
    where = "open report.html in a browser; results.csv, .parquet and .nc hold the answers"
    return f"{run.folder}: {where}{more}"
