"""Tables of a run: key results, loads and stresses by its phases, differences of two runs, on a terminal."""

from functools import partial

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from exudyn_crawler import Case, History, LoadCycle, Phase
from exudyn_crawler.case import statics
from exudyn_crawler.results.history.history import phases
from exudyn_crawler.results.history.summary import (
    HELD,
    START,
    compared,
    difference_table,
    greatest_over_time,
    key_results,
    load_table,
    start_ends,
)
from exudyn_crawler.results.stress.hot_spots import highest_by_phase, hot_spot_table
from exudyn_crawler.views import tables
from exudyn_crawler.views.tables import cell_text, print_table, write_table

ENDS = (("rest", 0.02, 4e5), ("tip over", 0.05, 3e5), ("never", 0.2, 9e5), ("nor this", 0.3, 0.0))
OWN = LoadCycle(phases=tuple(Phase(name=name, end=end, loads=(load,) * 13) for name, end, load in ENDS))
TABLE = pd.DataFrame(
    {
        "case": ["translation", "turning"],
        "quantity": ["normal force z of a shoe", "slip velocity y of shoe 10"],
        "statistic": ["mean greatest of shoes", "greatest"],
        "unit": ["N", "m/s"],
        "paper": [2.146e6, 0.0312],
        "computed": [432_149.7, -0.012345],
        "lower": [3.009e11, 1.0],
        "upper": [4.071e11, 2.0],
        "class": ["statics", "fluctuation"],
        "within": ["yes", "no"],
    }
)
CELLS = ["2 146 000", "432 100", "0.0312", "-0.01235", "3.009e+11", "4.071e+11"]


def test_phases_end_where_the_run_ends():
    assert phases(OWN, 0.06) == [("rest", 0.0, 0.02), ("tip over", 0.02, 0.05), ("never", 0.05, 0.06)]
    assert phases(OWN, 0.05) == [("rest", 0.0, 0.02), ("tip over", 0.02, 0.05)]
    # loads stay after the last phase
    assert phases(OWN, 1.0)[-1] == ("nor this", 0.2, 1.0)
    assert phases(LoadCycle.propel(), 2.0) == [("constant", 0.0, 2.0)]


@pytest.mark.parametrize("duration", [0.05, 0.06, 1.0])
def test_every_time_belongs_to_one_phase(duration):
    time = np.linspace(0.0, duration, 101)
    assert np.sum([phase.rows(time) for phase in phases(OWN, duration)], axis=0).tolist() == [1] * 101


def with_loads(history: History, loads: LoadCycle) -> History:
    return History(history.case.with_(loads=loads), history.dataset)


def test_loads_are_those_at_the_ends_of_what_was_run(history):
    table = load_table(with_loads(history, OWN))
    ends = ("begin (0 s)", "rest (0.02 s)", "tip over (0.05 s)", "never (0.06 s)")
    assert list(table.columns) == ["shoe", *(f"{end} in N" for end in ends)]
    assert table["tip over (0.05 s) in N"].tolist() == pytest.approx([3e5] * 13 + [39e5])
    # a cubic step, a fifteenth of the way
    s = 0.01 / 0.15
    assert table["never (0.06 s) in N"][0] == pytest.approx(3e5 + 6e5 * s**2 * (3.0 - 2.0 * s))


def test_highest_stresses_are_by_the_phases_of_the_case_whatever_their_names(history, stress):
    table = highest_by_phase(with_loads(history, OWN), stress)
    assert table["phase"].tolist() == ["rest", "tip over", "never"] * 2
    for shoe in (7, 13):
        own = table[table["shoe"] == shoe]
        highest = stress.highest_von_mises.sel(shoe=shoe)
        assert own["highest von Mises in MPa"].max() == pytest.approx(float(highest.max()) / 1e6)
        assert (own["begin in s"] < own["time in s"] + 1e-9).all()
        assert (own["time in s"] < own["end in s"] + 1e-9).all()
    place = stress.node_position.values[table["node"][0]]
    assert table.filter(like="in the shoe in m").iloc[0].tolist() == pytest.approx(place.tolist())


def test_hot_spots_are_in_megapascal_and_in_both_frames(flexible_run):
    history, stress, hot_spots = flexible_run
    table = hot_spot_table(hot_spots[13], stress)
    assert table["von Mises in MPa"].to_numpy() == pytest.approx(hot_spots[13]["value"].to_numpy() / 1e6)
    plain = ("rank", "node", "flag", "verdict", "region")
    columns = ["rank", "region", "von Mises in MPa", "verdict", "error in MPa", "jump in MPa"]
    assert list(table.columns[:6]) == columns
    assert all("in the track" in name for name in table.columns[-3:])
    assert all(
        " in " in name or name in plain or name.startswith("contribution of ") for name in table.columns
    )
    start = Case.stress().track.com_positions(history.case.shoe.com_height)[12]
    for k, axis in enumerate("xyz"):
        moved = table[f"{axis} in the track at t = 0 in m"] - table[f"{axis} in the shoe in m"]
        assert moved.to_numpy() == pytest.approx(start[k])


