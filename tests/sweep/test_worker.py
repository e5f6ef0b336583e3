"""One run of a sweep as a worker does it: answers, failures, goings-on."""

import json

import pytest

from exudyn_crawler import History, simulate
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.run.folder.record import held
from exudyn_crawler.sweep import worker
from exudyn_crawler.sweep.worker import (
    OUTCOME,
    Task,
    check_versions,
    folder_of,
    own_versions,
    read_outcome,
    run_task,
)
from tests.sweep.cases import FORCE, small_sweep

SWEEP = small_sweep()
DIGEST = "0123456789abcdef" * 4


def task_of(tmp_path, **changes):
    case_file, digest, _ = SWEEP.case_of(SWEEP.rows[0])
    given = {
        "digest": digest,
        "case": case_file.model_dump_json(),
        "answers": json.dumps([FORCE.model_dump(mode="json")]),
        "runs": str(tmp_path),
        "reductions": None,
        "versions": own_versions(),
    }
    return Task(**given | changes)


@pytest.mark.simulation
def test_a_run_answers_what_its_history_says(tmp_path):
    task = task_of(tmp_path)
    outcome = run_task(task)
    folder = tmp_path / task.digest[:16]
    history = History.load(folder / "history.nc")
    assert outcome["status"] == "done"
    assert outcome["answers"] == {FORCE.label: float((history.joint_force**2).sum("axis").max() ** 0.5)}
    assert read_outcome(str(tmp_path), task.digest) == outcome
    assert (folder / "case.toml").is_file()
    # what is there is not computed again
    written = (folder / "history.nc").stat().st_mtime_ns
    assert run_task(task)["answers"] == outcome["answers"]
    assert (folder / "history.nc").stat().st_mtime_ns == written


@pytest.mark.simulation
def test_a_run_that_was_stopped_goes_on_from_its_checkpoint(tmp_path, monkeypatch):
    sweep = small_sweep(0.03, vary=(SWEEP.vary[0].with_(key="solver.checkpoint_interval", values=(0.01,)),))
    case_file, digest, _ = sweep.case_of(sweep.rows[0])
    task = task_of(tmp_path, digest=digest, case=case_file.model_dump_json())

    def stopping(case, duration, progress, checkpoints, *_):
        simulate(case, 0.02, progress, checkpoints)
        raise SimulationStopped(0.02, "interrupted", None)

    with monkeypatch.context() as patch:
        patch.setattr("exudyn_crawler.case_run.simulate", stopping)
        assert run_task(task)["reason"] == "the simulation stopped at t = 0.02 s: interrupted"
    folder = tmp_path / digest[:16]
    assert list((folder / "checkpoints").glob("stage_*"))
    found = run_task(task)
    assert "going on from the checkpoint at t = 0.01 s" in (folder / "run.log").read_text()
    whole = simulate(case_file.case, 0.03)
    assert found["answers"] == {FORCE.label: float((whole.joint_force**2).sum("axis").max() ** 0.5)}


@pytest.mark.simulation
def test_a_failed_run_is_run_anew_when_it_is_asked_for(tmp_path):
    task = task_of(tmp_path)
    folder = tmp_path / task.digest[:16]
    (folder / "checkpoints").mkdir(parents=True)
    (folder / "checkpoints" / "stage_0000.npz").write_text("altered")
    outcome = run_task(task)
    assert outcome["status"] == "failed"
    assert "stage_0000.npz cannot be read" in outcome["reason"]
    assert run_task(task)["status"] == "failed"
    assert run_task(task_of(tmp_path, again=True))["status"] == "done"


def test_a_run_that_another_process_works_at_is_waited_for(tmp_path, monkeypatch):
    task = task_of(tmp_path)
    folder = tmp_path / task.digest[:16]
    folder.mkdir()
    monkeypatch.setattr(worker, "LOCK_WAIT", 0.0)
    with held(folder):
        outcome = run_task(task)
    assert outcome["status"] == "failed"
    assert f"{folder} is in use by another run" in outcome["reason"]


def test_a_worker_of_other_versions_is_refused(tmp_path):
    other = own_versions() | {"exudyn": "0.1", "Python": "2.7"}
    with pytest.raises(ValueError, match=r"other versions: Python .* there, 2\.7 here, exudyn .* there, 0"):
        run_task(task_of(tmp_path, versions=other))
    assert not any(tmp_path.iterdir())
    with pytest.raises(ValueError, match="numpy missing there"):
        check_versions({"numpy": "2"}, {}, "host")
    check_versions(own_versions(), dict(own_versions()), "host")


@pytest.mark.parametrize("text", ["", "[]", "{", '{"digest": "another", "answers": {}}'])
def test_outcomes_of_others_and_broken_ones_count_for_nothing(tmp_path, text):
    assert read_outcome(tmp_path, DIGEST) is None
    folder = folder_of(tmp_path, DIGEST)
    assert folder == tmp_path / "0123456789abcdef"
    folder.mkdir()
    (folder / OUTCOME).write_text(text)
    assert read_outcome(tmp_path, DIGEST) is None
