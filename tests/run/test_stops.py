"""Whatever stops a run, the same call finishes it, and what comes out is what an undisturbed run gives."""

import importlib
import json
import subprocess
import sys
from functools import partial

import pandas as pd
import pytest

from exudyn_crawler import Case, CaseFile, History, run_case
from exudyn_crawler.errors import INTERRUPTED, SimulationStopped
from exudyn_crawler.machines import Outputs, write_case
from exudyn_crawler.run.folder.record import note_file
from exudyn_crawler.run.solve import simulation
from exudyn_crawler.views import outputs
from studies.kinematics import study as kinematics_study
from tests.run.test_folder import DRAWN, QUIET, record, visible
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

# the package's public function of this name hides the module
case_run_module = importlib.import_module("exudyn_crawler.case_run")
STAGED = CaseFile(
    case=Case.turning().with_({"solver.checkpoint_interval": 0.05}), duration=0.15, outputs=QUIET
)


@pytest.fixture(scope="module")
def staged(tmp_path_factory):
    """Folder of a run of three stages."""
    out = tmp_path_factory.mktemp("runs") / "staged"
    run_case(STAGED, out)
    assert (out / "checkpoint.npz").exists()
    return out


def assert_same(out, whole):
    """Two folders hold the same; records and logs apart."""
    assert visible(out) == visible(whole)
    assert History.load(out / "history.nc").dataset.identical(History.load(whole / "history.nc").dataset)
    for name in visible(out) - {"run.json", "run.log", "history.nc", "forces.nc"}:
        assert (out / name).read_bytes() == (whole / name).read_bytes(), name
    assert record(out)["status"] == "done"
    assert set(record(out)["files"]) == visible(out)


def interrupt(*_args, **_options):
    raise KeyboardInterrupt


def no_room(*_args, **_options):
    raise OSError(28, "No space left on device")


def stopped_at(place, monkeypatch, call, stop=interrupt):
    """Call what stops at a place of the program."""
    with monkeypatch.context() as patch:
        patch.setattr(place, stop)
        with pytest.raises((KeyboardInterrupt, OSError)):
            call()


def not_again(monkeypatch):
    monkeypatch.setattr(case_run_module, "simulate", lambda *_: pytest.fail("it ran"))


@pytest.mark.parametrize(
    ("place", "stop"),
    [
        pytest.param("run.folder.checkpoints._write", interrupt, marks=pytest.mark.slow),
        pytest.param("run.folder.checkpoints.save_joined", no_room, marks=pytest.mark.slow),
        ("run.folder.checkpoints.Checkpoints.hand_over", interrupt),
        # between the places beside them
        pytest.param("run.folder.checkpoints.Checkpoints.settle", interrupt, marks=pytest.mark.slow),
        pytest.param("run.folder.checkpoints.Checkpoints.remove", interrupt, marks=pytest.mark.slow),
        ("views.tables.write_table", no_room),
    ],
)
def test_a_run_that_was_stopped_is_finished_by_the_same_call(staged, tmp_path, monkeypatch, place, stop):
    stopped_at(f"exudyn_crawler.{place}", monkeypatch, lambda: run_case(STAGED, tmp_path), stop)
    assert record(tmp_path)["status"] == ("stopped" if stop is interrupt else "failed")
    (tmp_path / ".partial-a1b2c3d4-history.nc").write_text("half")
    (tmp_path / "own.txt").write_text("mine")
    said = []
    run_case(STAGED, tmp_path, say=said.append)
    words = "going on", "continuing"
    assert place.endswith("_write") or any(word in line for word in words for line in said)
    (tmp_path / "own.txt").unlink()
    assert_same(tmp_path, staged)
    assert not list(tmp_path.glob(".partial*"))
    with pytest.raises(FileExistsError, match="holds results already"):
        run_case(STAGED, tmp_path)


def test_what_follows_the_simulation_does_not_simulate_again_and_refuses_an_altered_history(
    staged, tmp_path, monkeypatch
):
    stopped_at("exudyn_crawler.case_run.write_outputs", monkeypatch, lambda: run_case(STAGED, tmp_path))
    not_again(monkeypatch)
    history = tmp_path / "history.nc"
    content = history.read_bytes()
    history.write_bytes(content[:2000])
    with pytest.raises(ValueError, match=r"history\.nc must hold a history: "):
        run_case(STAGED, tmp_path)
    history.write_bytes(content)
    run_case(STAGED, tmp_path)
    assert_same(tmp_path, staged)


def test_an_interrupted_simulation_keeps_what_it_had_until_it_has_ended(staged, tmp_path, monkeypatch):
    def interrupted(system, *others, solve=simulation._solve):
        reason = solve(system, *others)
        return INTERRUPTED if system.layout.part(system.state(), "time") > 0.07 else reason

    with monkeypatch.context() as patch:
        patch.setattr(simulation, "_solve", interrupted)
        with pytest.raises(SimulationStopped, match="interrupted"):
            run_case(STAGED, tmp_path)
    whole = History.load(staged / "history.nc").dataset
    assert History.load(tmp_path / "history_stopped.nc").dataset.identical(whole.sel(time=slice(0.0, 0.1001)))
    run_case(STAGED, tmp_path)
    assert_same(tmp_path, staged)


