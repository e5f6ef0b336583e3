"""Case files: written and read back, filled in by bases, faults named by their path, and their schema."""

import re
import tomllib
from itertools import chain

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from jsonschema import Draft202012Validator

from exudyn_crawler import Case, CaseFile, FlexibleShoes, LoadCycle, PairContact, SphereContact, Terrain
from exudyn_crawler.case import CellContact, CellTerrain
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.machines import Outputs, read_case, saved_case, write_case
from exudyn_crawler.machines.case_file import case_text
from exudyn_crawler.machines.case_files import case_schema
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.fields import case_rows, key_paths, models_of, named_values, number_text, tag_of
from meshes import shoe_path
from tests.case.strategies import BASES, case_files, changed

SAME_FOLDER = settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.mark.simulation
@SAME_FOLDER
@given(case_files())
def test_what_is_written_is_read_back(tmp_path, case_file):
    path = write_case(case_file, tmp_path / "case.toml", overwrite=True)
    assert read_case(path) == case_file
    text = path.read_bytes()
    write_case(read_case(path), path, overwrite=True)
    assert path.read_bytes() == text


@pytest.mark.simulation
@SAME_FOLDER
@given(st.sampled_from(BASES).flatmap(changed))
def test_a_case_survives_a_history_and_knows_its_equals(case):
    again = Case.model_validate_json(case.model_dump_json())
    assert again == case
    assert hash(again.contact) == hash(case.contact)
    assert case.with_() == case


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_written_short_and_exactly(value):
    assert float(number_text(value)) == value
    assert tomllib.loads(f"x = {number_text(value)}")["x"] == value


def test_large_numbers_are_written_as_engineers_do():
    assert [number_text(x) for x in (20e6, 200e9, 386.4e3, 1.5e-3)] == ["20e6", "200e9", "386400.0", "0.0015"]


def test_every_value_has_its_unit_and_meaning():
    text = case_text(CaseFile(case=Case.turning()))
    assert "spring_stiffness = 20e6 # N/m, stiffness of each spring\n" in text
    assert "turn_rate = {times = [0.0, 5.0], values = [0.0, 0.017453292519943295]} # rad/s, " in text
    rows = {row.key: row for row in case_rows(CaseFile(case=Case.turning()))}
    assert all(row.meaning for row in rows.values())
    assert rows["terrain.density"][1:] == ("1600 kg/m3", "density of the units")
    assert rows["loads.phases[0].loads"].value == "13 x 386.4 kN"


def test_a_file_gives_only_what_differs_from_its_base(read):
    found = read('base = "turning"\nname = "soft"\nduration = 3\n[terrain]\nspring_stiffness = 10e6\n')
    soft = Terrain.kinematics().with_(spring_stiffness=10e6)
    assert found == CaseFile(case=Case.turning().with_(name="soft", terrain=soft), duration=3.0)


def test_parts_have_bases_of_their_own(read):
    found = read(
        'base = "translation"\n[terrain]\nbase = "stress"\nspring_damping = 1e5\n'
        '[contact]\nbase = "oil_sand"\n[loads]\nbase = "shovel_cycle"\n'
        '[flexible]\nbase = "ph4100c"\nmesh = "coarse"\n'
    )
    assert found.case.terrain == Terrain.stress().with_(spring_damping=1e5)
    assert found.case.loads == LoadCycle.shovel_cycle()
    assert found.case.flexible == FlexibleShoes.ph4100c("coarse")


PAIR, ADAMS = PairContact.oil_sand(), PairContact.adams()
SPHERES = SphereContact.oil_sand()
OIL_SAND = '[contact]\nmodel = "spheres"\nbase = "oil_sand"\n'


@pytest.mark.parametrize(
    ("text", "contact"),
    [
        ('model = "spheres"\nbase = "oil_sand"', SPHERES),
        ('model = "pair"\nbase = "oil_sand"', PAIR),
        ('base = "oil_sand"', PAIR),
        ("stiffness = 2e8", ADAMS.with_(stiffness=2e8)),
        ('model = "pair"\nstiffness = 2e8', ADAMS.with_(stiffness=2e8)),
        ('model = "spheres"\nbase = "oil_sand"\nradius = 0.25', SPHERES.with_(radius=0.25)),
    ],
)
def test_contact_is_of_the_model_that_is_named(read, text, contact):
    assert read(f'base = "translation"\n[contact]\n{text}\n').case.contact == contact


def test_a_contact_without_model_is_the_pair_law_beside_no_base_too(read):
    """A base alone is no old key."""
    base = case_text(CaseFile(case=Case.turning()))
    whole = re.sub(r"\[contact\]\n(.+\n)+", '[contact]\nbase = "adams"\n', base)
    assert whole != base
    assert read(whole).case == Case.turning()


