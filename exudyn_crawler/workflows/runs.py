"""Runs that are kept: one history file a case."""

from pathlib import Path

from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.history import History
from exudyn_crawler.parameters import Case
from exudyn_crawler.simulation import CrawlerModel


def history_file(out: Path, name: str) -> Path:
    """Where the history of a case is kept."""
    return out / f"{name}.nc"


def refuse_results(out: Path, overwrite: bool) -> None:
    """Refuse a folder that holds results already.

    Raises
    ------
    FileExistsError
        Naming what is there, unless `overwrite`.
    """
    found = sorted(path.name for path in out.iterdir() if path.suffix in {".nc", ".csv", ".png"})
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
