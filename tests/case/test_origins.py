"""Ledger of a datasheet's machine: what is the user's, what is the library's, what a value is made of."""

import math
from collections import Counter

import pytest

from exudyn_crawler.errors import CaseFileError, ParameterError
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet import figures, library, typical
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.discrepancies import datasheet_discrepancies, implausible_values
from exudyn_crawler.machines.datasheet.ledger import case_ledger, ledger_of, sheet_ledger, stated_ledger
from exudyn_crawler.machines.datasheet.ruled_machine import rules
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.origins import Origin
from exudyn_crawler.settings import fields
from tests.case.random_datasheets import drawn

HEAVIER = """
name = "r9800"
[datasheet]
source = "warrencat.com: 605.2 short tons, 24.5 N/cm2"
kind = "excavator"
operating_weight = "800 t"
gauge = "5.2 m"
shoe_width = "1600 mm"
shoes = 44
ground_pressure = "245 kPa"
remembered = ["gauge", "shoe_width"]
"""


def test_what_a_user_changed_of_a_library_machine_is_given_by_the_file_and_by_no_source(read):
    """Of a Caterpillar 6060 of 549 t with shoes of 1.4 m, 800 t with shoes of 1.6 m were made."""
    case_file = read(HEAVIER)
    rows = ledger_of(case_file)
    for name in ("operating_weight", "shoe_width", "shoes"):
        assert (rows[f"datasheet.{name}"].origin, rows[f"datasheet.{name}"].how) == (Origin.GIVEN, "the file")
    pressure = rows["datasheet.ground_pressure"]
    assert pressure.origin is Origin.LIBRARY
    assert pressure.how.startswith("Caterpillar 6060: warrencat.com")
    # the library's file had it from memory
    gauge = rows["datasheet.gauge"]
    assert gauge.origin is Origin.ASSUMED
    assert "of the library's Caterpillar 6060" in gauge.how
    assert rows["shoe.width"].origin is Origin.GIVEN
    assert rows["gear.car_body.gauge"].how == gauge.how


def test_what_is_left_of_another_machine_is_warned_of(read):
    case_file = read(HEAVIER)
    (line,) = datasheet_discrepancies(case_file.datasheet)
    assert line == (
        "datasheet: this is another machine than the library's Caterpillar 6060 (operating_weight 800 t in "
        "place of 549 t), of which are left: gauge, ground_pressure; give this machine's own, or leave them "
        "out"
    )
    assert line in list(implausible_values(case_file))
    near = case_file.datasheet.with_(operating_weight=600e3)
    assert list(datasheet_discrepancies(near)) == []
    wider = case_file.datasheet.with_(operating_weight=549e3, shoe_width=1.7)
    assert "shoe_width 1.7 m in place of 1.4 m" in next(iter(datasheet_discrepancies(wider)))
    own = case_file.datasheet.with_(gauge=5.9, ground_pressure=2.2e5)
    assert list(datasheet_discrepancies(own)) == []


def test_a_machine_that_cannot_be_built_says_what_is_left_of_the_library(read):
    """Of a dozer of 39.5 t a weight of 20.5 t was made, whose shoes alone would weigh more."""
    d155 = library.machines()["d155ax"].read_text()
    (weight,) = [line for line in d155.splitlines() if line.startswith("operating_weight")]
    with pytest.raises(CaseFileError, match=r"library's Komatsu D155AX-6 \(operating_weight 20.5 t in place"):
        read(d155.replace(weight, 'operating_weight = "20.5 t"'))


def test_a_file_begun_as_a_library_machine_remembers_it_whatever_its_source_says(read):
    text = library.text_of("cat6060", "r9800")
    assert text.startswith("# r9800, begun as the library's Caterpillar 6060")
    case_file = read(text)
    assert case_file.case.name == "r9800"
    assert Counter(row.origin for row in sheet_ledger(case_file.datasheet))[Origin.GIVEN] == 0
    own = case_file.datasheet.with_(source="Liebherr R 9800, sheet", operating_weight=800e3)
    rows = sheet_ledger(own)
    assert rows["datasheet.operating_weight"].how == "Liebherr R 9800, sheet"
    assert rows["datasheet.ground_pressure"].origin is Origin.LIBRARY
    with pytest.raises(CaseFileError, match="no 'cat606'; did you mean 'cat6060'"):
        read(text.replace('began_as = "cat6060"', 'began_as = "cat606"'))


@pytest.mark.parametrize("name", library.machines())
def test_files_begun_as_library_machines_are_the_same_machines(name, read):
    begun, before = read(library.text_of(name, "r9800")), read_case(library.machines()[name])
    assert begun.case == before.case.with_(name="r9800")
    assert begun.datasheet.with_(began_as=None) == before.datasheet
    assert library.beginning(before.datasheet).title == before.case.name


