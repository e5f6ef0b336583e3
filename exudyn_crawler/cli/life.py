"""The command that gives life in machine hours from the folders of runs."""

from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.cli.errors import readable
from exudyn_crawler.cli.looking import app
from exudyn_crawler.cli.options import RESULTS, Debug, Overwrite

__all__ = ["app"]


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

    given = read_duty(duty)  # refused before all that counts and draws is loaded
    from exudyn_crawler.life_run import life as life_into
    from exudyn_crawler.results.life.life_table import in_words
    from exudyn_crawler.views.tables import print_table

    folder = RESULTS / duty.stem if out is None else out
    found = life_into(given, folder, overwrite=overwrite, say=typer.echo)
    shown = found.table.loc[:, :"main load"].drop(columns=[f"{axis} in the shoe in m" for axis in "xyz"])
    print_table(in_words(shown), f"{given.name}: shortest lives by region")
    typer.echo(f"life, tables, fields and page (life.html) are in {folder}")
