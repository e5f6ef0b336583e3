"""The command that runs sweeps."""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.cli.errors import readable
from exudyn_crawler.cli.options import RESULTS, Debug
from exudyn_crawler.cli.spreading import app

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

    found = read_sweep(file)
    out = RESULTS / file.stem if out is None else out
    from exudyn_crawler.sweep.running import folder_state, run_sweep

    if dry_run:
        from exudyn_crawler.views.tables import print_table

        table = found.table()
        shown = f", the first {SHOWN}" if len(table) > SHOWN else ""
        print_table(table.head(SHOWN), f"{len(table)} runs{shown}; {_units(found.units(), found.columns)}")
        typer.echo(folder_state(found, out, storage=storage, workers=workers, retry=retry))
        return
    run = run_sweep(
        found, out, scheduler=scheduler, workers=workers, storage=storage, retry=retry, say=typer.echo
    )
    failed = int((run.table["status"] != "done").sum())
    told = f"; {failed} runs have failed, results.csv says why, --retry runs them anew" if failed else ""
    typer.echo(f"{out}: open report.html in a browser; results.csv, .parquet and .nc hold the answers{told}")


def _units(units: "dict[str, str]", columns: tuple[str, ...]) -> str:
    return ", ".join(f"{name} in {units[name]}" if units[name] else name for name in columns)
