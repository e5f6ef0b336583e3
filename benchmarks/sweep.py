"""What sweeps cost beside their runs: efficiency of workers, overhead a run, memory of the scheduler.

``python -m benchmarks.sweep`` prints the tables of docs/sweeps.md; it takes some minutes.
"""

import json
import os
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd
import psutil
from distributed import Client

from exudyn_crawler import Case, CaseFile
from exudyn_crawler.sweep.answers import Answer
from exudyn_crawler.sweep.cluster import connected, outcomes, run_alone
from exudyn_crawler.sweep.definition import Sweep
from exudyn_crawler.sweep.running import tasks_of
from exudyn_crawler.sweep.vary import Vary
from exudyn_crawler.sweep.worker import Outcome, Task, folder_of, own_versions
from exudyn_crawler.views.tables import print_table

RUNS, DURATION = 16, 5.0
TINY = 10_000


def short_sweep(count: int) -> Sweep:
    """Runs of the whole rigid track."""
    return Sweep(
        case=CaseFile(case=Case.translation(), duration=DURATION),
        vary=(Vary(key="terrain.spring_stiffness", low=10e6, high=80e6, count=count),),
        answers=(Answer(quantity="joint_force"),),
    )


def short_runs(workers: int) -> dict[str, float]:
    """Return the wall time of all runs on warm workers, and the share of the runs in it.

    The start of the workers and their first runs, which load the program, are separate values.
    """
    sweep = short_sweep(RUNS + workers)
    with TemporaryDirectory() as folder:
        begun = time.perf_counter()
        with connected(None, workers, Path(folder), lambda _text: None) as client:
            client.wait_for_workers(workers)
            started = time.perf_counter()
            tasks = tasks_of(sweep, sweep.planned, Path(folder))
            addresses = list(client.scheduler_info()["workers"])
            firsts = zip(addresses, islice(tasks, workers), strict=True)
            client.gather([client.submit(run_alone, task, workers=[where]) for where, task in firsts])
            ready, before = time.perf_counter(), sum(client.run(time.process_time).values())
            found = list(outcomes(client, tasks))
            wall = time.perf_counter() - ready
            spent = sum(client.run(time.process_time).values()) - before
        records = [folder_of(folder, one["digest"]) / "run.json" for one in found]
        own = [json.loads(path.read_text(encoding="utf-8"))["wall_time_s"] for path in records]
    busy = sum(own) / workers
    return {
        "workers": workers,
        "start of the workers, s": started - begun,
        "their first run, s": ready - started,
        "runs": len(found),
        "wall time, s": wall,
        "a run itself, s": sum(own) / len(own),
        "processor time a run, s": spent / len(own),
        "overhead a run, s": (wall - busy) * workers / len(own),
        "workers at runs": busy / wall,
    }


def pooled_runs(workers: int) -> float:
    """Wall time of the same runs in processes that no scheduler looks after, all that two cores can do."""
    sweep = short_sweep(RUNS + workers)
    with TemporaryDirectory() as folder, ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        tasks = tasks_of(sweep, sweep.planned, Path(folder))
        list(pool.map(run_alone, islice(tasks, workers)))
        ready = time.perf_counter()
        list(pool.map(run_alone, tasks))
        return time.perf_counter() - ready


def tiny(task: Task) -> Outcome:
    """Do nothing."""
    return {"digest": task.digest, "status": "done", "process": os.getpid()}


def tiny_tasks(client: Client) -> dict[str, float]:
    """Tasks that do nothing through the scheduler, which lives in this process as the client does."""
    process = psutil.Process()

    def tasks() -> Iterator[Task]:
        text = short_sweep(2).case.model_dump_json()
        for k in range(TINY):
            yield Task(f"{k:064d}", text, "[]", "", None, own_versions())

    before = greatest = process.memory_info().rss
    begun, busy = time.perf_counter(), time.process_time()
    for count, _ in enumerate(outcomes(client, tasks(), tiny), 1):
        if count % 100 == 0:
            greatest = max(greatest, process.memory_info().rss)
    wall, busy = time.perf_counter() - begun, time.process_time() - busy
    return {
        "tasks": TINY,
        "wall time, s": wall,
        "processor time of scheduler and client a task, ms": 1e3 * busy / TINY,
        "memory before, MB": before / 1e6,
        "growth, MB": (greatest - before) / 1e6,
    }


def main() -> None:
    """Print all tables."""
    table = pd.DataFrame([short_runs(1), short_runs(2)])
    table["without a scheduler, s"] = [pooled_runs(1), pooled_runs(2)]
    table["efficiency"] = table["wall time, s"][0] / (table["workers"] * table["wall time, s"])
    table["of what is without one"] = table["without a scheduler, s"] / table["wall time, s"]
    print_table(table, f"{RUNS} runs of {DURATION:g} s, {os.cpu_count()} cores")
    print(f"load of the machine over the last minutes: {os.getloadavg()}")
    with (
        TemporaryDirectory() as folder,
        connected(None, 2, Path(folder), lambda _text: None) as client,
    ):
        print_table(pd.DataFrame([tiny_tasks(client)]), "Tasks that do nothing, on two workers")


if __name__ == "__main__":
    main()
