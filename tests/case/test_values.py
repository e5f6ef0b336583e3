"""Values of a case: changed from outside, in units of engineers, and told beside those of another case."""

import tomllib

import pytest

import studies.cases
from exudyn_crawler import Case, CaseFile, LoadCycle, read_case, write_case
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.machines.case_file import differences, nearest_base, run_lines
from exudyn_crawler.settings.fields import value_text
from exudyn_crawler.settings.units import number_of
from tests.test_release import PROJECT

SOFT = 'base = "translation"\n[terrain]\nspring_stiffness = 10e6\n'


def test_values_are_changed_by_path_or_by_a_name_that_only_one_has(read):
    changes = ("terrain.spring_stiffness=3e7", "springs_per_unit = 1", "duration=2", "name=own ground")
    found = read(SOFT, (*changes, "drive.speed={times=[0, 1], values=[0, 0.2]}", "figure_format=svg"))
    assert found.case.terrain.spring_stiffness == 3e7
    assert found.case.terrain.springs_per_unit == 1
    assert (found.duration, found.case.name) == (2.0, "own ground")
    assert found.case.drive.speed.values == (0.0, 0.2)
    assert found.outputs.figure_format == "svg"
    assert read(SOFT).case.terrain.spring_stiffness == 10e6


def test_items_of_lists_are_changed_by_the_names_that_faults_have(read):
    """Also of lists that a base gives, and after the values that are no items."""
    changes = ("loads.phases[1].side_shift=0.3", "phases[0].loads[12] = 5e5", "loads.base=shovel_cycle")
    found = read(SOFT, (*changes, "terrain.origin[1]=-1", "loads.phases[2].loads=4e5")).case
    cycle = LoadCycle.shovel_cycle()
    assert found.loads.phases[1] == cycle.phases[1].with_(side_shift=0.3)
    assert found.loads.phases[0] == cycle.phases[0].with_(loads=(*cycle.phases[0].loads[:12], 5e5))
    assert found.loads.phases[2] == cycle.phases[2].with_(loads=(4e5,) * 13)
    assert found.loads.phases[3:] == cycle.phases[3:]
    assert found.terrain.origin == (0.0, -1.0)
    assert read(SOFT, ["phases[*].side_shift=0.1"]).case.loads.phases[0].side_shift == 0.1


def test_items_of_a_list_of_the_file_are_changed(read, tmp_path):
    (tmp_path / "cycle.toml").write_text('[[phases]]\nname = "a"\nend = 0\nloads = 4e5\n')
    text = 'base = "translation"\n[outputs]\nshoes = [1, 2]\n[loads]\nfile = "cycle.toml"\n'
    found = read(text, ["outputs.shoes[1]=7", "loads.phases[0].loads[0]=1e5"])
    assert found.outputs.shoes == (1, 7)
    assert found.case.loads.phases[0].loads == (1e5, *[4e5] * 12)


UNKNOWN = [
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
]
"""Keys that there are not, and those that were meant."""