def test_numbers_in_files_have_no_digits_of_rounding(tmp_path):
    table = pd.DataFrame({"time in s": [1.586 + 4e-16, 0.1 + 0.2, 1.0, 1.23456789e-7]})
    text = write_table(table, tmp_path / "table.csv").read_text()
    assert text.split() == ["time", "in", "s", "1.586", "0.3", "1", "1.23456789e-07"]


def test_a_change_is_found_with_its_place_and_time_and_none_of_a_run_from_itself(translation):
    assert difference_table(compared(translation), compared(translation)).empty
    changed = translation.dataset.copy(deep=True)
    bump = changed.velocity.sel(shoe=4, axis="y")
    bump[:] = bump.values + np.where(np.arange(len(bump)) == 50, 2.0, 0.0)
    changed["drive_force"] = changed.drive_force * 1.5
    table = difference_table(compared(translation), compared(History(translation.case, changed)))
    assert table[["quantity", "axis"]].to_numpy().tolist() == [["velocity", "y"], ["drive_force", ""]]
    row = table.iloc[0]
    assert (row["greatest difference"], row["of"], row["unit"]) == (pytest.approx(2.0), "shoe 4", "m/s")
    assert row["at in s"] == pytest.approx(0.1)
    assert row["rms difference"] == pytest.approx(2.0 / np.sqrt(13 * translation.time.size))
    assert table.iloc[1]["change in %"] == pytest.approx(50.0)


def test_rounding_on_an_axis_that_nothing_moves_along_is_no_difference(translation):
    straight, changed = (translation.dataset.copy(deep=True) for _ in range(2))
    # what a solver leaves there hangs on the machine
    straight.velocity.loc[{"axis": "y"}] = 0.0
    changed.velocity.loc[{"axis": "y"}] = 1e-11
    found = [compared(History(translation.case, one)) for one in (straight, changed)]
    assert difference_table(*found).empty


def test_the_time_that_both_have_is_compared_whatever_they_store(translation):
    seldom = History(translation.case, translation.dataset.isel(time=slice(0, 101, 5)))
    assert difference_table(compared(seldom), compared(translation)).empty
    # between stored times the other is read linearly
    table = difference_table(compared(translation), compared(seldom))
    assert table["at in s"].max() <= 0.2
    position = table[(table["quantity"] == "position") & (table["axis"] == "x")]
    assert position["greatest difference"].abs().max() < 1e-4


def test_straight_and_turning_differ_in_what_turns(translation, turning):
    table = difference_table(compared(translation), compared(turning)).set_index(["quantity", "axis"])
    assert table.loc[("angular_velocity", "z"), "greatest in B"] > 0.0
    assert (table["greatest difference"] != 0.0).all()
    # the load is the same
    assert ("shoe_load", "") not in table.index


def test_stresses_are_compared_where_both_runs_have_them(history, stress):
    doubled = stress.assign(highest_von_mises=2.0 * stress.highest_von_mises)
    table = difference_table(compared(history, stress), compared(history, doubled))
    assert table["quantity"].tolist() == ["highest_von_mises"]
    assert table["change in %"][0] == pytest.approx(100.0)
    highest = float(stress.highest_von_mises.max()) / 1e6
    assert (table["greatest in A"][0], table["unit"][0]) == (pytest.approx(highest), "MPa")
    assert table["greatest in B"][0] == pytest.approx(2.0 * highest)
    assert 0.0 < table["greatest difference"][0] <= highest * (1.0 + 1e-9)
    assert table["of"][0] in ("shoe 7", "shoe 13")
    assert difference_table(compared(history), compared(history, stress)).empty


def test_key_results_name_a_higher_stress_in_a_spider_behind_what_may_be_used(history, stress):
    held = int(np.flatnonzero(stress.in_spider.values)[5])
    usable = float(stress.highest_von_mises.max())
    raised = stress.peak_von_mises.copy()
    raised.loc[{"shoe": 7, "node": held}] = 3.0 * usable
    found = key_results(history, stress.assign(peak_von_mises=raised))
    assert found["result"].tolist()[:2] == ["highest von Mises stress", HELD]
    assert found["value"].tolist()[:2] == pytest.approx([usable / 1e6, 3.0 * usable / 1e6])
    assert found["of"][1] == "shoe 7"
    assert found["at"][1] == float(stress.peak_time.sel(shoe=7, node=held))
    assert HELD not in key_results(history, stress)["result"].tolist()


