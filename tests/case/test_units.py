"""Numbers with units as makers print them, and hints at those that cannot be read."""

import pytest

from exudyn_crawler.case import Case
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines import CaseFile, read_case, write_case
from exudyn_crawler.settings.reading import CaseFileError
from exudyn_crawler.settings.units import hint, number_of

SHEET = """
[datasheet]
kind = "excavator"
operating_weight = "22 t"
gauge = "2380 mm"
length_on_ground = "3655 mm"
shoe_width = "600 mm"
"""


@pytest.fixture
def refused(tmp_path):
    """Lines with which a file of a text is refused, without its name."""

    def lines(text):
        (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
        with pytest.raises(CaseFileError) as refusal:
            read_case(tmp_path / "mine.toml")
        return refusal.value.errors

    return lines


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        *[("8' 6\"", "m", 2.5908), ("8'6\"", "m", 2.5908), ("11 ft 6 in", "m", 3.5052)],
        *[("15'-8\"", "m", 4.7752), ("15'-8 1/2\"", "m", 4.7879), ("8\u2032 6\u2033", "m", 2.5908)],
        *[('36"', "m", 0.9144), ("8'", "m", 2.4384), ("8 ft", "m", 2.4384)],
        *[
            ("0.51 kgf/cm\u00b2", "Pa", 50013.915),
            ("6.31 m\u00b2", "m2", 6.31),
            ("40 kN\u00b7m", "N m", 40e3),
        ],
        *[("40 kNm", "N m", 40e3), ("2 m s\u207b\u00b2", "m/s2", 2.0), ("5.4 km/hr", "m/s", 1.5)],
        *[("200 short tons", "kg", 181436.948), ("200 long tons", "kg", 203209.38176)],
        # thousands of inches, a foot of 14 inches and a length without its last mark are not meant
        *[(text, "m", text) for text in ("8'000\"", "8' 14\"", "8' 6")],
    ],
)
def test_what_makers_print_is_the_number_in_a_fields_own_unit(text, unit, value):
    assert number_of(text, unit) == (pytest.approx(value, rel=1e-12) if isinstance(value, float) else value)


@pytest.mark.parametrize(
    ("text", "unit", "told"),
    [
        ("200 ton", "kg", "; a ton is 't' (1000 kg), 'short_ton' (907.2 kg) or 'long_ton' (1016 kg)"),
        ("0.51 kg/cm\u00b2", "Pa", "; did you mean '0.51 kgf/cm2'?"),
        ("310 HP", "W", "; did you mean '310 hp'?"),
        ("20570 KG", "N", "; did you mean '20570 kgf'?"),
        ("4.1", "m/s", "; without quotes it is 4.1 m/s, within them it needs a unit"),
        ("73,500 kg", "kg", "; numbers have no commas: '73500 kg', or '73.500 kg'"),
        ("1,234,567 kg", "kg", "; numbers have no commas: '1234567 kg'"),
        ("1.234,5 kg", "kg", "; numbers have a point: '1234.5 kg'"),
        ("wide", "m", ""),
    ],
)
def test_a_text_that_is_no_number_hints_at_what_could_be_meant(text, unit, told):
    assert hint(text, unit) == told


def test_a_number_beside_one_with_a_unit_is_refused_in_every_list(refused):
    assert number_of([0, "20 mm", "1 m"], "m") == [0, 0.02, 1.0]
    with pytest.raises(
        ParameterError, match=r"^5 must have a unit as '20 MN/m' has, such as '5 MN/m' or '5 N/m'$"
    ):
        number_of([5, "20 MN/m"], "N/m")
    profile = '[drive]\nspeed = {times = [0, 5, "10 s"], values = [0, 0.1, 0.1]}\n'
    assert refused(f'base = "translation"\n{profile}') == [
        "drive.speed.times: 5 must have a unit as '10 s' has, such as '5 s'"
    ]


def test_a_file_to_be_changed_by_hand_has_a_unit_for_each_load_or_for_none(tmp_path):
    loads = (0.0, 386.4e3, 500.0, 20.0, *(400e3,) * 9)
    case = Case.translation().with_({"loads.phases[0].loads": loads})
    path = write_case(CaseFile(case=case), tmp_path / "case.toml", by_hand=True)
    assert 'loads = [0.0, "386.4 kN", "500 N", "20 N", "400 kN"' in path.read_text()
    assert read_case(path).case.loads == case.loads


def test_all_faults_of_a_datasheet_are_lines_that_quote_what_was_typed(refused):
    lines = refused(
        SHEET.replace('"22 t"', '"73,500 kg"').replace('"600 mm"', '"600 ft"').replace("2380 mm", "2e5 mm")
        + 'shoes = "48 pieces"\ntravel_speed = "4.1"\nground_pressure = "0.51 kg/m"\n'
    )
    assert lines == [
        "datasheet.operating_weight: must be a number in kg, or such as '1 t', got '73,500 kg'; "
        "numbers have no commas: '73500 kg', or '73.500 kg'",
        "datasheet.gauge: must be less than or equal to 100 m, got '2e5 mm'",
        "datasheet.shoe_width: must be less than or equal to 100 m, got '600 ft'",
        "datasheet.shoes: must be a whole number, got '48 pieces'",
        "datasheet.ground_pressure: must be a number in Pa, or such as '1 MPa', got '0.51 kg/m'",
        "datasheet.travel_speed: must be a number in m/s, or such as '1 km/h', got '4.1'; "
        "without quotes it is 4.1 m/s, within them it needs a unit",
    ]


def test_a_key_in_a_wrong_place_is_told_where_it_belongs(refused):
    (line,) = refused('travel_speed = "5 km/h"\n' + SHEET)
    assert line == "travel_speed: unknown key; it belongs into [datasheet]"
    (line,) = refused('travel_speed = "5 km/h"\nshoes = 48\n' + SHEET)
    assert "travel_speed: it belongs into [datasheet]; " in line
    (line,) = refused(SHEET + "duration = 5.0\n")
    assert line == "datasheet.duration: unknown key; it belongs to the top of the file, before all tables"


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            'shoe_mesh = "C:\\Users\\me\\shoe.inp"',
            "; a path stands in single quotes: 'C:\\Users\\me\\shoe.inp'",
        ),
        ("gradeability = 50 %", '; a number with a unit stands in quotes: "50 %"'),
        ("pitch = 190 mm # new", '; a number with a unit stands in quotes: "190 mm"'),
        ('crawler_length = "15\'-8""', '; the sign for inches ends the text: "15 ft 8 in"'),
        ("pitch = 0,19", "; numbers have a point: 0.19"),
    ],
)
def test_lines_that_are_no_toml_hint_at_how_they_are_written(refused, line, told):
    (fault,) = refused(f"{SHEET}{line}\n")
    assert fault.startswith("not TOML: ")
    assert fault.endswith(told)


def test_a_factor_may_be_in_per_cent(tmp_path):
    (tmp_path / "mine.toml").write_text(SHEET + 'gradeability = "50 %"\n')
    assert read_case(tmp_path / "mine.toml").datasheet.gradeability == 0.5
