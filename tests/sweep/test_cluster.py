"""Workers that die, schedulers that do not answer, sweeps that are killed: by really doing so."""

import asyncio
import json
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import urlsplit

import dask
import psutil
import pytest
from distributed import Client, LocalCluster, get_client

from docs.rooms import ROOT
from exudyn_crawler import Case, CaseFile
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.model.reductions import VARIABLE
from exudyn_crawler.sweep import cluster
from exudyn_crawler.sweep.answers import Answer, HotSpot
from exudyn_crawler.sweep.cluster import _scheduler, connected, outcomes
from exudyn_crawler.sweep.definition import Sweep
from exudyn_crawler.sweep.running import run_sweep
from exudyn_crawler.sweep.vary import Vary
from exudyn_crawler.sweep.worker import Task, check_versions, own_versions
from tests.sweep.cases import FORCE, STIFFNESS, small_sweep

pytestmark = pytest.mark.usefixtures("without_reports")


def running(folder: Path) -> list[int]:
    """Processes that work at runs of a sweep."""
    records = [json.loads(path.read_text()) for path in folder.glob("runs/*/run.json")]
    return [record["process"] for record in records if record["status"] == "running"]


def kill_the_first_at_work(folder: Path, killed: list[int]) -> threading.Thread:
    """Kill the first process that works at a run, as soon as it does."""

    def kill():
        give_up = time.monotonic() + 120.0
        while not killed and time.monotonic() < give_up:
            if found := running(folder):
                os.kill(found[0], signal.SIGKILL)
                killed.append(found[0])
            time.sleep(0.005)

    thread = threading.Thread(target=kill, daemon=True)
    thread.start()
    return thread


def settings_of_the_process():
    """What a sweep could leave otherwise in the process that calls it, such as a notebook's."""
    return {
        "environment": dict(os.environ),
        "folder": os.getcwd(),
        "dask": json.dumps(dask.config.config, default=str),
        "signals": [signal.getsignal(one) for one in signal.valid_signals()],
        "levels": {name: logging.getLogger(name).level for name in ("", "distributed", "bokeh")},
        "hooks": (sys.excepthook, sys.stdout, sys.stderr, warnings.showwarning),
    }


@pytest.mark.simulation
def test_processes_of_a_sweep_on_this_machine_are_not_reached_from_others(tmp_path):
    with connected(None, 1, tmp_path, lambda _text: None):
        own = psutil.Process()
        reached = [
            connection.laddr.ip
            for process in (own, *own.children(recursive=True))
            for connection in process.net_connections()
            if connection.status == psutil.CONN_LISTEN
        ]
    # scheduler, nanny and worker, those of the dashboards beside them
    assert len(reached) >= 3
    assert set(reached) == {"127.0.0.1"}


@pytest.mark.slow
def test_a_cluster_leaves_the_process_as_it_was(tmp_path):
    before = settings_of_the_process()
    with connected(None, 2, tmp_path, print) as client:
        # two runs in one process would take turns
        assert [*client.nthreads().values()] == [1, 1]
        assert len({os.getpid(), *client.run(os.getpid).values()}) == 3
        assert client.submit(os.environ.get, "OMP_NUM_THREADS").result() == "1"
    assert settings_of_the_process() == before
    with pytest.raises(ValueError, match="No global client"):
        get_client()


UNGUARDED = """
import os
from exudyn_crawler.sweep.cluster import connected
from pathlib import Path
with connected(None, 1, Path("."), lambda _text: None) as client:
    print(len({os.getpid(), *client.run(os.getpid).values()}))
"""


@pytest.mark.slow
def test_a_script_without_a_guard_starts_its_workers_once(tmp_path):
    (tmp_path / "script.py").write_text(UNGUARDED)
    done = subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert (done.stderr, done.stdout) == ("", "2\n")