@pytest.mark.parametrize(
    ("change", "told"),
    [
        *((f"{key}=1", f"{key}: unknown key; did you mean {meant}?") for key, meant in UNKNOWN),
        ("spring_stiffness=soft", "terrain.spring_stiffness: must be a number in N/m, or such as '1 MN/m'"),
        ("terrain.spring_stiffness=-1", "terrain.spring_stiffness: must be greater than"),
        ("density=7000", "density: ambiguous key; give one of terrain.density, flexible.density"),
        ("base.x=1", "base.x: unknown key"),
        ("terrain.spring_stiffness", "a change must be like terrain.spring_stiffness=1e7 or loads"),
        ("loads.phases[0].loads[13]=1", "loads.phases[0].loads[13]: loads.phases[0].loads has 13 items"),
        ("loads.phases[-1].end=1", "a change must be like terrain.spring_stiffness=1e7 or loads.phases[0]"),
        (
            "loads.phases[1].end=1",
            "loads.phases[1].end: loads.phases has 1 items, counted from 0: there is no [1]",
        ),
        (
            "terrain.columns[1]=1",
            "terrain.columns[1]: terrain.columns must be a list to change an item of it",
        ),
        ("terrain[1]=1", "terrain[1]: terrain must be a list to change an item of it"),
        (
            "loads.phases[0][1]=1",
            "loads.phases[0][1]: loads.phases[0] must be a list to change an item of it",
        ),
        ("terrain.origin[1]=far", "terrain.origin[1]: must be a number in m, or such as '1 mm', got 'far'"),
        ("name=a\nb = 1", "name: must be printable"),
    ],
)
def test_changes_are_checked_like_the_file(refused, change, told):
    assert refused(SOFT, [change])[0].startswith(told)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        *[("20 MN/m", "N/m", 20e6), ("20kN/mm", "N/m", 20e6), ("800 MPa", "Pa", 800e6)],
        *[("9 km/h", "m/s", 2.5), ("4.7 mm", "m", 0.0047), ("3 in", "m", 0.0762), ("4.7 t", "kg", 4700.0)],
        *[("1.6 t/m3", "kg/m3", 1600.0), ("120 kN s/m", "N s/m", 120e3), ("9810 mm/s^2", "m/s2", 9.81)],
        *[("5 min", "s", 300.0), ("3 %", "", 0.03)],
        *[("37 200 kg", "kg", 37200.0), ("1'200.5 mm", "m", 1.2005), ("1\u202f410 t", "kg", 1.41e6)],
        *[("180 deg/s", "rad/s", 3.141592653589793), ("5 deg", "deg", 5.0), ("2 1/d", "1/h", 2 / 24)],
        *[("30 kN m", "N m", 30e3), ("-1.5e2 mm", "m", -0.15), ("100 N/mm2", "N/m^2.0", 100e6)],
        # what is no number of the unit stays as it is, to be refused
        *[
            (text, "m", text)
            for text in ("20", "20 N", "20 foo", "37 20 m", "m", "2 m^9^9^9^9", "1,5 m", "f('os')")
        ],
        *[("0.1 Hz", "rad/s", "0.1 Hz"), ("5 deg", "", "5 deg"), (True, "m", True), ("51/h", "1/h", "51/h")],
    ],
)
def test_a_text_with_a_unit_is_the_number_in_the_fields_own(text, unit, value):
    assert number_of(text, unit) == value


def test_every_kind_of_number_in_a_file_may_have_a_unit(read):
    text = (
        'base = "translation"\nduration = "500 ms"\nloads = "450 kN"\n'
        '[terrain]\nspring_stiffness = "18 MN/m"\norigin = ["5044 mm", "3.2901 m"]\n'
        '[contact]\nstiffness = "80 N/mm2"\n'
        '[drive]\nspeed = {times = [0, "5 s"], values = [0, "0.36 km/h"]}\n'
    )
    found = read(text, ["drive.speed.times[1]=6000 ms", "terrain.grade=1 %", "terrain.origin[1]=329.01 cm"])
    case = found.case
    assert (found.duration, case.terrain.spring_stiffness, case.terrain.grade) == (0.5, 18e6, 0.01)
    assert case.loads.phases[0].loads == (450e3,) * 13
    assert (case.contact.stiffness, case.terrain.origin) == (80e6, (5.044, 3.2901))
    assert (case.drive.speed.times, case.drive.speed.values) == ((0.0, 6.0), (0.0, 0.1))
    with pytest.raises(CaseFileError, match=r"a number in N/m, or such as '1 MN/m', got '18 MPa'$"):
        read(text, ["terrain.spring_stiffness=18 MPa"])


@pytest.mark.parametrize("case", [Case.turning(), Case.stress(), Case.rolled()])
def test_a_file_to_be_changed_by_hand_has_units_and_no_rounding(tmp_path, case):
    path = write_case(CaseFile(case=case), tmp_path / "case.toml", by_hand=True)
    assert tomllib.loads(path.read_text())["terrain"]["spring_stiffness"] == "20 MN/m"
    assert not any(word in path.read_text() for word in ("00000000", "99999999"))
    found = read_case(path).case
    assert nearest_base(found)[1] == {}
    assert found.loads.phases[0].loads == pytest.approx(case.loads.phases[0].loads, rel=1e-9)