def test_key_results_are_those_of_the_history(translation):
    found = key_results(translation).set_index("result")
    speed = np.linalg.norm(translation.velocity.values, axis=-1)
    time, shoe = np.unravel_index(speed.argmax(), speed.shape)
    expected = [pytest.approx(speed.max()), f"shoe {shoe + 1}", pytest.approx(float(translation.time[time]))]
    assert found.loc["greatest speed", ["value", "of", "at"]].tolist() == expected
    link = found.loc["greatest force of a link"]
    assert link["value"] == pytest.approx(np.linalg.norm(translation.joint_force.values, axis=-1).max() / 1e3)
    assert link["of"].startswith("link ")
    depth = 1e3 * float(translation.penetration.max())
    assert found.loc["deepest penetration", "value"] == pytest.approx(depth)
    begin, end = translation.position.values[[0, -1], -1]
    assert found.loc["distance travelled", "value"] == pytest.approx(np.linalg.norm(end - begin))
    assert "highest von Mises stress" not in found.index
    # units that roll push shoes aside, which friction holds only once they slip
    weight = 13 * statics.mean_load(translation.case)
    assert 1e3 * found.loc["residual force at the start", "value"] < 2e-4 * weight


def whole_run(results):
    """Key results by name, with the greater one of start and time after it."""
    names = results["result"].str.removesuffix(START)
    return results.assign(result=names).drop_duplicates("result", keep="last").set_index("result")


def test_the_start_of_a_drive_is_apart_and_has_its_peak_by_name(rolled):
    """The drive ramps for 0.1 of 0.2 s: both halves have their own greatest pull."""
    time = rolled.time.values
    assert start_ends(rolled) == 0.1
    pull = np.abs(rolled.drive_pull.values) / 1e3
    found = key_results(rolled).set_index("result")
    after = time >= 0.1
    assert found.loc["greatest pull of the drive", "value"] == pytest.approx(pull[after].max())
    assert found.loc["greatest pull of the drive" + START, "value"] == pytest.approx(pull[~after].max())
    assert found.loc["greatest pull of the drive" + START, "at"] < 0.1
    # a value that is not exceeded during the start has one row
    assert not any(name.endswith(START) for name in found.index if found["at"].get(name, 0.0) >= 0.1)


def test_a_run_that_ends_during_its_start_has_one_window(translation):
    assert start_ends(translation) == 0.0
    assert not key_results(translation)["result"].str.endswith(START).any()


def test_the_greatest_over_time_is_the_key_result_at_its_time(translation, rolled):
    for history in (translation, rolled):
        found = whole_run(key_results(history))
        curves = greatest_over_time(
            history, ["link_tension", "joint_force", "roller_force", "contact_force", "ground_pressure"]
        )
        assert len(curves) == 3 + (history is rolled)
        for result, curve in curves.items():
            assert curve.dims == ("time",)
            assert float(curve.max()) == pytest.approx(found.loc[result, "value"])
            assert float(curve.time[curve.argmax("time")]) == pytest.approx(found.loc[result, "at"])
            assert curve.units == found.loc[result, "unit"]


def test_the_highest_stress_comes_first(history, stress):
    first = key_results(history, stress).iloc[0][["result", "value", "unit"]].tolist()
    highest = pytest.approx(float(stress.highest_von_mises.max()) / 1e6)
    assert first == ["highest von Mises stress", highest, "MPa"]


def test_a_rolled_track_is_asked_for_rollers_and_pull(rolled):
    found = whole_run(key_results(rolled))
    assert "greatest force of the drive" not in found.index
    forces = np.linalg.norm(rolled.roller_force.values, axis=-1)
    row = found.loc["greatest force of a roller on the rails of a side"]
    assert row["value"] == pytest.approx(forces.max() / 1e3)
    _, roller, rail = np.unravel_index(forces.argmax(), forces.shape)
    assert row["of"] == f"roller {roller + 1}, rail {rolled.rail.values[rail]}"
    pull = float(rolled.drive_pull.max()) / 1e3
    assert found.loc["greatest pull of the drive", "value"] == pytest.approx(pull)
    begin, end = rolled.side_frame_position.values[[0, -1]]
    way = pytest.approx(np.linalg.norm(end - begin))
    assert found.loc["distance travelled", ["of", "value"]].tolist() == ["side frame", way]
    start, case = found.loc["residual force at the start"], rolled.case
    shoes = case.shoe.mass * np.linalg.norm(rolled.acceleration.values[0], axis=-1)
    frame = case.gear.mass * np.linalg.norm(rolled.side_frame_acceleration.values[0])
    greatest = {f"shoe {shoes.argmax() + 1}": shoes.max(), "side frame": frame}
    assert start["of"] == max(greatest, key=greatest.get)
    assert 1e3 * start["value"] == pytest.approx(max(greatest.values()))


@pytest.mark.parametrize("width", [40, 80, 120])
def test_no_number_is_cut_at_any_width(width, capsys, monkeypatch):
    monkeypatch.setattr(tables, "Console", partial(Console, width=width, force_terminal=True, no_color=True))
    print_table(TABLE, "Paper against computed")
    said = capsys.readouterr().out
    assert all(text in said for text in [*CELLS, *TABLE.columns, "fluctuation"])
    assert "…" not in said


def test_numbers_are_readable():
    values = (300_940.0, 99_996.0, -2.146e6, 12_345.6, 2.1e9, float("nan"), 12)
    texts = ["300 900", "100 000", "-2 146 000", "12 350", "2.1e+09", "", "12"]
    assert [cell_text(value) for value in values] == texts
