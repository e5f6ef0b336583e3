"""Runs as their folders say: waiting, at work, stopped, failed, done."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from exudyn_crawler.case import Case
from exudyn_crawler.machines import CaseFile, read_case
from exudyn_crawler.run.folder import queue, record
from exudyn_crawler.run.folder.queue import DONE, FAILED, RUNNING, STOPPED, WAITING, Runs

CASE = CaseFile(case=Case.translation(), duration=0.02)


@pytest.fixture
def runs(tmp_path):
    return Runs(tmp_path)


def noted(home, **content):
    (home / record.RECORD).write_text(json.dumps(content))


def ended_process():
    """Number that no process has."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_a_case_waits_in_a_folder_of_its_name_and_can_be_taken_out(runs):
    assert runs.add(CASE, "mine") == "mine"
    home = runs.folder / "mine"
    assert read_case(home / "case.toml") == CASE
    assert runs.named("mine").status == WAITING
    assert runs.add(CASE, "mine") == "mine_2"
    for name in ("mine", "mine_2"):
        runs.stop(name)
    assert runs.all() == []
    assert not home.exists()


def test_a_folder_says_how_its_run_is(runs):
    home = runs.folder / runs.add(CASE, "mine")
    (home / queue.WAITS).unlink()
    assert runs.named("mine").status == FAILED
    noted(home, status="running", process=ended_process())
    assert runs.named("mine").status == STOPPED
    # another process has the number, and does not hold the folder
    noted(home, status="running", process=os.getpid())
    assert runs.named("mine").status == STOPPED
    with record.held(home):
        assert runs.named("mine").status == RUNNING
    noted(home, status="done")
    assert runs.named("mine").status == DONE
    noted(home, status="stopped")
    runs.go_on("mine")
    assert runs.named("mine").status == WAITING
    runs.stop("mine")
    assert runs.named("mine").status == STOPPED


def test_runs_start_one_after_the_other_as_processes_that_outlive_the_page(runs, monkeypatch):
    # in place of a run a process that holds its folder until it is asked to stop
    script = (
        "import json, os, pathlib, signal, sys, time; from exudyn_crawler.run.folder import record;"
        "home = pathlib.Path(sys.argv[-1]);"
        "lock = record.held(home); lock.__enter__();"
        "(home / 'run.json').write_text(json.dumps({'status': 'running', 'process': os.getpid()}));"
        "print('at work', flush=True); time.sleep(60)"
    )
    monkeypatch.setattr(queue, "COMMAND", (sys.executable, "-c", script))
    for name in ("first", "second"):
        runs.add(CASE, name)
    runs.start_next()
    runs.start_next()
    home = runs.folder / "first"
    while not (home / record.RECORD).exists():
        assert runs.named("first").status == RUNNING
        time.sleep(0.05)
    assert runs.named("second").status == WAITING
    number = json.loads((home / record.RECORD).read_text())["process"]
    assert os.getsid(number) == number
    # the next start of the program finds it at work, and can stop it
    later = Runs(runs.folder.parent)
    assert later.named("first").status == RUNNING
    later.stop("first")
    runs._started["first"].wait(10)
    assert later.named("first").status == STOPPED


@pytest.mark.skipif(sys.platform == "win32", reason="needs locks that a process inherits")
def test_a_run_that_starts_is_at_work_for_a_page_that_begins_anew(runs, monkeypatch):
    # a process that has not come so far as to hold its folder
    monkeypatch.setattr(queue, "COMMAND", (sys.executable, "-c", "import time; time.sleep(60)"))
    for name in ("first", "second"):
        runs.add(CASE, name)
    # what a process of before has left
    noted(runs.folder / "first", status="stopped", process=os.getpid())
    runs.start_next()
    later = Runs(runs.folder.parent)
    assert later.named("first").status == RUNNING
    later.start_next()
    assert later.named("second").status == WAITING
    later.stop("first")
    assert runs._started["first"].wait(10) == -signal.SIGTERM
    assert later.named("first").status == STOPPED
    later.start_next()
    assert later.named("second").status == RUNNING
    later.stop("second")
    later._started["second"].wait(10)


def test_one_process_has_the_queue_of_a_folder(runs):
    with (
        runs.held(),
        pytest.raises(BlockingIOError, match=f"{runs.folder.parent} has a page .* process {os.getpid()}"),
        Runs(runs.folder.parent).held(),
    ):
        pass
    with Runs(runs.folder.parent).held():
        assert runs.all() == []
