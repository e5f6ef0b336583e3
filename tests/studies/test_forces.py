"""Forces study: the F-paper's words, reuse of histories, files."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import Case, CaseFile, simulate
from exudyn_crawler.run.folder.folder import matching_history
from studies.comparison import reported_values
from studies.forces import compare_forces, force_quantity, force_statistic, study, turning_ratios
from studies.grounds import plain


def test_every_row_of_the_paper_is_computed_but_for_those_of_a_missing_case(translation, turning):
    table = compare_forces({"translation": translation, "turning": turning})
    assert len(table) == len(reported_values("forces"))
    # shoe 7's fingers are alone on unit 7 from 4 s on
    later = table["quantity"] == "shoe 7 on unit 7 three volumes"
    assert later.sum() == 1
    assert (table["computed"].isna() == later).all()
    computed = compare_forces({"translation": translation})["computed"]
    assert (computed.isna() == ((table["case"] == "turning") | later)).all()


@pytest.mark.parametrize(
    ("quantity", "variable", "chosen"),
    [
        ("shoe 10 normal force z", "normal_force", {"shoe": 10, "axis": "z"}),
        ("shoe 7 (crossing two units) penetration depth", "penetration", {"shoe": 7}),
        ("slip velocity y of shoe 10", "slip_velocity", {"shoe": 10, "axis": "y"}),
        ("contact force x", "contact_force", {"shoe": [1, 4, 7, 10, 13], "axis": "x"}),
        ("penetration depth of a shoe", "penetration", {"shoe": [1, 4, 7, 10, 13]}),
    ],
)
def test_the_papers_words_name_contact_quantities(translation, quantity, variable, chosen):
    contacts = translation.contacts_by_shoe()
    found = force_quantity(translation, contacts, quantity)
    xr.testing.assert_identical(found, contacts[variable].sel(chosen))


def test_the_papers_words_name_joints_and_others_are_refused(translation):
    contacts, joints = translation.contacts_by_shoe(), [1, 4, 7, 10, 12]
    values = force_quantity(translation, contacts, "parallel joint torque z")
    xr.testing.assert_identical(values, translation.joint_torque.sel(joint=joints, axis="z"))
    with pytest.raises(ValueError, match="'mood of a shoe' names no quantity"):
        force_quantity(translation, contacts, "mood of a shoe")


def test_means_are_magnitudes_over_time_and_greatest_over_shoes():
    values = xr.DataArray([[-1.0, 2.0], [-3.0, 2.0], [-3.0, 2.0]], {"time": [0.0, 1.0, 3.0], "shoe": [1, 4]})
    # by the trapezoidal rule: (2 * 1 + 3 * 2) / 3 and 2
    means = {"mean greatest of shoes": 8 / 3, "mean least": 2.0, "mean": (8 / 3 + 2.0) / 2}
    assert {words: force_statistic(values, words) for words in means} == pytest.approx(means)
    assert force_statistic(values, "max abs") == 3.0


def test_turning_ratios_cover_every_component_and_leave_ratios_to_rounding_empty(translation, turning):
    straight = simulate(plain(translation.case), translation.duration)
    table = turning_ratios(straight, turning)
    assert len(table) == 2 + 5 * 3 + 2 * 3
    rows = table.set_index(["quantity", "axis"])
    normals = [one.contacts_by_shoe().normal_force.sel(shoe=10, axis="z") for one in (straight, turning)]
    extremes = [float(abs(one).max()) for one in normals]
    ratio = rows.loc[("shoe 10 normal force", "z"), "extreme ratio"]
    assert ratio == pytest.approx(extremes[1] / extremes[0], rel=1e-12)
    sideways = rows.loc[("shoe 10 slip velocity", "y")]
    assert np.isnan(sideways["extreme ratio"])
    assert sideways["extreme turning"] > 1e-4


@pytest.mark.slow
def test_a_study_reuses_a_history_of_the_same_parameters(translation, tmp_path):
    earlier = tmp_path / "runs"
    (earlier / "translation").mkdir(parents=True)
    translation.save(earlier / "translation" / "history.nc")
    said = []
    out = tmp_path / "out"
    runs, table = study(out, ["translation"], duration=0.4, reuse=earlier, say=said.append)
    assert runs["translation"].history.dataset.identical(translation.dataset)
    assert said[-1:] == [f"translation: reusing the history in {earlier}, whose parameters are the same"]
    names = {path.name for path in out.iterdir()}
    assert {"comparison.csv", "translation", "translation_shoe_7_crossing.png"} <= names
    assert "turning_ratios.csv" not in names
    assert len(pd.read_csv(out / "comparison.csv")) == len(table)
    forces = xr.load_dataset(out / "translation" / "forces.nc")
    assert set(forces) == {"contact_force", "terrain_deformation"}
    history = runs["translation"].history
    whole = history.normal_force + history.friction_force
    assert forces.contact_force.values == pytest.approx(whole.values)


def test_histories_are_found_where_runs_and_studies_keep_them(translation, tmp_path):
    asked = CaseFile(case=Case.translation(), duration=0.4)
    for number, name in enumerate(("history.nc", "translation/history.nc")):
        folder = tmp_path / str(number)
        (folder / name).parent.mkdir(parents=True)
        translation.save(folder / name)
        assert matching_history(folder, asked).dataset.identical(translation.dataset)
    with pytest.raises(FileNotFoundError, match=r"no history at .*history\.nc or .*translation/history\.nc"):
        matching_history(tmp_path, asked)


def test_a_history_of_other_parameters_is_refused_by_name(translation, tmp_path):
    translation.save(tmp_path / "history.nc")
    other = Case.translation().with_({"contact.stiffness": 2e8})
    with pytest.raises(ValueError, match=r"contact.stiffness is 100 MN/m.exponent, not 200 MN/m.exponent"):
        matching_history(tmp_path, CaseFile(case=other, duration=0.4))
    with pytest.raises(ValueError, match=r"duration is 0.4 s, not 10 s"):
        study(tmp_path / "out", ["translation"], duration=10.0, reuse=tmp_path)
    assert not (tmp_path / "out").exists()


def test_unasked_a_history_of_other_parameters_is_run_anew(translation, tmp_path):
    translation.save(tmp_path / "history.nc")
    said = []
    runs, _ = study(None, ["translation"], duration=0.01, reuse=tmp_path, strict=False, say=said.append)
    assert runs["translation"].history.duration == pytest.approx(0.01)
    assert "running again" in said[0]


def test_results_are_refused_before_anything_runs(tmp_path, monkeypatch):
    monkeypatch.setattr("exudyn_crawler.case_run.simulate", lambda *_: pytest.fail("it ran"))
    (tmp_path / "turning").mkdir()
    (tmp_path / "turning" / "history.nc").write_text("kept")
    with pytest.raises(FileExistsError, match=r"holds results already \(turning/history\.nc, "):
        study(tmp_path, ["translation"], duration=0.1)
