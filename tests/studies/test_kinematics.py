"""Studies as a user runs them, short."""

import subprocess
import sys

import pandas as pd
import pytest

from exudyn_crawler import Case, History
from exudyn_crawler.machines import CaseFile, read_case
from exudyn_crawler.views.figures import KINEMATICS
from studies.comparison import reported_values
from studies.kinematics import study as kinematics_study

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What a short run of the kinematics study leaves."""
    out = tmp_path_factory.mktemp("study") / "results"
    line = [sys.executable, "-m", "studies", "kinematics", "--case", "translation", "--duration", "0.05"]
    done = subprocess.run([*line, "--out", out], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    # the progress bar is for terminals; on a busy machine lines tell every ten seconds what goes on
    assert all(" s so far, " in line for line in done.stderr.splitlines()), done.stderr
    assert "Kinematics, translation: paper against computed" in done.stdout
    assert str(out) in done.stdout
    return out


def test_a_short_study_leaves_a_folder_a_case_and_its_comparison(folder):
    names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    assert names == {"translation", "comparison.csv", "run.json", "run.log"}
    run = folder / "translation"
    assert len(KINEMATICS) == 5
    for quantity in KINEMATICS:
        assert (run / f"{quantity.replace(' ', '_')}.png").read_bytes().startswith(b"\x89PNG")
    history = History.load(run / "history.nc")
    assert read_case(run / "case.toml") == CaseFile(case=history.case, duration=0.05)
    assert history.case == Case.translation()
    assert history.duration == pytest.approx(0.05, rel=1e-9)


def test_the_comparison_has_a_row_for_every_reported_one(folder):
    table = pd.read_csv(folder / "comparison.csv")
    reported = reported_values("kinematics")
    assert table["quantity"].tolist() == reported["quantity"].tolist()
    assert table["paper"].tolist() == reported["value"].tolist()
    short = table["statistic"].str.contains("at t=|mean over") | (table["case"] == "turning")
    assert table["computed"].isna().tolist() == short.tolist()


def test_results_are_not_overwritten_unasked(folder, refused):
    before = (folder / "comparison.csv").stat().st_mtime_ns
    err = refused("studies", "kinematics", "--case", "translation", "--duration", 0.02, "--out", folder)
    assert err.startswith(f"error: {folder} holds results already (comparison.csv, ")
    assert (folder / "comparison.csv").stat().st_mtime_ns == before


@pytest.mark.slow
def test_both_cases_are_drawn_against_each_other_and_overwritten_when_asked(tmp_path):
    runs, table = kinematics_study(tmp_path, duration=0.02)
    assert list(runs) == ["translation", "turning"]
    assert [run.folder for run in runs.values()] == [tmp_path / "translation", tmp_path / "turning"]
    assert len(list(tmp_path.glob("shoe_10_*.png"))) == 5
    over = table["statistic"] == "max over its translation value"
    assert table.loc[over, "computed"].notna().all()
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="holds results already"):
        kinematics_study(tmp_path, ["translation"], duration=0.01)
    kinematics_study(tmp_path, ["translation"], duration=0.01, overwrite=True)
    assert History.load(tmp_path / "translation" / "history.nc").duration == pytest.approx(0.01, rel=1e-9)
    # nothing of the case that was not run again is left
    left = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".")}
    assert left == {"translation", "comparison.csv", "run.json", "run.log", "notes.txt"}


def test_unknown_cases_are_refused():
    told = r"cases must be among translation, turning, got \['sideways'\]"
    with pytest.raises(ValueError, match=told):
        kinematics_study(None, ["sideways"], duration=0.01)


def test_the_verification_study_prints_both_tables(told):
    out = told("studies", "verify")
    for words in ("Two-body problem at t = 0.5 s", "Paper against computed", "-3.324"):
        assert words in out
