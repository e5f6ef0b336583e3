"""The command `exudyn-crawler`; the scripts in `studies/` run the same functions.

Nothing heavy is imported before a command needs it, so that help comes at once.
"""

import sys
from collections.abc import Callable
from enum import StrEnum
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from exudyn_crawler.script import BAD_INPUT, readable_errors
from studies.defaults import CYCLE_DURATION, DURATION, RESULTS

app = typer.Typer(
    help="Simulator of the crawler tracks of mining shovels.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


class CaseChoice(StrEnum):
    """Cases of the rigid studies."""

    translation = "translation"
    turning = "turning"
    both = "both"


class GroundChoice(StrEnum):
    """Uneven grounds that can be run over."""

    step = "step"
    ramp = "ramp"
    rough = "rough"


class StudyChoice(StrEnum):
    """Studies whose case can be written as a file."""

    kinematics = "kinematics"
    forces = "forces"
    stress = "stress"
    uneven = "uneven"


Chosen = Annotated[CaseChoice, typer.Option(help="what to run")]
Duration = Annotated[float, typer.Option(help="simulated time in s")]
Out = Annotated[Path, typer.Option(help="folder for the results")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace earlier results")]
Debug = Annotated[bool, typer.Option("--debug", help="show the traceback of an error")]


def _names(case: CaseChoice) -> tuple[str, ...]:
    everyone = (CaseChoice.translation, CaseChoice.turning)
    return tuple(one.value for one in everyone if case in (one, CaseChoice.both))


def readable(function: Callable[..., None]) -> Callable[..., None]:
    """Give a command's errors in a line each, with its option `debug` for the traceback."""

    @wraps(function)
    def told(*args: Any, **options: Any) -> None:
        with readable_errors(options.get("debug", False)):
            function(*args, **options)

    return told


@app.command()
@readable
def kinematics(
    case: Chosen = CaseChoice.both,
    duration: Duration = DURATION,
    out: Out = RESULTS / "kinematics",
    overwrite: Overwrite = False,
    debug: Debug = False,
) -> None:
    """Run the kinematics study and compare it with the papers.

    Example: exudyn-crawler kinematics --case translation --duration 2 --out results/short
    """
    from exudyn_crawler.views.tables import print_table
    from studies.comparison import summary
    from studies.kinematics import run_kinematics

    _, table = run_kinematics(_names(case), duration, out, overwrite, say=typer.echo)
    print_table(table, "Kinematics: paper against computed")
    print_table(summary(table).reset_index(), "Rows within their class")
    typer.echo(f"results, figures and comparison.csv are in {out}")


@app.command()
@readable
def forces(
    case: Chosen = CaseChoice.both,
    duration: Duration = DURATION,
    out: Out = RESULTS / "forces",
    reuse: Annotated[
        Path | None,
        typer.Option(
            help=f"folder with histories to reuse; {RESULTS / 'kinematics'} where they fit, if not given"
        ),
    ] = None,
    overwrite: Overwrite = False,
    lateral: Annotated[
        bool, typer.Option("--lateral", help="show instead what moves a straight track sideways")
    ] = False,
    debug: Debug = False,
) -> None:
    """Run the forces study and compare it with the paper.

    Example: exudyn-crawler forces --case translation --out results/straight
    """
    from exudyn_crawler.views.tables import print_table
    from studies.comparison import summary
    from studies.forces import lateral_effects, run_forces

    if lateral:
        print_table(lateral_effects(duration), "Lateral motion: paper, and computed for some causes")
        return
    folder, strict = (RESULTS / "kinematics", False) if reuse is None else (reuse, True)
    _, table = run_forces(_names(case), duration, out, folder, strict, overwrite, say=typer.echo)
    print_table(table, "Forces: paper against computed")
    print_table(summary(table).reset_index(), "Rows within their class")
    typer.echo(f"results, figures, comparison.csv and turning_ratios.csv are in {out}")


@app.command()
@readable
def stress(
    duration: Duration = CYCLE_DURATION,
    mesh: Annotated[str, typer.Option(help="coarse, study or fine, or the path of a mesh")] = "study",
    modes: Annotated[
        str | None,
        typer.Option(
            help='modes that answer dynamically: all, 1200Hz (and below), 1-20,25 (by number) or "10 fixed"; '
            "the others follow without inertia"
        ),
    ] = None,
    cycle: Annotated[Path | None, typer.Option(help="TOML file of an own load cycle")] = None,
    out: Out = RESULTS / "stress",
    overwrite: Overwrite = False,
    choices: Annotated[
        bool, typer.Option("--choices", help="show instead what the study's open choices do, over 8 s")
    ] = False,
    debug: Debug = False,
) -> None:
    """Run the stress study and compare it with the paper; a study that was killed goes on.

    Example: exudyn-crawler stress --duration 8 --mesh coarse --out results/short
    """
    from exudyn_crawler.case import Case, LoadCycle
    from exudyn_crawler.views.tables import print_table
    from studies.comparison import summary
    from studies.stress import open_choices, run_stress
    from studies.stress_comparison import stress_summary

    if choices:
        print_table(open_choices(min(duration, 8.0), mesh), "Paper, and computed for some choices")
        return
    case = Case.stress(mesh)
    if modes is not None:
        case = case.with_(flexible=case.flexible_shoes().with_modes(modes))
    if cycle is not None:
        case = case.with_(loads=LoadCycle.from_toml(cycle))
    print_table(case.loads.table(), "Loads on the shoes at the ends of the phases, kN")
    history, results, table = run_stress(case, duration, out, overwrite, say=typer.echo)
    for shoe, hot_spots in results.hot_spots.items():
        print_table(hot_spots, f"Shoe {shoe}: highest von Mises stresses (Pa; places in m at t = 0)")
    print_table(stress_summary(history, results), "Highest von Mises stress, MPa")
    print_table(table, "Stress: paper against computed")
    print_table(summary(table).reset_index(), "Rows within their class")
    typer.echo(f"results, figures and tables are in {out}")


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

    page = write_report(folder, out, overwrite)
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

    Example: exudyn-crawler animate results/kinematics/translation.nc --end 5
    """
    from exudyn_crawler.results.history import History
    from exudyn_crawler.run.folder import note_file
    from exudyn_crawler.views.animation import write_animation

    path = history.with_suffix(".mp4") if out is None else out
    write_animation(History.load(history), path, overwrite, scale, start=start, end=end)
    note_file(path)
    typer.echo(path)


@app.command()
@readable
def uneven(
    ground: Annotated[GroundChoice, typer.Argument(help="ground to run over")] = GroundChoice.step,
    duration: Duration = DURATION,
    out: Annotated[
        Path | None, typer.Option(help=f"folder for the results; {RESULTS}/uneven_GROUND, if not given")
    ] = None,
    overwrite: Overwrite = False,
    debug: Debug = False,
) -> None:
    """Run the track over uneven ground; keep the history and a figure of its end.

    Example: exudyn-crawler uneven ramp --duration 2
    """
    from studies.uneven_ground import run_uneven_ground

    out = RESULTS / f"uneven_{ground.value}" if out is None else out
    run_uneven_ground(ground.value, duration, out, overwrite)
    typer.echo(f"history and figure are in {out}")


@app.command()
@readable
def verify(debug: Debug = False) -> None:
    """Solve the two-body problem by hand and by the engine, side by side.

    Example: exudyn-crawler verify
    """
    from exudyn_crawler.case import PairContact
    from exudyn_crawler.views.tables import print_table
    from studies.two_bodies import (
        compare_verification,
        compare_with_paper,
        engine_solution,
        hand_solution,
    )

    law = PairContact.oil_sand()
    engine = engine_solution(law)
    print_table(compare_verification(hand_solution(law), engine), "Two-body problem at t = 0.5 s")
    print_table(compare_with_paper(engine), "Paper against computed")


@app.command()
@readable
def init(
    name: Annotated[str, typer.Argument(help="name of the case; the file is NAME.toml", metavar="NAME")],
    study: Annotated[StudyChoice, typer.Option(help="study whose case to start from")] = (
        StudyChoice.kinematics
    ),
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing file")] = False,
    debug: Debug = False,
) -> None:
    """Write a case file with every value, its unit and its meaning, to be changed and run.

    Example: exudyn-crawler init soft_ground --study kinematics
    """
    from exudyn_crawler.case import write_case
    from studies.starts import study_case_file

    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    written = write_case(study_case_file(study.value, path.stem), path, overwrite)
    typer.echo(f"{written}: change it, then: exudyn-crawler run {written}")


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
    from exudyn_crawler.case import read_case

    case_file = read_case(case)
    out = RESULTS / case.stem if out is None else out

    from exudyn_crawler.run_case import run_case

    history = run_case(case_file, out, overwrite, reuse, say=typer.echo)
    typer.echo(f"{case_file.case.name}: {history.duration:g} s; case, log, results and figures are in {out}")


@app.command()
@readable
def info(
    case: Annotated[
        str, typer.Argument(help="case file, or name of a study", metavar="[CASE.toml|STUDY]")
    ] = StudyChoice.kinematics.value,
    debug: Debug = False,
) -> None:
    """Show a case with everything filled in: every value with its unit and meaning.

    Example: exudyn-crawler info soft_ground.toml
    """
    from exudyn_crawler.case import read_case
    from exudyn_crawler.case.text import case_table
    from exudyn_crawler.views.tables import print_table
    from studies.starts import study_case_file

    known = case in [study.value for study in StudyChoice]
    case_file = study_case_file(case) if known else read_case(case)
    print_table(case_table(case_file), case)


def run_script(command: Callable[..., None]) -> None:
    """Run one command as a script of its own, with its arguments and exit codes."""
    single = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    single.command()(command)
    _call(single)


def main() -> None:
    """Entry point of `exudyn-crawler`."""
    _call(app)


def _call(commands: typer.Typer) -> None:
    """Call a command line; what is wrong with its words is told in one line, as all errors are."""
    try:
        sys.exit(commands(standalone_mode=False) or 0)
    except typer.Abort:
        sys.exit(BAD_INPUT)
    except Exception as error:
        # Typer's errors have no public class that all its versions share
        told = getattr(error, "format_message", None)
        if told is None:
            raise
        text = told()
        if text:
            print(f"error: {' '.join(text.split())}; --help shows what is allowed", file=sys.stderr)
        sys.exit(BAD_INPUT)


if __name__ == "__main__":
    main()
