"""Values of a case by their paths."""

import pytest

from exudyn_crawler.sweep.paths import change_at, checked_case, content_of, entry_at, place_of
from tests.sweep.cases import small_case


def test_a_path_is_names_and_numbers():
    assert place_of("loads.phases[2].end") == ("loads", "phases", 2, "end")
    assert place_of("loads.phases[*].loads[0]") == ("loads", "phases", "*", "loads", 0)


@pytest.mark.parametrize("path", ["", "a..b", "a b", "loads.phases[-1]", "[2]", "a.[1]"])
def test_what_is_no_path_is_refused(path):
    with pytest.raises(ValueError, match=r"key must be a path such as terrain\.spring_stiffness"):
        place_of(path)


def test_a_field_is_found_by_its_place_and_those_of_its_parts():
    case = small_case()
    assert entry_at(case, place_of("terrain.spring_stiffness")).unit == "N/m"
    assert entry_at(case, place_of("loads.phases[*].loads")).unit == "N"
    assert entry_at(case, place_of("shoe.load_point[2]")).unit == "m"
    assert entry_at(case, place_of("duration")).unit == "s"
    assert entry_at(case, place_of("terrain.stiffness")) is None
    assert entry_at(case, place_of("terrain.spring_stiffness.more")) is None


def test_a_content_is_the_same_case():
    case = small_case()
    assert checked_case(content_of(case)) == case


def test_values_are_changed_in_tables_lists_and_beside_the_case():
    content = content_of(small_case())
    change_at(content, place_of("duration"), lambda before: 2.0 * before)
    change_at(content, place_of("loads.phases[*].loads"), lambda _: 4e5)
    change_at(content, place_of("shoe.load_point[2]"), lambda before: before + 0.01)
    found = checked_case(content)
    before = small_case()
    assert found.duration == 2.0 * before.duration
    # one number is that of every shoe
    assert found.case.loads.phases[0].loads == (4e5, 4e5, 4e5)
    assert found.case.shoe.load_point[2] == pytest.approx(before.case.shoe.load_point[2] + 0.01)
    assert found.case.shoe.load_point[:2] == before.case.shoe.load_point[:2]


def test_parts_that_a_list_does_not_have_are_refused():
    content = content_of(small_case())
    with pytest.raises(ValueError, match=r"there is no \[3\]: the list has 1 parts"):
        change_at(content, place_of("loads.phases[3].loads"), lambda before: before)


def test_few_of_many_faults_are_told():
    content = content_of(small_case())
    for name in ("spring_stiffness", "spring_damping", "density", "unit_length"):
        change_at(content, place_of(f"terrain.{name}"), lambda _: -1.0)
    with pytest.raises(ValueError, match=r"^terrain\.unit_length: .*; 1 more$"):
        checked_case(content)
