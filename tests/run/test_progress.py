"""Progress: a bar on a terminal, lines elsewhere, numbers only."""

import logging
import time as clock

import pytest

from exudyn_crawler import CaseFile
from exudyn_crawler.model.reductions import reductions_in
from exudyn_crawler.run.folder import progress
from exudyn_crawler.run.folder.progress import (
    EARLIER,
    FIELDS,
    ONCE,
    REDUCE,
    SIMULATE,
    RunTimes,
    heartbeat,
    progress_bar,
    rule_of_thumb,
)
from tests.rolled import small_flexible_case


def run(duration=1.0, start=0.0, steps=5, **options):
    with progress_bar("haul", duration, **options) as tell:
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
    with progress_bar("haul", 100.0) as tell:
        for time in (89.0, 90.0, 91.0):
            tell(time)
    assert capsys.readouterr().err.splitlines()[2] == "haul: 91 of 100 s, 3 s wall per s, about 27 s left"


def test_short_runs_and_quiet_ones_say_nothing(monkeypatch, capsys):
    run()
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    run(show=False)
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
        with heartbeat("drawing"):
            clock.sleep(0.2)
            if fails:
                raise ArithmeticError
    except ArithmeticError:
        assert fails
    lines = capsys.readouterr().err.splitlines()
    assert set(lines) == {"drawing: 0 s so far"}
    clock.sleep(0.05)
    assert capsys.readouterr().err == ""


def test_a_log_has_the_progress_of_all_parts(monkeypatch, caplog, capsys):
    """Also where nothing is shown, as on a worker of a sweep."""
    monkeypatch.setattr(progress, "LINE_EVERY", 0.02)
    with caplog.at_level(logging.INFO, "exudyn_crawler"), heartbeat("drawing", 60.0, show=False):
        clock.sleep(0.1)
    assert set(caplog.messages) == {"drawing: 0 s so far of about 60 s"}
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    with caplog.at_level(logging.INFO, "exudyn_crawler"):
        run(show=False)
    assert "haul: 0.2 of 1 s" in caplog.messages
    assert capsys.readouterr() == ("", "")


def test_a_terminal_has_a_bar_of_what_is_expected(capsys):
    with heartbeat("drawing", 60.0, show=True):
        clock.sleep(0.3)
    shown = capsys.readouterr().err
    assert "drawing" in shown
    assert "of about 60 s" in shown


def test_times_of_parts_are_those_of_earlier_runs_on_this_machine(tmp_path):
    case_file = CaseFile(case=small_flexible_case(), duration=1.0)
    rule = rule_of_thumb(case_file)
    with reductions_in(tmp_path):
        first = RunTimes(case_file)
        assert first.expected() == rule
        assert "by a rule of thumb: reduce the flexible shoe 8.3 s (once), compile" in first.line()
        for factor in (2.0, 3.0, 30.0):
            first = RunTimes(case_file)
            first.note({part: factor * time for part, time in rule.items()})
        again = RunTimes(case_file)
        assert again.expected() == {part: 3.0 * time for part, time in rule.items() if part not in ONCE}
        assert "as in earlier runs on this machine: simulate " in again.line()
        # another shoe is reduced, as slowly as the first
        case = case_file.case
        stiff = case_file.with_(case=case.with_(flexible=case.flexible.with_(youngs_modulus=210e9)))
        assert RunTimes(stiff).expected()[REDUCE] == 3.0 * rule[REDUCE]
        (tmp_path / EARLIER).write_text("[1")
        assert RunTimes(case_file).expected() == rule


def test_a_part_that_was_found_says_nothing_of_its_time(tmp_path):
    case_file = CaseFile(case=small_flexible_case(), duration=1.0)
    with reductions_in(tmp_path):
        RunTimes(case_file).note({REDUCE: 0.3, FIELDS: 0.2, SIMULATE: 1.0})
        stiff = case_file.with_({"flexible.youngs_modulus": 210e9})
        assert RunTimes(stiff).expected()[REDUCE] == rule_of_thumb(stiff)[REDUCE]
        assert REDUCE not in RunTimes(case_file).expected()
