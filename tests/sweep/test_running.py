"""Sweeps into their folders: what is run, what is taken as it is, what is left."""

import json

import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler.run.folder.record import held
from exudyn_crawler.sweep import worker
from exudyn_crawler.sweep.answers import Answer
from exudyn_crawler.sweep.running import folder_state, run_sweep
from exudyn_crawler.sweep.vary import Vary
from tests.sweep.cases import FORCE, STIFFNESS, small_sweep

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def ran(scheduler, tmp_path_factory):
    """Sweep of two runs in its folder, and the lines that it told."""
    told, folder = [], tmp_path_factory.mktemp("sweep")
    return run_sweep(small_sweep(), folder, scheduler=scheduler, progress=False, say=told.append), told


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
    again = run_sweep(small_sweep(), run.folder, say=told.append)
    assert told[0] == "2 runs: 2 done, 0 to run"
    assert again.table.equals(run.table)
    more = small_sweep(vary=(Vary(key=STIFFNESS, values=(1e7, 2e7, 3e7)),))
    assert folder_state(more, run.folder, workers=1, retry=False).startswith(
        "3 runs: 2 done, 1 to run\n1 runs of about"
    )
    wider = run_sweep(more, run.folder, scheduler=scheduler, progress=False)
    assert wider.table["status"].tolist() == ["done"] * 3
    assert set(before) < set(times_of(run))


@pytest.mark.usefixtures("without_reports")
def test_other_answers_are_those_of_the_same_histories(ran, scheduler):
    run, _ = ran
    before = times_of(run)
    other = small_sweep(answers=(Answer(quantity="penetration", statistic="mean"),))
    found = run_sweep(other, run.folder, scheduler=scheduler, progress=False)
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
    run, _ = ran
    with held(run.folder), pytest.raises(BlockingIOError, match="is in use by another sweep"):
        run_sweep(small_sweep(), run.folder)


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
        run = run_sweep(small_sweep(), tmp_path, say=told.append, **how)
    assert run.table["status"].tolist() == ["failed", "done"]
    assert run.table["reason"].tolist() == ["RuntimeError: it sank", ""]
    assert any(line.endswith("failed: RuntimeError: it sank") for line in told)
    # it stays so until it is asked for
    for retry, status, reason in ((False, "failed", "RuntimeError: it sank"), (True, "done", "")):
        again = run_sweep(small_sweep(), tmp_path, retry=retry, **how)
        assert again.table["status"].tolist() == [status, "done"]
        assert again.table["reason"][0] == reason


def test_what_is_refused_leaves_no_folder(tmp_path):
    wrong = small_sweep(vary=(Vary(key="contact.dynamic_friction", values=(0.5,)),))
    with pytest.raises(ValueError, match="dynamic_friction must not exceed"):
        run_sweep(wrong, tmp_path / "out")
    assert not (tmp_path / "out").exists()
