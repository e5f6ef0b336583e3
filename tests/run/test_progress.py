"""Progress: a bar on a terminal, lines elsewhere, numbers only."""

import time as clock

import pytest

from exudyn_crawler.run.folder import progress
from exudyn_crawler.run.folder.progress import heartbeat, progress_bar


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
