"""Estimates: what grows with what, and finished runs before rules of thumb."""

import pytest

from exudyn_crawler import Case, CaseFile, FlexibleShoes
from exudyn_crawler.sweep.estimate import BEGIN, RECOVERY, estimate, run_bytes, run_time
from tests.sweep.cases import small_case


def test_time_and_size_grow_with_the_duration():
    short, long = small_case(1.0), small_case(3.0)
    assert run_time(long) - BEGIN == pytest.approx(3.0 * (run_time(short) - BEGIN))
    assert run_bytes(long) - 20e3 == pytest.approx(3.0 * (run_bytes(short) - 20e3))


def test_a_rigid_second_takes_what_was_measured():
    # docs/speed.md: 0.32 ms a step; profile of a run of 2 s: half of what its steps take goes to its history
    case = CaseFile(case=Case.translation(), duration=1.0)
    assert run_time(case) - BEGIN == pytest.approx(500 * 2 * 0.32e-3, rel=0.2)


def test_a_rolled_second_takes_what_was_measured():
    # processor time beside other work: 2.4 ms a step of 24 rigid shoes, 3.7 ms with a flexible one
    rigid = Case.rolled()
    flexible = rigid.with_(flexible=FlexibleShoes.ph4100c("coarse").with_(shoes=(11,)))
    for case, measured in ((rigid, 2.4e-3), (flexible, 3.7e-3)):
        steps = 1.0 / case.solver.step
        recovery = 0.0 if case.flexible is None else RECOVERY / case.solver.output_interval
        found = run_time(CaseFile(case=case, duration=1.0)) - BEGIN - recovery
        assert found == pytest.approx(steps * measured, rel=0.2)


def test_a_rigid_run_leaves_what_was_measured():
    # 9.4e6 bytes a run of 3 s, mean of the 40 of studies/terrain_sweep.toml
    case = CaseFile(case=Case.translation(), duration=3.0)
    assert run_bytes(case) == pytest.approx(9.4e6, rel=0.2)


def test_finished_runs_tell_how_long_one_takes():
    found = [{"status": "done", "wall_time_s": 30.0}, {"status": "failed"}]
    told = estimate(small_case(), 120, 2, found)
    assert told.startswith(
        "120 runs of about 30 s each (as 1 finished ones took): 30 min on 2 workers, 1 core"
    )
    assert "by a rule of thumb" in estimate(small_case(), 120, 2, [])
