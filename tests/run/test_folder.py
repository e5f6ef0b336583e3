"""Run folders: what a run keeps, repeats bit for bit, and never overwrites unasked."""

import json
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from exudyn_crawler import Case, CaseFile, History, read_case, run_case
from exudyn_crawler.errors import SimulationStopped
from exudyn_crawler.machines import Outputs
from exudyn_crawler.run.folder.folder import refuse_other_results, run_in
from studies.forces import study as forces_study
from studies.kinematics import study as kinematics_study

pytestmark = pytest.mark.simulation

QUIET = Outputs(figures=False, pictures=False, paraview=False, page=False)
QUIET_TEXT = "[outputs]\nfigures = false\npictures = false\nparaview = false\npage = false\n"
SHORT = CaseFile(case=Case.turning(), duration=0.05, outputs=QUIET)
DRAWN = CaseFile(case=Case.translation(), duration=0.01, outputs=Outputs(shoes=(1,), page=False))
HOLD = """
import sys, time
from pathlib import Path
from exudyn_crawler.run.folder.folder import run_in
with run_in(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


HELD = """
import sys, time
from pathlib import Path
from exudyn_crawler.run.folder.record import held
with held(Path(sys.argv[1]), "run"):
    print("held", flush=True)
    time.sleep(60)
"""


def visible(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


def record(folder):
    return json.loads((folder / "run.json").read_text())


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Folder of a short run."""
    out = tmp_path_factory.mktemp("runs") / "kept"
    run_case(SHORT, out)
    return out


def test_a_folder_keeps_what_its_results_come_from(kept):
    names = {"case.toml", "run.json", "run.log", "history.nc", "forces.nc"}
    names |= {"extremes.csv", "loads.csv", "drive_work.csv"}
    assert visible(kept) == names
    assert read_case(kept / "case.toml") == SHORT
    found = record(kept)
    assert found["status"] == "done"
    assert set(found["files"]) == names
    assert found["versions"]["exudyn"] == History.load(kept / "history.nc").dataset.attrs["exudyn_version"]
    # in a checkout also whether it was changed; nothing where neither git nor the installation knows
    assert re.fullmatch(r"([0-9a-f]{12,}(, changed)?)?", found["commit"])
    assert {"platform", "processor", "cpu_count", "python"} <= set(found["machine"])
    assert 0.0 < sum(found["stages_s"].values()) <= found["wall_time_s"]
    assert found["started"] < found["finished"]
    log = (kept / "run.log").read_text()
    for words in ("simulate: begins", "tables and figures: ", "INFO done"):
        assert words in log


def assert_same_bits(first, again):
    for name in first.variables:
        pair = [dataset[name].values for dataset in (first, again)]
        one, other = (values.astype(str) if values.dtype == object else values for values in pair)
        assert one.tobytes() == other.tobytes()


@pytest.mark.slow
def test_the_same_case_gives_the_same_numbers_bit_for_bit(kept, tmp_path):
    # in a process of its own, where nothing is warm yet
    script = (
        "from exudyn_crawler import read_case, run_case\n"
        f"run_case(read_case({str(kept / 'case.toml')!r}), {str(tmp_path / 'again')!r})"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)
    first, again = (History.load(folder / "history.nc").dataset for folder in (kept, tmp_path / "again"))
    assert set(first.variables) == set(again.variables)
    assert_same_bits(first, again)
    assert np.ptp(first.position.values[-1] - first.position.values[0]) > 1e-6  # something moved
    for table in ("extremes.csv", "loads.csv", "case.toml"):
        assert (kept / table).read_bytes() == (tmp_path / "again" / table).read_bytes()


@pytest.mark.slow
def test_flexible_shoes_repeat_bit_for_bit(tmp_path):
    # a reduction in each process: eigenvalue solvers may start at random, threads may sum in any order
    text = (
        'base = "stress"\nduration = 0.01\n'
        f'[flexible]\nbase = "ph4100c"\nmesh = "coarse"\nshoes = [13]\nfixed_modes = 4\n{QUIET_TEXT}'
    )
    (tmp_path / "case.toml").write_text(text)
    for name in ("first", "again"):
        command = [sys.executable, "-m", "exudyn_crawler", "run", "case.toml", "--out", name]
        subprocess.run(command, check=True, timeout=300, cwd=tmp_path, capture_output=True)
    first, again = (History.load(tmp_path / name / "history.nc").dataset for name in ("first", "again"))
    assert_same_bits(first, again)


