"""Measured loads from CSV files, as spreadsheets and loggers write them."""

import numpy as np
import pytest

from exudyn_crawler import Case, LoadCycle, read_case
from exudyn_crawler.case.parameters.checks import implausible
from exudyn_crawler.errors import CaseFileError, ImplausibleWarning
from exudyn_crawler.results.history.history import MOST_PHASES, RunPhase, phases

SUMS = "time [s],sum [kN],side shift [mm]\n0,390,0\n2.5,780,40\n"


def written(folder, text, encoding="utf-8"):
    path = folder / "measured.csv"
    path.write_bytes(text.encode(encoding))
    return path


def test_sum_is_spread_over_the_shoes_in_si_units(tmp_path):
    cycle = LoadCycle.from_csv(written(tmp_path, SUMS), 3)
    assert [phase.end for phase in cycle.phases] == [0.0, 2.5]
    assert cycle.phases[1].loads == pytest.approx((260e3,) * 3, rel=1e-14)
    assert cycle.side_shift.value(2.5) == pytest.approx(0.04, rel=1e-14)
    assert cycle.loads([0.0, 2.5, 9.0]).sum(axis=1) == pytest.approx([390e3, 780e3, 780e3], rel=1e-14)


def test_columns_of_shoes_may_come_in_any_order_and_unit(tmp_path):
    text = "shoe 2 [N],Time (min),Load on shoe 1 in MN\n3000,0,0.001\n4000,0.5,0.002\n"
    cycle = LoadCycle.from_csv(written(tmp_path, text), 2)
    assert cycle.phases[1].end == pytest.approx(30.0)
    assert [phase.loads for phase in cycle.phases] == [(1e3, 3e3), (2e3, 4e3)]


def test_semicolons_decimal_commas_and_a_byte_order_mark_are_read(tmp_path):
    text = "time [s];load [kN]\r\n0;386,4\r\n1,5;400\r\n;\r\n"
    cycle = LoadCycle.from_file(written(tmp_path, text, "utf-8-sig"), 1)
    assert [(phase.end, *phase.loads) for phase in cycle.phases] == [(0.0, 386.4e3), (1.5, 400e3)]


def test_german_thousands_are_asked_about_and_loads_that_pull_are_warned_of(tmp_path):
    with pytest.raises(CaseFileError, match=r"measured\.csv: is 5\.023 in row 1 5\.023 or 5023\?"):
        LoadCycle.from_csv(written(tmp_path, "time [s];sum [kN]\n0;5.023\n5;5.130\n"), 1)
    pulled = written(tmp_path, "time [s],sum [kip],side shift [mm]\n0,1129,-3\n5,-1153,3\n")
    with pytest.warns(ImplausibleWarning) as caught:
        cycle = LoadCycle.from_csv(pulled, 1)
    assert [str(one.message) for one in caught] == [
        f"{pulled}: 'sum [kip]' is -1153 in row 2 and pulls the shoes up; loads press down and are positive"
    ]
    assert cycle.phases[0].loads == pytest.approx((1129e3 * 4.4482216152605,))


def test_loads_below_the_weight_of_a_shoe_are_warned_of():
    case = Case.translation()
    count, weight = case.track.shoe_count, case.shoe.mass * 9.81
    for share, told in ((0.4, True), (0.6, False)):
        light = case.with_(loads=LoadCycle.constant((share * weight,) * count))
        assert any("on a shoe, which weighs" in line for line in implausible(light)) is told


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("time [s],load [kN]\n", "must have a line of heads and rows below it, got 1 lines"),
        ("time,load [kN]\n0,1\n", "column 'time' needs its unit, such as 'time [s]'"),
        ("time [s],load [mm]\n0,1\n", "column 'load [mm]' must be in a unit such as kN, got 'mm'"),
        ("time [s],force [kN]\n0,1\n", "column 'force [kN]' must be one of 'time [s]', 'load [kN]'"),
        ("time [s],load [kN],sum [kN]\n0,1,2\n", "or one for every shoe: 'shoe 1 [kN]'"),
        ("time [s],shoe 1 [kN],shoe 3 [kN]\n0,1,2\n", "columns of shoes must be 1 to 2, each once, got"),
        ("time [s],load [kN]\n0,1\n0,2\n", "times must rise from 0 s or later, got 0 s in row 2"),
        ("time [s],load [kN]\n-1,1\n", "times must rise from 0 s or later, got -1 s in row 1"),
        ("time [s],load [kN]\n0,386,4\n", "row 1 must have 2 cells, as its head, got 3"),
        (
            "time [s],load [kN]\n0,nan\n",
            "'load [kN]' must be finite and at most 1e+15 in size in row 1, got 'nan'",
        ),
        ("time [s],load [kN]\n0,\n", "'load [kN]' must be a number in row 1, got ''"),
        ("time [s],load [kN]\n0,1e14\n", "phases[0].loads[0..1]: must be less than or equal to"),
        ("\udcff", "must be a text in UTF-8"),
    ],
)
def test_files_without_loads_over_time_are_refused_in_a_line(tmp_path, text, reason):
    path = tmp_path / "measured.csv"
    path.write_text(text, errors="surrogateescape")
    with pytest.raises(CaseFileError) as refused:
        LoadCycle.from_csv(path, 2)
    assert reason in str(refused.value)
    assert str(refused.value).count("\n") <= 1


def test_a_case_file_names_its_measured_loads(tmp_path):
    written(tmp_path, SUMS)
    (tmp_path / "case.toml").write_text('base = "translation"\n[loads]\nfile = "measured.csv"\n')
    assert read_case(tmp_path / "case.toml").case.loads == LoadCycle.from_csv(tmp_path / "measured.csv")


def test_rows_of_a_long_measurement_are_one_phase(tmp_path):
    times = np.arange(MOST_PHASES + 1.0)
    rows = "\n".join(f"{time:g},1" for time in times)
    cycle = LoadCycle.from_csv(written(tmp_path, f"time [s],load [kN]\n{rows}\n"), 1)
    assert phases(cycle, 7.0) == [RunPhase("loads", 0.0, 7.0)]
