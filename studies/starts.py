"""Case files that a user can start from: what the studies run."""

from collections.abc import Callable

from exudyn_crawler.case import Case
from exudyn_crawler.case.files import CaseFile
from studies import uneven_ground
from studies.defaults import CYCLE_DURATION, DURATION

STARTS: dict[str, tuple[Callable[[], Case], float]] = {
    "kinematics": (Case.translation, DURATION),
    "forces": (Case.turning, DURATION),
    "stress": (Case.stress, CYCLE_DURATION),
    "uneven": (lambda: uneven_ground.uneven_case("rough"), uneven_ground.DURATION),
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
