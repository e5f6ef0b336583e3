"""Dask for sweeps: a cluster of this machine's, or a scheduler elsewhere, and tasks run by its workers."""

import logging
import os
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from os.path import exists
from pathlib import Path
from unittest.mock import patch

import dask
import distributed

from exudyn_crawler.errors import GOES_ON, CrawlerError
from exudyn_crawler.sweep.worker import Outcome, Task, check_versions, own_versions, run_task, write_outcome

CONNECT_WAIT = 20.0  # s to wait for a scheduler
WORKER_WAIT = 120.0  # s to wait for the first worker: a batch system may have to start it
LEAST_AHEAD, AHEAD = 64, 4
"""Tasks that the scheduler holds: so many at least, and so many a worker. It never has all of a sweep."""


@contextmanager
def connected(
    scheduler: str | None, workers: int | None, runs: Path, report: Callable[[str], None]
) -> Iterator[distributed.Client]:
    """Client of a cluster whose workers can do what a sweep asks for, and see the folder of its runs.

    Arguments as of `run_sweep`. The scheduler does not become the process's own: one that never answered
    would stay that, and whoever saves a dataset afterwards would be sent to it. Raises `ValueError` if no
    scheduler answers, or its workers are not fit.
    """
    # a scheduler that is lost is said in a line, other versions by check_versions in one of what matters
    with distributed.utils.silence_logging_cmgr(logging.CRITICAL), warnings.catch_warnings():
        warnings.simplefilter("ignore", distributed.versions.VersionMismatchWarning)
        with _local(workers) if scheduler is None else _remote(scheduler) as client:
            if client.dashboard_link:
                report(f"dashboard: {client.dashboard_link}")
            if not client.scheduler_info()["workers"]:
                report(f"waiting up to {WORKER_WAIT:g} s for a worker at {client.scheduler.address}")
            _check_workers(client, runs)
            yield client


@contextmanager
def _local(workers: int | None) -> Iterator[distributed.Client]:
    count = workers or os.cpu_count() or 1
    quiet = {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
    environment = dask.config.get("distributed.nanny.pre-spawn-environ") | {"NUMBA_NUM_THREADS": 1}
    with (
        # Dask puts the environment of its workers into this process, too, which would go on with one thread
        patch.dict(os.environ),
        dask.config.set({"distributed.nanny.pre-spawn-environ": environment}),
        # a process a run: two in one would wait for each other, and write into each other's logs
        distributed.LocalCluster(n_workers=count, threads_per_worker=1, processes=True, **quiet) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        yield client


def _remote(scheduler: str) -> distributed.Client:
    try:
        is_file = Path(scheduler).suffix == ".json"
        if is_file and not Path(scheduler).is_file():
            raise FileNotFoundError("no such file")
        where = {"scheduler_file" if is_file else "address": scheduler}
        return distributed.Client(**where, timeout=CONNECT_WAIT, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"scheduler must be one that answers, got {scheduler}: {reason}") from error


def _check_workers(client: distributed.Client, runs: Path) -> None:
    """Refuse workers that could not do what a sweep asks for; a scheduler may get some only by and by."""
    try:
        client.wait_for_workers(1, timeout=WORKER_WAIT)
    except TimeoutError as error:
        there = client.scheduler.address
        raise ValueError(f"{there} must have a worker within {WORKER_WAIT:g} s, got none") from error
    # by name: a worker without the package fails on the import, which is reported apart
    for where, answer in client.run(own_versions, on_error="return").items():
        if isinstance(answer, BaseException):
            raise ValueError(f"worker {where} does not have the package: {answer}")
        check_versions(own_versions(), answer, where)
    with tempfile.NamedTemporaryFile(prefix=".seen-", dir=runs) as token:
        for where, sees in client.run(exists, token.name).items():
            if not sees:
                raise ValueError(f"worker {where} must see {runs}: put it on storage that all machines share")


def run_alone(task: Task) -> Outcome:
    """Do a task as `run_task`, on a worker of a cluster."""
    # xarray would take locks of the cluster for files that a run has for itself
    with dask.config.set(scheduler="synchronous"):
        return run_task(task)


def outcomes(
    client: distributed.Client, tasks: Iterator[Task], run: Callable[[Task], Outcome] = run_alone
) -> Iterator[Outcome]:
    """Outcomes as they come; raises as `check_versions`, and ConnectionError if the scheduler is lost."""
    running = distributed.as_completed(loop=client.loop, raise_errors=False)
    held: dict[str, Task] = {}

    def submit(count: int) -> None:
        for task in islice(tasks, count):
            future = client.submit(run, task, key=f"run-{task.digest}", pure=False)
            held[future.key] = task
            running.add(future)

    submit(max(LEAST_AHEAD, AHEAD * len(client.scheduler_info()["workers"])))
    for future in running:
        task = held.pop(future.key)
        try:
            outcome = future.result()
        except distributed.scheduler.KilledWorker as error:
            times, last = error.allowed_failures + 1, error.last_worker.address
            reason = f"{times} workers died while they ran it, the last one {last}"
            outcome = write_outcome(task, CrawlerError(reason), {})
        except (distributed.client.FutureCancelledError, distributed.comm.CommClosedError) as error:
            raise ConnectionError(f"the scheduler was lost; finished runs are kept: {GOES_ON}") from error
        future.release()
        yield outcome
        submit(1)