@pytest.mark.slow
def test_a_worker_that_is_killed_is_survived(scheduler, tmp_path):
    sweep, killed = small_sweep(0.5), []
    thread = kill_the_first_at_work(tmp_path / "killed", killed)
    run = run_sweep(sweep, tmp_path / "killed", workers=2, progress=False)
    thread.join()
    assert len(killed) == 1
    assert killed[0] != os.getpid()
    assert run.table["status"].tolist() == ["done", "done"]
    whole = run_sweep(sweep, tmp_path / "whole", scheduler=scheduler, progress=False)
    assert run.table[FORCE.label].tolist() == whole.table[FORCE.label].tolist()
    finished_by = {json.loads(path.read_text())["process"] for path in run.folder.glob("runs/*/outcome.json")}
    assert killed[0] not in finished_by


@pytest.mark.slow
def test_a_run_whose_workers_die_fails_with_this_reason_and_may_be_retried(tmp_path):
    sweep, killed = small_sweep(0.5, vary=(Vary(key=STIFFNESS, values=(1e7,)),)), []
    thread = kill_the_first_at_work(tmp_path, killed)
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}):
        run = run_sweep(sweep, tmp_path, workers=1, progress=False)
    thread.join()
    assert run.table["status"].tolist() == ["failed"]
    assert "1 workers died while they ran it" in run.table["reason"][0]
    again = run_sweep(sweep, tmp_path, workers=1, progress=False, retry=True)
    assert again.table["status"].tolist() == ["done"]


OTHER, OTHERS = {"exudyn": "0.1"}, r"worker .* has other versions: exudyn "
SWEEP = """
[case]
base = "translation"
duration = 1.0
[case.solver]
checkpoint_interval = 0.2
[[vary]]
key = "terrain.spring_stiffness"
values = [1e7, 2e7, 3e7, 4e7, 5e7, 6e7]
[[answers]]
quantity = "joint_force"
"""
COMMAND = [sys.executable, "-m", "exudyn_crawler", "sweep", "s.toml", "--workers", "2", "--out"]


def rows_without_times(folder: Path) -> list[str]:
    return [line.rpartition(",")[0] for line in (folder / "results.csv").read_text().splitlines()]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Results of the sweep that nothing stops."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "s.toml").write_text(SWEEP)
    subprocess.run([*COMMAND, "out"], cwd=folder, check=True, capture_output=True)
    return rows_without_times(folder / "out")


