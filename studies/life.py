"""Life of the P&H 4100C's shoes in machine hours, from the stress study's propel and loading cycle.

Field observation (S-paper, section 6): shoes crack in the roller path, their lugs stay whole. The papers drag
the chain, so that their load case shows the cracks of a dragged shoe. It is compared with the rollers study,
if there is one.
"""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from exudyn_crawler import Duty, FatigueMaterial, History, life
from exudyn_crawler.results.life.duty import DutyRun, read_duty
from exudyn_crawler.results.life.life import in_words
from exudyn_crawler.run.folder.record import HISTORY
from exudyn_crawler.views.tables import write_table
from studies.rollers import overhang_cases
from studies.running import by_name
from studies.stress import RUN, study as stress_study

PROPEL = "propel"  # phase of the stress study's cycle with a pulled track, and its run in the duty
PROPEL_SHARE = 0.07  # greatest fraction of machine hours (makers' figures for rope shovels)
CYCLES_AN_HOUR = 70.0  # dig cycles: 60 to 90 per full hour at 40 to 60 s each; assumed in that range
CHANGES_AN_HOUR = 4.0
"""Moves between digging positions per hour, each about a minute of the run's repeated 15 s; assumed."""
MATERIALS = (FatigueMaterial.cast_nicrmo, FatigueMaterial.cast_manganese, FatigueMaterial.a36)
"""Materials of shoes, the usual one first."""


def digging_duty(kind: str, propel: Path, dig: Path, material: FatigueMaterial) -> Duty:
    """Return the duty of a digging shovel: runs of propel and dig cycle, or of both in one run."""
    end = None
    if propel == dig:
        loads = History.load(propel / HISTORY).case.loads
        end = next(phase.end for phase in loads.phases if phase.name == PROPEL)
    runs = (
        DutyRun(name=f"{kind} propel", folder=str(propel), end=end, share=PROPEL_SHARE),
        DutyRun(name="dig cycle", folder=str(dig), begin=end or 0.0, an_hour=CYCLES_AN_HOUR),
    )
    name = f"{kind} propel and dig cycle, {material.name}"
    return Duty(name=name, runs=runs, material=material, changes_an_hour=CHANGES_AN_HOUR)


def overhang_duty(rollers: Path, material: FatigueMaterial) -> Duty:
    """Return the duty of `rolled_duty.toml`: shoes with overhanging rails that wear, runs in a folder."""
    duty = read_duty(Path(__file__).with_name("rolled_duty.toml"))
    runs = tuple(run.with_(folder=str(rollers / Path(run.folder).name)) for run in duty.runs)
    return duty.with_(name=f"rails that overhang, {material.name}", runs=runs, material=material)


def study(
    out: Path,
    stress: Path,
    rollers: Path | None = None,
    *,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _text: None,
) -> tuple[dict[str, pd.DataFrame], pd.DataFrame]:
    """Find the shoes' shortest lives for each material, by folder; tabulate the shortest and their causes.

    `stress` and `rollers` are the folders of these studies; the stress study runs if it is missing. `out`
    gets a folder per kind of propel and material, and `summary.csv`. See `life` for other arguments and
    errors.
    """
    if not (stress / RUN / HISTORY).is_file():
        stress_study(stress, say=say)
    cycle = stress / RUN
    duties = {
        f"dragged_{material.__name__}": digging_duty("dragged", cycle, cycle, material())
        for material in MATERIALS
    }
    if rollers is not None:
        kinds = "rolled", rollers / "pass", rollers / "loading"
        duties |= {f"rolled_{material.__name__}": digging_duty(*kinds, material()) for material in MATERIALS}
        if all((rollers / name / HISTORY).is_file() for name in overhang_cases()):
            duties |= {
                f"overhang_{material.__name__}": overhang_duty(rollers, material()) for material in MATERIALS
            }
    tables: dict[str, pd.DataFrame] = {}
    for name, duty in duties.items():
        say(f"{name}: {duty.name}")
        # histories and modes of nine lives would take 5 GB
        tables[name] = life(duty, out / name, overwrite=overwrite, say=say).table
    shortest = {name: table.head(1) for name, table in tables.items()}
    summary = in_words(by_name("propel_and_material", shortest))
    write_table(summary, out / "summary.csv", overwrite)
    return tables, summary
