"""Commands over several runs: the life of a duty, the spread of a run that is repeated, sweeps."""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.cli.application import readable
from exudyn_crawler.cli.looking import app
from exudyn_crawler.cli.options import RESULTS, Debug, Overwrite, Run, run_folder


@app.command()
@readable
def life(
    duty: Annotated[Path, typer.Argument(help="duty file", metavar="DUTY.toml")],
    out: Annotated[
        Path | None, typer.Option(help=f"folder of the results; {RESULTS}/DUTY, if not given")
    ] = None,
    overwrite: Overwrite = False,
    debug: Debug = False,
) -> None:
    """Give the life of the shoes in machine hours, where they crack and why, from a mix of runs.

    Example: exudyn-crawler life digging.toml --out results/digging
    """
    from exudyn_crawler.results.life.duty import read_duty

    asked = read_duty(duty)  # wrong files end the command before all that counts and draws is loaded
    from exudyn_crawler.life_run import life as life_into
    from exudyn_crawler.results.life.life_table import in_words
    from exudyn_crawler.views.tables import print_table

    folder = RESULTS / duty.stem if out is None else out
    result = life_into(asked, folder, overwrite=overwrite, say=typer.echo)
    shown = result.table.loc[:, :"main load"].drop(columns=[f"{axis} in the shoe in m" for axis in "xyz"])
    print_table(in_words(shown), f"{asked.name}: shortest lives by region")
    typer.echo(f"life, tables, fields and page (life.html) are in {folder}")


@app.command()
@readable
def spread(
    run: Run,
    starts: Annotated[int, typer.Option(help="starts that differ by rounding, the run's own among them")] = 3,
    laws: Annotated[
        bool, typer.Option(help="repeat it with the contact law shared by area, or whole a pair, too")
    ] = True,
    overwrite: Overwrite = False,
    debug: Debug = False,
) -> None:
    """Repeat a run from starts that differ by rounding and by another contact law, and judge its stresses.

    Example: exudyn-crawler spread results/stress/cycle
    """
    folder = run_folder(run)  # before all that runs is loaded
    from exudyn_crawler.spread_run import spread as spread_into
    from exudyn_crawler.views.tables import print_table

    result = spread_into(folder, starts, laws=laws, overwrite=overwrite, say=typer.echo)
    print_table(result.by_shoe(), f"{folder}: highest stresses of the repeated runs at the first one's node")
    typer.echo(f"runs, tables of hot spots and verdicts of all nodes are in {folder / 'spread'}")


NEEDED = ("distributed", "SALib", "pyarrow")
"""Modules of the extra `sweep`."""
SHOWN = 60
"""Rows of the table of runs that are printed."""


@app.command()
@readable
def sweep(
    file: Annotated[Path, typer.Argument(help="sweep file", metavar="SWEEP.toml")],
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="show the runs, their number and the time they take; run none")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help=f"folder of the sweep; {RESULTS}/SWEEP, if not given")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(help="Dask scheduler: tcp://host:8786 or a scheduler file; this machine, if not given"),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="processes on this machine; one a core, if not given", min=1)
    ] = None,
    storage: Annotated[
        str | None, typer.Option(help="folder of the runs instead, which all workers share")
    ] = None,
    retry: Annotated[bool, typer.Option("--retry", help="run those anew that have failed")] = False,
    debug: Debug = False,
) -> None:
    """Run a case with some of its values varied, on all cores or a cluster; the same command goes on.

    Example: exudyn-crawler sweep soils.toml --dry-run
    """
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise ValueError(f"sweeps need {', '.join(missing)}: pip install 'exudyn-crawler[sweep]'")
    if scheduler is not None and workers is not None:
        raise ValueError("--workers must be left out with --scheduler, whose workers there are")
    from exudyn_crawler.sweep.files import read_sweep

    plan = read_sweep(file)
    out = RESULTS / file.stem if out is None else out
    from exudyn_crawler.sweep.running import folder_state, run_sweep

    if dry_run:
        from exudyn_crawler.views.tables import print_table

        table = plan.table()
        shown = f", the first {SHOWN}" if len(table) > SHOWN else ""
        print_table(table.head(SHOWN), f"{len(table)} runs{shown}; {_units(plan.units(), plan.columns)}")
        typer.echo(folder_state(plan, out, storage=storage, workers=workers, retry=retry))
        return
    run = run_sweep(
        plan, out, scheduler=scheduler, workers=workers, storage=storage, retry=retry, say=typer.echo
    )
    failed = int((run.table["status"] != "done").sum())
    more = f"; {failed} runs have failed, results.csv says why, --retry runs them again" if failed else ""
    typer.echo(f"{out}: open report.html in a browser; results.csv, .parquet and .nc hold the answers{more}")


def _units(units: "dict[str, str]", columns: tuple[str, ...]) -> str:
    return ", ".join(f"{name} in {units[name]}" if units[name] else name for name in columns)
