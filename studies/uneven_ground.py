"""Uneven-ground study: the track over a step, a ramp or random roughness, with the second contact model."""

from collections.abc import Callable
from pathlib import Path

from exudyn_crawler.case import Case, SphereContact, Terrain
from exudyn_crawler.case.files import CaseFile
from exudyn_crawler.results.history import History
from exudyn_crawler.run.folder import kept_run
from exudyn_crawler.runs import saved_run
from exudyn_crawler.views.curves import save_figure
from exudyn_crawler.views.ground_figures import ground_figure

STEP_PLACE, STEP_HEIGHT = 14.0, 0.1
"""m: below the middle of the track at t = 0; height."""
RAMP_START, RAMP_END, RAMP_HEIGHT = 8.0, 20.0, 0.6
"""m: 5 % over the whole track."""
ROUGHNESS, SEED = 0.02, 1
"""m, standard deviation of the units' heights; seed of the generator."""
DURATION = 10.0
"""s, in which the track travels 0.75 m: every shoe passes a unit's edge or stands where its neighbour was."""


def strip() -> Terrain:
    """One row of 13 units below the track, 1 m long and 5 m wide, for ground that changes along it.

    Density, height, stiffness per area and tilt stiffness are those of the S-paper's units of 1 x 1 m.
    """
    width = 5.0
    square = Terrain.stress()
    return square.with_(
        columns=13,
        rows=1,
        unit_width=width,
        spring_stiffness=width * square.spring_stiffness,
        spring_damping=width * square.spring_damping,
        origin=(8.0, 6.8),
    )


GROUNDS: dict[str, Callable[[], Terrain]] = {
    "step": lambda: strip().with_step(STEP_PLACE, STEP_HEIGHT),
    "ramp": lambda: strip().with_ramp(RAMP_START, RAMP_END, RAMP_HEIGHT),
    "rough": lambda: strip().with_roughness(ROUGHNESS, SEED),
}
"""Terrains of the study by name."""


def uneven_case(ground: str) -> Case:
    """Straight propel over one of the grounds, whose faces are drawn back from the units' seams.

    Seams of units 1 m long lie under most shoes: whole faces would make the ground stiffer there and lift
    the shoes by what is not in its heights.

    Raises
    ------
    ValueError
        For an unknown ground.
    """
    if ground not in GROUNDS:
        raise ValueError(f"ground must be of {list(GROUNDS)}, got {ground!r}")
    spheres = SphereContact.oil_sand().with_(faces="drawn_back")
    return Case.translation().with_(name=ground, terrain=GROUNDS[ground](), contact=spheres)


def run_uneven_ground(
    ground: str,
    duration: float = DURATION,
    out: Path | None = None,
    overwrite: bool = False,
    progress: bool | None = None,
) -> History:
    """Run the track over one of the grounds.

    Parameters
    ----------
    ground : str
        "step", "ramp" or "rough".
    duration : float
        s.
    out : Path, optional
        Folder for the history and a figure of its end; None writes nothing.
    overwrite : bool
        Replace files of an earlier run.

    Raises
    ------
    ValueError
        For an unknown ground or a bad duration.
    FileExistsError, BlockingIOError
        Before anything runs, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError, SimulationStopped
        As of `simulate`.
    """
    case = uneven_case(ground)
    with kept_run(out, {ground: CaseFile(case=case, duration=duration)}, overwrite) as keeper:
        with keeper.timed("simulate"):
            history = saved_run(case, duration, out, overwrite, progress)
        if out is not None:
            save_figure(ground_figure(history, duration), out / f"{ground}_ground.png", overwrite)
    return history


if __name__ == "__main__":
    from exudyn_crawler.cli import run_script, uneven

    run_script(uneven)
