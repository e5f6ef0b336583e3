"""Estimates: what grows with what, and finished runs before rules of thumb."""

import pytest

from exudyn_crawler import Case, CaseFile
from exudyn_crawler.sweep.estimate import BEGIN, estimate, run_bytes, run_time
from tests.sweep.cases import small_case


def test_time_and_size_grow_with_the_duration():
    short, long = small_case(1.0), small_case(3.0)
    assert run_time(long) - BEGIN == pytest.approx(3.0 * (run_time(short) - BEGIN))
    assert run_bytes(long) - 20e3 == pytest.approx(3.0 * (run_bytes(short) - 20e3))


def test_a_rigid_second_takes_what_was_measured():
    # docs/speed.md: 0.16 s of processor time, up to twice that by the clock of a machine that works
    case = CaseFile(case=Case.translation(), duration=1.0)
    assert 0.16 < run_time(case) - BEGIN < 0.32


def test_finished_runs_tell_how_long_one_takes():
    found = [{"status": "done", "wall_time_s": 30.0}, {"status": "failed"}]
    told = estimate(small_case(), 120, 2, found)
    assert told.startswith(
        "120 runs of about 30 s each (as 1 finished ones took): 30 min on 2 workers, 1 core"
    )
    assert "by a rule of thumb" in estimate(small_case(), 120, 2, [])
