"""Comparison with the papers: the words of their tables, statistics, and verdicts at their limits."""

import math

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from exudyn_crawler import Case, History
from exudyn_crawler.views.tables import within_by_class
from studies.comparison import (
    compare_kinematics,
    comparison_table,
    kinematic_quantity,
    kinematics_value,
    needed_time,
    reported_values,
    statistic_of,
    time_mean,
    verdict,
)

COLUMNS = ["study", "case", "quantity", "statistic", "unit", "value", "class", "source"]
"""Of the tables of reported values."""
TIME = np.array([0.0, 1.0, 2.0, 5.0, 10.0])  # unequal on purpose


def by_hand(scale=1.0):
    """History of 13 shoes: shoe n moves by n t along x, 2 n t along y, -n t along z, all times `scale`."""
    shoes = np.arange(1, 14)
    rate = scale * shoes[:, None] * np.array([1.0, 2.0, -1.0])
    motion = TIME[:, None, None] * rate
    dims = ("time", "shoe", "axis")
    names = ("velocity", "acceleration", "angular_velocity", "angular_acceleration")
    dataset = xr.Dataset(
        {"position": (dims, 100.0 + motion)} | dict.fromkeys(names, (dims, motion)),
        coords={"time": TIME, "shoe": shoes, "axis": ["x", "y", "z"]},
    )
    return History(case=Case.translation(), dataset=dataset)


@pytest.mark.parametrize(
    ("quantity", "statistic", "expected"),
    [
        ("shoe 13 x displacement", "at t=5 s", 65.0),
        ("shoe 2 x displacement", "at t=7 s", 14.0),
        ("shoe 4 y velocity", "max", 80.0),
        ("any shoe z displacement from equilibrium", "min", -130.0),
        ("any shoe z displacement from equilibrium", "max", 0.0),
        ("any shoe z acceleration", "max abs", 130.0),
        ("any shoe x velocity", "mean over 10 s", 35.0),  # mean of n is 7, of t is 5
        ("shoe 3 x acceleration", "mean", 15.0),
        ("shoe 10 z angular velocity", "mean over 10 s", -50.0 * 180.0 / math.pi),
        ("any shoe y angular acceleration", "max", 260.0 * 180.0 / math.pi),
    ],
)
def test_quantities_and_statistics_are_read_as_words(quantity, statistic, expected):
    value = kinematics_value({"translation": by_hand()}, "translation", quantity, statistic)
    assert value == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_turning_is_put_over_translation():
    histories = {"translation": by_hand(), "turning": by_hand(-3.0)}
    row = ("turning", "shoe 10 y velocity", "max over its translation value")
    assert kinematics_value(histories, *row) == pytest.approx(3.0, rel=1e-12)
    assert math.isnan(kinematics_value({"turning": by_hand()}, *row))


def test_the_mean_over_time_weighs_times_and_not_samples():
    values = xr.DataArray([0.0, 1.0, 1.0], coords={"time": [0.0, 1.0, 11.0]}, dims="time")
    assert float(time_mean(values)) == pytest.approx(10.5 / 11.0, rel=1e-12)


def test_a_run_that_is_missing_or_too_short_gives_no_number():
    short = History(case=Case.translation(), dataset=by_hand().dataset.isel(time=slice(0, 3)))
    for statistic in ("at t=5 s", "mean over 10 s"):
        value = kinematics_value({"translation": short}, "translation", "shoe 1 x velocity", statistic)
        assert math.isnan(value)
    assert math.isnan(kinematics_value({}, "turning", "shoe 1 x velocity", "max"))


@pytest.mark.parametrize(
    "words", ["speed", "shoe 1 w velocity", "shoe x velocity", "shoe 1 x jerk", "any shoe x velocity now", ""]
)
def test_unknown_quantities_are_refused(words):
    with pytest.raises(ValueError, match=f"'{words}' names no kinematic quantity"):
        kinematic_quantity(by_hand(), words)


@pytest.mark.parametrize("words", ["median", "at t=x s", "mean over ten s", ""])
def test_unknown_statistics_are_refused(words):
    with pytest.raises(ValueError, match=f"'{words}' names no statistic"):
        statistic_of(kinematic_quantity(by_hand(), "shoe 1 x velocity"), words)