def test_what_the_base_says_of_another_model_is_forgotten(refused):
    faults = refused('base = "translation"\n[contact]\nmodel = "spheres"\nfriction_speed = 0.01\n')
    start = "contact: spheres_x, spheres_y, radius, reference_stiffness, reference_exponent and "
    assert any(line.startswith(start) and line.endswith(' start from "oil_sand"') for line in faults)


def test_a_mesh_is_sought_beside_the_file(read, refused, tmp_path):
    (tmp_path / "own.msh.gz").write_bytes(shoe_path("coarse").read_bytes())
    text = 'base = "translation"\n[flexible]\nbase = "ph4100c"\nmesh = "{}"\n'
    assert read(text.format("own.msh.gz")).case.flexible.mesh == str(tmp_path / "own.msh.gz")
    (fault,) = refused(text.format("lost.msh"))
    assert fault == "flexible.mesh: the mesh must be one of coarse, study, fine or a file, got 'lost.msh'"


def test_named_values_are_the_constructors_that_need_nothing():
    assert {"kinematics", "stress"} <= set(named_values(Terrain))
    assert {"propel", "shovel_cycle"} <= set(named_values(LoadCycle))
    assert not {"constant", "from_toml"} & set(named_values(LoadCycle))
    assert named_values(Terrain)["stress"]() == Terrain.stress()


CELLS = {*key_paths(CellTerrain, "terrain."), *key_paths(CellContact, "contact.")}
"""Paths of a ground of cells."""
GEARS = models_of(Case.model_fields["gear"].annotation)
OF_SPHERES = {*key_paths(SphereContact, "contact.")} - {*key_paths(PairContact, "contact.")}


@pytest.mark.parametrize("path", ["terrain.width", "contact.law.k_phi", "terrain.relief.roughness.seed"])
def test_a_misspelt_key_of_cells_is_named_with_the_one_that_was_meant(refused, path):
    assert path in CELLS
    table, _, name = path.rpartition(".")
    text = dict.fromkeys(("terrain", "contact"), 'model = "cells"\n') | {"contact.law": 'model = "bekker"\n'}
    text[table] = text.get(table, "") + f"{name}s = 1\n"
    faults = refused('base = "turning"\n' + "".join(f"[{one}]\n{lines}" for one, lines in text.items()))
    wanted = f"{name}s: unknown key; did you mean {'' if 'law' in table else f'{table}.'}{name}?"
    assert any(one.startswith(table) and wanted in one for one in faults)


@pytest.mark.parametrize("path", sorted(set(key_paths(Case)) - CELLS))
def test_a_misspelt_key_is_named_with_the_one_that_was_meant(read, refused, path):
    table, _, name = path.rpartition(".")
    wrong = f"{name[:2]}{name[3:]}" if len(name) > 4 else f"{name}s"
    head, start = f"[{table}]\n" if table else "", f"{table}." if table else ""
    if table.endswith((".phases", ".bogies", ".arms")):
        head, start = f"[[{table}]]\n", f"{table}[0]."
    if path in OF_SPHERES:
        head += 'model = "spheres"\n'
    elif table.startswith("gear"):
        kind = next(tag_of(kind) for kind in GEARS if path in key_paths(kind, "gear."))
        head = f'[gear]\nkind = "{kind}"\n{"" if table == "gear" else head}'
    faults = refused(f'base = "turning"\n{head}{wrong} = 1\n')
    assert f"{start}{wrong}: unknown key; did you mean {start}{name}?" in faults


