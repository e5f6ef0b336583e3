"""The commands that run a case many times: sweeps, and scatter over what is drawn from distributions."""

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from exudyn_crawler.cli.application import RESULTS, OfName
from exudyn_crawler.cli.commands import command
from exudyn_crawler.views.tables import print_rows, print_table

if TYPE_CHECKING:
    from exudyn_crawler.sweep.results import SweepRun
    from exudyn_crawler.sweep.scatter import AnySweep

NEEDED = ("distributed", "SALib", "pyarrow")  # modules of the extra `sweep`
SHOWN = 60  # rows of the table of runs that are printed


def _sweeping(show: Callable[["SweepRun"], None], example: str, sampled: bool = False) -> None:
    """Register the command, named and described as `show`, that runs a sweep and shows its results."""

    def run(
        file: Annotated[Path, typer.Argument(help="sweep file", metavar="SWEEP.toml")],
        dry_run: Annotated[
            bool, typer.Option("--dry-run", help="show the runs, their number and their time; run none")
        ] = False,
        out: OfName = None,
        scheduler: Annotated[
            str | None,
            typer.Option(help="Dask: tcp://host:8786 or a scheduler file; this machine, if not given"),
        ] = None,
        workers: Annotated[
            int | None, typer.Option(help="processes on this machine; one a core, if not given", min=1)
        ] = None,
        storage: Annotated[
            str | None, typer.Option(help="another folder for the runs, which all workers share")
        ] = None,
        retry: Annotated[bool, typer.Option("--retry", help="run failed runs again")] = False,
    ) -> None:
        if missing := [module for module in NEEDED if find_spec(module) is None]:
            raise ValueError(f"sweeps need {', '.join(missing)}: pip install 'exudyn-crawler[sweep]'")
        from exudyn_crawler.sweep.scatter import read_scatter

        plan, folder = read_scatter(file), out or RESULTS / file.stem
        if sampled and not plan.is_sampled:
            raise ValueError(
                f"{file}: design must draw a sample, such as 'latin_hypercube', got {plan.design!r}"
            )
        if scheduler is not None and workers is not None:
            raise ValueError("--workers must be left out with --scheduler, which has workers of its own")
        from exudyn_crawler.sweep.definition import Sweep
        from exudyn_crawler.sweep.running import folder_state, run_duty_scatter, run_sweep

        how: dict[str, Any] = {"storage": storage, "workers": workers, "retry": retry}
        if dry_run:
            _show_plan(plan)
            if isinstance(plan, Sweep):
                typer.echo(folder_state(plan, folder, **how))
            return
        if isinstance(plan, Sweep):
            done = run_sweep(plan, folder, scheduler=scheduler, say=typer.echo, **how)
        else:
            done = run_duty_scatter(plan, folder, typer.echo)
        show(done)
        failed = int((done.table["status"] != "done").sum())
        more = f"; {failed} runs have failed, results.csv says why, --retry runs them again" if failed else ""
        where = "open report.html in a browser; results.csv, .parquet and .nc hold the answers"
        typer.echo(f"{done.folder}: {where}{more}")

    run.__name__, run.__doc__ = show.__name__, show.__doc__
    command(example)(run)


def _show_plan(plan: "AnySweep") -> None:
    from exudyn_crawler.case.parameters.fields import value_text

    table, units = plan.table(), plan.units()
    shown = f", the first {SHOWN}" if len(table) > SHOWN else ""
    read = {name: [value_text(one, units[name]) for one in table[name].head(SHOWN)] for name in plan.columns}
    title = f"{len(table)} runs{shown}; {', '.join(plan.columns)}"
    print_table(table.head(SHOWN).assign(**read), title)


def sweep(run: "SweepRun") -> None:
    """Run a case with some of its values varied, on all cores or a cluster; the same command continues it."""
    from exudyn_crawler.sweep.results import best_and_worst, for_reading

    read, columns = for_reading(run.table), ("answer", "which", "run", "value", "unit", "folder")
    units = read.attrs["units"]
    best = [(*one[:3], one.value, units[one.answer], one.folder) for one in best_and_worst(run.sweep, read)]
    print_rows(columns, best, "Best and worst runs", ("run", "value"))


def scatter(run: "SweepRun") -> None:
    """Run a case or weigh a duty with values drawn at random: quantiles of answers, shoes that crack."""
    from exudyn_crawler.sweep.results import for_reading, scatter_tables

    tables = scatter_tables(run.sweep, for_reading(run.table))
    titles = {"quantiles": "Quantiles over the runs", "failures": "Shoes that crack"}
    for name in (one for one in titles if one in tables and len(tables[one])):
        print_table(tables[name], titles[name])


_sweeping(sweep, "sweep soils.toml --dry-run")
_sweeping(scatter, "scatter studies/duty_scatter.toml", sampled=True)