def test_unknown_studies_are_refused():
    with pytest.raises(ValueError, match=r"study must be one of .*'kinematics'.*, got 'speed'"):
        reported_values("speed")


@pytest.mark.parametrize(
    ("kind", "unit", "least", "greatest"),
    [
        ("exact", "N", 0.9999, 1.0001),
        ("prescribed", "m", 0.99, 1.01),
        ("statics", "N", 0.9, 1.1),
        ("structural", "MPa", 0.75, 1.25),
        ("structural", "Hz", 0.9, 1.1),
        ("fluctuation", "N", 0.5, 2.0),
    ],
)
@pytest.mark.parametrize("paper", [3.0, -40.0])
def test_verdicts_change_at_the_limits_of_their_class(kind, unit, least, greatest, paper):
    within, beyond = (least + 1e-7, greatest - 1e-7), (least - 1e-7, greatest + 1e-7, -1.0)
    assert [verdict(paper, ratio * paper, kind, unit) for ratio in within] == ["yes"] * 2
    assert [verdict(paper, ratio * paper, kind, unit) for ratio in beyond] == ["no"] * 3


def test_lateral_rows_and_missing_numbers_have_no_verdict():
    assert verdict(1.0, 1.0, "lateral", "m") == ""
    for kind in ("exact", "prescribed", "statics", "structural", "fluctuation"):
        assert verdict(1.0, math.nan, kind, "m") == ""


def test_every_kinematics_row_has_its_computation_and_columns_their_order():
    table = compare_kinematics({"translation": by_hand(), "turning": by_hand(2.0)})
    assert len(table) == len(reported_values("kinematics")) == 40
    assert table["computed"].notna().all()
    table = compare_kinematics({"translation": by_hand()})
    assert list(table.columns) == [
        "study", "case", "quantity", "statistic", "unit", "paper", "computed", "ratio", "class", "within",
    ]  # fmt: skip
    assert table.loc[table["case"] == "turning", "within"].eq("not reached").all()
    known = table[table["case"] == "translation"]
    assert (known["ratio"] * known["paper"]).tolist() == pytest.approx(known["computed"].tolist(), rel=1e-12)


def test_rows_that_a_shorter_run_does_not_reach_are_not_compared():
    short = History(case=Case.translation(), dataset=by_hand().dataset.isel(time=slice(0, 4)))
    table = compare_kinematics({"translation": short, "turning": by_hand()})
    straight = table[table["case"] == "translation"]
    reached = straight["statistic"] == "at t=5 s"
    assert straight.loc[reached, "within"].isin(["yes", "no"]).all()
    assert straight.loc[~reached, "within"].eq("not reached").all()
    assert straight.loc[~reached, "ratio"].isna().all()
    # what the run had stays to be read
    assert straight.loc[straight["statistic"] == "max", "computed"].notna().all()
    assert table.loc[table["case"] == "turning", "within"].ne("not reached").all()
    assert within_by_class(straight)["of"].sum() == 1


def test_the_summary_counts_rows_with_a_verdict():
    kinds = ("statics", "statics", "lateral", "prescribed")
    reported = pd.DataFrame([["s", "c", "q", "max", "m", 1.0, kind, "x"] for kind in kinds], columns=COLUMNS)
    counts = within_by_class(comparison_table(reported, [1.05, 2.0, 1.0, math.nan]))
    assert counts.to_dict("records") == [{"class": "statics", "within": 1, "of": 2}]


@pytest.mark.parametrize("study", ["kinematics", "forces", "stress", "verification"])
def test_reported_rows_are_complete_and_say_how_far_a_run_has_to_go(study):
    table = reported_values(study)
    if study != "verification":
        for row in table.itertuples():
            assert needed_time(study, row.case, row.statistic) in (0.0, 5.0, 10.0, 15.0, 40.0), row
    assert list(table.columns) == COLUMNS
    assert table.notna().all(axis=None)
    assert not table.duplicated(["case", "quantity", "statistic"]).any() or study == "stress"
    assert set(table["class"]) <= {"exact", "prescribed", "statics", "structural", "fluctuation", "lateral"}