def test_results_of_something_else_are_refused_before_a_run(tmp_path):
    refuse_other_results(tmp_path / "none")
    (tmp_path / "notes.txt").touch()
    refuse_other_results(tmp_path)
    (tmp_path / "peaks.csv").touch()
    with pytest.raises(FileExistsError, match="holds results already"):
        refuse_other_results(tmp_path)
    (tmp_path / "case.toml").touch()
    refuse_other_results(tmp_path)


def test_an_earlier_run_stays_unless_asked(kept):
    before = contents(kept)
    with pytest.raises(FileExistsError, match="holds results already"):
        run_case(SHORT, kept)
    assert contents(kept) == before


@pytest.mark.slow
def test_overwriting_leaves_nothing_of_the_earlier_run_and_all_that_is_the_users(tmp_path):
    run_case(DRAWN, tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "own.csv").write_text("mine too")
    assert (tmp_path / "velocity.png").exists()
    run_case(CaseFile(case=Case.turning(), duration=0.01, outputs=QUIET), tmp_path, overwrite=True)
    assert not list(tmp_path.glob("*.png"))
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (tmp_path / "own.csv").read_text() == "mine too"
    assert History.load(tmp_path / "history.nc").case == Case.turning()
    assert read_case(tmp_path / "case.toml").case == Case.turning()


def test_nothing_outside_the_folder_is_removed(kept, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(kept, out)
    (tmp_path / "precious").write_text("mine")
    (out / "link").symlink_to(tmp_path / "precious")
    (out / "own").mkdir()
    paths = ["../precious", "own/../../precious", str(tmp_path / "precious")]
    odd = [*paths, "link", "own", ".", "", "a\0b", 7, None]
    (out / "run.json").write_text(json.dumps({"files": [*odd, "loads.csv"]}))
    bare = SHORT.with_(duration=0.01, outputs=QUIET.with_(tables=False))
    run_case(bare, out, overwrite=True)
    assert (tmp_path / "precious").read_text() == "mine"
    assert (out / "link").exists()
    assert not (out / "loads.csv").exists()
    for broken in ('{"files": 7}', '{"files": "abc"}', "[" * 100_000, "{", "7"):
        (out / "run.json").write_text(broken)
        with run_in(out, bare, overwrite=True):
            assert record(out)["status"] == "running"
        assert record(out)["status"] == "done"


@pytest.mark.parametrize("name", ["run.log", "checkpoints"])
def test_a_run_follows_no_link_out_of_its_folder(tmp_path, name):
    """It would add to the log of somebody else, and remove checkpoints there."""
    other = tmp_path / "other"
    other.mkdir()
    (other / "stage_0000.npz").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / name).symlink_to(other / "stage_0000.npz" if name == "run.log" else other)
    for overwrite in (False, True):
        with pytest.raises(FileExistsError, match=f"{name} must not be a link, .* to .*other"):
            run_case(SHORT, out, overwrite=overwrite)
    assert contents(other) == {"stage_0000.npz": b"mine"}


