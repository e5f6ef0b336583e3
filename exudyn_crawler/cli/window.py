"""Command that opens the page to work in."""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.cli import application
from exudyn_crawler.cli.commands import command


@command("exudyn-crawler app machines")
def app(
    folder: Annotated[Path, typer.Argument(help="folder of case files and results")] = Path(),
    port: Annotated[
        int | None, typer.Option(help="port of the address; default: a free one", min=1024, max=65535)
    ] = None,
    show: Annotated[bool, typer.Option("--browser/--no-browser", help="open the page in the browser")] = True,
) -> None:
    """Open a page to work in: assemble a machine, run it, see its results; on this computer alone."""
    if find_spec("nicegui") is None:
        raise ValueError(application.needs("the page to work in", ["nicegui"], "app"))
    from exudyn_crawler.files import writable_folder
    from exudyn_crawler.run.folder.queue import Runs

    home = writable_folder(folder).resolve()

    def say(address: str) -> None:
        typer.echo(
            f"{address}\nopen it in a browser on this computer; Ctrl-C ends the page, started runs go on"
        )

    try:
        with Runs(home).held():
            # the modules of the page take seconds to load
            from exudyn_crawler.app.page import build
            from exudyn_crawler.app.serving import serve

            serve(home, build(home), port, show, say)
    except KeyboardInterrupt:
        typer.echo("the page has ended; started runs go on")
