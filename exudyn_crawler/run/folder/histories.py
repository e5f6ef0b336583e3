"""Histories in folders, found again by their parameters."""

from pathlib import Path
from typing import TYPE_CHECKING

from exudyn_crawler.case import CaseFile

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
    differences = _differences(history.case.model_dump(), case.model_dump())
    if abs(history.duration - case_file.duration) > SAME_TIME:
        differences.append(f"duration is {history.duration:g} s, not {case_file.duration:g} s")
    if differences:
        raise ValueError(f"{path} comes from other parameters: {'; '.join(differences[:5])}")
    return history


def _differences(found: object, wanted: object, name: str = "") -> list[str]:
    """Names of the parameters in which two dumped cases differ, with both values."""
    if isinstance(found, dict) and isinstance(wanted, dict):
        if found.get("model") != wanted.get("model"):
            # another model has other parameters: nothing else is comparable
            found, wanted = ({"model": one.get("model")} for one in (found, wanted))
        return [
            difference
            for key in sorted(found.keys() | wanted.keys())
            for difference in _differences(found.get(key), wanted.get(key), f"{name}.{key}".lstrip("."))
        ]
    return [] if found == wanted else [f"{name} is {found}, not {wanted}"]
