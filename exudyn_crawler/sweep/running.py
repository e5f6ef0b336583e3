"""Run of a sweep into its folder: finished runs are reused, missing ones run, and all are collected."""

import json
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from exudyn_crawler.errors import ASK_TO_OVERWRITE
from exudyn_crawler.files import writable_folder, write_netcdf
from exudyn_crawler.machines import CaseFile, write_case
from exudyn_crawler.run.folder import progress as parts, record
from exudyn_crawler.settings.fields import in_units
from exudyn_crawler.sweep import answers, page, results, scatter
from exudyn_crawler.sweep.definition import FOLDER_DIGITS, PlannedRun, Sweep
from exudyn_crawler.sweep.worker import DONE, FAILED, Outcome, Task, own_versions, read_outcome

if TYPE_CHECKING:
    from exudyn_crawler.sweep.cluster import Scheduler

SETTINGS = "sweep.json"
"""File name of the settings of a sweep, in its folder."""


def run_sweep(
    sweep: scatter.AnySweep,
    out: str | Path,
    *,
    scheduler: "Scheduler | None" = None,
    workers: int | None = None,
    wait: float | None = None,
    retry: bool = False,
    overwrite: bool = False,
    progress: bool | None = None,
    say: Callable[[str], None] = record.quiet,
) -> results.SweepRun:
    """Run all unfinished runs of a sweep on Dask, and collect the answers.

    A stopped sweep continues when it is run into the same folder; one with more values or other answers
    reuses the finished runs. Failed runs do not stop the others. Draws from a duty are no runs: their lives
    are evaluated in this process, with errors of `life`.

    Every run has a folder in `runs` of `out`, which all workers must share. `scheduler` is a Dask cluster:
    its address or scheduler file, a cluster object or a client. Without it, a cluster on this machine has
    `workers` processes, one for each core if None. Runs are submitted before there is a worker; `wait` limits
    the time (s) without one. `retry` repeats failed runs; `overwrite` replaces tables and page of another
    sweep; see `run_case` for the other arguments.

    Raises ValueError before any run if values do not fit each other, no scheduler answers, or a worker has
    other versions, several threads, or does not see the folder; later if such a worker joins. Raises
    TimeoutError after `wait`; OSError if another sweep works in the folder, or the folder cannot be written
    to, or has results of other runs than this sweep's.
    """
    sweep.planned  # noqa: B018 - refuses runs before a folder is made
    folder = writable_folder(Path(out))
    work = record.RunFolder(folder, say)
    with record.held(folder, "sweep"):
        if not overwrite:
            refuse_other_results(sweep, folder)
        with record.recorded(work):
            return _run_into(sweep, work, scheduler, workers, wait, retry, progress)


def refuse_other_results(sweep: scatter.AnySweep, folder: Path) -> None:
    """Raise FileExistsError if the results in a folder have runs or draws that are not in a sweep."""
    path = folder / results.TABLE
    if not path.is_file():
        return
    try:
        if isinstance(sweep, scatter.DutyScatter):
            earlier = json.loads((folder / SETTINGS).read_text(encoding="utf-8"))
            is_other = earlier != json.loads(json.dumps(sweep.model_dump(mode="json")))
        else:
            rows = pd.read_csv(path, dtype=str, keep_default_na=False)
            is_other = not {*rows["folder"]} <= {*sweep.table()["folder"]}
    except (OSError, ValueError, KeyError):
        is_other = True
    if is_other:
        raise FileExistsError(
            f"{path} has results of another sweep, or of this one before it was changed: choose another "
            f"folder (--out), or {ASK_TO_OVERWRITE} to replace its tables and page; its runs stay"
        )


def _run_into(
    sweep: scatter.AnySweep,
    work: record.RunFolder,
    scheduler: "Scheduler | None",
    workers: int | None,
    wait: float | None,
    retry: bool,
    progress: bool | None,
) -> results.SweepRun:
    """Run the missing runs of a sweep in its folder, and collect; arguments: see `run_sweep`."""
    folder = work.path
    assert folder is not None
    if isinstance(sweep, scatter.DutyScatter):
        with work.timed("draws"):
            lives = enumerate(sweep.lives(work.say), 1)
        stored: dict[str, Outcome] = {str(k): {"status": DONE, "answers": hours} for k, hours in lives}
        return _gathered(sweep, stored, folder, None, work)
    runs = writable_folder(folder.resolve() / "runs")
    write_case(sweep.case, folder / "base.toml", overwrite=True)
    stored, missing, line = _state(sweep, runs, retry)
    work.say(line)
    if missing:
        # Dask is not needed to plan a sweep or to see its results
        from exudyn_crawler.sweep.cluster import connected, outcomes

        shared = None if scheduler is None else folder / "reductions"
        tasks = tasks_of(sweep, missing, runs, shared, retry)
        with (
            work.timed("runs"),
            connected(scheduler, workers, runs, work.say) as client,
            parts.progress_bar("sweep", len(missing), progress, unit="runs") as tell,
            closing(outcomes(client, tasks, wait=wait, report=work.say)) as finished,
        ):
            for count, outcome in enumerate(finished, 1):
                stored[outcome["digest"]] = outcome
                if outcome["status"] == FAILED:
                    work.say(f"run {outcome['digest'][:FOLDER_DIGITS]} failed: {outcome['reason']}")
                tell(count)
    return _gathered(sweep, stored, folder, runs, work)


