"""Studies as a user runs them, short; and the papers' 10 s in full (slow)."""

import subprocess
import sys

import pandas as pd
import pytest

from exudyn_crawler import Case, History, simulate
from exudyn_crawler.case import CaseFile, read_case
from exudyn_crawler.views.figures import KINEMATICS
from studies.comparison import compare_kinematics, reported_values
from studies.kinematics import study as kinematics_study

pytestmark = pytest.mark.simulation

BOUNCES = ("z displacement", "z velocity", "z acceleration", "y angular velocity")


def study(name, *arguments):
    command = [sys.executable, "-m", "studies", name, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What a short run of the kinematics study leaves."""
    out = tmp_path_factory.mktemp("study") / "results"
    done = study("kinematics", "--case", "translation", "--duration", 0.05, "--out", out)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""  # the progress bar is for terminals
    assert "Kinematics, translation: paper against computed" in done.stdout
    assert str(out) in done.stdout
    return out


def test_a_short_study_leaves_a_folder_a_case_and_its_comparison(folder):
    names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    assert names == {"translation", "comparison.csv", "run.json", "run.log"}
    run = folder / "translation"
    figures = [run / f"{quantity.replace(' ', '_')}.png" for quantity in KINEMATICS]
    assert len(figures) == 5
    for figure in figures:
        assert figure.read_bytes().startswith(b"\x89PNG")
    history = History.load(run / "history.nc")
    kept = read_case(run / "case.toml")
    assert kept == CaseFile(case=history.case, duration=0.05)
    assert history.case == Case.translation()
    assert history.duration == pytest.approx(0.05, rel=1e-9)


def test_the_comparison_has_a_row_for_every_reported_one(folder):
    table = pd.read_csv(folder / "comparison.csv")
    reported = reported_values("kinematics")
    assert table["quantity"].tolist() == reported["quantity"].tolist()
    assert table["paper"].tolist() == reported["value"].tolist()
    short = table["statistic"].str.contains("at t=|mean over") | (table["case"] == "turning")
    assert table["computed"].isna().tolist() == short.tolist()


def test_results_are_not_overwritten_unasked(folder):
    before = (folder / "comparison.csv").stat().st_mtime_ns
    refused = study("kinematics", "--case", "translation", "--duration", 0.02, "--out", folder)
    assert refused.returncode == 2
    assert refused.stderr.startswith(f"error: {folder} holds results already (comparison.csv, ")
    assert refused.stderr.count("\n") == 1
    assert (folder / "comparison.csv").stat().st_mtime_ns == before


@pytest.mark.slow
def test_results_are_overwritten_when_asked(tmp_path):
    kinematics_study(tmp_path, duration=0.02)
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="holds results already"):
        kinematics_study(tmp_path, ["translation"], duration=0.01)
    kinematics_study(tmp_path, ["translation"], duration=0.01, overwrite=True)
    history = History.load(tmp_path / "translation" / "history.nc")
    assert history.duration == pytest.approx(0.01, rel=1e-9)
    # nothing of the case that was not run again is left
    left = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".")}
    assert left == {"translation", "comparison.csv", "run.json", "run.log", "notes.txt"}


@pytest.mark.parametrize(
    "duration", ["nan", *(pytest.param(one, marks=pytest.mark.slow) for one in ("0", "-1", "1000"))]
)
def test_a_bad_duration_is_one_line_and_exit_code_2(duration, tmp_path):
    refused = study("kinematics", "--duration", duration, "--out", tmp_path / "out")
    assert refused.returncode == 2
    expected = (
        "terrain must carry the track"
        if duration == "1000"
        else "Invalid value for '--duration': duration must be positive and finite"
    )
    assert refused.stderr.startswith(f"error: {expected}")
    assert refused.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_an_output_folder_under_a_file_is_one_line_and_exit_code_2(tmp_path):
    (tmp_path / "file").touch()
    refused = study("kinematics", "--duration", 0.01, "--out", tmp_path / "file" / "out")
    assert refused.returncode == 2
    assert refused.stderr.startswith("error: output folder")
    assert refused.stderr.count("\n") == 1


@pytest.mark.slow
def test_both_cases_are_drawn_against_each_other(tmp_path):
    runs, table = kinematics_study(tmp_path, duration=0.02)
    assert list(runs) == ["translation", "turning"]
    assert [run.folder for run in runs.values()] == [tmp_path / "translation", tmp_path / "turning"]
    assert len(list(tmp_path.glob("shoe_10_*.png"))) == 5
    over = table["statistic"] == "max over its translation value"
    assert table.loc[over, "computed"].notna().all()


def test_unknown_cases_are_refused():
    with pytest.raises(
        ValueError, match=r"cases must be of \['translation', 'turning'\], got \['sideways'\]"
    ):
        kinematics_study(None, ["sideways"], duration=0.01)


def test_the_verification_study_prints_both_tables():
    done = study("verify")
    assert (done.returncode, done.stderr) == (0, "")
    for words in ("Two-body problem at t = 0.5 s", "Paper against computed", "-3.324"):
        assert words in done.stdout


@pytest.fixture(scope="module")
def full():
    """Histories of the papers' 10 s."""
    return {case.name: simulate(case, 10.0) for case in (Case.translation(), Case.turning())}


@pytest.mark.slow
def test_the_full_study_comes_as_close_as_its_classes_ask(full):
    table = compare_kinematics(full)
    by_class = {kind: rows["within"].eq("yes") for kind, rows in table.groupby("class")}
    assert by_class["prescribed"].all()
    assert by_class["statics"].all()
    assert table.loc[table["class"] == "lateral", "within"].eq("").all()
    fluctuation = table[table["class"] == "fluctuation"].set_index(["case", "quantity"])
    # named as disagreeing: the turning track of the paper bounces more (docs/studies.md)
    bounces = [("turning", f"any shoe {what}") for what in BOUNCES]
    assert fluctuation.loc[bounces, "within"].eq("no").all()
    assert fluctuation.loc[bounces, "ratio"].gt(0.08).all()
    assert fluctuation.drop(bounces)["within"].eq("yes").mean() >= 0.7


@pytest.mark.slow
@pytest.mark.parametrize("finer", [{"step": 1e-3}, {"residual": 0.02}])
def test_the_statics_rows_are_converged(full, finer):
    tight = {}
    for case in (Case.translation(), Case.turning()):
        tight[case.name] = simulate(case.with_(solver=case.solver.with_(**finer)), 10.0)
    tables = [compare_kinematics(one) for one in (full, tight)]
    rows = tables[0]["class"] == "statics"
    default, converged = (table.loc[rows, "computed"].to_numpy() for table in tables)
    assert default == pytest.approx(converged, rel=0.01)