def test_a_key_like_no_other_is_answered_with_what_is_allowed(refused):
    (fault,) = refused('base = "translation"\n[outputs]\nqqqqqq = 1\n')
    assert re.fullmatch(r"outputs\.qqqqqq: unknown key; allowed are figures, .*shoes", fault)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("[loads]\nloads = 1e5", "loads.loads: unknown key; allowed are phases"),
        ("[drive]\nspeed = 0.1", "drive.speed: must be values over time, such as {times = [0, 5]"),
        ("[[vary]]\nkey = 1", "vary: unknown key; allowed are name, shoe, "),
        ('case = "own.toml"', "case: unknown key; allowed are name, shoe, "),
        ('[shoe]\nmass = "heavy"', "shoe.mass: must be a number in kg, or such as '1 t', got 'heavy'"),
        ('[shoe]\nmass = "4681"', "shoe.mass: must be a number in kg, or such as '1 t', got '4681'"),
        ("[shoe]\nmass = true", "shoe.mass: must be a number, got True"),
        ("[shoe]\nmass = nan", "shoe.mass: must be a finite number, got nan"),
        ("[shoe]\nmass = -1", "shoe.mass: must be greater than or equal to 0.1 kg, got -1"),
        ("[terrain]\ncolumns = 2.5", "terrain.columns: must be a whole number"),
        ('[terrain]\ntilt = "yaw"', "terrain.tilt: must be 'pitch' or 'roll', got 'yaw'"),
        ("[terrain]\ncolumn_tilt = 1", "terrain.column_tilt: must be true or false, got 1"),
        ('terrain = "stress"', "terrain: must be a table, got 'stress'"),
        ("name = 1979-05-27", "name: must be a text, got "),
        ("[shoe]\nload_point = [1, 2]", "shoe.load_point[2]: missing, got [1, 2]"),
        ("duration = 0", "duration must be positive and finite, got 0.0 s"),
        ("duration = 1e4", "terrain must carry the track over the whole drive: at t = "),
        ("[track]\nshoe_count = 12", "loads must name every shoe of the track (12) or be a number, got lo"),
        ("[outputs]\nshoes = [1, 14]", "outputs.shoes must be in 1..13, got [14]"),
        ("[outputs]\npicture_times = [0, 20]", "outputs.picture_times must be in 0..10 s, got [0.0, 20.0]"),
        ("[outputs]\npicture_times = [2, 1]", "outputs.picture_times: must be different and rise, got (2.0,"),
        ("[outputs]\npicture_times = [-1, 1]", "outputs.picture_times[0]: must be greater than or equal"),
        ("[outputs]\npicture_times = []", "outputs.picture_times: must have at least 1 item"),
        ('[contact]\nmodel = "hertz"', "contact.model: must be 'pair' or 'spheres' or 'cells', got 'hertz'"),
        ("[contact]\nmodel = [1]", "contact.model: must be 'pair' or 'spheres' or 'cells', got [1]"),
        ('contact = "spheres"', "contact: must be a table, got 'spheres'"),
        # keys of the other model
        ("[contact]\nradius = 0.2", "contact.radius: unknown key; allowed are model, stiffness, "),
        (f"{OIL_SAND}sharing = 'area'", "contact.sharing: unknown key; allowed are model, spheres_x, "),
        (f"{OIL_SAND}raduis = 0.2", "contact.raduis: unknown key; did you mean contact.radius?"),
        ("[drive]\non = [[0, 15, 20]]", "drive.on[0]: "),
        (
            "[drive]\non = [[5, 15]]",
            "drive: speed must be zero at 5 s, when the drive is switched on, got 0.1 m/s",
        ),
        ("drive.speed = {times = [0, 1, 1], values = [0, 1, 2]}", "drive.speed: times must increase, got ("),
    ],
)
def test_wrong_values_are_named_by_their_path(refused, text, fault):
    (found,) = refused(f'base = "translation"\n{text}\n')
    assert found.startswith(fault)


def test_all_faults_are_told_at_once(refused):
    faults = refused('base = "turning"\n[shoe]\nmass = "a"\n[solver]\nstep = 0\nsteps = 3\n')
    assert [fault.partition(":")[0] for fault in faults] == ["shoe.mass", "solver.step", "solver.steps"]


def test_of_many_errors_the_first_are_named_and_all_counted(refused):
    (fault,) = refused('base = "translation"\n' + "".join(f"key{k} = 1\n" for k in range(10_000)))
    named = ", ".join(f"key{k}" for k in range(20))
    assert fault.startswith(f"{named} and 9980 more: unknown keys; allowed are name, shoe,")
    faults = refused(f'base = "translation"\n[drive.speed]\ntimes = {["x"] * 10_000}\n')
    assert [fault.partition(":")[0] for fault in faults] == ["drive.speed.times[0..9999]"]
    apart = [1.0, "x"] * 5_000
    faults = refused(f'base = "translation"\n[drive.speed]\ntimes = {apart}\n')
    assert [fault.partition(":")[0] for fault in faults[:100]] == [
        f"drive.speed.times[{k}]" for k in range(1, 201, 2)
    ]
    assert faults[100:] == ["4900 more errors"]


def test_a_wrong_base_is_answered_with_those_there_are(refused):
    assert refused('base = "turn"\n')[0].startswith("base: no 'turn'; did you mean 'turning'? allowed are '")
    (told,) = refused('base = "turning"\n[terrain]\nbase = 3\n')
    assert told.startswith("terrain.base: no 3; allowed are '")
    (told,) = refused('base = "turning"\n[solver]\nbase = "a"\n')
    assert told == "solver.base: no 'a'; allowed are no names at all"


def test_what_a_file_without_base_lacks_is_named(refused):
    (fault,) = refused('[shoe]\nbase = "ph4100c"\n')
    assert fault.startswith(
        'track, terrain, contact, drive, loads are missing; give them, or start from "translat'
    )
    (lacking,) = refused('base = "translation"\n[flexible]\n')
    assert lacking.startswith("flexible: shoes, ")
    assert lacking.endswith(' are missing; give them, or start from "ph4100c"')
    (single,) = refused('base = "translation"\n[terrain.relief.roughness]\n')
    assert single == "terrain.relief.roughness.spectrum: missing"