@pytest.mark.slow
@pytest.mark.parametrize("stopped_within", [None, "exudyn_crawler.run.folder.checkpoints.save_joined"])
def test_a_finished_run_is_made_longer_and_gives_what_the_longer_one_gives(
    staged, tmp_path, monkeypatch, stopped_within
):
    short, out, said = STAGED.with_(duration=0.12), tmp_path / "out", []
    run_case(short, out)
    note_file(out / "loads.csv")
    if stopped_within:
        stopped_at(stopped_within, monkeypatch, lambda: run_case(STAGED, out))
        assert History.load(out / "history.nc").duration == pytest.approx(0.12)
    run_case(STAGED, out, say=said.append)
    assert said[0].startswith("time: about ")
    assert said[1:] == ["turning: going on from the checkpoint at t = 0.1 s"]
    assert_same(out, staged)
    with pytest.raises(FileExistsError, match="holds results already"):
        run_case(short, out)


@pytest.mark.slow
def test_overwriting_that_was_stopped_goes_on(staged, tmp_path, monkeypatch):
    run_case(DRAWN, tmp_path)
    for place in ("run.folder.checkpoints.save_joined", "views.tables.write_table"):
        stopped_at(f"exudyn_crawler.{place}", monkeypatch, lambda: run_case(STAGED, tmp_path, overwrite=True))
        assert not (tmp_path / "velocity.png").exists()
    not_again(monkeypatch)
    run_case(STAGED, tmp_path, overwrite=True)
    assert_same(tmp_path, staged)


@pytest.fixture
def bare_study(monkeypatch):
    """The kinematics study with its runs, its comparison and hardly a figure."""
    monkeypatch.setattr(outputs, "WRITERS", {"tables": outputs.write_tables})
    monkeypatch.setattr("studies.kinematics.KINEMATICS", {"velocity": "velocity"})
    return partial(kinematics_study, duration=0.01)


def test_a_study_goes_on_with_the_case_that_it_was_stopped_in(bare_study, tmp_path, monkeypatch):
    ended = []

    def second_fails(case, *arguments, simulate=case_run_module.simulate):
        if case.name == "turning":
            raise KeyboardInterrupt
        ended.append(case.name)
        return simulate(case, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(case_run_module, "simulate", second_fails)
        with pytest.raises(KeyboardInterrupt):
            bare_study(tmp_path)
    assert record(tmp_path / "translation")["status"] == "done"
    assert (record(tmp_path)["status"], record(tmp_path / "turning")["status"]) == ("stopped", "stopped")
    said = []
    runs, table = bare_study(tmp_path, say=said.append)
    assert ended == ["translation"]
    assert said[0] == f"translation: finished already, in {tmp_path / 'translation'}"
    assert runs["translation"].history.duration == pytest.approx(0.01)
    assert len(pd.read_csv(tmp_path / "comparison.csv")) == len(table)
    files = set(record(tmp_path)["files"])
    assert {"comparison.csv", "translation/history.nc", "turning/history.nc"} <= files
    with pytest.raises(FileExistsError, match="holds results already"):
        bare_study(tmp_path)


@pytest.mark.slow
def test_a_study_that_was_stopped_while_overwriting_runs_all_its_cases_anew(
    bare_study, tmp_path, monkeypatch
):
    bare_study(tmp_path)
    first = record(tmp_path / "translation")["started"]

    def again():
        return bare_study(tmp_path, overwrite=True)

    stopped_at("studies.kinematics.compare_kinematics", monkeypatch, again)
    second = {name: record(tmp_path / name)["started"] for name in ("translation", "turning")}
    assert second["translation"] > first
    again()
    assert {name: record(tmp_path / name)["started"] for name in second} == second
    assert {f"{name}/loads.csv" for name in second} <= set(record(tmp_path)["files"])
    assert (tmp_path / "turning" / "loads.csv").exists()


def test_a_history_too_large_for_memory_gives_the_same_files(staged, tmp_path, monkeypatch):
    monkeypatch.setattr("exudyn_crawler.results.history.history.MOST_IN_MEMORY", 0)
    run_case(STAGED, tmp_path)
    assert_same(tmp_path, staged)


RIGID = CaseFile(case=STAGED.case, duration=1.0, outputs=Outputs(shoes=(7,), page=False))


def flexible():
    parts = {"solver.checkpoint_interval": 0.1, "flexible.shoes": (13,), "flexible.fixed_modes": 4}
    case = Case.stress(SMALL_SHOE).with_(parts)
    return CaseFile(case=case, duration=0.4, outputs=Outputs(shoes=(13,), picture_times=(0.2,)))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize("shoes", ["rigid", "flexible"])
def test_the_command_finishes_what_was_stopped_at_any_of_forty_moments(tmp_path, shoes):
    write_case(RIGID if shoes == "rigid" else flexible(), tmp_path / "case.toml")
    line = [sys.executable, "-m", "tests.stops", tmp_path / "case.toml", tmp_path, "40", "2026"]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    trials = json.loads(done.stdout)
    for trial in trials:
        assert trial["differs"] == [], trial
        assert (trial["then"], trial["status"]) == (0, "done"), trial
        if trial["signal"] != "SIGKILL":
            assert "run the same command again to continue" in trial["told"] or trial["ended"] == -15, trial
        assert trial["ended"] != 0, trial
    assert len(trials) == 40
