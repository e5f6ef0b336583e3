"""Two runs beside each other: differences where there are any, of what both have."""

import numpy as np
import pytest

from exudyn_crawler import History
from exudyn_crawler.results.history.tables import compared, difference_table


def test_a_run_does_not_differ_from_itself(translation):
    found = compared(translation)
    assert difference_table(found, found).empty


def test_a_change_is_found_with_its_place_and_time(translation):
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
    changed = translation.dataset.copy(deep=True)
    # what a solver leaves there hangs on the machine
    changed.velocity.loc[{"axis": "y"}] = 1e-11
    assert difference_table(compared(translation), compared(History(translation.case, changed))).empty


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


def test_stresses_are_compared_where_both_runs_have_them(flexible_run):
    history, stress, _ = flexible_run
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
