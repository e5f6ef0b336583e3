"""Forces study: contact by shoe, deformation, the F-paper's words, reuse of histories, files."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import Case, simulate
from exudyn_crawler.results.balance import track_imbalance
from exudyn_crawler.results.contacts import contact_force, contacts_by_shoe, pair, terrain_deformation
from exudyn_crawler.runs import matching_history
from studies.comparison import time_mean
from studies.force_comparison import (
    compare_forces,
    force_quantity,
    force_statistic,
    turning_ratios,
)
from studies.forces import run_forces
from studies.reported import reported_values

WEIGHT = 13 * (386.4e3 + 4681.67 * 9.81)


def test_a_shoe_on_two_units_has_the_sum_of_their_forces_and_the_deeper_penetration(translation):
    shoe = contacts_by_shoe(translation).sel(shoe=7)
    seven, twelve = (translation.dataset.isel(contact=pair(translation, 7, unit)) for unit in (7, 12))
    for name in ("normal_force", "friction_force", "friction_torque"):
        assert shoe[name].values == pytest.approx((seven[name] + twelve[name]).values, abs=1e-9)
    assert (twelve.penetration > seven.penetration).all()
    assert shoe.penetration.values == pytest.approx(twelve.penetration.values, rel=1e-15)
    assert shoe.slip_velocity.values == pytest.approx(twelve.slip_velocity.values, rel=1e-15)


def test_contact_by_shoe_carries_what_contact_by_pair_does(translation):
    by_shoe = contacts_by_shoe(translation).contact_force.sum("shoe")
    by_pair = contact_force(translation).sum("contact")
    assert by_shoe.values == pytest.approx(by_pair.values, abs=1e-6 * WEIGHT)
    assert time_mean(by_shoe).sel(axis="z") == pytest.approx(WEIGHT, rel=1e-3)


def test_a_pair_that_never_met_is_refused(translation):
    with pytest.raises(ValueError, match=r"shoe 7 never met unit 17; it met units \[7, 12\]"):
        pair(translation, 7, 17)


def test_deformation_counts_every_spring_from_equilibrium(translation):
    deformation = terrain_deformation(translation)
    assert float(deformation[0]) == 0.0
    heave = translation.unit_heave - translation.unit_heave.isel(time=0)
    assert deformation.values == pytest.approx(
        2.0 * heave.sum("unit").values, abs=1e-13
    )  # m, rounding of 50 units


def test_every_row_of_the_paper_is_computed(translation, turning):
    table = compare_forces({"translation": translation, "turning": turning})
    assert len(table) == len(reported_values("forces"))
    assert table["computed"].notna().all()


def test_a_missing_case_leaves_its_rows_empty(translation):
    table = compare_forces({"translation": translation})
    assert (table["computed"].isna() == (table["case"] == "turning")).all()


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
    contacts = contacts_by_shoe(translation)
    xr.testing.assert_identical(
        force_quantity(translation, contacts, quantity), contacts[variable].sel(chosen)
    )


def test_the_papers_words_name_joints(translation):
    values = force_quantity(translation, contacts_by_shoe(translation), "parallel joint torque z")
    assert values.joint.values.tolist() == [1, 4, 7, 10, 12]
    xr.testing.assert_identical(values, translation.joint_torque.sel(joint=[1, 4, 7, 10, 12], axis="z"))


def test_other_words_are_refused(translation):
    with pytest.raises(ValueError, match="'mood of a shoe' names no quantity"):
        force_quantity(translation, contacts_by_shoe(translation), "mood of a shoe")


def test_means_are_magnitudes_over_time_and_greatest_over_shoes():
    values = xr.DataArray(
        [[-1.0, 2.0], [-3.0, 2.0], [-3.0, 2.0]],
        dims=("time", "shoe"),
        coords={"time": [0.0, 1.0, 3.0], "shoe": [1, 4]},
    )
    # by the trapezoidal rule: (2 * 1 + 3 * 2) / 3 and 2
    assert force_statistic(values, "mean greatest of shoes") == pytest.approx(8 / 3)
    assert force_statistic(values, "mean least") == pytest.approx(2.0)
    assert force_statistic(values, "mean") == pytest.approx((8 / 3 + 2.0) / 2)
    assert force_statistic(values, "max abs") == 3.0


def test_turning_ratios_cover_every_component_and_leave_ratios_to_rounding_empty(translation, turning):
    table = turning_ratios(translation, turning)
    assert len(table) == 2 + 5 * 3 + 2 * 3
    row = table.set_index(["quantity", "axis"]).loc[("shoe 10 normal force", "z")]
    extremes = [
        float(abs(contacts_by_shoe(one).normal_force.sel(shoe=10, axis="z")).max())
        for one in (translation, turning)
    ]
    assert row["extreme ratio"] == pytest.approx(extremes[1] / extremes[0], rel=1e-12)
    sideways = table.set_index(["quantity", "axis"]).loc[("shoe 10 slip velocity", "y")]
    assert np.isnan(sideways["extreme ratio"])
    assert sideways["extreme turning"] > 1e-4


def test_the_track_balances_through_stick_slip(longer):
    off = track_imbalance(longer, about=(14.0, 9.29, 0.0))
    assert float(np.abs(off.force).max()) < 1e-6 * WEIGHT


def test_a_study_reuses_a_history_of_the_same_parameters(translation, tmp_path):
    (tmp_path / "runs").mkdir()
    translation.save(tmp_path / "runs" / "translation.nc")
    said = []
    histories, table = run_forces(["translation"], 0.4, tmp_path / "out", tmp_path / "runs", say=said.append)
    assert histories["translation"].dataset.identical(
        matching_history(tmp_path / "runs", Case.translation(), 0.4).dataset
    )
    assert said == [f"translation: reusing the history in {tmp_path / 'runs'}, whose parameters are the same"]
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"comparison.csv", "translation_forces.nc", "translation_shoe_7_crossing.png"} <= names
    assert "translation.nc" not in names
    assert len(pd.read_csv(tmp_path / "out" / "comparison.csv")) == len(table)
    forces = xr.load_dataset(tmp_path / "out" / "translation_forces.nc")
    assert {"penetration", "contact_force", "joint_torque", "terrain_deformation"} <= set(forces)


def test_a_history_of_other_parameters_is_refused_by_name(translation, tmp_path):
    translation.save(tmp_path / "translation.nc")
    other = Case.translation()
    other = other.with_(contact=other.contact.with_(stiffness=2e8))
    with pytest.raises(ValueError, match=r"contact.stiffness is 100000000.0, not 200000000.0"):
        matching_history(tmp_path, other, 0.4)
    with pytest.raises(ValueError, match=r"duration is 0.4 s, not 10 s"):
        run_forces(["translation"], 10.0, tmp_path / "out", tmp_path, strict=True)
    assert not (tmp_path / "out").exists()


def test_unasked_a_history_of_other_parameters_is_run_anew(translation, tmp_path):
    translation.save(tmp_path / "translation.nc")
    said = []
    histories, _ = run_forces(["translation"], 0.01, None, tmp_path, strict=False, say=said.append)
    assert histories["translation"].duration == pytest.approx(0.01)
    assert "running anew" in said[0]


def test_results_are_refused_before_anything_runs(tmp_path, monkeypatch):
    (tmp_path / "comparison.csv").write_text("kept")
    monkeypatch.setattr("exudyn_crawler.runs.simulate", lambda *_: pytest.fail("it ran"))
    with pytest.raises(FileExistsError, match="holds results already"):
        run_forces(["translation"], 0.1, tmp_path)
    with pytest.raises(ValueError, match="cases must be of"):
        run_forces(["sideways"], 0.1, None)


def test_rolling_units_push_a_straight_track_sideways(translation):
    rolling = Case.translation()
    rolling = rolling.with_(terrain=rolling.terrain.with_(tilt="roll"))
    moved = simulate(rolling, 0.4)
    sideways = [float(abs(h.velocity.sel(axis="y")).max()) for h in (translation, moved)]
    assert sideways[0] < 1e-9  # m/s: an even track stays in its plane but for rounding
    assert sideways[1] > 1e-5


@pytest.mark.slow
def test_the_forces_study_comes_as_close_as_its_classes_ask():
    _, table = run_forces()
    statics = table[table["class"] == "statics"]
    assert (statics["within"] == "yes").all()
    fluctuation = table[table["class"] == "fluctuation"]
    assert (fluctuation["within"] == "yes").mean() >= 0.7
