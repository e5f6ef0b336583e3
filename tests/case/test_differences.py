"""What a case has otherwise than the papers' case that is nearest."""

import pytest

from exudyn_crawler import Case, CaseFile
from exudyn_crawler.case.files.changes import differences, parameter_differences, rows_beside_base


@pytest.mark.parametrize("name", ["translation", "turning", "stress"])
def test_a_papers_case_is_its_own_base(name):
    case = getattr(Case, name)().with_(name="own name")
    base, rows = rows_beside_base(CaseFile(case=case, duration=1.0))
    assert base == name
    assert {row.in_the_base for row in rows} == {""}


def test_changed_values_stand_beside_those_of_the_base():
    case = Case.turning()
    case = case.with_(terrain=case.terrain.with_(spring_stiffness=1e7), gravity=1.62)
    base, rows = rows_beside_base(CaseFile(case=case, duration=1.0))
    marked = {row.key: (row.value, row.in_the_base) for row in rows if row.in_the_base}
    assert base == "turning"
    assert marked == {"gravity": ("1.62", "9.81"), "terrain.spring_stiffness": ("10e6", "20e6")}


def test_what_the_base_has_not_is_marked_too():
    case = Case.stress("coarse").with_(flexible=None)
    base, rows = rows_beside_base(CaseFile(case=case, duration=1.0))
    marked = {row.key: row.in_the_base for row in rows if row.in_the_base}
    assert (base, marked) == ("stress", {"flexible": "-"})


def test_two_cases_differ_in_what_was_changed_and_not_in_their_names():
    case = Case.translation()
    other = case.with_(name="other", gravity=1.62, terrain=case.terrain.with_(spring_damping=0.0))
    rows = {row.key: row for row in parameter_differences(case, other)}
    assert rows["gravity"] == ("gravity", "9.81", "1.62", "m/s2")
    assert set(rows) == {"gravity", "terrain.spring_damping"}
    assert parameter_differences(case, case) == []
    lost = parameter_differences(Case.stress("coarse"), Case.stress("coarse").with_(flexible=None))
    assert next(row for row in lost if row.key == "flexible.mesh").second == "-"


def test_values_that_differ_in_their_last_digits_alone_are_shown_in_full():
    case = Case.translation()
    (one,) = differences(case, case.with_(gravity=9.81 + 1e-12))
    assert str(one) == "gravity is 9.81, not 9.810000000001"
    (name,) = differences(case, case.with_(name="other"))
    assert str(name) == "name is translation, not other"
