"""Case files that a user can start from: what the studies run."""

from collections.abc import Callable

from exudyn_crawler.case_files import CaseFile
from exudyn_crawler.parameters import Case, Drive, FlexibleShoes, LoadCycle, Terrain
from exudyn_crawler.workflows.defaults import DURATION

CYCLE_DURATION = 40.0
"""s, propel and one loading cycle of the S-paper."""


def _stress_case() -> Case:
    """Propel and loading cycle of the S-paper, with six flexible shoes."""
    return Case.translation().with_(
        name="stress",
        terrain=Terrain.stress(),
        drive=Drive.propel_and_load(),
        loads=LoadCycle.shovel_cycle(),
        flexible=FlexibleShoes.ph4100c(),
    )


STARTS: dict[str, tuple[Callable[[], Case], float]] = {
    "kinematics": (Case.translation, DURATION),
    "forces": (Case.turning, DURATION),
    "stress": (_stress_case, CYCLE_DURATION),
}
"""Case and duration (s) to start from, by study."""


def study_case_file(study: str, name: str | None = None) -> CaseFile:
    """Case file of a study, under another name if one is given.

    Raises
    ------
    ValueError
        If there is no such study.
    """
    if study not in STARTS:
        raise ValueError(f"study must be of {list(STARTS)}, got {study!r}")
    make, duration = STARTS[study]
    case = make()
    return CaseFile(case=case if name is None else case.with_(name=name), duration=duration)
