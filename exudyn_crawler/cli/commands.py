"""The commands that need no study.

Nothing heavy is imported before a command needs it, so that help comes at once.
"""

from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.cli.errors import readable
from exudyn_crawler.cli.options import RESULTS, Debug, Overwrite
from exudyn_crawler.cli.registered import CASES, Commands, registered, study_case

START = "kinematics"
"""Study whose case `init` starts from where none is named."""

app = typer.Typer(
    cls=Commands,
    help="Simulator of the crawler tracks of mining shovels.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


@app.command()
@readable
def init(
    name: Annotated[str, typer.Argument(help="name of the case; the file is NAME.toml", metavar="NAME")],
    study: Annotated[str, typer.Option(help="study whose case to start from, such as stress")] = START,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing file")] = False,
    debug: Debug = False,
) -> None:
    """Write a case file with every value, its unit and its meaning, to be changed and run.

    Example: exudyn-crawler init soft_ground --study kinematics
    """
    from exudyn_crawler.case.files import write_case

    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    case_file = study_case(study)
    own = case_file.with_(case=case_file.case.with_(name=path.stem))
    written = write_case(own, path, overwrite)
    typer.echo(f"{written}: change it, then: exudyn-crawler run {written}")


@app.command()
@readable
def info(
    case: Annotated[
        str, typer.Argument(help="case file, or name of a study", metavar="[CASE.toml|STUDY]")
    ] = START,
    debug: Debug = False,
) -> None:
    """Show a case with everything filled in: every value with its unit and meaning.

    Example: exudyn-crawler info soft_ground.toml
    """
    from exudyn_crawler.case.files import read_case
    from exudyn_crawler.case.text import case_table
    from exudyn_crawler.views.tables import print_table

    case_file = study_case(case) if case in registered(CASES) else read_case(case)
    print_table(case_table(case_file), case)


@app.command()
@readable
def run(
    case: Annotated[Path, typer.Argument(help="case file", metavar="CASE.toml")],
    out: Annotated[Path | None, typer.Option(help=f"folder of the run; {RESULTS}/CASE, if not given")] = None,
    reuse: Annotated[
        Path | None, typer.Option(help="folder whose history takes the place of the simulation")
    ] = None,
    overwrite: Overwrite = False,
    debug: Debug = False,
) -> None:
    """Run a case file into a folder of its own.

    Example: exudyn-crawler run soft_ground.toml --out results/soft_ground
    """
    from exudyn_crawler.case.files import read_case

    case_file = read_case(case)  # refused before the engine is loaded, which takes a second
    from exudyn_crawler.case_run import run_case

    out = RESULTS / case.stem if out is None else out
    history = run_case(case_file, out, overwrite=overwrite, reuse=reuse, say=typer.echo).history
    typer.echo(f"{case_file.case.name}: {history.duration:g} s; case, log, results and figures are in {out}")


@app.command()
@readable
def report(
    folder: Annotated[Path, typer.Argument(help="folder of a run or a study", metavar="RUN")],
    out: Annotated[Path | None, typer.Option(help="file to write; RUN/report.html, if not given")] = None,
    overwrite: Overwrite = False,
    debug: Debug = False,
) -> None:
    """Make one self-contained page of a run, to be read offline in a browser.

    Example: exudyn-crawler report results/stress
    """
    from exudyn_crawler.run.folder import note_file
    from exudyn_crawler.views.report.page import write_report

    page = write_report(folder, out, overwrite, typer.echo)
    note_file(page)
    typer.echo(f"{page}: open it in a browser")


@app.command()
@readable
def animate(
    history: Annotated[Path, typer.Argument(help="history of a run (NetCDF)", metavar="HISTORY.nc")],
    out: Annotated[
        Path | None, typer.Option(help=".mp4 or .gif file to write; HISTORY.mp4, if not given")
    ] = None,
    scale: Annotated[
        float | None, typer.Option(help="magnification of the ground's displacements; fitting, if not given")
    ] = None,
    start: Annotated[float, typer.Option(help="s, first time shown")] = 0.0,
    end: Annotated[float | None, typer.Option(help="s, last time shown; the run's end, if not given")] = None,
    overwrite: Overwrite = False,
    debug: Debug = False,
) -> None:
    """Animate the track on the deforming terrain, without a display.

    Example: exudyn-crawler animate results/kinematics/translation/history.nc --end 5
    """
    from exudyn_crawler.results.history import History
    from exudyn_crawler.run.folder import note_file
    from exudyn_crawler.views.animation import write_animation

    path = history.with_suffix(".mp4") if out is None else out
    write_animation(History.load(history), path, overwrite, scale, start=start, end=end)
    note_file(path)
    typer.echo(path)
