"""Figures of datasheets that no machine of their kind and weight has, printed, following, or refused."""

import csv
import re

import pytest

from exudyn_crawler.case import Case
from exudyn_crawler.machines import CaseFile, read_case
from exudyn_crawler.machines.datasheet import plausible, typical
from exudyn_crawler.machines.datasheet.discrepancies import implausible_values, machine_discrepancies
from exudyn_crawler.machines.datasheet.library import machines
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.reading import CaseFileError

EXCAVATOR = {
    "kind": "excavator",
    "operating_weight": "22 t",
    "gauge": "2380 mm",
    "length_on_ground": "3655 mm",
    "crawler_length": "4450 mm",
    "shoe_width": "600 mm",
    "shoes": 49,
    "lower_rollers": 9,
    "carrier_rollers": 2,
    "drawbar_pull": "178 kN",
    "travel_speed": "5.5 km/h",
}
MINING = {
    "operating_weight": "605.2 short_ton",
    "gauge": "5.2 m",
    "shoe_width": "1400 mm",
    "ground_pressure": "245 kPa",
}
DOZER = {
    "kind": "dozer",
    "operating_weight": "20.5 t",
    "gauge": "2140 mm",
    "length_on_ground": "3275 mm",
    "shoe_width": "560 mm",
    "shoes": 42,
    "grouser_height": "80 mm",
    "lower_rollers": 7,
    "bogies": 3,
}


@pytest.fixture
def lines(tmp_path):
    """Warnings, or lines with which it is refused, of a datasheet of some values."""

    def of(values):
        text = "\n".join(f"{name} = {value!r}" for name, value in values.items())
        (tmp_path / "mine.toml").write_text(f"[datasheet]\n{text}\n")
        try:
            return list(implausible_values(read_case(tmp_path / "mine.toml")))
        except CaseFileError as error:
            return error.errors

    return of


@pytest.mark.parametrize("name", sorted(machines()))
def test_machines_of_the_library_are_plausible(name):
    assert list(implausible_values(read_case(machines()[name]))) == []


def test_a_plausible_excavator_has_no_warnings(lines):
    assert lines(EXCAVATOR) == []


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (
            {"travel_speed": 5.5},
            "travel_speed: 5.5 m/s is outside of 0.25 to 2.2 m/s of an excavator; did you mean 5.5 km/h?",
        ),
        ({"gauge": 2380}, None),
        ({"gauge": 0.6001}, "gauge: 600.1 mm is outside of 1.261 to 3.643 m of an excavator of 22 t"),
        (
            {"drawbar_pull": 178},
            "drawbar_pull: 178 N is outside of 64.75 to 302.1 kN of an excavator of 22 t; "
            "did you mean 178 kN?",
        ),
        (
            {"sag": "0.5 m"},
            "sag: 500 mm is outside of 3.655 to 182.8 mm of an excavator of 22 t; is it from the frame to",
        ),
        (
            {"power": 110},
            "power: 110 W is outside of 33 to 308 kW of an excavator of 22 t; did you mean 110 kW or",
        ),
    ],
)
def test_a_figure_of_another_unit_asks_for_it(lines, changes, told):
    found = lines(EXCAVATOR | changes)
    if told is None:
        assert found == [
            "datasheet.gauge: must be less than or equal to 100 m, got 2380; is it in mm? It has to be in m"
        ]
    else:
        assert found[0].startswith(f"datasheet.{told}")


def test_counts_of_both_tracks_are_asked_about_and_what_follows_is_odd(lines):
    """Pitch of 98 shoes by the loop, 2 C + pi d; that of 22 t is 0.066 m x 22^(1/3)."""
    found = lines(EXCAVATOR | {"shoes": 98, "lower_rollers": 18, "carrier_rollers": 4})
    assert found[0] == (
        "datasheet.shoes: 98 is outside of 30 to 64 of an excavator; "
        "are 98 those of both tracks? One track has 49"
    )
    assert found[1].endswith("are 18 those of both tracks? One track has 9")
    assert found[2].endswith("are 4 those of both tracks? One track has 2")
    assert found[3].startswith("datasheet: pitch that follows: 97.32 mm is outside of 126.1 to 266.2 mm")
    assert found[3].endswith(f"{66.0 * 22.0 ** (1 / 3):.4g} mm as a rule")
    assert [line.split(":")[1] for line in found[3:]] == [
        " pitch that follows",
        " sprocket_gaps that follows",
        " shoe_weight that follows",
    ]