def test_another_machine_over_one_of_the_library_has_not_the_name_of_that(read):
    text = '[datasheet]\nbase = "cat6060"\n'
    assert read(text).case.name == "Caterpillar 6060"
    assert read(f'{text}travel = "backward"\n').case.name == "Caterpillar 6060"
    changed = read(f'{text}operating_weight = "800 t"\n')
    assert changed.case.name == "excavator"
    assert sheet_ledger(changed.datasheet)["datasheet.gauge"].how.startswith("of the library's Caterpillar")


def test_values_of_a_library_machine_beside_its_datasheet_are_its_own(read):
    text = library.text_of("m113", "mine")
    rows = case_ledger(read(text))
    assert rows["shoe.inertia"].origin is Origin.LIBRARY
    assert rows["gear.tumbler.backlash"].origin is Origin.LIBRARY
    rows = case_ledger(read(text.replace("backlash = 0.01176", "backlash = 0.011")))
    assert rows["gear.tumbler.backlash"].origin is Origin.GIVEN
    assert rows["gear.tumbler.lugs"].origin is Origin.LIBRARY


def test_gauge_follows_from_the_width_over_the_shoes():
    rows = sheet_ledger(
        Datasheet(operating_weight=35e3, width_over_shoes=3.39, shoe_width=0.8, length_on_ground=4.0)
    )
    assert rows["datasheet.gauge"].value == pytest.approx(2.59)
    assert rows["datasheet.gauge"].origin is Origin.DERIVED


def test_of_a_case_over_a_named_one_only_what_the_file_states_is_given(read):
    case = read('base = "shovel"\n[gear]\nroller_radius = "0.41 m"\n').case
    rows = stated_ledger(case, ["base", "gear.roller_radius"])
    assert [row.path for row in rows if row.origin is Origin.GIVEN] == ["gear.roller_radius"]
    assert rows["shoe.mass"].origin is Origin.LIBRARY


def machine_sheets():
    """Datasheets of the library, and some that were drawn at random and can be built."""
    for path in library.machines().values():
        yield read_case(path).datasheet
    for seed in range(12):
        try:
            sheet = Datasheet(**drawn(seed))
            derived(sheet)
        except ParameterError:
            continue
        yield sheet


SHEETS = list(machine_sheets())


def case_values(sheet):
    """Values of the case that follows; None where none does."""
    try:
        return derived(sheet).case.model_dump()
    except ParameterError:
        return None


@pytest.mark.parametrize("sheet", SHEETS, ids=range(len(SHEETS)))
def test_typical_values_that_change_the_machine_are_those_of_the_ledger(sheet, monkeypatch):
    """By another path than the table of rules: what a derivation asks for, and what of that has no effect."""
    taken = {row.name for row in derived(sheet).ruled.typical}
    before = case_values(sheet)
    asked = set()
    look_up = Datasheet.typical_value

    def recorded(sheet, name):
        asked.add(name)
        return look_up(sheet, name)

    monkeypatch.setattr(Datasheet, "typical_value", recorded)
    derived.__wrapped__(sheet)
    own = {name for name, value in sheet.typical if value is not None}
    assert taken <= asked - own
    for name in sorted(asked - own - taken):
        row = typical.row_of(name, sheet.kind)
        for bound in (row.low, row.high):
            after = case_values(sheet.with_({f"typical.{name}": bound}))
            assert after in (None, before), f"{name} changes the machine"


@pytest.mark.parametrize("sheet", SHEETS, ids=range(len(SHEETS)))
def test_no_figure_agrees_with_what_it_made(sheet):
    """By another path than the table of rules: a printed figure is moved, and the machine derived again."""
    keys = {
        "weight of all parts": "operating_weight",
        "weight of a shoe": "shoe_weight",
        "length on ground": "length_on_ground",
        "length over shoes": "crawler_length",
        "contact area": "contact_area",
        "mean ground pressure": "ground_pressure",
    }
    built = {figure.name: figure for figure in figures.figures(derived(sheet).case, sheet)}
    for name, key in keys.items():
        figure = built.get(name)
        if figure is None or figure.printed is None:
            continue
        # numbers of shoes and teeth take a small change without moving
        by = 1.002 if figure.verdict == "agrees" else 1.04
        moved = sheet.with_({key: by * figure.printed})
        try:
            after = {one.name: one.value for one in figures.figures(derived(moved).case, moved)}[name]
        except ParameterError:
            continue
        assert math.isclose(after, figure.value, rel_tol=2e-4) == (figure.verdict == "agrees"), name


def test_rules_are_of_values_that_there_are():
    known = {f"datasheet.{name}" for name in Datasheet.model_fields}
    plain = set()
    for sheet in SHEETS:
        for item in fields.values_of(derived(sheet).case):
            plain.add(".".join(fields.names_of(item.place)))
    names = known | plain | {"chain.circle"} | set(Datasheet.model_fields) | set(typical.names())
    for rule in rules():
        for path in rule.paths:
            assert path in names or path.endswith("*") or path.startswith("gear.arms"), path
        assert set(rule.made_of) <= names, rule
        # an empty text is that of the one typical value, with its range
        assert rule.text or rule.source or len(rule.made_of) == 1, rule
