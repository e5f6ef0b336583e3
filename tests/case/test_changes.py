"""Values of a case file changed from outside: by path or last name, checked like the file."""

import re

import pytest

from exudyn_crawler import LoadCycle, read_case
from exudyn_crawler.errors import CaseFileError


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text('base = "translation"\n[terrain]\nspring_stiffness = 10e6\n')
    return file


def test_values_are_changed_by_path_or_by_a_name_that_only_one_has(path):
    changes = ("terrain.spring_stiffness=3e7", "springs_per_unit = 1", "duration=2", "name=own ground")
    found = read_case(path, (*changes, "drive.speed={times=[0, 1], values=[0, 0.2]}", "figure_format=svg"))
    assert found.case.terrain.spring_stiffness == 3e7
    assert found.case.terrain.springs_per_unit == 1
    assert (found.duration, found.case.name) == (2.0, "own ground")
    assert found.case.drive.speed.values == (0.0, 0.2)
    assert found.outputs.figure_format == "svg"
    assert read_case(path).case.terrain.spring_stiffness == 10e6


def test_items_of_lists_are_changed_by_the_names_that_faults_have(path):
    """Also of lists that a base gives, and after the values that are no items."""
    changes = ("loads.phases[1].side_shift=0.3", "phases[0].loads[12] = 5e5", "loads.base=shovel_cycle")
    found = read_case(path, (*changes, "terrain.origin[1]=-1", "loads.phases[2].loads=4e5")).case
    cycle = LoadCycle.shovel_cycle()
    assert found.loads.phases[1] == cycle.phases[1].with_(side_shift=0.3)
    assert found.loads.phases[0] == cycle.phases[0].with_(loads=(*cycle.phases[0].loads[:12], 5e5))
    assert found.loads.phases[2] == cycle.phases[2].with_(loads=(4e5,) * 13)
    assert found.loads.phases[3:] == cycle.phases[3:]
    assert found.terrain.origin == (0.0, -1.0)
    assert read_case(path, ["phases[*].side_shift=0.1"]).case.loads.phases[0].side_shift == 0.1


def test_items_of_a_list_of_the_file_are_changed(read, tmp_path):
    (tmp_path / "cycle.toml").write_text('[[phases]]\nname = "a"\nend = 0\nloads = 4e5\n')
    text = 'base = "translation"\n[outputs]\nshoes = [1, 2]\n[loads]\nfile = "cycle.toml"\n'
    found = read(text, ["outputs.shoes[1]=7", "loads.phases[0].loads[0]=1e5"])
    assert found.outputs.shoes == (1, 7)
    assert found.case.loads.phases[0].loads == (1e5, *[4e5] * 12)


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("terrain.spring_stifness", "terrain.spring_stiffness"),
        ("spring_stifness", "terrain.spring_stiffness"),
        ("terrain.spring.stiffness", "terrain.spring_stiffness"),
        ("terain.spring_stiffness", "terrain.spring_stiffness"),
        ("terrain.origin.x", "terrain.origin"),
        ("case.terrain.origin[1]", "terrain.origin"),
        ("loads.phases[0].ende", "loads.phases.end"),
        ("loads.phase[0].end", "loads.phases.end"),
        ("load.phases[0].end", "loads.phases.end"),
        ("loads.phases[0].loads[1].x", "loads.phases.loads"),
    ],
)
def test_an_unknown_key_is_answered_with_the_one_that_was_meant(path, key, meant):
    told = re.escape(f"{path}: {key}: unknown key; did you mean {meant}?")
    with pytest.raises(CaseFileError, match=f"^{told}"):
        read_case(path, [f"{key}=1"])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("spring_stiffness=soft", "terrain.spring_stiffness: must be a number in N/m, or such as '1 MN/m'"),
        ("terrain.spring_stiffness=-1", "terrain.spring_stiffness: must be greater than"),
        ("density=7000", "density: which one is meant? terrain.density, flexible.density"),
        ("base.x=1", "base.x: unknown key"),
        ("terrain.spring_stiffness", "a change must be like terrain.spring_stiffness=1e7 or loads"),
        ("loads.phases[0].loads[13]=1", "loads.phases[0].loads[13]: loads.phases[0].loads has 13 items"),
        ("loads.phases[-1].end=1", "a change must be like terrain.spring_stiffness=1e7 or loads.phases[0]"),
        ("loads.phases[1].end=1", "loads.phases[1].end: loads.phases has 1 items, counted from 0, no [1]"),
        ("terrain.columns[1]=1", "terrain.columns[1]: there is no list terrain.columns to change an item of"),
        ("terrain[1]=1", "terrain[1]: there is no list terrain to change an item of"),
        ("loads.phases[0][1]=1", "loads.phases[0][1]: there is no list loads.phases[0] to change an item of"),
        ("terrain.origin[1]=far", "terrain.origin[1]: must be a number in m, or such as '1 mm', got 'far'"),
        ("name=a\nb = 1", "name: must be printable"),
    ],
)
def test_changes_are_checked_like_the_file(path, change, told):
    with pytest.raises(CaseFileError, match="^" + re.escape(f"{path}: {told}")):
        read_case(path, [change])
