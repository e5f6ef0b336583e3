"""Values of a case file changed from outside: by path or last name, checked like the file."""

import re

import pytest

from exudyn_crawler import read_case
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


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("terrain.spring_stifness=1", "terrain.spring_stifness: unknown key; did you mean"),
        ("spring_stifness=1", "spring_stifness: unknown key; did you mean terrain.spring_stiffness?"),
        ("spring_stiffness=soft", "terrain.spring_stiffness: Input should be a valid number, got 'soft'"),
        ("terrain.spring_stiffness=-1", "terrain.spring_stiffness: Input should be greater than"),
        ("density=7000", "density: which one is meant? terrain.density, flexible.density"),
        ("terrain.origin.x=1", "terrain.origin: Input should be a valid array"),
        ("base.x=1", "base.x: base must be a table to change a value of it, got 'translation'"),
        ("terrain.spring_stiffness", "a change must be like terrain.spring_stiffness=1e7, got"),
        ("loads.phases[0].end=1", "a change must be like"),
        ("name=a\nb = 1", "name must be printable"),
    ],
)
def test_changes_are_checked_like_the_file(path, change, told):
    with pytest.raises(CaseFileError, match="^" + re.escape(f"{path}: {told}")):
        read_case(path, [change])
