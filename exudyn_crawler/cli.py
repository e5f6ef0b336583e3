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

from exudyn_crawler.workflows.defaults import DURATION, RESULTS
from exudyn_crawler.workflows.script import BAD_INPUT, readable_errors

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


class StudyChoice(StrEnum):
    """Studies whose case can be written as a file."""

    kinematics = "kinematics"
    forces = "forces"
    stress = "stress"


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
    from exudyn_crawler.comparison import summary
    from exudyn_crawler.tables import print_table
    from exudyn_crawler.workflows.kinematics import run_kinematics

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
    from exudyn_crawler.comparison import summary
    from exudyn_crawler.tables import print_table
    from exudyn_crawler.workflows.forces import lateral_effects, run_forces

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
def verify(debug: Debug = False) -> None:
    """Solve the two-body problem by hand and by the engine, side by side.

    Example: exudyn-crawler verify
    """
    from exudyn_crawler.parameters import ContactLaw
    from exudyn_crawler.tables import print_table
    from exudyn_crawler.verification import (
        compare_verification,
        compare_with_paper,
        engine_solution,
        hand_solution,
    )

    law = ContactLaw.oil_sand()
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
    from exudyn_crawler.workflows.starts import study_case_file

    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    written = study_case_file(study.value, path.stem).write(path, overwrite)
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
    from exudyn_crawler.case_files import CaseFile

    case_file = CaseFile.read(case)
    out = RESULTS / case.stem if out is None else out

    from exudyn_crawler.workflows.single import run_case

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
    from exudyn_crawler.case_files import CaseFile
    from exudyn_crawler.case_text import case_table
    from exudyn_crawler.tables import print_table
    from exudyn_crawler.workflows.starts import study_case_file

    known = case in [study.value for study in StudyChoice]
    case_file = study_case_file(case) if known else CaseFile.read(case)
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
