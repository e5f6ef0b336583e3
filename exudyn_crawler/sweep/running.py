"""A sweep into its folder: what has finished is taken, what is missing run, and all of it gathered."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from pathlib import Path

import pandas as pd
import xarray as xr

from exudyn_crawler.case import write_case
from exudyn_crawler.files import whole_file, writable_folder
from exudyn_crawler.netcdf import write_netcdf
from exudyn_crawler.run.folder.folder import held
from exudyn_crawler.run.folder.keeper import Keeper, quiet, recorded
from exudyn_crawler.run.folder.progress import progress_bar
from exudyn_crawler.run.folder.record import earlier_record
from exudyn_crawler.sweep.answers import ANSWERS
from exudyn_crawler.sweep.definition import FOLDER_DIGITS, PlannedRun, Sweep
from exudyn_crawler.sweep.estimate import estimate
from exudyn_crawler.sweep.page import write_page
from exudyn_crawler.sweep.storage import Outcome, check_storage, is_address, read_outcome
from exudyn_crawler.sweep.table import results_dataset, results_table, write_parquet, write_units_csv
from exudyn_crawler.sweep.worker import DONE, FAILED, Task, own_versions

RUNS = "runs"
"""Folder of the folders of runs, where a sweep names no other storage."""
BASE_CASE, DEFINITION = "base.toml", "sweep.json"
TABLE, COLUMNS, DATASET = "results.csv", "results.parquet", "results.nc"
REDUCTIONS = "reductions"


@dataclass(frozen=True)
class SweepRun:
    """A sweep that was run.

    Attributes
    ----------
    sweep : Sweep
    table : pandas.DataFrame
        A row a run: its number and folder, what varies, the answers, status, reason of a failure and wall
        time; `attrs["units"]` holds the units of the columns.
    dataset : xarray.Dataset
        Answers over what varies if the design is a grid, else over the runs.
    folder : Path
        Where all of it is kept.
    """

    sweep: Sweep
    table: pd.DataFrame
    dataset: xr.Dataset
    folder: Path

    def _repr_html_(self) -> str:
        """Folder and table, for notebooks."""
        return f"<p>Sweep kept in {escape(str(self.folder))}</p>" + self.table.to_html(index=False)


def run_sweep(
    sweep: Sweep,
    out: str | Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    storage: str | None = None,
    retry: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = quiet,
) -> SweepRun:
    """Run all runs of a sweep that have not finished, on Dask, and gather the answers.

    A sweep that was stopped goes on when it is run into the same folder; one with more values or other
    answers takes what is there. Runs that fail do not stop the others. A script that calls this without a
    scheduler does so below ``if __name__ == "__main__":``, since its worker processes import it.

    Parameters
    ----------
    sweep : Sweep
    out : path
        Folder of the sweep; every run has a folder in `runs` there.
    scheduler : str, optional
        Address or scheduler file of a Dask cluster; None starts one of this machine's.
    workers : int, optional
        Processes of the cluster of this machine's; None is one a core.
    storage : str, optional
        Where runs are kept in place of `runs`: a folder that all workers share, or an address that fsspec
        knows, ``s3://bucket/folder``, where each is copied when it has ended.
    retry : bool
        Run those anew that have failed.
    progress : bool, optional
        Show a progress bar; None shows one on a terminal and a line every 10 s elsewhere.
    say : callable
        Is told, in a line, what is going on.

    Raises
    ------
    ValueError
        Before anything runs: if values do not fit each other, no scheduler answers, a worker has other
        versions or does not see the folder, or the storage cannot be written to.
    BlockingIOError
        If another sweep works in the folder.
    NotADirectoryError, PermissionError
        If the folder cannot be written to.
    """
    planned = sweep.planned
    folder = writable_folder(Path(out))
    kept_in = _storage(folder, storage)
    if not is_address(kept_in):
        writable_folder(Path(kept_in))
    with _kept_sweep(folder, sweep, say) as keeper:
        check_storage(kept_in)
        found = _there(planned, kept_in)
        missing = _missing(sweep, planned, found, retry)
        keeper.say(_told(planned, found, len(missing)))
        if missing:
            shared = None if scheduler is None or is_address(kept_in) else folder / REDUCTIONS
            tasks = tasks_of(sweep, missing, kept_in, shared, retry)
            with (
                keeper.timed("runs"),
                _outcomes(tasks, scheduler, workers, kept_in, keeper.say) as coming,
                progress_bar("sweep", len(missing), progress, unit="runs") as tell,
            ):
                for count, outcome in enumerate(coming, 1):
                    found[outcome["digest"]] = outcome
                    _tell_failure(outcome, keeper)
                    tell(count)
        with keeper.timed("tables and page"):
            return _gathered(sweep, results_table(sweep, planned, found), folder, kept_in, keeper)


@contextmanager
def _outcomes(
    tasks: Iterator[Task],
    scheduler: str | None,
    workers: int | None,
    storage: str,
    say: Callable[[str], None],
) -> Iterator[Iterator[Outcome]]:
    """Outcomes of tasks as they come from a cluster, which lives as long as the block."""
    # planning a sweep and looking at its results do without Dask
    from exudyn_crawler.sweep.cluster import connected, outcomes

    with connected(scheduler, workers, storage, say) as client:
        yield outcomes(client, tasks)


def _tell_failure(outcome: Outcome, keeper: Keeper) -> None:
    if outcome["status"] == FAILED:
        keeper.say(f"run {outcome['digest'][:FOLDER_DIGITS]} failed: {outcome['reason']}")


def _gathered(sweep: Sweep, table: pd.DataFrame, folder: Path, storage: str, keeper: Keeper) -> SweepRun:
    """Results in all forms, and the page."""
    dataset = results_dataset(sweep, table)
    write_units_csv(table, folder / TABLE)
    write_parquet(table, folder / COLUMNS)
    write_netcdf(dataset, folder / DATASET, overwrite=True)
    write_page(sweep, table, folder, storage, keeper.say)
    return SweepRun(sweep, table, dataset, folder)


def standing_of(sweep: Sweep, out: Path, *, storage: str | None, workers: int | None, retry: bool) -> str:
    """What of a sweep is in a folder, and how long the rest takes; arguments as of `run_sweep`."""
    planned = sweep.planned
    found = _there(planned, _storage(out, storage))
    missing = _missing(sweep, planned, found, retry)
    told = estimate(sweep.case.with_(outputs=sweep.outputs), len(missing), workers, found.values())
    return f"{_told(planned, found, len(missing))}\n{told}"


def _storage(folder: Path, storage: str | None) -> str:
    """Where runs are kept: a whole path, or an address."""
    if storage is not None and is_address(storage):
        return storage
    return str((folder / RUNS if storage is None else Path(storage)).resolve())


@contextmanager
def _kept_sweep(folder: Path, sweep: Sweep, say: Callable[[str], None]) -> Iterator[Keeper]:
    """Hold the folder of a sweep; its log, record, base case and definition are there."""
    with held(folder, "sweep"):
        keeper = Keeper(say, anew=False)
        with recorded(folder, keeper, earlier_record(folder)):
            write_case(sweep.case, folder / BASE_CASE, overwrite=True)
            with whole_file(folder / DEFINITION, overwrite=True) as temporary:
                temporary.write_text(sweep.model_dump_json(indent=2) + "\n", encoding="utf-8")
            yield keeper


def _there(planned: tuple[PlannedRun, ...], storage: str) -> dict[str, Outcome]:
    """Outcomes that a storage has of planned runs, by digest, failed ones among them."""
    found = {}
    for digest in dict.fromkeys(one.digest for one in planned):
        outcome = read_outcome(storage, digest)
        if outcome is not None:
            found[digest] = outcome
    return found


def _missing(
    sweep: Sweep, planned: tuple[PlannedRun, ...], found: dict[str, Outcome], retry: bool
) -> dict[str, PlannedRun]:
    """Runs that have not finished or have other answers, each once, by digest."""
    asked = ANSWERS.dump_python(sweep.answers, mode="json")
    missing: dict[str, PlannedRun] = {}
    for one in planned:
        outcome = found.get(one.digest, {})
        status = outcome.get("status")
        done = status == DONE and outcome.get("asked") == asked
        if not (done or (status == FAILED and not retry)):
            missing.setdefault(one.digest, one)
    return missing


def tasks_of(
    sweep: Sweep,
    missing: dict[str, PlannedRun],
    storage: str,
    reductions: Path | None = None,
    retry: bool = False,
) -> Iterator[Task]:
    """Tasks of planned runs by digest, each made when it is asked for: all cases take too much memory.

    Parameters
    ----------
    reductions : Path, optional
        Folder of reductions that workers share.
    retry : bool
        Run those anew that have failed.
    """
    answers = ANSWERS.dump_json(sweep.answers).decode()
    for digest, one in missing.items():
        case_file, _ = sweep.case_of(one.values)
        yield Task(
            digest=digest,
            case=case_file.model_dump_json(),
            answers=answers,
            storage=storage,
            reductions=None if reductions is None else str(reductions.resolve()),
            versions=own_versions(),
            again=retry,
        )


def _told(planned: tuple[PlannedRun, ...], found: dict[str, Outcome], missing: int) -> str:
    failed = sum(outcome["status"] == FAILED for outcome in found.values())
    different = len({one.digest for one in planned})
    same = f", {len(planned) - different} of them the same as others" if different < len(planned) else ""
    there = f"{different - missing} are there" + (f" ({failed} failed)" if failed else "")
    return f"{len(planned)} runs{same}: {there}, {missing} to run"
