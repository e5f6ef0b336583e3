"""The commands that a newcomer begins with: a demo that runs as it is."""

import typer

import exudyn_crawler as crawler
from exudyn_crawler.cli import application
from exudyn_crawler.cli.application import RESULTS, Out, Overwrite
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


def _prepare(case_file: "crawler.CaseFile") -> None:
    """Compile what runs need, and reduce the demo's shoe; both stay on this machine."""
    from exudyn_crawler.model.formulation import compile_equations

    typer.echo(
        "compiling the equations of motion and reducing a shoe, once on this machine: about two minutes"
    )
    compile_equations("dragged")
    crawler.run_case(case_file.with_({"duration": 0.02}), progress=False)
