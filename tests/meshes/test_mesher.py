"""The mesher's process: results and errors come back, crashes, hangs and interrupts end it alone."""

import os
import signal
import threading
import time
from pathlib import Path

import pytest

from fem.body.mesh import MeshError
from meshes import mesher


def doubled(value):
    print("lines of the mesher")
    os.system("echo lines of compiled code >&2")
    return 2 * value


def refused(value):
    raise ValueError(f"value must be small, got {value}")


def crashes():
    mesher.begin_step("the meshing of its surface", "the solid has an edge 0.5 um long")
    os.write(2, b"double free or corruption (out)\n")
    os.abort()


def hangs(path):
    mesher.begin_step("the meshing of the solid")
    path.write_text(str(os.getpid()))
    # as compiled code that holds the interpreter
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    time.sleep(60.0)


def hangs_when_told(path, go):
    mesher.begin_step("the reading of the file")
    path.write_text("reads")
    while not go.exists():
        time.sleep(0.01)
    hangs(path)


def test_results_and_errors_come_back_and_lines_do_not(capfd):
    assert mesher.call(doubled, 21) == 42
    with pytest.raises(ValueError, match="value must be small, got 7"):
        mesher.call(refused, 7)
    with pytest.raises(FileNotFoundError):
        mesher.call(os.stat, "/no/such/file")
    assert capfd.readouterr() == ("", "")


def test_a_crash_is_told_of_with_the_step_and_what_may_have_caused_it():
    words = (
        r"netgen crashed during the meshing of its surface \(SIGABRT: double free or corruption \(out\)\); "
    )
    with pytest.raises(MeshError, match=words + "the solid has an edge 0.5 um long"):
        mesher.call(crashes)


def test_a_step_that_takes_too_long_is_ended(tmp_path, monkeypatch):
    path, go = tmp_path / "pid", tmp_path / "go"

    def shorten():
        # not before the process has started, which may take seconds
        while not path.exists():
            time.sleep(0.01)
        monkeypatch.setattr(mesher, "LONGEST", 0.5)
        go.touch()

    thread = threading.Thread(target=shorten)
    thread.start()
    with pytest.raises(
        MeshError, match=r"netgen was ended after 0\.5 s during the meshing of the solid; heal"
    ):
        mesher.call(hangs_when_told, path, go)
    thread.join()


def test_an_interrupt_ends_the_mesher(tmp_path):
    path: Path = tmp_path / "pid"

    def interrupt():
        while not (path.is_file() and path.read_text(encoding="utf-8")):
            time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        mesher.call(hangs, path)
    thread.join()
    with pytest.raises(ProcessLookupError):
        os.kill(int(path.read_text(encoding="utf-8")), 0)
