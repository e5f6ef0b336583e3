"""Sweeps into their folders and single runs by a worker: answers, failures, goings-on, what is left."""

import json
import shutil

import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import History, simulate
from exudyn_crawler.errors import NoAnswerError, SimulationStopped
from exudyn_crawler.run.folder.record import held
from exudyn_crawler.sweep import worker
from exudyn_crawler.sweep.answers import Answer
from exudyn_crawler.sweep.results import SweepRun, results_dataset, results_table
from exudyn_crawler.sweep.running import folder_state, run_sweep
from exudyn_crawler.sweep.vary import Vary
from exudyn_crawler.sweep.worker import (
    OUTCOME,
    Task,
    check_versions,
    folder_of,
    own_versions,
    read_outcome,
    run_task,
)
from tests.sweep.cases import FORCE, STIFFNESS, small_sweep

SWEEP = small_sweep()
DIGEST = "0123456789abcdef" * 4


@pytest.fixture(scope="module")
def ran(scheduler, tmp_path_factory):
    """Sweep of two runs in its folder, and the lines that it told."""
    told, folder = [], tmp_path_factory.mktemp("sweep")
    return run_sweep(SWEEP, folder, scheduler=scheduler, progress=False, say=told.append), told


def times_of(run):
    return [path.stat().st_mtime_ns for path in sorted(run.folder.glob("runs/*/history.nc"))]


def test_a_sweep_is_a_folder_of_ordinary_runs_with_their_answers(ran):
    run, told = ran
    assert told[0] == "2 runs: 0 done, 2 to run"
    assert run.table["status"].tolist() == ["done", "done"]
    for name in run.table["folder"]:
        folder = run.folder / "runs" / name
        outcome, record = (json.loads((folder / f"{one}.json").read_text()) for one in ("outcome", "run"))
        assert outcome["answers"] == {FORCE.label: run.table.set_index("folder").loc[name, FORCE.label]}
        assert {"case.toml", "history.nc"} <= {path.name for path in folder.iterdir()}
        assert record["status"] == "done"
    assert json.loads((run.folder / "run.json").read_text())["status"] == "done"


def test_results_are_one_table_in_all_forms(ran):
    run, _ = ran
    column = run.table[FORCE.label].tolist()
    read = pd.read_csv(run.folder / "results.csv")[f"{FORCE.label} in N"]
    assert read.tolist() == pytest.approx(column, rel=1e-9)
    with xr.open_dataset(run.folder / "results.nc", engine="h5netcdf") as dataset:
        assert dataset[FORCE.label].sel(spring_stiffness=[1e7, 2e7]).values.tolist() == column
    assert run.table[FORCE.label].nunique() == 2


@pytest.mark.usefixtures("without_reports")
def test_finished_runs_are_taken_as_they_are_and_more_of_them_added(ran, scheduler):
    run, _ = ran
    before, told = times_of(run), []
    again = run_sweep(SWEEP, run.folder, say=told.append)
    assert told[0] == "2 runs: 2 done, 0 to run"
    assert again.table.equals(run.table)
    more = small_sweep(vary=(Vary(key=STIFFNESS, values=(1e7, 2e7, 3e7)),))
    state = folder_state(more, run.folder, workers=1, retry=False)
    assert state.startswith("3 runs: 2 done, 1 to run\n1 runs of about")
    wider = run_sweep(more, run.folder, scheduler=scheduler, progress=False)
    assert wider.table["status"].tolist() == ["done"] * 3
    assert set(before) < set(times_of(run))


@pytest.mark.usefixtures("without_reports")
def test_other_answers_are_those_of_the_same_histories(ran, scheduler):
    run, _ = ran
    before = times_of(run)
    other = small_sweep(answers=(Answer(quantity="penetration", statistic="mean"),))
    # the folder may have the results of one value more
    found = run_sweep(other, run.folder, scheduler=scheduler, overwrite=True, progress=False)
    assert found.table["penetration_mean"].notna().all()
    assert times_of(run) == before


def test_the_page_links_to_reports_of_best_and_worst_runs(ran):
    run, _ = ran
    text = (run.folder / "report.html").read_text()
    for name in run.table["folder"]:
        assert f'href="runs/{name}/report.html"' in text
        assert (run.folder / "runs" / name / "report.html").is_file()
    for heading in ("Best and worst runs", "Response curves", "Main effects", "Sobol indices"):
        assert f"<h2>{heading}</h2>" in text
    assert "variance of the grid" in text


def test_two_sweeps_in_one_folder_are_refused(ran):
    with held(ran[0].folder), pytest.raises(BlockingIOError, match="is in use by another sweep"):
        run_sweep(SWEEP, ran[0].folder)


