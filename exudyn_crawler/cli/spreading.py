"""The command that tells how far a run's stresses hang on rounding and on the choice of the contact law."""

from typing import Annotated

import typer

from exudyn_crawler.cli.errors import readable
from exudyn_crawler.cli.life import app
from exudyn_crawler.cli.options import Debug, Overwrite, Run
from exudyn_crawler.cli.places import run_folder

__all__ = ["app"]


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
    folder = run_folder(run)  # refused before all that runs is loaded
    from exudyn_crawler.spread_run import spread as spread_into
    from exudyn_crawler.views.tables import print_table

    found = spread_into(folder, starts, laws=laws, overwrite=overwrite, say=typer.echo)
    print_table(found.by_shoe(), f"{folder}: highest stresses of the repeated runs at the first one's node")
    typer.echo(f"runs, tables of hot spots and verdicts of all nodes are in {folder / 'spread'}")
