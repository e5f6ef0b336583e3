"""Runs that are kept: one history file a case."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from exudyn_crawler.case import Case
from exudyn_crawler.case.fields import TAG
from exudyn_crawler.case.files import CaseFile
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.results.history import History
from exudyn_crawler.run.checkpoints import Checkpoints
from exudyn_crawler.run.folder import Keeper
from exudyn_crawler.run.simulation import simulate

STOPPED_HISTORY = "history_stopped.nc"
"""History of a run that stopped early."""
HISTORY = "history.nc"
"""History of a folder that keeps the run of one case; a study's folder has one named after every case."""


def history_file(folder: Path, name: str) -> Path:
    """Where a study keeps the history of a case."""
    return folder / f"{name}.nc"


CASES = {"translation": Case.translation, "turning": Case.turning}
"""Cases of the rigid studies by name."""


def study_cases(names: Sequence[str], duration: float) -> dict[str, CaseFile]:
    """Cases of the rigid studies with their duration, checked before anything runs.

    Raises
    ------
    ValueError
        For an unknown case or none, or a duration that is not positive or takes a track off its terrain.
    """
    unknown = sorted(set(names) - set(CASES))
    if unknown or not names:
        raise ValueError(f"cases must be of {list(CASES)}, got {list(names)}")
    return {name: CaseFile(case=CASES[name](), duration=duration) for name in names}


def saved_run(
    case: Case, duration: float, out: Path | None, overwrite: bool, progress: bool | None
) -> History:
    """Simulate a case and keep its history in `out`, if given, even if it stops early.

    Raises
    ------
    SimulationStopped
        After what there is was saved.
    OSError
        If it cannot be saved in `out`, with the place where it is.
    """
    try:
        history = simulate(case, duration, progress)
    except SimulationStopped as stop:
        if out is not None:
            keep_history(stop.history, history_file(out, f"{case.name}_stopped"), overwrite)
        raise
    if out is not None:
        keep_history(history, history_file(out, case.name), overwrite)
    return history


def keep_history(history: History, path: Path, overwrite: bool = False) -> None:
    """Save a history; where that fails, in a temporary folder, since it may have taken hours to make.

    Raises
    ------
    OSError
        If the history is not at `path`, with the place where it is.
    """
    try:
        history.save(path, overwrite)
    except OSError as error:
        spare = Path(tempfile.mkdtemp(prefix="exudyn-crawler-")) / path.name
        try:
            history.save(spare)
        except OSError:
            spare.parent.rmdir()
            raise error from None
        raise OSError(f"{error}; the history was kept as {spare}") from error


def kept_checkpoints(out: Path, case: Case, overwrite: bool, keeper: Keeper) -> Checkpoints:
    """Checkpoints of a run in its folder; tells where it goes on."""
    checkpoints = Checkpoints(out / "checkpoints")
    if overwrite:
        checkpoints.clear()
    elif kept := checkpoints.load(case):
        keeper.say(f"going on from the checkpoint at t = {kept[-1].time:g} s")
    return checkpoints


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
    if not path.is_file() and (folder / HISTORY).is_file():
        path = folder / HISTORY
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
        if found.get(TAG) != wanted.get(TAG):
            names = [TAG]  # parts of different classes
        return [
            difference
            for key in names
            for difference in _differences(found.get(key), wanted.get(key), f"{name}.{key}".lstrip("."))
        ]
    return [] if found == wanted else [f"{name} is {found}, not {wanted}"]
