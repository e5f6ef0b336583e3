"""Values of its base that a case file keeps in parts of another scale."""

import pytest

from exudyn_crawler.machines.unscaled_values import unscaled_lines

SMALLER = """
base = "translation"
[shoe]
mass = 1000.0
inertia = [900.0, 40.0, 900.0, 0.0, 0.0, 0.0]
com_height = 0.1
"""


@pytest.fixture
def lines_of(tmp_path):
    """Lines of a case file's text."""

    def lines_of(text, changes=()):
        (tmp_path / "case.toml").write_text(text)
        return unscaled_lines(tmp_path / "case.toml", changes)

    return lines_of


def test_a_part_of_another_scale_says_what_stays_of_the_base(lines_of):
    shoe, track = lines_of(SMALLER)
    assert shoe.startswith("shoe: mass 1000 kg in place of 4681.67 kg; from the base 'translation' stay ")
    stay = shoe.partition(" stay ")[2].split(", ")
    assert {"length", "width", "finger_length", "load_point"} <= set(stay)
    assert not {"mass", "inertia", "com_height"} & set(stay)
    assert track == "track: all of it stays that of the base 'translation'"


def test_a_file_near_to_its_base_says_nothing(lines_of):
    assert lines_of(SMALLER.replace("1000.0", "4000.0")) == []
    assert lines_of('base = "translation"\n[terrain]\nspring_stiffness = 2e6\n') == []


def test_a_file_without_a_base_says_nothing(lines_of, tmp_path):
    from exudyn_crawler.case import Case
    from exudyn_crawler.machines import CaseFile, write_case

    written = write_case(
        CaseFile(case=Case.translation().with_({"shoe.mass": 2000.0})), tmp_path / "whole.toml"
    )
    assert unscaled_lines(written) == []


def test_a_change_of_the_command_line_counts(lines_of):
    (shoe, _) = lines_of('base = "translation"\n', ["shoe.mass=2000"])
    assert "mass 2000 kg in place of 4681.67 kg" in shoe
