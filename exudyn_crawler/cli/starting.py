"""The commands that a newcomer begins with, and those that hand a case to editors and other programs."""

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

import exudyn_crawler as crawler
from exudyn_crawler.cli import application
from exudyn_crawler.cli.application import RESULTS, Changes, Out, Overwrite
from exudyn_crawler.cli.commands import command, show_answers

DEMO = "demo"


@command
def demo(
    out: Out = RESULTS / DEMO,
    prepare: bool = typer.Option(
        False, "--prepare", help="only compile and reduce, as the installation does"
    ),
    overwrite: Overwrite = False,
) -> None:
    """Roll a machine over a track with a flexible shoe, and make a page to look at.

    Example: exudyn-crawler demo
    """
    case_file = application.study_case(DEMO)
    if prepare:
        _prepare(case_file)
        return
    case = case_file.case
    typer.echo(
        f"a machine rolls over {case.track.shoe_count} shoes, one of them flexible, for "
        f"{case_file.duration:g} s: this takes about 20 s, and the first time on a machine two minutes"
    )
    done = crawler.run_case(case_file, out, overwrite=overwrite, take_finished=True, say=typer.echo)
    show_answers(done)
    typer.echo(f"{out / 'report.html'}: open it in a browser")
    typer.echo(f"next, a machine of your own: exudyn-crawler init my_machine --study {DEMO}")


@command
def schema(
    out: Annotated[Path, typer.Argument(help="file to write", metavar="FILE")] = Path("case.schema.json"),
    overwrite: Overwrite = False,
) -> None:
    """Write the JSON schema of case files, by which editors complete and check them.

    Example: exudyn-crawler schema
    """
    from exudyn_crawler.case.files import case_schema
    from exudyn_crawler.files import whole_file

    with whole_file(out, overwrite) as temporary:
        temporary.write_text(json.dumps(case_schema(), indent=1) + "\n", encoding="utf-8")
    typer.echo(f"{out}: begin a case file beside it with the line '#:schema {out.name}'")


@command
def fmu(
    case: Annotated[Path, typer.Argument(help="case file of a machine on its track", metavar="CASE.toml")],
    changes: Changes = None,
    out: Annotated[Path | None, typer.Option(help="file to write; CASE.fmu, if not given")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a case as a unit of co-simulation (FMU, FMI 2.0) that other programs step.

    Example: exudyn-crawler fmu mine.toml
    """
    if find_spec("pythonfmu") is None:
        raise ValueError("units of co-simulation need pythonfmu: pip install 'exudyn-crawler[fmu]'")
    case_file = crawler.read_case(case, changes or ())
    from exudyn_crawler.co_simulation import write_fmu

    written = write_fmu(case_file, out or case.with_suffix(".fmu"), overwrite)
    typer.echo(f"{written}: in speed, force and moment; out motion of the frame, forces of pins and ground")


def _prepare(case_file: "crawler.CaseFile") -> None:
    """Compile what runs need, and reduce the demo's shoe; both stay on this machine."""
    from exudyn_crawler.model.formulation import compile_equations

    typer.echo(
        "compiling the equations of motion and reducing a shoe, once on this machine: about two minutes"
    )
    compile_equations("dragged")
    crawler.run_case(case_file.with_({"duration": 0.02}), progress=False)