@pytest.mark.parametrize(
    "content", [b"a = ", b"\xff\xfe", b"[a]\n[a]\n", b"a = 1\na = 2\n", b"a = " + b"[" * 100_000]
)
def test_what_is_no_toml_is_refused(refused, content):
    (fault,) = refused(content)
    assert fault.startswith("not TOML: ")


@pytest.mark.parametrize(("value", "point"), [("9,81", "9.81"), ("-0,5 # m/s2", "-0.5")])
def test_a_decimal_comma_is_told_in_a_line_that_is_no_toml(refused, value, point):
    (fault,) = refused(f'base = "turning"\ngravity = {value}\n')
    assert fault.endswith(f"); numbers have a point: {point}")


def test_marks_of_windows_editors_are_no_fault_and_none_takes_a_value_away(read):
    assert read(b'\xef\xbb\xbfbase = "turning"\r\n').case == Case.turning()
    assert read('base = "turning"\n[drive]\nturn_rate = "none"\n').case.drive == Case.translation().drive


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no case file .*nowhere\.toml"):
        read_case(tmp_path / "nowhere.toml")


def test_an_existing_file_is_kept_unless_asked(tmp_path):
    path = write_case(CaseFile(case=Case.turning()), tmp_path / "case.toml")
    with pytest.raises(FileExistsError, match=r"case\.toml exists"):
        write_case(CaseFile(case=Case.translation()), path)
    assert read_case(path).case == Case.turning()


@pytest.mark.parametrize(
    ("count", "drawn"), [(13, (1, 4, 7, 10, 13)), (2, (1, 2)), (3, (1, 2, 3)), (40, (1, 11, 21, 30, 40))]
)
def test_five_shoes_along_the_track_are_drawn(count, drawn):
    assert Outputs().drawn_shoes(count) == drawn
    assert Outputs(shoes=(2,)).drawn_shoes(count) == (2,)


WRITTEN = {name: make() for name, make in named_values(Case).items()}
WRITTEN["cells"] = Case.rolled().on_cells(BekkerSoil.lete_sand())


@pytest.fixture(scope="module")
def schema() -> Draft202012Validator:
    found = case_schema()
    Draft202012Validator.check_schema(found)
    return Draft202012Validator(found)


def told(schema: Draft202012Validator, text: str) -> str:
    errors = schema.iter_errors(tomllib.loads(text))
    return " ".join(one.message for error in errors for one in chain([error], error.context))


@pytest.mark.parametrize("name", WRITTEN)
def test_every_case_that_is_written_fits(schema, name):
    assert told(schema, case_text(CaseFile(case=WRITTEN[name]))) == ""


@pytest.mark.parametrize(
    "text",
    [
        "base = 'translation'\n[terrain]\nspring_stiffness = '10 MN/m'",
        "base = 'rolled'\n[contact]\nmodel = 'cells'\n[contact.law]\nmodel = 'bekker'\nbase = 'lete_sand'",
        "base = 'stress'\nduration = 2\n[[loads.phases]]\nname = 'dig'\nend = 3\nloads = '450 kN'",
        "flexible = 'none'",
    ],
)
def test_files_that_hold_little_fit(schema, text):
    assert told(schema, text) == ""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("terain = 1", "'terain' was unexpected"),
        ("[terrain]\nspring_stifness = 1", "'spring_stifness' was unexpected"),
        ("base = 'stres'", "'stres' is not one of"),
        ("[shoe]\nmass = -1", "-1 is less than the minimum"),
        ("drive = 3", "3 is not of type 'object'"),
    ],
)
def test_mistakes_are_found(schema, text, words):
    assert words in told(schema, text)


def test_a_field_under_its_earlier_name_is_read(read, tmp_path):
    """Files, changes, sweeps' paths and stored results of earlier versions have `track_distance`."""
    earlier = "gear.car_body.track_distance"
    wide = Case.shovel().with_({"gear.car_body.gauge": 9.5})
    assert Case.shovel().with_({earlier: 9.5}) == wide
    assert Case.shovel().with_({earlier: 9.5, "gear.car_body.mass": wide.gear.car_body.mass}) == wide
    assert read('base = "shovel"\nduration = 1\n[gear.car_body]\ntrack_distance = "950 cm"\n').case == wide
    path = write_case(CaseFile(case=Case.shovel(), duration=1.0), tmp_path / "full.toml")
    path.write_text(path.read_text().replace("gauge =", "track_distance ="))
    assert read_case(path, [f"{earlier}=9.5"]).case == wide
    assert saved_case(wide.model_dump_json().replace('"gauge"', '"track_distance"')) == wide
    item = fields.entry_at(wide, fields.parse_path(earlier))
    assert (item.path, item.value) == ("gear.car_body.gauge", 9.5)