def test_a_speed_that_follows_from_motors_is_held_against_its_kind(lines):
    found = lines(
        {name: value for name, value in EXCAVATOR.items() if name != "travel_speed"}
        | {"motor_speed": 300.0, "gear_ratio": 10.0}
    )
    assert found[0].startswith("datasheet: travel_speed that follows: 9.")


@pytest.mark.parametrize(
    ("values", "told"),
    [
        (
            MINING | {"operating_weight": "800 kg"},
            "operating_weight: 800 kg is outside of 1 to 1000 t of an excavator; did you mean 800 t?",
        ),
        (
            MINING | {"operating_weight": 558},
            "operating_weight: 558 kg is outside of 1 to 1000 t of an excavator; did you mean 558 t?",
        ),
        (
            MINING | {"shoe_width": "140 mm"},
            "shoe_width: 140 mm is outside of 0.8188 to 4.094 m of an excavator of 549 t; "
            "did you mean 1400 mm?",
        ),
        (
            DOZER,
            "pitch that follows: 230.8 mm is outside of 136.8 to 218.9 mm of a dozer of 20.5 t, "
            "180.6 mm as a rule",
        ),
    ],
)
def test_a_machine_that_cannot_be_built_is_refused_by_the_figure_at_fault(lines, values, told):
    found = lines(values)
    assert re.fullmatch(rf"datasheet[.:] ?{re.escape(told)}", found[0])
    assert len(found) == 2


def test_parts_too_heavy_for_the_weight_are_named(lines):
    assert lines(DOZER)[1].startswith(
        "datasheet: a side frame would weigh -313.7 kg: 42 shoes of 57.26 kg, "
        "bogies of 553.4 kg on each track"
    )


def test_values_that_a_case_has_of_its_own_are_held_against_its_machine(tmp_path):
    """Those of the file beside a datasheet, and those of a machine without one, by its weight of 1410 t."""
    case_file = read_case(machines()["pc300lc"])
    changed = case_file.case.with_({"gear.car_body.gauge": 5.0, "gear.torque_limit": 5e5})
    found = list(machine_discrepancies(case_file.with_(case=changed)))
    assert [line.split(":")[0] for line in found] == ["gear.car_body.gauge", "gear.torque_limit"]
    assert "5 m is outside of 1.477 to 4.267 m of an excavator of 35.37 t" in found[0]
    shovel = Case.shovel()
    assert list(machine_discrepancies(CaseFile(case=shovel))) == []
    wide = shovel.with_({"gear.car_body.gauge": 20.0})
    (line,) = machine_discrepancies(CaseFile(case=wide))
    assert line.startswith("gear.car_body.gauge: 20 m is outside of 5.0")
    assert " of a machine of 1410 t" in line


def test_every_figure_of_a_datasheet_has_a_range_or_one_of_all_machines():
    """Numbers without either are of the run, or are held in pairs beside others."""
    free = {"grade", "contact_area", "width_over_shoes", "lift_chart"}
    for name, field in Datasheet.model_fields.items():
        if fields.has_unit(field) and name not in free:
            assert plausible.row_of(name, "excavator") or fields.plausible_range(field), name


def test_rows_of_the_table_are_whole():
    known = {"seen", "remembered", "project", "chosen"}
    paths = set(fields.key_paths(Datasheet))
    names = set(typical.names())
    with plausible.TABLE.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(plausible.table())
    for row in plausible.table().values():
        assert row.name in paths
        assert row.low < row.high
        assert row.by in plausible.SIZES
        assert row.typical in names | {""}
        assert row.known in known
        assert row.source
