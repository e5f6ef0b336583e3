"""Progress: a bar on a terminal, lines elsewhere, numbers only."""

import logging
import threading
import time as clock

import pytest

from exudyn_crawler import Case, CaseFile
from exudyn_crawler.run.folder import progress
from tests.rolled import small_flexible_case


def run(duration=1.0, start=0.0, steps=5, **options):
    with progress.progress_bar("haul", duration, **options) as tell:
        for step in range(steps + 1):
            tell(start + (duration - start) * step / steps)


def test_a_pipe_gets_a_line_now_and_then(monkeypatch, capsys):
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    run()
    told = capsys.readouterr()
    assert told.out == ""
    lines = told.err.splitlines()
    # nothing is known of the speed before the second step, and the end is told by others
    assert lines[:2] == ["haul: 0 of 1 s", "haul: 0.2 of 1 s"]
    assert len(lines) == 5
    assert all("s wall per s, about " in line and line.endswith(" s left") for line in lines[2:])
    assert "nan" not in told.err


def test_a_resumed_run_is_as_fast_as_it_is_now(monkeypatch, capsys):
    """What lies before the start and the first step, which compiles, say nothing of its speed."""
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    clocks = iter([0.0, 1.0, 30.0, 33.0])
    monkeypatch.setattr(progress.clock, "perf_counter", lambda: next(clocks))
    with progress.progress_bar("haul", 100.0) as tell:
        for time in (89.0, 90.0, 91.0):
            tell(time)
    assert capsys.readouterr().err.splitlines()[2] == "haul: 91 of 100 s, 3 s wall per s, about 27 s left"


def test_short_runs_say_nothing(capsys):
    run()
    assert capsys.readouterr() == ("", "")


def test_a_bar_has_numbers_only(capsys, monkeypatch):
    monkeypatch.setattr(progress, "REFRESH", 0.0)
    run(show=True)
    told = capsys.readouterr().err
    assert "1.00 of 1 s" in told
    assert "nan" not in told


@pytest.mark.parametrize("fails", [False, True])
def test_a_heart_beats_until_the_end(monkeypatch, capsys, fails):
    monkeypatch.setattr(progress, "LINE_EVERY", 0.02)
    try:
        with progress.heartbeat("drawing"):
            clock.sleep(0.2)
            if fails:
                raise ArithmeticError
    except ArithmeticError:
        assert fails
    assert set(capsys.readouterr().err.splitlines()) == {"drawing: 0 s so far"}
    clock.sleep(0.05)
    assert capsys.readouterr().err == ""


def test_a_log_has_the_progress_of_all_parts(monkeypatch, caplog, capsys):
    """Also where nothing is shown, as on a worker of a sweep."""
    monkeypatch.setattr(progress, "LINE_EVERY", 0.02)
    with caplog.at_level(logging.INFO, "exudyn_crawler"), progress.heartbeat("drawing", 60.0, show=False):
        clock.sleep(0.1)
    assert set(caplog.messages) == {"drawing: 0 s so far, 0 of about 60 s of processor time"}
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    with caplog.at_level(logging.INFO, "exudyn_crawler"):
        run(show=False)
    assert "haul: 0.2 of 1 s" in caplog.messages
    assert capsys.readouterr() == ("", "")


def test_what_is_left_is_by_how_fast_a_part_has_been(monkeypatch, caplog):
    """A machine whose processors have other work: 2 s of processor time took 10 s."""
    monkeypatch.setattr(progress, "LINE_EVERY", 0.02)
    processor = iter([0.0, 2.0, *[70.0] * 1000])
    wall = iter([0.0, 0.0, *[10.0] * 1000])
    monkeypatch.setattr(progress.clock, "process_time", lambda: next(processor))
    monkeypatch.setattr(progress.clock, "perf_counter", lambda: next(wall))
    waiting = threading.Event()
    with caplog.at_level(logging.INFO, "exudyn_crawler"), progress.heartbeat("drawing", 60.0, show=False):
        waiting.wait(0.2)
    assert caplog.messages[0] == "drawing: 10 s so far, 2 of about 60 s of processor time, about 290 s left"


def test_more_than_the_rule_says_is_said():
    assert progress._of_expected(70.0, 60.0, 100.0) == (
        ", 70 s of processor time, more than the 60 s of the rule"
    )


def test_a_terminal_has_a_bar_of_what_is_expected(capsys):
    with progress.heartbeat("drawing", 60.0, show=True):
        clock.sleep(0.3)
    shown = capsys.readouterr().err
    assert "drawing" in shown
    assert "of about 60 s" in shown


def test_parts_that_stay_on_a_machine_are_told_apart():
    case = small_flexible_case().with_({"flexible.mesh": "coarse"})
    line = progress.times_line(progress.rule_of_thumb(CaseFile(case=case, duration=1.0)))
    every, once = line.split(", at the first start on a computer about ")
    assert every.startswith("time: about ")
    for part in (progress.SIMULATE, progress.RECOVER, progress.WRITE):
        assert f"{part} " in every
    assert (
        "(reduce the flexible shoe 8.3 s, static fields of the shoe 4.1 s, compile the equations 50 s" in once
    )
    assert once.endswith(" more, by a rule of thumb")
    rigid = CaseFile(case=Case.translation().with_({"formulation": "engine"}), duration=1.0)
    assert "once" not in progress.times_line(progress.rule_of_thumb(rigid))
