"""Stresses of the flexible shoes of the P&H 4100C track over propel and a loading cycle.

Reproduces the figures and tables of S. Frimpong and M. Thiruvengadam, "Multibody Dynamic Stress Simulation
of Rigid-Flexible Shovel Crawler Shoes", Minerals 2016, 6(3), 61 (S-paper).
"""

from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler import Case, LoadCycle
from exudyn_crawler.comparison import summary
from exudyn_crawler.stress_comparison import stress_summary
from exudyn_crawler.tables import print_table
from exudyn_crawler.workflows.script import readable_errors
from exudyn_crawler.workflows.stress import DURATION, open_choices, run_stress


def main(
    duration: Annotated[float, typer.Option(help="simulated time in s")] = DURATION,
    mesh: Annotated[str, typer.Option(help="coarse, study or fine, or the path of a mesh")] = "study",
    modes: Annotated[
        str | None,
        typer.Option(
            help='modes that answer dynamically: all, 1200Hz (and below), 1-20,25 (by number) or "10 fixed"; '
            "the others follow without inertia"
        ),
    ] = None,
    cycle: Annotated[Path | None, typer.Option(help="TOML file of an own load cycle")] = None,
    out: Annotated[Path, typer.Option(help="folder for the results")] = Path("results/stress"),
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace earlier results")] = False,
    choices: Annotated[
        bool, typer.Option("--choices", help="show instead what the study's open choices do")
    ] = False,
) -> None:
    """Run the stress study and compare it with the paper; a study that was killed goes on.

    Example: python -m studies.stress --duration 8 --mesh coarse --out results/short
    """
    with readable_errors():
        if choices:
            print_table(open_choices(min(duration, 8.0), mesh), "Paper, and computed for some choices")
            return
        case = Case.stress(mesh)
        assert case.flexible is not None
        if modes is not None:
            case = case.with_(flexible=case.flexible.with_modes(modes))
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


if __name__ == "__main__":
    typer.run(main)