@pytest.mark.slow
@pytest.mark.simulation
@pytest.mark.usefixtures("without_reports")
def test_failed_runs_are_kept_with_their_reason_and_stop_no_others(scheduler, tmp_path, monkeypatch):
    whole = worker.case_run.run_case

    def failing(case_file, *given, **how):
        if case_file.case.terrain.spring_stiffness == 1e7:
            raise RuntimeError("it sank")
        return whole(case_file, *given, **how)

    told, how = [], {"scheduler": scheduler, "progress": False}
    with monkeypatch.context() as patch:
        patch.setattr(worker.case_run, "run_case", failing)
        run = run_sweep(SWEEP, tmp_path, say=told.append, **how)
    assert run.table["status"].tolist() == ["failed", "done"]
    assert run.table["reason"].tolist() == ["RuntimeError: it sank", ""]
    assert any(line.endswith("failed: RuntimeError: it sank") for line in told)
    without = "1 of 2 runs have no answer (1 failed); 1 of them: RuntimeError: it sank"
    assert run.check_answers() == without
    # it stays so until it is asked for
    for retry, status, reason in ((False, "failed", "RuntimeError: it sank"), (True, "done", "")):
        again = run_sweep(SWEEP, tmp_path, retry=retry, **how)
        assert again.table["status"].tolist() == [status, "done"]
        assert again.table["reason"][0] == reason


def test_what_is_refused_leaves_no_folder(tmp_path):
    wrong = small_sweep(vary=(Vary(key="contact.dynamic_friction", values=(0.5,)),))
    with pytest.raises(ValueError, match="dynamic_friction must not exceed"):
        run_sweep(wrong, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def task_of(tmp_path, sweep=SWEEP, **changes):
    """First run of a sweep."""
    case_file, digest, _ = sweep.case_of(sweep.rows[0])
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
    folder = folder_of(tmp_path, task.digest)
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
    task = task_of(tmp_path, sweep)

    def stopping(case, duration, progress, checkpoints, *_):
        simulate(case, 0.02, progress, checkpoints)
        raise SimulationStopped(0.02, "interrupted", None)

    with monkeypatch.context() as patch:
        patch.setattr("exudyn_crawler.case_run.simulate", stopping)
        assert run_task(task)["reason"] == "the simulation stopped at t = 0.02 s: interrupted"
    folder = folder_of(tmp_path, task.digest)
    assert list((folder / "checkpoints").glob("stage_*"))
    found = run_task(task)
    assert "going on from the checkpoint at t = 0.01 s" in (folder / "run.log").read_text()
    whole = simulate(sweep.case_of(sweep.rows[0])[0].case, 0.03)
    assert found["answers"] == {FORCE.label: float((whole.joint_force**2).sum("axis").max() ** 0.5)}


@pytest.mark.simulation
def test_a_failed_run_is_run_anew_when_it_is_asked_for(tmp_path):
    task = task_of(tmp_path)
    folder = folder_of(tmp_path, task.digest)
    (folder / "checkpoints").mkdir(parents=True)
    (folder / "checkpoints" / "stage_0000.npz").write_text("altered")
    assert "stage_0000.npz cannot be read" in run_task(task)["reason"]
    assert run_task(task)["status"] == "failed"
    assert run_task(task_of(tmp_path, again=True))["status"] == "done"


def test_a_run_that_another_process_works_at_is_waited_for(tmp_path, monkeypatch):
    task = task_of(tmp_path)
    folder = folder_of(tmp_path, task.digest)
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


def test_a_sweep_of_which_no_run_has_an_answer_is_an_error(tmp_path):
    outcomes = {run.digest: {"status": "failed", "reason": "it sank", "answers": {}} for run in SWEEP.planned}
    table = results_table(SWEEP, outcomes)
    run = SweepRun(SWEEP, table, results_dataset(SWEEP, table), tmp_path)
    with pytest.raises(NoAnswerError, match=r"2 of 2 runs have no answer \(2 failed\); 2 of them: it sank"):
        run.check_answers()
    table.loc[0, FORCE.label] = 1.0
    assert run.check_answers().startswith("1 of 2 runs have no answer")


@pytest.mark.usefixtures("without_reports")
def test_results_of_another_sweep_are_replaced_only_where_that_is_allowed(ran, scheduler, tmp_path):
    folder = tmp_path / "sweep"
    shutil.copytree(ran[0].folder, folder)
    before = (folder / "results.csv").read_bytes()
    other = small_sweep(vary=(Vary(key=STIFFNESS, values=(1e7,)),))
    with pytest.raises(FileExistsError, match=r"results.csv has results of another sweep.*\(--overwrite"):
        run_sweep(other, folder)
    assert (folder / "results.csv").read_bytes() == before
    assert json.loads((folder / "run.json").read_text())["status"] == "done"
    fewer = run_sweep(other, folder, scheduler=scheduler, overwrite=True)
    assert len(pd.read_csv(folder / "results.csv")) == len(fewer.table) == 1
    # the runs have stayed
    again = run_sweep(SWEEP, folder, scheduler=scheduler)
    assert again.table["status"].tolist() == ["done", "done"]