@pytest.mark.parametrize("name", PROJECT["entry-points"]["exudyn_crawler.cases"])
def test_every_case_to_start_from_is_read_as_it_was_written(tmp_path, name):
    path = write_case(getattr(studies.cases, name)(), tmp_path / "case.toml", by_hand=True)
    assert path.read_text() == write_case(read_case(path), tmp_path / "again.toml", by_hand=True).read_text()


def test_numbers_are_read_in_the_units_of_engineers():
    numbers = (386.4e3, "N"), (200e9, "Pa"), (8e8, "Pa"), (20e6, "N/m")
    assert [value_text(*one) for one in numbers] == ["386.4 kN", "200 GPa", "800 MPa", "20 MN/m"]
    assert [value_text(pressure, "Pa") for pressure in (51e3, 900.0, 1.2e6)] == [
        "51 kPa",
        "900 Pa",
        "1.2 MPa",
    ]
    assert value_text((0.1, 2e5, 0.0), "N") == "0.0001, 200, 0 kN"
    assert [value_text(one, "m") for one in (0.0081, None, ())] == ["0.0081 m", "none", "none"]


@pytest.mark.parametrize("name", ["translation", "turning", "stress"])
def test_a_papers_case_is_its_own_base(name):
    assert nearest_base(getattr(Case, name)().with_(name="own name")) == (name, {})


def test_changed_values_stand_beside_those_of_the_base_and_what_it_has_not_is_marked():
    case = Case.turning().with_({"terrain.spring_stiffness": 1e7, "gravity": 1.62})
    assert nearest_base(case) == ("turning", {"gravity": "9.81 m/s2", "terrain.spring_stiffness": "20 MN/m"})
    base, of_base = nearest_base(Case.stress("coarse").with_(flexible=None))
    assert (base, of_base["flexible"]) == ("stress", "-")


def test_two_cases_differ_in_what_was_changed():
    case = Case.translation()
    other = case.with_({"gravity": 1.62, "terrain.spring_damping": 0.0})
    rows = {row.key: row for row in differences(case, other)}
    assert rows["gravity"] == ("gravity", "9.81 m/s2", "1.62 m/s2")
    assert set(rows) == {"gravity", "terrain.spring_damping"}
    assert differences(case, case) == []
    lost = differences(Case.stress("coarse"), Case.stress("coarse").with_(flexible=None))
    assert next(row for row in lost if row.key == "flexible.mesh").second == "-"
    (name,) = differences(case, case.with_(name="other"))
    assert str(name) == "name is translation, not other"
    # what differs in its last digits alone is shown in full
    (one,) = differences(case, case.with_(gravity=9.81 + 1e-12))
    assert str(one) == "gravity is 9.81 m/s2, not 9.810000000001 m/s2"


def test_before_a_run_it_is_said_what_it_comes_to():
    track, run = run_lines(CaseFile(case=Case.translation(), duration=10.0))
    # 13 shoes with 386.4 kN each and their own weight, on 13 undersides of 0.655742 m x 3.505 m
    carried = 13 * (386.4 + 4.68167 * 9.81)
    light = CaseFile(case=Case.translation().with_({"shoe.mass": 50.29}), duration=1.0)
    assert run_lines(light)[0].startswith("track: 13 shoes of 50.29 kg; ")
    assert f"13 shoes of 4.682 t; the ground carries {carried / 1e3:.4g} MN at the start, " in track
    assert f"{carried / (13 * 0.655742 * 3.505):.4g} kPa below the shoes, which sink by about 65." in track
    assert run.startswith("run: 10 s, 0.75 m of travel by the drive, 5000 steps of 2 ms, ")
    _, run, *_ = run_lines(CaseFile(case=Case.stress(), duration=40.0))
    assert "10400 steps of 2 ms, or 10 ms while the drive is off, 10400 stored times" in run
