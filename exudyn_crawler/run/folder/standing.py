"""How a folder stands to a run that is to go into it: new to it, stopped within it, shorter or finished."""

from collections.abc import Mapping
from enum import Enum
from pathlib import Path

import h5py

from exudyn_crawler.case import CaseFile, read_case
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.netcdf import check_seal
from exudyn_crawler.run.folder.histories import HISTORY, SAME_TIME
from exudyn_crawler.run.folder.record import DONE, earlier_record
from fem.interrupts import interrupts_wait

CASE = "case.toml"


class Standing(Enum):
    """What a folder holds of a run."""

    NOTHING = "nothing"
    UNFINISHED = "a run of it that was stopped"
    LONGER_ASKED = "a run of it, but of less time, that was stopped"
    SHORTER = "a finished run of less time"
    FINISHED = "all of it"


def standing(out: Path, case_file: CaseFile) -> Standing:
    """What the folder of a run holds of a case; nothing, too, if it holds another one."""
    record = earlier_record(out)
    if not record:
        return Standing.NOTHING
    try:
        found = read_case(out / CASE)
    except (CaseFileError, FileNotFoundError):
        return Standing.NOTHING
    if record.get("status") != DONE:
        if found == case_file:
            return Standing.UNFINISHED
        same = found.case == case_file.case and found.duration < case_file.duration
        return Standing.LONGER_ASKED if same else Standing.NOTHING
    end = _end(out / HISTORY)
    if found.case != case_file.case or end is None or end > case_file.duration + SAME_TIME:
        return Standing.NOTHING
    return Standing.SHORTER if end < case_file.duration - SAME_TIME else Standing.FINISHED


def study_standing(out: Path, cases: Mapping[str, CaseFile]) -> Standing:
    """What the folder of a study holds of cases in folders of their names; it is never shorter."""
    record = earlier_record(out)
    if not record:
        return Standing.NOTHING
    found = {name: standing(out / name, case_file) for name, case_file in cases.items()}
    if record.get("status") != DONE:
        return Standing.UNFINISHED
    if all(one is Standing.FINISHED for one in found.values()):
        return Standing.FINISHED
    if any(one is Standing.NOTHING and (out / name / CASE).exists() for name, one in found.items()):
        return Standing.NOTHING
    return Standing.UNFINISHED


@interrupts_wait()
def _end(path: Path) -> float | None:
    """Time of the last state of a history, s; None if there is none that can be read."""
    try:
        check_seal(path)
        with h5py.File(path, "r") as file:
            return float(file["time"][-1])
    # altered bytes make the readers raise all kinds of errors
    except Exception:
        return None
