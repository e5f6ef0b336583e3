"""Dask for sweeps: a cluster on this machine or a remote scheduler, and tasks on its workers."""

import asyncio
import json
import logging
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from typing import Any, TypeAlias

import dask
import distributed

from exudyn_crawler.errors import GOES_ON, CrawlerError
from exudyn_crawler.sweep import with_parent
from exudyn_crawler.sweep.worker import (
    Outcome,
    Task,
    check_versions,
    own_versions,
    run_task,
    sees,
    token_in,
    write_outcome,
)

CONNECT_WAIT = 20.0  # s to wait for a scheduler
START_WAIT = 300.0  # s to wait for the first process on this machine
LOOK = 1.0  # s between counts of the workers
LEAST_AHEAD, AHEAD = 64, 4
"""Number of tasks on the scheduler: at least, and for each worker. The scheduler never has all of a sweep."""

Scheduler: TypeAlias = str | os.PathLike[str] | distributed.Client | distributed.deploy.Cluster
"""Place where a sweep runs: address, scheduler file, or object of Dask."""

_one_run = Lock()
"""Lock of the run of this process: two runs would write into each other's logs."""


@contextmanager
def connected(
    scheduler: Scheduler | None, workers: int | None, runs: Path, report: Callable[[str], None]
) -> Iterator[distributed.Client]:
    """Yield the client of a cluster, with its present workers checked.

    Arguments are those of `run_sweep`; all workers must see the folder of its runs. The scheduler does not
    become the default of the process: a scheduler without answer would otherwise remain the default, and
    later saving of datasets would use it. Raises `ValueError` if no scheduler answers, or its workers are not
    fit.
    """
    # the sweep reports a lost scheduler in one line, and check_versions other versions
    with distributed.utils.silence_logging_cmgr(logging.CRITICAL), warnings.catch_warnings():
        warnings.simplefilter("ignore", distributed.versions.VersionMismatchWarning)
        with _local(workers) if scheduler is None else _remote(scheduler) as client:
            if client.dashboard_link:
                report(f"dashboard, for a browser: {client.dashboard_link}")
            with token_in(runs, client.id):
                _check_workers(client, runs)
                yield client


