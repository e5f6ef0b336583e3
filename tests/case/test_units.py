"""Units in words in files and changes, and units for reading."""

import tomllib

import pytest

import studies.cases
from exudyn_crawler import Case, read_case, write_case
from exudyn_crawler.case.case_file import CaseFile, nearest_base
from exudyn_crawler.case.parameters.fields import value_text
from exudyn_crawler.case.parameters.reading import number_of
from exudyn_crawler.errors import CaseFileError
from tests.test_release import PROJECT


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        *[("20 MN/m", "N/m", 20e6), ("20kN/mm", "N/m", 20e6), ("800 MPa", "Pa", 800e6)],
        *[("9 km/h", "m/s", 2.5), ("4.7 mm", "m", 0.0047), ("3 in", "m", 0.0762), ("4.7 t", "kg", 4700.0)],
        *[("1.6 t/m3", "kg/m3", 1600.0), ("120 kN s/m", "N s/m", 120e3), ("9810 mm/s^2", "m/s2", 9.81)],
        *[("5 min", "s", 300.0), ("3 %", "", 0.03)],
        *[("180 deg/s", "rad/s", 3.141592653589793), ("5 deg", "deg", 5.0), ("2 1/d", "1/h", 2 / 24)],
        *[("30 kN m", "N m", 30e3), ("-1.5e2 mm", "m", -0.15), ("100 N/mm2", "N/m^2.0", 100e6)],
        # what is no number of the unit stays as it is, to be refused
        *[(text, "m", text) for text in ("20", "20 N", "20 foo", "m", "2 m^9^9^9^9", "1,5 m", "f('os')")],
        *[("0.1 Hz", "rad/s", "0.1 Hz"), ("5 deg", "", "5 deg"), (True, "m", True), ("51/h", "1/h", "51/h")],
    ],
)
def test_a_text_with_a_unit_is_the_number_in_the_fields_own(text, unit, value):
    assert number_of(text, unit) == value


def test_every_kind_of_number_in_a_file_may_have_a_unit(read):
    text = (
        'base = "translation"\nduration = "500 ms"\nloads = "450 kN"\n'
        '[terrain]\nspring_stiffness = "18 MN/m"\norigin = ["5044 mm", 3.2901]\n'
        '[contact]\nstiffness = "80 N/mm2"\n'
        '[drive]\nspeed = {times = [0, "5 s"], values = [0, "0.36 km/h"]}\n'
    )
    changes = ["drive.speed.times[1]=6000 ms", "terrain.grade=1 %", "terrain.origin[1]=329.01 cm"]
    found = read(text, changes)
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
    content = tomllib.loads(path.read_text())
    assert content["terrain"]["spring_stiffness"] == "20 MN/m"
    assert not any(word in path.read_text() for word in ("00000000", "99999999"))
    found = read_case(path).case
    assert nearest_base(found)[1] == {}
    assert found.loads.phases[0].loads == pytest.approx(case.loads.phases[0].loads, rel=1e-9)


@pytest.mark.parametrize("name", PROJECT["entry-points"]["exudyn_crawler.cases"])
def test_every_case_to_start_from_is_read_as_it_was_written(tmp_path, name):
    path = write_case(getattr(studies.cases, name)(), tmp_path / "case.toml", by_hand=True)
    again = write_case(read_case(path), tmp_path / "again.toml", by_hand=True)
    assert path.read_text() == again.read_text()


def test_numbers_are_read_in_the_units_of_engineers():
    numbers = (386.4e3, "N"), (200e9, "Pa"), (8e8, "Pa"), (20e6, "N/m")
    said = [value_text(*one) for one in numbers]
    assert said == ["386.4 kN", "200 GPa", "800 MPa", "20 MN/m"]
    assert value_text((0.1, 2e5, 0.0), "N") == "0.0001, 200, 0 kN"
    assert [value_text(one, "m") for one in (0.0081, None, ())] == ["0.0081 m", "none", "none"]