@pytest.mark.slow
@pytest.mark.parametrize("kind", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_a_sweep_that_is_stopped_goes_on(tmp_path, kind, whole):
    (tmp_path / "s.toml").write_text(SWEEP)
    process = subprocess.Popen(
        [*COMMAND, "stopped"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # tests that a shell runs in the background ignore SIGINT, and what they start does
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    while not list(tmp_path.glob("stopped/runs/*/outcome.json")):
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(kind)
    _, told = process.communicate(timeout=60)
    if kind != signal.SIGKILL:
        assert process.returncode == 130
        assert told.splitlines()[-1] == "error: interrupted; run the same command again to continue"
    before = {
        path: path.stat().st_mtime_ns
        for path in tmp_path.glob("stopped/runs/*/history.nc")
        if (path.parent / "outcome.json").is_file()
    }
    assert 0 < len(before) < 6
    # workers whose sweep was killed end soon
    give_up = time.monotonic() + 60.0
    while any(Path(f"/proc/{pid}").exists() for pid in running(tmp_path / "stopped")):
        assert time.monotonic() < give_up
        time.sleep(0.1)
    again = subprocess.run([*COMMAND, "stopped"], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert f"6 runs: {len(before)} done" in again.stdout
    assert all(path.stat().st_mtime_ns == time for path, time in before.items())
    assert rows_without_times(tmp_path / "stopped") == whole


@pytest.mark.slow
@pytest.mark.parametrize("after", [0.0, 1.0, 3.0])
def test_a_sweep_that_is_stopped_while_workers_start_says_so_in_a_line(tmp_path, after):
    (tmp_path / "s.toml").write_text(SWEEP)
    how = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen([*COMMAND, "out"], cwd=tmp_path, **how)
    assert process.stdout.readline() == "6 runs: 0 done, 6 to run\n"
    time.sleep(after)
    process.terminate()
    _, told = process.communicate(timeout=120)
    assert process.returncode == 130
    assert told == "error: interrupted; run the same command again to continue\n"


def test_a_scheduler_that_does_not_answer_is_told_in_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "CONNECT_WAIT", 0.5)
    for address, told in (
        ("tcp://127.0.0.1:9", "the scheduler tcp://127.0.0.1:9 does not answer: "),
        (str(tmp_path / "none.json"), "none.json does not answer: no such file"),
        ("nowhere", "the scheduler nowhere does not answer"),
        ("http://127.0.0.1:8787/status", "this is the dashboard; the scheduler's address is like tcp://"),
    ):
        with pytest.raises(ValueError, match=r"the scheduler .* does not answer") as refused:
            run_sweep(small_sweep(), tmp_path / "out", scheduler=address)
        assert told in str(refused.value)
        assert "\n" not in str(refused.value)
    assert list((tmp_path / "out" / "runs").iterdir()) == []
    assert dask.config.get("scheduler", None) is None


def test_a_server_that_is_no_scheduler_is_told_in_time_and_leaves_nothing_behind(tmp_path, monkeypatch):
    """A client that fails to connect is closed at the end of the process, after 40 s, with a traceback."""
    monkeypatch.setattr(cluster, "CONNECT_WAIT", 0.5)
    made = []

    class Noted(Client):
        def __init__(self, *given, **how):
            made.append(given)

        def __del__(self):
            """Have nothing to close."""

    monkeypatch.setattr(cluster.distributed, "Client", Noted)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with (
            pytest.raises(ValueError, match=f"^the scheduler {address} does not answer: "),
            connected(address, None, tmp_path, print),
        ):
            pass
    assert made == []


@pytest.mark.parametrize(
    ("name", "instead", "told"),
    [
        ("check_versions", lambda wanted, *there: check_versions(wanted | OTHER, *there), OTHERS),
        ("sees", lambda *_: False, r"must see .*runs: put it on storage that all machines share"),
    ],
)
def test_workers_that_cannot_do_the_same_are_refused(scheduler, tmp_path, monkeypatch, name, instead, told):
    monkeypatch.setattr(cluster, name, instead)
    with pytest.raises(ValueError, match=told):
        run_sweep(small_sweep(), tmp_path, scheduler=scheduler)
    assert list((tmp_path / "runs").iterdir()) == []


def test_a_worker_of_another_version_that_comes_later_ends_the_sweep(scheduler, tmp_path):
    task = Task("0" * 64, "", "[]", str(tmp_path), None, own_versions() | OTHER)
    with (
        connected(scheduler, None, tmp_path, print) as client,
        pytest.raises(ValueError, match="has other versions: exudyn "),
    ):
        list(outcomes(client, iter([task])))


def in_process(workers: int, threads: int = 1) -> LocalCluster:
    """Cluster whose workers are threads of this process."""
    how = {"n_workers": workers, "threads_per_worker": threads, "processes": False}
    return LocalCluster(**how, dashboard_address="127.0.0.1:0")


def empty_tasks(count: int, folder: Path) -> list[Task]:
    return [Task(f"{k:064d}", "", "[]", str(folder), None, own_versions()) for k in range(count)]


def digest_of(task: Task) -> dict[str, str]:
    """Outcome of a task that does nothing."""
    return {"digest": task.digest}


def test_a_sweeps_own_scheduler_is_heard_on_this_machine_alone():
    with _scheduler() as cluster:
        served = [cluster.scheduler_address, cluster.dashboard_link]
    assert [urlsplit(address).hostname for address in served] == ["127.0.0.1", "127.0.0.1"]


def test_tasks_are_there_before_an_adaptive_cluster_has_a_worker(tmp_path):
    """Which starts its first one for them."""
    tasks = empty_tasks(3, tmp_path)
    with in_process(0) as adaptive:
        adaptive.adapt(minimum=0, maximum=1, interval="50 ms")
        with connected(adaptive, None, tmp_path, print) as client:
            assert client.nthreads() == {}
            came = [one["digest"] for one in outcomes(client, iter(tasks), digest_of, wait=30.0)]
    assert sorted(came) == [task.digest for task in tasks]


def test_a_queue_is_waited_for_as_long_as_asked(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "LOOK", 0.02)
    told = []
    with (
        in_process(0) as empty,
        connected(empty.scheduler_address, None, tmp_path, print) as client,
        pytest.raises(TimeoutError, match=r"must have a worker within 0\.1 s, got none: run the same"),
    ):
        list(outcomes(client, iter(empty_tasks(1, tmp_path)), digest_of, wait=0.1, report=told.append))
    assert told == [f"waiting for a worker at {empty.scheduler_address}, up to 0.1 s"]


def test_clusters_and_clients_are_taken_and_left_open(scheduler, tmp_path):
    tasks = empty_tasks(2, tmp_path)
    with in_process(1) as own, Client(scheduler, set_as_default=False) as caller:
        for taken in (own, caller):
            with connected(taken, None, tmp_path, print) as client:
                assert len(list(outcomes(client, iter(tasks), digest_of))) == 2
        assert own.status.name == caller.status == "running"
        assert caller.submit(abs, -1).result() == 1
    assert [*tmp_path.iterdir()] == []
    with (
        pytest.raises(ValueError, match=r"^the scheduler 5 does not answer: [^\n]*$"),
        connected(5, None, tmp_path, print),
    ):
        pass


def test_a_client_that_does_not_wait_is_refused(scheduler, tmp_path):
    async def refused() -> None:
        async with Client(scheduler, asynchronous=True, set_as_default=False) as own:
            with (
                pytest.raises(ValueError, match="got an asynchronous one"),
                connected(own, None, tmp_path, print),
            ):
                pass

    # the thread of the tests may have a loop of its own
    with ThreadPoolExecutor(1) as pool:
        pool.submit(lambda: asyncio.run(refused())).result()


def test_workers_of_several_threads_are_refused_also_later(tmp_path):
    told = "must have one thread, got 4: a run needs a process of its own"
    with in_process(1, threads=4) as wide, Client(wide, set_as_default=False) as client:
        with pytest.raises(ValueError, match=told), connected(wide, None, tmp_path, print):
            pass
        with pytest.raises(ValueError, match=told):
            list(outcomes(client, iter(empty_tasks(1, tmp_path))))


def test_a_worker_that_joins_later_must_see_the_folder(scheduler, tmp_path):
    tasks = empty_tasks(1, tmp_path / "elsewhere")
    with (
        connected(scheduler, None, tmp_path, print) as client,
        pytest.raises(ValueError, match="elsewhere: put it on storage that all machines share"),
    ):
        list(outcomes(client, iter(tasks)))
    assert not (tmp_path / "elsewhere").exists()


def test_a_worker_without_the_package_ends_the_sweep(scheduler, tmp_path):
    def lacking(_task):
        raise ModuleNotFoundError("No module named 'exudyn_crawler'")

    with (
        connected(scheduler, None, tmp_path, print) as client,
        pytest.raises(ValueError, match="a worker does not have the package: No module named"),
    ):
        list(outcomes(client, iter(empty_tasks(1, tmp_path)), lacking))


def test_two_workers_in_one_process_take_turns(tmp_path, monkeypatch):
    working, most = [], []

    def work(task):
        working.append(task.digest)
        most.append(len(working))
        time.sleep(0.02)
        working.remove(task.digest)
        return digest_of(task)

    monkeypatch.setattr(cluster, "run_task", work)
    with in_process(2) as two, connected(two, None, tmp_path, print) as client:
        assert len(list(outcomes(client, iter(empty_tasks(6, tmp_path))))) == 6
    assert most == [1] * 6


def test_more_workers_have_more_tasks(scheduler, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "LEAST_AHEAD", 1)
    with connected(scheduler, None, tmp_path, print) as client:
        submitted = cluster._Submitted(client, iter(empty_tasks(9, tmp_path)), digest_of)
        assert submitted.fill() == 1
        assert len(submitted.held) == cluster.AHEAD
        submitted.cancel()


def test_the_scheduler_holds_few_tasks_at_a_time(scheduler, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "LEAST_AHEAD", 5)
    asked, came = [], []

    def tasks():
        for k in range(40):
            asked.append(k)
            yield Task(f"{k:064d}", "", "[]", str(tmp_path), None, {})

    with connected(scheduler, None, tmp_path, print) as client:
        for outcome in outcomes(client, tasks(), lambda task: {"digest": task.digest}):
            came.append(outcome["digest"])
            assert len(asked) - len(came) <= 5
    assert sorted(came) == [f"{k:064d}" for k in range(40)]


@pytest.mark.slow
def test_workers_reduce_a_shoe_once_for_all_grounds(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    base = Case.stress("coarse")
    case = base.with_(flexible=base.part(FlexibleShoes).with_(shoes=(13,)))
    sweep = Sweep(
        case=CaseFile(case=case, duration=0.02),
        vary=(Vary(key=STIFFNESS, values=(1e7, 2e7, 4e7)),),
        answers=(HotSpot(shoe=13), Answer(quantity="highest_von_mises")),
    )
    run = run_sweep(sweep, tmp_path / "sweep", workers=2, progress=False)
    assert run.table["status"].tolist() == ["done"] * 3
    found = {}
    for path in run.folder.glob("runs/*/outcome.json"):
        took = "the reduced shoe is taken from" in (path.parent / "run.log").read_text()
        found.setdefault(json.loads(path.read_text())["process"], []).append(took)
    # one process makes it and remembers it, the other one finds it on disk and remembers it, too
    assert sorted(map(any, found.values())) == [False, True]
    kept = sorted("".join(path.suffixes) for path in (tmp_path / "cache" / "reductions").glob("[!.]*.h5"))
    assert kept == [".fields.h5", ".h5"]
    hot, highest = (run.table[answer.label].to_numpy() for answer in sweep.answers)
    assert hot == pytest.approx(highest, rel=1e-6)
    assert (hot > 1e6).all()


@pytest.mark.slow
def test_a_scheduler_elsewhere_runs_a_sweep_by_its_address_and_by_its_file(tmp_path):
    (tmp_path / "s.toml").write_text(SWEEP.replace("duration = 1.0", "duration = 0.02"))
    file = tmp_path / "scheduler.json"
    dask_command = [sys.executable, "-m", "dask"]
    ends = ["--scheduler-file", str(file)]
    begin = {"cwd": tmp_path, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen(
        [*dask_command, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *ends], **begin
    )
    worker = subprocess.Popen([*dask_command, "worker", "--nworkers", "1", "--nthreads", "1", *ends], **begin)
    try:
        while not file.is_file():
            assert scheduler.poll() is None
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        for out, where in (("by_file", str(file)), ("by_address", address)):
            command = [sys.executable, "-m", "exudyn_crawler", "sweep", "s.toml", "--out", out]
            done = subprocess.run(
                [*command, "--scheduler", where], cwd=tmp_path, check=True, capture_output=True, text=True
            )
            assert "6 runs: 0 done, 6 to run" in done.stdout
            assert len(list((tmp_path / out / "runs").glob("*/history.nc"))) == 6
        (tmp_path / "s.toml").write_text(SWEEP)
        lost = subprocess.Popen(
            [*command[:-1], "lost", "--scheduler", address], cwd=tmp_path, stderr=subprocess.PIPE, text=True
        )
        while not list(tmp_path.glob("lost/runs/*/outcome.json")):
            assert lost.poll() is None
            time.sleep(0.02)
        scheduler.kill()
        *progress, line = lost.communicate(timeout=60)[1].splitlines()
        assert lost.returncode == 1
        told = "error: the scheduler was lost; finished runs are kept: run the same command again to continue"
        assert line == told
        assert all(one.startswith("sweep: ") for one in progress)
    finally:
        for process in (worker, scheduler):
            process.terminate()
            process.wait(60.0)