@contextmanager
def _local(workers: int | None) -> Iterator[distributed.Client]:
    count = workers or os.cpu_count() or 1
    with (
        _scheduler() as cluster,
        _workers(cluster.scheduler_address, count),
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        try:
            client.wait_for_workers(1, timeout=START_WAIT)
        except TimeoutError as error:
            raise OSError(f"no process of {count} has started within {START_WAIT:g} s") from error
        yield client


@contextmanager
def _workers(address: str, count: int) -> Iterator[None]:
    """Have workers of one thread on this machine, by Dask's command: they import nothing of a user's script.

    Raises OSError if the command cannot be started.
    """
    command = [sys.executable, "-m", "distributed.cli.dask_worker", address]
    # else workers listen to all computers, whose pickles they would run
    command += ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0", "--no-dashboard"]
    command += ["--nworkers", str(count), "--nthreads", "1", "--preload-nanny", with_parent.__name__]
    environment = os.environ | {"NUMBA_NUM_THREADS": "1", "DASK_LOGGING__DISTRIBUTED": "critical"}
    environment["PYTHONPATH"] = os.pathsep.join(sys.path)  # what the script can import, its tasks can, too
    # a session of its own: Ctrl-C is for the sweep, which ends its workers
    with subprocess.Popen(command, stdin=subprocess.PIPE, env=environment, start_new_session=True):
        yield


@contextmanager
def _scheduler() -> Iterator[distributed.LocalCluster]:
    """Yield a scheduler on this machine without workers; an interrupt waits until it can be closed."""
    started: Future[distributed.LocalCluster] = Future()

    def start() -> None:
        # one process for each run: two runs in one would wait for each other
        how: dict[str, Any] = {"n_workers": 0, "threads_per_worker": 1, "processes": True}
        how |= {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
        try:
            started.set_result(distributed.LocalCluster(**how))
        except Exception as error:
            started.set_exception(error)

    Thread(target=start, daemon=True).start()
    try:
        cluster = started.result()
    except KeyboardInterrupt:
        started.result().close()
        raise
    with cluster:
        yield cluster


@contextmanager
def _remote(scheduler: Scheduler) -> Iterator[distributed.Client]:
    if isinstance(scheduler, distributed.Client):
        if scheduler.asynchronous:
            raise ValueError("scheduler must be a client that waits for its results, got an asynchronous one")
        yield scheduler
        return
    with _client(scheduler) as client:
        yield client


def _client(scheduler: Scheduler) -> distributed.Client:
    """Return the client of a cluster, or of a scheduler by its address or file."""
    how: dict[str, Any] = {"timeout": CONNECT_WAIT, "set_as_default": False}
    try:
        if not isinstance(scheduler, str | os.PathLike):
            return distributed.Client(scheduler, **how)
        where = os.fspath(scheduler)
        is_file = Path(where).suffix == ".json"
        if is_file and not Path(where).is_file():
            raise FileNotFoundError("no such file")
        _check_answers(json.loads(Path(where).read_text(encoding="utf-8"))["address"] if is_file else where)
        return distributed.Client(**({"scheduler_file": where} if is_file else {"address": where}), **how)
    except (OSError, ValueError, KeyError, TypeError, TimeoutError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"the scheduler {scheduler} does not answer: {reason}") from error


def _check_answers(address: str) -> None:
    """Raise OSError or ValueError if no scheduler answers at an address.

    A client that cannot connect waits 40 s at the end of the process and leaves a traceback there.
    """
    if address.startswith(("http://", "https://")):
        raise ValueError("this is the dashboard; the scheduler's address is like tcp://host:8786")
    address = distributed.core.coerce_to_address(address)
    if address.startswith("inproc://"):
        return
    answered: Future[None] = Future()
    how = distributed.Security().get_connection_args("client")

    async def connect() -> None:
        comm = await distributed.comm.connect(address, timeout=CONNECT_WAIT, **how)
        await comm.close()

    def ask() -> None:
        try:
            # the dashboard's server accepts the connection but never answers in Dask's protocol
            asyncio.run(asyncio.wait_for(connect(), CONNECT_WAIT))
        except TimeoutError as error:
            answered.set_exception(OSError(str(error) or f"no scheduler there within {CONNECT_WAIT:g} s"))
        except Exception as error:
            answered.set_exception(error)
        else:
            answered.set_result(None)

    # the caller's thread may run an event loop, as a notebook does
    Thread(target=ask, daemon=True).start()
    answered.result()


def _check_workers(client: distributed.Client, runs: Path) -> None:
    """Raise ValueError if a present worker cannot do the tasks of a sweep; later workers check themselves."""
    # by name: a worker without the package fails on the import
    answers = client.run(check_worker, own_versions(), str(runs), client.id, on_error="return")
    for where, answer in answers.items():
        if isinstance(answer, ValueError):
            raise answer
        if isinstance(answer, BaseException):
            raise ValueError(f"worker {where} does not have the package: {answer}")


def check_worker(
    versions: dict[str, str], runs: str, token: str | None, dask_worker: distributed.Worker
) -> None:
    """Raise ValueError for a worker with other versions, several threads, or no view of the token."""
    where = dask_worker.address
    check_versions(versions, own_versions(), where)
    threads = dask_worker.state.nthreads
    if threads > 1:
        raise ValueError(
            f"worker {where} must have one thread, got {threads}: a run needs a process of its own, start "
            "workers with --nthreads 1 and as many as there are cores (--nworkers)"
        )
    if token is not None and not sees(runs, token):
        raise ValueError(f"worker {where} must see {runs}: put it on storage that all machines share")


def run_alone(task: Task) -> Outcome:
    """Run a task with `run_task` on a worker of a cluster; raises as `check_worker`."""
    check_worker(task.versions, task.runs, task.token, distributed.get_worker())
    # xarray would otherwise lock the files of a run on the whole cluster
    with _one_run, dask.config.set(scheduler="synchronous"):
        return run_task(task)


def outcomes(
    client: distributed.Client,
    tasks: Iterator[Task],
    run: Callable[[Task], Outcome] = run_alone,
    wait: float | None = None,
    report: Callable[[str], None] = lambda _text: None,
) -> Generator[Outcome, None, None]:
    """Yield the outcomes of tasks as they finish.

    Tasks are submitted before there is a worker: adaptive clusters start one only then. Raises as
    `check_worker`, TimeoutError if there is no worker for `wait` s, ConnectionError if the scheduler is lost.
    """
    submitted = _Submitted(client, tasks, run)
    try:
        submitted.fill()
        awaited = _Awaited(client.scheduler.address, wait, report)
        looked = time.monotonic()
        while submitted.held:
            outcome = submitted.next(LOOK)
            if outcome is not None:
                yield outcome
            if time.monotonic() > looked + LOOK:
                awaited.look(submitted.fill())
                looked = time.monotonic()
    except (distributed.client.FutureCancelledError, distributed.comm.CommClosedError) as error:
        raise ConnectionError(f"the scheduler was lost; finished runs are kept: {GOES_ON}") from error
    finally:
        submitted.cancel()


class _Submitted:
    """Tasks on a scheduler: a part of the sweep, since all would be too many."""

    def __init__(
        self, client: distributed.Client, tasks: Iterator[Task], run: Callable[[Task], Outcome]
    ) -> None:
        self.client = client
        self.tasks = tasks
        self.run = run
        self.held: dict[str, tuple[distributed.Future, Task]] = {}
        self.finished: SimpleQueue[str] = SimpleQueue()

    def fill(self) -> int:
        """Submit tasks for all present workers, and return the number of workers."""
        try:
            workers = len(self.client.nthreads())
        except OSError as error:
            raise distributed.comm.CommClosedError(str(error)) from error
        self._submit(max(LEAST_AHEAD, AHEAD * workers) - len(self.held))
        return workers

    def _submit(self, count: int) -> None:
        for task in islice(self.tasks, max(count, 0)):
            seen = replace(task, token=self.client.id)
            future = self.client.submit(self.run, seen, key=f"run-{task.digest}", pure=False)
            self.held[future.key] = future, task
            future.add_done_callback(lambda done: self.finished.put(done.key))

    def next(self, timeout: float) -> Outcome | None:
        """Return the outcome of a finished task, and submit another one in its place.

        Returns None if no task finishes within `timeout` (s); raises the error of the task.
        """
        try:
            future, task = self.held.pop(self.finished.get(timeout=timeout))
        except Empty:
            return None
        try:
            outcome: Outcome = future.result()
        except distributed.scheduler.KilledWorker as error:
            times = error.allowed_failures + 1
            last = error.last_worker.address
            reason = f"{times} workers died while they ran it, the last one {last}"
            outcome = write_outcome(task, CrawlerError(reason), {})
        except ImportError as error:
            raise ValueError(f"a worker does not have the package: {error}") from error
        future.release()
        self._submit(1)
        return outcome

    def cancel(self) -> None:
        """Cancel the remaining tasks: the scheduler may continue without this sweep."""
        if self.held and self.client.status == "running":
            self.client.cancel([future for future, _ in self.held.values()])


class _Awaited:
    """Workers that a batch system starts from its queue."""

    def __init__(self, address: str, wait: float | None, report: Callable[[str], None]) -> None:
        self.address = address
        self.wait = wait
        self.report = report
        self.seen = time.monotonic()
        self.is_told = False

    def look(self, workers: int) -> None:
        """Report once that there is no worker; raise TimeoutError if there has been none for `wait` s."""
        if workers:
            self.seen = time.monotonic()
            self.is_told = False
            return
        if self.wait is not None and time.monotonic() - self.seen > self.wait:
            limit = f"within {self.wait:g} s"
            raise TimeoutError(f"{self.address} must have a worker {limit}, got none: {GOES_ON}")
        if not self.is_told:
            limit = "as long as it takes" if self.wait is None else f"up to {self.wait:g} s"
            self.report(f"waiting for a worker at {self.address}, {limit}")
            self.is_told = True
