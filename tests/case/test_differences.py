"""What a case has otherwise than the papers' case that is nearest."""

import pytest

from exudyn_crawler import Case
from exudyn_crawler.case.case_file import CaseFile, differences, nearest_base, run_lines


@pytest.mark.parametrize("name", ["translation", "turning", "stress"])
def test_a_papers_case_is_its_own_base(name):
    case = getattr(Case, name)().with_(name="own name")
    assert nearest_base(case) == (name, {})


def test_changed_values_stand_beside_those_of_the_base():
    case = Case.turning()
    case = case.with_(terrain=case.terrain.with_(spring_stiffness=1e7), gravity=1.62)
    assert nearest_base(case) == ("turning", {"gravity": "9.81 m/s2", "terrain.spring_stiffness": "20 MN/m"})


def test_what_the_base_has_not_is_marked_too():
    case = Case.stress("coarse").with_(flexible=None)
    base, of_base = nearest_base(case)
    assert (base, of_base["flexible"]) == ("stress", "-")


def test_two_cases_differ_in_what_was_changed_and_not_in_their_names():
    case = Case.translation()
    other = case.with_(name="other", gravity=1.62, terrain=case.terrain.with_(spring_damping=0.0))
    rows = {row.key: row for row in differences(case, other.with_(name=case.name))}
    assert rows["gravity"] == ("gravity", "9.81 m/s2", "1.62 m/s2")
    assert set(rows) == {"gravity", "terrain.spring_damping"}
    assert differences(case, case) == []
    lost = differences(Case.stress("coarse"), Case.stress("coarse").with_(flexible=None))
    assert next(row for row in lost if row.key == "flexible.mesh").second == "-"


def test_values_that_differ_in_their_last_digits_alone_are_shown_in_full():
    case = Case.translation()
    (one,) = differences(case, case.with_(gravity=9.81 + 1e-12))
    assert str(one) == "gravity is 9.81 m/s2, not 9.810000000001 m/s2"
    (name,) = differences(case, case.with_(name="other"))
    assert str(name) == "name is translation, not other"


def test_before_a_run_it_is_said_what_it_comes_to():
    track, run = run_lines(CaseFile(case=Case.translation(), duration=10.0))
    # 13 shoes with 386.4 kN each and their own weight, on 13 undersides of 0.655742 m x 3.505 m
    carried = 13 * (386.4 + 4.68167 * 9.81)
    assert f"13 shoes of 4.682 t; the ground carries {carried / 1e3:.4g} MN at the start, " in track
    assert f"{carried / (13 * 0.655742 * 3.505):.4g} kPa below the shoes, which sink by about 65." in track
    assert run.startswith("run: 10 s, 0.75 m of travel by the drive, 5000 steps of 2 ms, ")
