"""Kinematics of the P&H 4100C crawler track on oil sand, straight and turning.

Reproduces the figures and tables of S. Frimpong and M. Thiruvengadam, "Multi-Body Kinematics Simulation
Modeling and Analysis of Shovel Crawler Performance in Rugged Surface Mining Terrains" (K-chapter) and
"Multi-Body Dynamic Modeling and Simulation of Crawler-Formation Interactions in Surface Mining
Operations - Crawler Kinematics" (K-paper).
"""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.comparison import summary
from exudyn_crawler.tables import print_table
from exudyn_crawler.workflows.kinematics import run_kinematics
from exudyn_crawler.workflows.runs import CASES, DURATION
from exudyn_crawler.workflows.script import readable_errors


class CaseChoice(StrEnum):
    """Cases that can be run."""

    translation = "translation"
    turning = "turning"
    both = "both"


def main(
    case: Annotated[CaseChoice, typer.Option(help="what to run")] = CaseChoice.both,
    duration: Annotated[float, typer.Option(help="simulated time in s")] = DURATION,
    out: Annotated[Path, typer.Option(help="folder for the results")] = Path("results/kinematics"),
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace earlier results")] = False,
) -> None:
    """Run the kinematics study and compare it with the papers.

    Example: python -m studies.kinematics --case translation --duration 2 --out results/short
    """
    cases = tuple(CASES) if case is CaseChoice.both else (case.value,)
    with readable_errors():
        _, table = run_kinematics(cases, duration, out, overwrite)
    print_table(table, "Kinematics: paper against computed")
    print_table(summary(table).reset_index(), "Rows within their class")
    typer.echo(f"results, figures and comparison.csv are in {out}")


if __name__ == "__main__":
    typer.run(main)