def test_a_link_in_place_of_a_result_is_replaced_and_its_target_kept(kept, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(kept, out)
    (tmp_path / "precious.nc").write_text("mine")
    for name in ("history.nc", "run.json", "case.toml"):
        (out / name).unlink()
        (out / name).symlink_to(tmp_path / "precious.nc")
    run_case(SHORT.with_(duration=0.01), out, overwrite=True)
    assert (tmp_path / "precious.nc").read_text() == "mine"
    assert not (out / "history.nc").is_symlink()
    assert History.load(out / "history.nc").duration == pytest.approx(0.01)


def test_a_link_to_a_folder_is_this_folder(kept, tmp_path):
    """Two runs that reach one folder by different paths are kept apart, and results stay unless asked."""
    real = tmp_path / "real"
    shutil.copytree(kept, real)
    link = tmp_path / "link"
    link.symlink_to(real)
    before = contents(real)
    with pytest.raises(FileExistsError, match="holds results already"):
        run_case(SHORT, link)
    assert contents(real) == before
    with subprocess.Popen(
        [sys.executable, "-c", HELD, str(real)], stdout=subprocess.PIPE, text=True
    ) as other:
        try:
            assert other.stdout.readline() == "held\n"
            with pytest.raises(BlockingIOError, match="link is in use by another run"):
                run_case(SHORT, link, overwrite=True)
        finally:
            other.kill()
    assert contents(real) == before


def test_the_case_of_another_run_is_refused_and_the_authors_own_file_kept(tmp_path):
    own = tmp_path / "case.toml"
    text = f'base = "turning" # mine\nduration = 0.05\n{QUIET_TEXT}'
    own.write_text(text)
    with pytest.raises(FileExistsError, match=r"case\.toml is the case of another run"):
        run_case(CaseFile(case=Case.translation(), duration=0.05), tmp_path)
    assert contents(tmp_path).keys() == {"case.toml", ".lock"}
    run_case(SHORT, tmp_path)
    assert own.read_text() == text


def test_a_stopped_run_is_recorded_with_its_reason_and_leaves_nothing_of_the_one_it_was_to_replace(
    kept, tmp_path
):
    out = shutil.copytree(kept, tmp_path / "out")
    case = Case.translation().with_({"solver.maximum_iterations": 2, "solver.minimum_step": 1.5e-3})
    with pytest.raises(SimulationStopped):
        run_case(CaseFile(case=case, duration=10.0), out, overwrite=True)
    found = record(out)
    assert found["status"] == "stopped"
    assert "the simulation stopped at t = " in found["error"]
    assert "history_stopped.nc" in found["files"]
    assert "Traceback" in (out / "run.log").read_text()
    assert visible(out) == {"case.toml", "run.json", "run.log", "history_stopped.nc", "checkpoints"}


@pytest.mark.slow
def test_a_study_keeps_a_folder_a_case_and_a_record_of_all(tmp_path):
    kinematics, forces = tmp_path / "kinematics", tmp_path / "forces"
    kinematics_study(kinematics, ["translation"], duration=0.01)
    forces_study(forces, ["translation"], duration=0.01, reuse=kinematics)
    for folder in (kinematics, forces):
        assert read_case(folder / "translation" / "case.toml").case == Case.translation()
        assert record(folder)["status"] == record(folder / "translation")["status"] == "done"
        run = {f"translation/{name}" for name in visible(folder / "translation")}
        assert set(record(folder)["files"]) == visible(folder) - {"translation"} | run
        # the study's log tells what its runs told
        assert "tables and figures: " in (folder / "run.log").read_text()
    assert "simulate" in record(kinematics / "translation")["stages_s"]
    assert "simulate" not in record(forces / "translation")["stages_s"]
    assert "reusing the history" in (forces / "translation" / "run.log").read_text()


def test_a_run_without_a_folder_gives_the_same_and_writes_nothing(kept, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = run_case(SHORT)
    assert (run.folder, run.stresses) == (None, None)
    assert run.history.dataset.identical(History.load(kept / "history.nc").dataset)
    assert list(tmp_path.iterdir()) == []


def test_two_runs_in_one_folder_are_one_too_many_and_a_killed_one_leaves_it_free(tmp_path):
    out = tmp_path / "out"
    with subprocess.Popen([sys.executable, "-c", HOLD, str(out)], stdout=subprocess.PIPE, text=True) as other:
        try:
            assert other.stdout.readline() == "held\n"
            with pytest.raises(BlockingIOError, match=f"out is in use by another run .process {other.pid}, "):
                run_case(SHORT, out)
            with pytest.raises(BlockingIOError, match="in use"):
                run_case(SHORT, out, overwrite=True)
            assert record(out)["status"] == "running"
        finally:
            other.kill()
    run_case(SHORT, out)
    assert record(out)["status"] == "done"


def test_a_failure_of_the_work_itself_is_recorded_and_passed_on(tmp_path):
    def fail():
        with run_in(tmp_path, SHORT) as folder:
            with folder.timed("half"):
                pass
            raise RuntimeError("halfway")

    with pytest.raises(RuntimeError, match="halfway"):
        fail()
    found = record(tmp_path)
    assert (found["status"], found["error"]) == ("failed", "halfway")
    assert "half" in found["stages_s"]


@pytest.mark.parametrize("is_made_again", [False, True])
def test_a_folder_that_is_removed_during_the_run_is_no_success(tmp_path, is_made_again):
    out = tmp_path / "out"
    case_file = CaseFile(case=Case.translation(), duration=0.01)

    def work():
        with run_in(out, case_file):
            shutil.rmtree(out)
            if is_made_again:
                out.mkdir()
                (out / "history.nc").write_text("half")

    with pytest.raises(FileNotFoundError, match="out was removed or emptied while"):
        work()
    assert record(out)["status"] == "failed" if is_made_again else not out.exists()
