"""Fields of parameters: paths and their grammar, changes at them, and the walk over a case."""

import pytest

from exudyn_crawler import Case, CaseFile, LoadCycle, PairContact, SphereContact, Terrain
from exudyn_crawler.case import CellContact
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.fields import entry_at, parse_path, walk, with_value

CONTENT = {"loads": {"phases": [{"end": 0.0}, {"end": 5.0}]}, "name": "a"}


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("duration", ("duration",)),
        ("loads.phases[2].end", ("loads", "phases", 2, "end")),
        ("loads.phases[*].loads[0]", ("loads", "phases", "*", "loads", 0)),
    ],
)
def test_a_path_is_names_and_numbers(text, path):
    assert parse_path(text) == path
    assert fields.path_text(path) == text


@pytest.mark.parametrize("text", ["", "a..b", "a b", "loads.phases[-1]", "[2]", "a.[1]", "a\n"])
def test_what_is_no_path_is_refused(text):
    with pytest.raises(ValueError, match=r"a path must be like terrain\.spring_stiffness"):
        parse_path(text)


def test_changes_are_copies_and_reach_all_items():
    changed = fields.with_change(CONTENT, parse_path("loads.phases[*].end"), lambda end: end + 1.0)
    assert [phase["end"] for phase in changed["loads"]["phases"]] == [1.0, 6.0]
    assert CONTENT["loads"]["phases"][0]["end"] == 0.0
    assert with_value(CONTENT, ("terrain", "grade"), 0.1)["terrain"] == {"grade": 0.1}


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("loads.phases[2].end", r"loads\.phases has 2 items, counted from 0: there is no \[2\]"),
        ("loads[0]", "loads must be a list to change an item of it"),
        ("drive.on[0]", r"drive\.on must be a list to change an item of it"),
        ("name.x", "name must be a table to change a value of it, got 'a'"),
    ],
)
def test_paths_that_lead_nowhere_are_refused(path, told):
    with pytest.raises(ValueError, match=f"^{told}$"):
        with_value(CONTENT, parse_path(path), 1.0)


def test_parameters_are_changed_by_paths_and_validated_again():
    case = Case.stress("coarse")
    changed = case.with_(
        {"terrain.origin[1]": -1.0, "loads.phases[*].side_shift": 0.1, "terrain.grade": 0.02}, name="b"
    )
    assert changed.name == "b"
    assert changed.terrain == case.terrain.with_(origin=(case.terrain.origin[0], -1.0), grade=0.02)
    phases = LoadCycle.shovel_cycle().phases
    assert changed.loads.phases == tuple(phase.with_(side_shift=0.1) for phase in phases)
    assert changed.with_({"loads.phases": phases, "name": "stress", "terrain": case.terrain}) == case


def test_a_case_file_is_changed_by_the_paths_that_it_writes():
    case_file = CaseFile(case=Case.translation())
    changed = case_file.with_({"gravity": 1.62, "outputs.shoes": (1, 2), "duration": 1.0})
    assert (changed.case.gravity, changed.outputs.shoes, changed.duration) == (1.62, (1, 2), 1.0)
    assert with_value(case_file.model_dump(mode="json"), ("case",), 1.0, CaseFile)["case"]["case"] == 1.0


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("terrain.spring_stifness", r"terrain\.spring_stifness: unknown key; did you mean terrain\.spring_s"),
        ("terrain.spring_stiffness", r"terrain\.spring_stiffness: must be greater than"),
        ("loads.phases[1].end", r"loads\.phases\[1\]\.end: loads\.phases has 1 items"),
        ("loads phases", r"loads phases: a path must be like"),
    ],
)
def test_wrong_changes_of_parameters_name_the_path(path, told):
    with pytest.raises(ParameterError, match=f"^{told}"):
        Case.translation().with_({path: -1.0})


def test_a_field_is_that_of_its_path_and_of_those_in_it():
    case = CaseFile(case=Case.translation())
    units = {"terrain.spring_stiffness": "N/m", "loads.phases[*].loads": "N", "duration": "s"}
    units |= {"shoe.load_point[2]": "m"}
    assert {path: entry_at(case, parse_path(path)).unit for path in units} == units
    assert entry_at(case, parse_path("terrain.stiffness")) is None
    assert entry_at(case, parse_path("terrain.spring_stiffness.more")) is None


WHOLE = CaseFile(case=Case.stress("coarse"))


def test_each_table_comes_before_its_values_and_those_before_its_tables():
    paths = [entry.path for entry in walk(WHOLE)]
    assert len(set(paths)) == len(paths)
    assert paths[:4] == ["name", "terrain_formulation", "formulation", "gravity"]
    assert paths[4:6] == ["machine", "duration"]
    drive = paths.index("drive")
    assert paths[drive : drive + 4] == ["drive", "drive.speed", "drive.turn_rate", "drive.on"]
    loads = paths.index("loads")
    phase = [f"loads.phases[0]{end}" for end in ("", ".name", ".end", ".loads")]
    assert paths[loads + 1 : loads + 5] == phase
    tables = [entry.path for entry in walk(WHOLE) if fields.is_table(entry.value) and len(entry.place) == 1]
    parts = ["shoe", "track", "gear", "terrain", "contact", "drive", "loads", "flexible", "solver", "outputs"]
    assert tables == parts


def test_every_value_is_met_with_its_field_in_a_part_by_itself_too():
    found = {entry.path: entry for entry in walk(WHOLE)}
    assert found["loads.phases[1].loads"].value == WHOLE.case.loads.phases[1].loads
    assert found["terrain.spring_stiffness"].unit == "N/m"
    assert found["track.shoe_count"].unit == ""
    assert found["contact"].meaning == "contact of shoes and terrain: model pair, spheres or cells"
    assert found["drive.speed"].value == WHOLE.case.drive.speed
    assert all(entry.meaning for entry in found.values())
    part = [entry.path for entry in walk(Terrain.stress(), ("ground",))]
    assert part[:2] == ["ground.grade", "ground.side_slope"]


def test_key_paths_are_those_of_every_class_that_a_field_may_hold():
    paths = list(fields.key_paths(Case))
    assert len(set(paths)) == len(paths)
    assert {"contact.model", "contact.sharing", "contact.radius", "drive.on", "loads.phases.end"} <= {*paths}
    contact = Case.model_fields["contact"].annotation
    assert fields.models_of(contact) == (PairContact, SphereContact, CellContact)
