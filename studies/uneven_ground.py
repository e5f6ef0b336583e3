"""The crawler track on ground whose units have different heights: a step, a ramp, a random roughness.

The papers' ground is even and their contact law presumes it; here the second contact model runs, with
spheres under the shoes (docs/general_contact.md).
"""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from exudyn_crawler.workflows.script import readable_errors
from exudyn_crawler.workflows.uneven_ground import DURATION, run_uneven_ground


class GroundChoice(StrEnum):
    """Grounds that can be run."""

    step = "step"
    ramp = "ramp"
    rough = "rough"


def main(
    ground: Annotated[GroundChoice, typer.Argument(help="ground to run over")] = GroundChoice.step,
    duration: Annotated[float, typer.Option(help="simulated time in s")] = DURATION,
    out: Annotated[Path | None, typer.Option(help="folder for the results [results/uneven_GROUND]")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace earlier results")] = False,
) -> None:
    """Run the track over uneven ground; keep the history and a figure of its end.

    Example: python -m studies.uneven_ground ramp --duration 2
    """
    out = Path(f"results/uneven_{ground.value}") if out is None else out
    with readable_errors():
        run_uneven_ground(ground.value, duration, out, overwrite)
    typer.echo(f"history and figure are in {out}")


if __name__ == "__main__":
    typer.run(main)
