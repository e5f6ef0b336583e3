"""Runs that are kept: one history file a case."""

from collections.abc import Sequence
from pathlib import Path

from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.files import writable_folder
from exudyn_crawler.history import History
from exudyn_crawler.parameters import Case
from exudyn_crawler.simulation import CrawlerModel

RESULT_SUFFIXES = {".nc", ".csv", ".png"}


def history_file(folder: Path, name: str) -> Path:
    """Where the history of a case is kept."""
    return folder / f"{name}.nc"


CASES = {"translation": Case.translation, "turning": Case.turning}
"""Cases of the rigid studies by name."""
DURATION = 10.0
"""s, simulated in the rigid studies of the papers."""


def prepare(cases: Sequence[str], out: Path | None, overwrite: bool) -> None:
    """Check what a rigid study was asked for, before anything runs.

    Raises
    ------
    ValueError
        For an unknown case or none.
    FileExistsError, PermissionError, NotADirectoryError
        If `out` holds results and `overwrite` is false, or cannot be written to.
    """
    unknown = sorted(set(cases) - set(CASES))
    if unknown or not cases:
        raise ValueError(f"cases must be of {list(CASES)}, got {list(cases)}")
    if out is not None:
        refuse_results(writable_folder(out), overwrite)


def refuse_results(out: Path, overwrite: bool) -> None:
    """Refuse a folder that holds results already.

    Raises
    ------
    FileExistsError
        Naming what is there, unless `overwrite`.
    """
    found = sorted(path.name for path in out.iterdir() if path.suffix in RESULT_SUFFIXES)
    if found and not overwrite:
        raise FileExistsError(
            f"{out} holds results already ({', '.join(found[:3])}, ...): "
            f"choose another folder or ask for overwriting"
        )


def saved_run(
    case: Case, duration: float, out: Path | None, overwrite: bool, progress: bool | None
) -> History:
    """Simulate a case and keep its history in `out`, if given, even if it stops early.

    Raises
    ------
    SimulationStopped
        After what there is was saved.
    """
    try:
        history = CrawlerModel(case).simulate(duration, progress)
    except SimulationStopped as stop:
        if out is not None:
            stop.history.save(history_file(out, f"{case.name}_stopped"), overwrite)
        raise
    if out is not None:
        history.save(history_file(out, case.name), overwrite)
    return history


def matching_history(folder: Path, case: Case, duration: float) -> History:
    """History that an earlier run of the same case left in a folder.

    Raises
    ------
    FileNotFoundError
        If the folder holds none of this name.
    ValueError
        If it comes from other parameters or is shorter or longer, naming what differs.
    """
    path = history_file(folder, case.name)
    history = History.load(path)
    differences = _differences(history.case.model_dump(), case.model_dump())
    if abs(history.duration - duration) > 1e-6:
        differences.append(f"duration is {history.duration:g} s, not {duration:g} s")
    if differences:
        raise ValueError(f"{path} comes from other parameters: {'; '.join(differences[:5])}")
    return history


def _differences(found: object, wanted: object, name: str = "") -> list[str]:
    """Names of the parameters in which two dumped cases differ, with both values."""
    if isinstance(found, dict) and isinstance(wanted, dict):
        names = sorted(found.keys() | wanted.keys())
        return [
            difference
            for key in names
            for difference in _differences(found.get(key), wanted.get(key), f"{name}.{key}".lstrip("."))
        ]
    return [] if found == wanted else [f"{name} is {found}, not {wanted}"]
