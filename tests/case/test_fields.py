"""The walk over a case: order, places, units and meanings, and the classes that a field may hold."""

from exudyn_crawler import Case, CaseFile, PairContact, SphereContact, Terrain
from exudyn_crawler.case.parameters.fields import is_table, key_paths, models_of, walk

WHOLE = CaseFile(case=Case.stress("coarse"))


def test_each_table_comes_before_its_values_and_those_before_its_tables():
    paths = [entry.path for entry in walk(WHOLE)]
    assert len(set(paths)) == len(paths)
    assert paths[:4] == ["name", "terrain_formulation", "formulation", "gravity"]
    assert paths[4:7] == ["undercarriage", "machine", "duration"]
    drive = paths.index("drive")
    assert paths[drive : drive + 4] == ["drive", "drive.speed", "drive.turn_rate", "drive.on"]
    loads = paths.index("loads")
    assert paths[loads + 1 : loads + 5] == [
        f"loads.phases[0]{end}" for end in ("", ".name", ".end", ".loads")
    ]
    tables = [entry.path for entry in walk(WHOLE) if is_table(entry.value) and len(entry.place) == 1]
    parts = ["shoe", "track", "terrain", "contact", "drive", "loads", "flexible", "solver", "outputs"]
    assert tables == parts


def test_every_value_is_met_with_its_field():
    found = {entry.path: entry for entry in walk(WHOLE)}
    assert found["loads.phases[1].loads"].value == WHOLE.case.loads.phases[1].loads
    assert found["terrain.spring_stiffness"].unit == "N/m"
    assert found["track.shoe_count"].unit == ""
    assert found["contact"].meaning == "how shoes and terrain touch: model pair or spheres"
    assert found["drive.speed"].value == WHOLE.case.drive.speed
    assert all(entry.meaning for entry in found.values())


def test_a_part_is_walked_by_itself():
    assert [entry.path for entry in walk(Terrain.stress(), ("ground",))][:2] == [
        "ground.origin",
        "ground.columns",
    ]


def test_key_paths_are_those_of_every_class_that_a_field_may_hold():
    paths = list(key_paths(Case))
    assert len(set(paths)) == len(paths)
    assert {"contact.model", "contact.sharing", "contact.radius", "drive.on", "loads.phases.end"} <= set(
        paths
    )
    assert models_of(Case.model_fields["contact"].annotation) == (PairContact, SphereContact)
    assert models_of(Terrain.model_fields["heights"].annotation) == ()
