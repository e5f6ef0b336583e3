"""Cases of the studies to start from, as `pyproject.toml` registers them; this does not load the runs."""

from exudyn_crawler import Case, CaseFile
from studies.defaults import CYCLE_DURATION, DURATION
from studies.grounds import uneven_case


def kinematics() -> CaseFile:
    """Straight propel."""
    return CaseFile(case=Case.translation(), duration=DURATION)


def forces() -> CaseFile:
    """Propel with a turn."""
    return CaseFile(case=Case.turning(), duration=DURATION)


def stress() -> CaseFile:
    """Whole cycle with six flexible shoes."""
    return CaseFile(case=Case.stress(), duration=CYCLE_DURATION)


def rollers() -> CaseFile:
    """Machine that rolls over rigid shoes."""
    return CaseFile(case=Case.rolled(), duration=DURATION)


def uneven() -> CaseFile:
    """Straight propel over random roughness."""
    return CaseFile(case=uneven_case("rough"), duration=DURATION)