def _gathered(
    sweep: scatter.AnySweep,
    stored: dict[str, Outcome],
    folder: Path,
    runs: Path | None,
    work: record.RunFolder,
) -> results.SweepRun:
    """Write tables and page of a sweep's outcomes; `runs` is the folder of its runs, if any."""
    record.write_json(folder / SETTINGS, sweep.model_dump(mode="json"))
    with work.timed("tables and page"):
        table = results.results_table(sweep, stored)
        dataset = results.results_dataset(sweep, table)
        results.write_units_csv(table, folder / results.TABLE)
        write_netcdf(dataset, folder / "results.nc", overwrite=True)
        page.write_page(sweep, table, folder, runs, work.say)
        return results.SweepRun(sweep, table, dataset, folder)


def folder_state(sweep: Sweep, out: Path, *, workers: int | None, retry: bool) -> str:
    """Describe the state of a sweep in a folder, and the time of the rest; arguments: see `run_sweep`."""
    stored, missing, line = _state(sweep, out.resolve() / "runs", retry)
    rest = estimate(sweep.case.with_(outputs=sweep.outputs), len(missing), workers, stored.values())
    return f"{line}\n{rest}"


def _state(sweep: Sweep, runs: Path, retry: bool) -> tuple[dict[str, Outcome], list[PlannedRun], str]:
    """Return present outcomes by digest, runs to do (again), each once, and a line on both."""
    different = {case.digest: case for case in sweep.planned if not case.obstacle}
    read = {digest: read_outcome(runs, digest) for digest in different}
    stored = {digest: outcome for digest, outcome in read.items() if outcome is not None}
    failed = {digest for digest, outcome in stored.items() if outcome["status"] == FAILED}
    asked = {
        digest: answers.ANSWERS.dump_python(case.answers, mode="json") for digest, case in different.items()
    }
    answered = {
        digest for digest, stored_case in stored.items() if stored_case.get("asked") == asked[digest]
    } - failed
    missing = [
        case
        for digest, case in different.items()
        if digest not in answered and (retry or digest not in failed)
    ]
    count = sum(not case.obstacle for case in sweep.planned)
    there = len(different) - len(missing)
    same = f", {count - len(different)} of them the same as others" if len(different) < count else ""
    more = f" ({len(failed)} failed)" if failed else ""
    return stored, missing, f"{count} runs{same}: {there} done{more}, {len(missing)} to run"


def tasks_of(
    sweep: Sweep,
    missing: Iterable[PlannedRun],
    runs: Path,
    reductions: Path | None = None,
    retry: bool = False,
) -> Iterator[Task]:
    """Yield tasks of planned runs on demand: all cases together take too much memory."""
    shared = None if reductions is None else str(reductions.resolve())
    for planned in missing:
        case = sweep.case_of(planned.values)[0].model_dump_json()
        asked = answers.ANSWERS.dump_json(planned.answers).decode()
        yield Task(planned.digest, case, asked, str(runs), shared, own_versions(), again=retry)


def run_time(case_file: CaseFile) -> float:
    """Return the processor time of a run (s) by a rule of thumb, without preparation and outputs."""
    times = parts.rule_of_thumb(case_file)
    return sum(times[part] for part in (parts.SIMULATE, parts.RECOVER) if part in times)


def estimate(case_file: CaseFile, missing: int, workers: int | None, stored: Iterable[Outcome]) -> str:
    """Describe the time of the missing runs; finished runs show the time of one."""
    times = [float(outcome["wall_time_s"]) for outcome in stored if outcome.get("status") == DONE]
    each = sum(times) / len(times) if times else run_time(case_file)
    whence = f"as {len(times)} finished ones took" if times else "of processor time, by a rule of thumb"
    count = workers or os.cpu_count() or 1
    whole = each * missing / min(count, max(missing, 1))
    return (
        f"{missing} runs of about {each:.2g} s each ({whence}): {in_units(whole, parts.TIMES)} on {count} "
        f"workers, {each * missing / 3600:.2g} core hours"
    )
