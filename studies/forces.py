"""Contact, friction and joint forces, sinkage and terrain deformation of the P&H 4100C track.

Reproduces the figures and tables of S. Frimpong and M. Thiruvengadam, "Contact and Joint Forces Modeling
and Simulation of Crawler-formation Interactions" (F-paper).
"""

from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.comparison import summary
from exudyn_crawler.tables import print_table
from exudyn_crawler.workflows.forces import lateral_effects, run_forces
from exudyn_crawler.workflows.runs import CASES, DURATION
from exudyn_crawler.workflows.script import readable_errors
from studies.kinematics import CaseChoice

KINEMATICS = Path("results/kinematics")


def main(
    case: Annotated[CaseChoice, typer.Option(help="what to study")] = CaseChoice.both,
    duration: Annotated[float, typer.Option(help="simulated time in s")] = DURATION,
    out: Annotated[Path, typer.Option(help="folder for the results")] = Path("results/forces"),
    reuse: Annotated[
        Path | None,
        typer.Option(help=f"folder with histories to reuse; {KINEMATICS} where they fit, if not given"),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace earlier results")] = False,
    lateral: Annotated[
        bool, typer.Option("--lateral", help="show instead what moves a straight track sideways")
    ] = False,
) -> None:
    """Run the forces study and compare it with the paper.

    Example: python -m studies.forces --case translation --out results/straight
    """
    with readable_errors():
        if lateral:
            print_table(lateral_effects(duration), "Lateral motion: paper, and computed for some causes")
            return
        cases = tuple(CASES) if case is CaseChoice.both else (case.value,)
        folder, strict = (KINEMATICS, False) if reuse is None else (reuse, True)
        _, table = run_forces(cases, duration, out, folder, strict, overwrite, say=typer.echo)
    print_table(table, "Forces: paper against computed")
    print_table(summary(table).reset_index(), "Rows within their class")
    typer.echo(f"results, figures, comparison.csv and turning_ratios.csv are in {out}")


if __name__ == "__main__":
    typer.run(main)
