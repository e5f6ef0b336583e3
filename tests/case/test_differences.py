"""What a case has otherwise than the papers' case that is nearest."""

import pytest

from exudyn_crawler import Case, CaseFile
from exudyn_crawler.case.differences import parameter_differences, table_beside_base


@pytest.mark.parametrize("name", ["translation", "turning", "stress"])
def test_a_papers_case_is_its_own_base(name):
    case = getattr(Case, name)().with_(name="own name")
    base, table = table_beside_base(CaseFile(case=case, duration=1.0))
    assert base == name
    assert set(table["in the base"]) == {""}


def test_changed_values_stand_beside_those_of_the_base():
    case = Case.turning()
    case = case.with_(terrain=case.terrain.with_(spring_stiffness=1e7), gravity=1.62)
    base, table = table_beside_base(CaseFile(case=case, duration=1.0))
    marked = table[table["in the base"] != ""].set_index("key")
    assert base == "turning"
    assert marked["in the base"].to_dict() == {"gravity": "9.81", "terrain.spring_stiffness": "20e6"}
    assert marked["value"].to_dict() == {"gravity": "1.62", "terrain.spring_stiffness": "10e6"}


def test_what_the_base_has_not_is_marked_too():
    case = Case.stress("coarse").with_(flexible=None)
    base, table = table_beside_base(CaseFile(case=case, duration=1.0))
    marked = table[table["in the base"] != ""].set_index("key")["in the base"]
    assert (base, marked.to_dict()) == ("stress", {"flexible": "-"})


def test_two_cases_differ_in_what_was_changed_and_not_in_their_names():
    case = Case.translation()
    other = case.with_(name="other", gravity=1.62, terrain=case.terrain.with_(spring_damping=0.0))
    table = parameter_differences(case, other).set_index("key")
    assert table.loc["gravity"].tolist() == ["9.81", "1.62", "m/s2"]
    assert set(table.index) == {"gravity", "terrain.spring_damping"}
    assert parameter_differences(case, case).empty
    lost = parameter_differences(Case.stress("coarse"), Case.stress("coarse").with_(flexible=None))
    assert lost.set_index("key").loc["flexible.mesh", "B"] == "-"
