"""The track over uneven ground: a step, a ramp or random roughness.

No paper reports it; the rigid track of the papers goes straight over ground whose units have different
heights, with the second contact model.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Unpack

from exudyn_crawler import Case, CaseFile, CaseRun, SphereContact, Terrain
from studies.defaults import DURATION
from studies.running import Running, kept_study

STEP_PLACE, STEP_HEIGHT = 14.0, 0.1
"""m: below the middle of the track at t = 0; height."""
RAMP_START, RAMP_END, RAMP_HEIGHT = 8.0, 20.0, 0.6
"""m: 5 % over the whole track."""
ROUGHNESS, SEED = 0.02, 1
"""m, standard deviation of the units' heights; seed of the generator."""


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


def study(
    out: Path | None = None,
    grounds: Sequence[str] = tuple(GROUNDS),
    *,
    duration: float = DURATION,
    **how: Unpack[Running],
) -> dict[str, CaseRun]:
    """Run the track over some of the grounds; each run's figure `ground` shows its end.

    Parameters
    ----------
    out : Path, optional
        Folder of the study: a folder a ground; None writes nothing.
    grounds : sequence of str
        Of "step", "ramp" and "rough".
    duration : float
        s.
    **how
        Options `overwrite`, `progress` and `say` of `run_case`.

    Returns
    -------
    dict
        Runs by ground.

    Raises
    ------
    ValueError
        Before anything runs, for an unknown ground or a bad duration.
    FileExistsError, BlockingIOError
        Before a run, if results are there and `overwrite` is false, or another run works there.
    EquilibriumError, SimulationStopped
        As of `run_case`.
    """
    files = {ground: CaseFile(case=uneven_case(ground), duration=duration) for ground in grounds}
    with kept_study(out, files, **how) as (runs, _):
        return runs


if __name__ == "__main__":
    from exudyn_crawler.cli import run_script

    run_script("studies.commands:uneven")
