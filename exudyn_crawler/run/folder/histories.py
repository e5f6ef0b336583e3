"""Histories in folders, found again by their parameters."""

from pathlib import Path
from typing import TYPE_CHECKING

from exudyn_crawler.case import CaseFile
from exudyn_crawler.case.files.differences import differences

if TYPE_CHECKING:
    from exudyn_crawler.results.history.history import History

HISTORY = "history.nc"
"""History in the folder of a run."""
STOPPED_HISTORY = "history_stopped.nc"
"""In its place, of a run that stopped early."""
SAME_TIME = 1e-6
"""s by which durations may differ and be the same."""


def matching_history(folder: Path, case_file: CaseFile) -> "History":
    """History of the same case and duration in the folder of an earlier run, or of a study that ran it.

    Raises
    ------
    FileNotFoundError
        If the folder holds none.
    ValueError
        If it comes from other parameters or is shorter or longer, naming what differs.
    """
    # naming a history must not wait for what reads it
    from exudyn_crawler.results.history.history import History

    case = case_file.case
    # a run's folder, a study's, and a study's as it was when it kept its histories side by side
    places = (folder / HISTORY, folder / case.name / HISTORY, folder / f"{case.name}.nc")
    path = next((place for place in places if place.is_file()), None)
    if path is None:
        raise FileNotFoundError(f"no history at {places[0]} or {places[1]}")
    history = History.load(path)
    found = [str(one) for one in differences(history.case, case)]
    if abs(history.duration - case_file.duration) > SAME_TIME:
        found.append(f"duration is {history.duration:g} s, not {case_file.duration:g} s")
    if found:
        raise ValueError(f"{path} comes from other parameters: {'; '.join(found[:5])}")
    return history
