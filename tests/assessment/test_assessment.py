"""An assessment of the P&H 4100C: its items against hand calculations, inputs with origin, refusals."""

import numpy as np
import pytest

from exudyn_crawler import Case, assess
from exudyn_crawler.assessment import forces, pressure, states
from exudyn_crawler.assessment.assessment import assessment_of
from exudyn_crawler.assessment.grounds import ground, grounds
from exudyn_crawler.assessment.inputs import numbers_of
from exudyn_crawler.assessment.ledger import rules
from exudyn_crawler.assessment.load_cases import read_load_cases
from exudyn_crawler.assessment.settings import AssessmentSettings, read_assessment
from exudyn_crawler.assessment.slewing import least_over_slew
from exudyn_crawler.case import MachineCycle
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.machines import read_case, write_case
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.typical import row_of
from exudyn_crawler.origins import Entry, Ledger, Origin
from exudyn_crawler.settings import fields
from tests.results.test_machine_answers import SHEET
from tests.test_release import read

GRAVITY = 9.81
FILE = "studies/shovel_assessment.toml"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Assessment of the study's file, without the finite elements of a shoe."""
    path = tmp_path_factory.mktemp("assessment") / "shovel.toml"
    path.write_text(read(FILE).replace("\n[work]", '\nmesh = "none"\n\n[work]'))
    asked = read_assessment(path)
    return assessment_of(asked.machine.case, asked.settings, given=asked.given)


def item(found, name):
    return next(one for one in found.governing if one.item == name)


def test_items_are_sorted_and_the_first_line_says_what_governs(found):
    used = [one.utilisation for one in found.governing if np.isfinite(one.utilisation)]
    assert used == sorted(used, reverse=True)
    names = [one.item for one in found.governing]
    assert len(names) == len(set(names))
    assert names[0] in found.lines[0]
    over = [one.item for one in found.governing if one.utilisation > 1.0]
    assert found.lines[1].startswith(f"{len(over)} of {len(names)} items exceed")
    assert all(one.source.text and one.formula and one.source.mark in "SDR" for one in found.governing)


def test_pressure_straight_ahead_by_hand(found):
    """Resultant of lower and upper structure, and of the payload 17 m ahead."""
    numbers = found.numbers
    lower, upper = numbers.weights.lower_mass, numbers.weights.upper_mass
    payload = 90724.8
    mass = lower + upper + payload
    place = (lower * numbers.weights.lower_com[0] - upper * 1.0 + payload * 17.0) / mass
    length, width = numbers.fewest.length, 3.505
    wanted = 0.5 * GRAVITY * mass / (length * width) * (1.0 + 6.0 * abs(place) / length)
    rows = found.over_slew
    row = rows[(rows["state"] == "with payload") & (rows["slew in deg"] == 0.0)].iloc[0]
    assert row["left track, greatest in kPa"] == pytest.approx(wanted / 1e3)
    assert row["ahead in m"] == pytest.approx(place)


def test_a_rigid_plate_stands_beside_the_beams(found):
    """With payload: ahead and astern it is two beams; at 30 degrees P / A + M c / I of both rectangles."""
    table = found.plate.set_index("slew in deg")
    plate = table["plate on linear ground in kPa"]
    for angle in (0.0, 180.0):
        assert plate[angle] == pytest.approx(table.loc[angle, "beams in kPa"], rel=1e-3)
    states = found.over_slew
    row = states[(states["slew in deg"].round() == 30.0) & (states["state"] == "with payload")].iloc[0]
    gauge, length, width = found.numbers.fewest
    along = 2.0 * width * length**3 / 12.0
    across = 2.0 * (width * length * gauge**2 / 4.0 + length * width**3 / 12.0)
    change = (
        row["ahead in m"] * 0.5 * length / along + row["to the left in m"] * 0.5 * (gauge + width) / across
    )
    weight = found.numbers.weight + 90724.8 * GRAVITY
    assert plate[30.0] == pytest.approx(weight * (0.5 / (width * length) + change) / 1e3, rel=3e-3)


def test_length_on_the_ground_is_that_below_the_rollers(found):
    """7 rollers 0.95 m apart, 0.655742 m of pitch: 5.7 m and a pitch; at least nine whole shoes."""
    assert found.numbers.footprints.length == pytest.approx(5.7 + 0.655742)
    assert found.numbers.fewest.length == pytest.approx(9 * 0.655742)
    assert found.numbers.edges[:2] == pytest.approx((2.85, 2.85))


def test_rated_load_by_hand(found):
    """0.75 T, T = M / (17 - 2.85) m, about the front edge, straight ahead."""
    weights = found.numbers.weights
    held = weights.lower_mass * (2.85 - weights.lower_com[0]) + weights.upper_mass * (2.85 + 1.0)
    rated = 0.75 * held / (17.0 - 2.85) / 1e3
    rows = found.over_slew
    straight = rows[(rows["slew in deg"] == 0.0) & (rows["state"] == "without payload")][
        "rated load in t"
    ].iloc[0]
    assert straight == pytest.approx(rated)
    assert item(found, "payload over rated load").number == pytest.approx(90.7248)


def test_travel_by_hand(found):
    """V f / 2 with the idler's 2 T f on the level; the drive climbs F = V (sin a + f cos a).

    The chain bears its tension at rest, the pull and w v2 / g.
    """
    numbers = found.numbers
    level = next(row for row in found.loads if row.name == "travels straight on the level")
    rest = numbers.chain.rest
    assert level.needed == pytest.approx(0.03 * 0.5 * numbers.weight + 2.0 * rest * 0.03)
    thrown = numbers.chain.weight * numbers.chain.speed**2 / 9.81
    assert level.tension == pytest.approx(rest + level.needed + thrown, rel=1e-9)
    grade = item(found, "permitted grade over grade that the drive climbs")
    slope = np.arctan(grade.limit)
    pull = numbers.weight * (np.sin(slope) + 0.03 * np.cos(slope)) + 4.0 * rest * 0.03
    assert pull == pytest.approx(2.0 * numbers.drive.pull)
    assert "2 T eta / r" in grade.formula
    assert "mu" not in grade.formula


def test_rest_tension_by_hand(found):
    """W l2 / (8 f): 38 shoes of 4681.67 kg, carriers 1.8 m apart, a rail of 0.6 m on them, 2.5 % of sag.

    The chain's own rest has 261 kN (docs/closed-track.md).
    """
    weight = 4681.67 * GRAVITY / 0.655742
    assert found.numbers.chain.rest == pytest.approx(weight * 1.2**2 / (8.0 * 0.025 * 1.8))
    assert found.numbers.chain.rest == pytest.approx(261e3, rel=0.1)


def test_supports_share_the_load_of_a_track(found):
    """One roller bears all of the more loaded track but its shoes; two and the outer ones what levers say."""
    by_name = {row.name: row for row in found.loads}
    alone = by_name["one roller on a ridge"]
    shoes = found.numbers.rollers.grounded_shoe_weight
    assert alone.roller == pytest.approx(alone.track_load - shoes)
    assert by_name["two rollers bear a track"].roller < by_name["two rollers bear a track"].track_load - shoes
    hollow = by_name["hollow below the middle"].roller_loads
    assert np.count_nonzero(hollow) == 2


def test_side_forces_by_hand(found):
    """On a side slope of 0.05 the push over the weight is 0.05; in a turn all friction, 0.3, is across."""
    by_name = {row.name: row for row in found.loads}
    part = 0.655742 * 3.505
    turn = by_name["turns on the spot"]
    assert turn.side_force == pytest.approx(0.3 * turn.greatest_pressure * part)
    assert by_name["travels straight on the level"].side_force == pytest.approx(0.0, abs=1.0)
    assert by_name["travels straight on the level"].lies == "level"
    numbers = found.numbers
    empty = numbers.work._replace(payload=0.0, digging=(0.0, 0.0), wind=0.0, slew_rate=0.0)
    still = numbers._replace(work=empty)
    cases = read_load_cases()
    leaning = next(case for case in cases.cases if case.slope)
    row = states.case_loads(still, cases, leaning)
    assert row.lies == "side slope"
    # both edges downhill in turn
    greatest = 0.0
    for downhill in np.radians([90.0, 270.0]):
        gravity = forces.gravity_on_slope(GRAVITY, np.arctan(0.05), downhill)
        stands = forces.resultant(forces.forces_at(numbers.weights, empty, states.SLEW, gravity))
        for track in pressure.pressure_of_tracks(stands, numbers.fewest):
            greatest = max(greatest, float(track.greatest.max()))
    assert row.side_force == pytest.approx(0.05 * greatest * part)
    icy = numbers._replace(work=empty, ground=numbers.ground._replace(friction=0.02))
    assert states.case_loads(icy, cases, leaning).side_force == pytest.approx(0.4 * row.side_force)
    assert item(found, "force across a shoe").number == pytest.approx(
        max(one.side_force for one in found.loads if one.support == "even") / 1e3
    )


def test_every_factor_says_where_it_comes_from(found):
    """Factors of the program are remembered and marked so, in the table, too; those of 1 are none."""
    table = found.items
    with_factor = table["factor"] != 1.0
    assert with_factor.any()
    assert table.loc[with_factor, "factor from"].str.endswith("[R]").all()
    assert (table.loc[~with_factor, "factor from"] == "").all()
    assert "remembered" in item(found, "tipping").source.text


def test_moments_about_each_edge_by_hand(found):
    """Front edge, upper structure ahead: level with payload; and on a side slope that falls to the front."""
    numbers = found.numbers
    weights = numbers.weights
    table = found.tipping.set_index(["state", "edge", "slew in deg"])
    level = table.loc[("with payload, level", "front", 0.0)]
    held = weights.lower_mass * (2.85 - weights.lower_com[0]) + weights.upper_mass * (2.85 + 1.0)
    assert level["stabilising in MN m"] == pytest.approx(GRAVITY * held / 1e6)
    assert level["overturning in MN m"] == pytest.approx(GRAVITY * 90724.8 * (17.0 - 2.85) / 1e6)
    assert level["margin"] == pytest.approx(held / (90724.8 * (17.0 - 2.85)))
    # the machine tilted by the slope has that much less left
    sloped = table.loc[("with payload, side slope", "front", 0.0)]
    tilt = np.degrees(np.arctan(0.05))
    assert sloped["tips further at in deg"] == pytest.approx(level["tips further at in deg"] - tilt)
    wind = table.loc[("without payload, wind", "left", 90.0)]
    calm = table.loc[("without payload, level", "left", 90.0)]
    assert wind["overturning in MN m"] - calm["overturning in MN m"] == pytest.approx(
        250.0 * 250.0 * 8.0 / 1e6
    )
    least = least_over_slew(found.tipping)
    assert len(least) == 2 * 3 * 4
    assert least["tips further at in deg"].min() == found.tipping["tips further at in deg"].min()


def test_a_turn_stalls_at_the_friction_that_the_drive_has_the_pull_for(found):
    stalls = item(found, "friction over that at which a turn on the spot stalls")
    settings = found.settings.with_({"ground.friction": 0.999 * stalls.limit})
    case = Case.shovel()
    at_limit = assessment_of(case, settings)
    row = next(row for row in at_limit.loads if row.drive == "turn")
    assert row.ends == "goes"
    assert row.needed == pytest.approx(numbers_of(case, settings).drive.pull, rel=2e-3)
    beyond = assessment_of(case, settings.with_({"ground.friction": 1.001 * stalls.limit}))
    assert next(row for row in beyond.loads if row.drive == "turn").ends == "stalls"


@pytest.mark.parametrize(
    ("kind", "own", "share"),
    [(None, None, 0.75), ("excavator", None, 0.75), ("dozer", None, 1.0), ("dozer", 0.9, 0.9)],
)
def test_a_pull_without_a_torque_is_the_typical_one_of_the_machine(kind, own, share):
    sheet = None if kind is None else SHEET.with_({"kind": kind, "typical.pull_share": own})
    case = derived(SHEET).case
    assert case.gear.torque_limit is None
    marked = assessment_of(case, AssessmentSettings(mesh=None), sheet=sheet)
    assert 2.0 * marked.numbers.drive.pull == pytest.approx(share * marked.numbers.weight)
    how = marked.ledger["drive.torque"].how
    row = row_of("pull_share", kind or "")
    assert (row.source if own is None else "typical.pull_share of the datasheet") in how
    heavy = assessment_of(Case.shovel().with_({"gear.torque_limit": None}), AssessmentSettings(mesh=None))
    assert 2.0 * heavy.numbers.drive.pull == pytest.approx(0.5 * heavy.numbers.weight)
    assert "typical.csv: 0.5 of shovels" in heavy.ledger["drive.torque"].how


def test_inputs_say_where_they_come_from(found):
    ledger = found.ledger
    assert ledger["work.payload"].origin is Origin.GIVEN
    assert ledger["work.height"].origin is Origin.GIVEN
    assert ledger["length"].origin is Origin.DERIVED
    assert ledger["drive.torque"].origin is Origin.ASSUMED
    assert ledger["pins.tensile_strength"].origin is Origin.ASSUMED
    assert all(entry.how for entry in ledger)
    # values, units and meanings are those of the fields, or of the numbers that the formulas take
    assert ledger["length"].value == found.numbers.footprints.length
    assert (ledger["length"].unit, ledger["length"].meaning[:17]) == ("m", "length of a track")
    assert ledger["chain.weight"].value == found.numbers.chain.weight
    assert ledger["chain.weight"].unit == "N/m"
    remembered = Entry("gear.roller_radius", 0.4, "m", Origin.ASSUMED, "0.75 to 0.9 p, remembered")
    marked = assessment_of(Case.shovel(), AssessmentSettings(mesh=None), origins=Ledger([remembered]))
    assert marked.ledger["gear.roller_radius"] == remembered


def test_rules_of_inputs_are_of_numbers_that_there_are(found):
    """Rules name a key of the settings, or a number that no field has with its unit."""
    keys = {item.path for item in fields.values_of(found.settings)}
    for rule in rules():
        known = [path for path in rule.paths if path in keys or path.endswith("*")]
        assert (known == list(rule.paths)) != bool(rule.unit), rule
        assert rule.text
        if rule.unit:
            assert set(rule.paths) <= set(found.numbers.ruled)


@pytest.mark.parametrize("name", ["pc300lc", "d155ax"])
def test_machines_of_datasheets_are_assessed(name):
    """Pressure over the sheet's length as it prints it within 15 %; what it does not say is no given."""
    path = library.machines()[name]
    found = assess(path)
    sheet = read_assessment(path).machine.datasheet
    area = 2.0 * sheet.shoe_width * sheet.length_on_ground
    assert found.numbers.weight / area == pytest.approx(sheet.ground_pressure, rel=0.15)
    # its end wheels are a little higher than the rollers
    assert 0.8 < found.numbers.footprints.length / sheet.length_on_ground < 1.0
    ledger = found.ledger
    gauge = ledger["gear.car_body.gauge"].origin
    assert gauge is (Origin.ASSUMED if "gauge" in sheet.remembered else Origin.LIBRARY)
    assert ledger["gear.roller_radius"].origin is Origin.ASSUMED
    # what the settings leave to the case has its origin
    assert ledger["ground.friction"].how.startswith("LETE sand; the file may name another soil")
    assert "left out: the shoe's stress" in found.lines[-1]
    loads = {row.name: row for row in found.loads}
    assert loads["travels straight on the level"].ends == "goes"
    assert loads["one roller on a ridge"].roller_loads.sum() == pytest.approx(
        loads["one roller on a ridge"].track_load - found.numbers.rollers.grounded_shoe_weight
    )


def test_a_blocked_track_and_a_stall_pull_all_that_the_drive_has(found):
    stall = next(row for row in found.loads if row.name == "drives stall")
    assert stall.tension == pytest.approx(found.numbers.chain.rest + found.numbers.drive.pull, rel=1e-4)
    assert stall.group == "HZS"
    assert stall.strength == 1.2


def test_factors_and_cases_of_ones_own(tmp_path):
    (tmp_path / "cases.toml").write_text(
        'name = "ours"\n[[groups]]\nname = "A"\ntitle = "all"\nstrength = 2.0\ntipping = 1.4\n'
        '[[cases]]\nname = "stands"\ngroup = "A"\n'
    )
    (tmp_path / "ours.toml").write_text(
        'machine = "shovel"\nmesh = "none"\nload_cases = "cases.toml"\n[drive]\nbreaking_tension = "3 MN"\n'
    )
    found = assess(tmp_path / "ours.toml")
    assert [row.name for row in found.loads] == ["stands"]
    tension = item(found, "chain tension")
    assert tension.factor == 2.0
    assert tension.factor_source == "given by the user"
    assert tension.utilisation == pytest.approx(2.0 * found.numbers.chain.rest / 3e6, rel=1e-4)


def test_clay_and_play_give_items_of_their_own():
    settings = AssessmentSettings(
        mesh=None, ground={"undrained_strength": 100e3}, pins={"play": 1e-3}, drive={"power": 1e6}
    )
    found = assessment_of(Case.shovel(), settings)
    names = {one.item for one in found.governing}
    assert {
        "mean pressure over bearing capacity of clay",
        "pin in its hole, contact",
        "power of travel",
    } <= names


def test_named_grounds_have_sources():
    assert all(one.source and one.mark == "R" for one in grounds().values())
    with pytest.raises(ValueError, match="did you mean 'stiff clay'"):
        ground("stif clay")


def test_factors_of_the_program_are_marked_as_remembered():
    cases = read_load_cases()
    assert [(group.strength, group.tipping) for group in cases.groups] == [
        (1.5, 1.5),
        (1.33, 1.3),
        (1.2, 1.2),
    ]
    assert {group.mark for group in cases.groups} == {"R"}


def test_what_is_wrong_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"gear\.kind must be 'machine'"):
        assessment_of(Case.closed())
    for text, words in (
        ('machine = "shovel"\n[ground]\nname = "swamp"', "swamp"),
        ('machine = "showel"', "showel"),
        ('machine = "shovel"\n[work]\nreach = "far"', "work.reach"),
        ('machine = "shovel"\nload_cases = "nowhere.toml"', "nowhere.toml"),
    ):
        (tmp_path / "wrong.toml").write_text(text)
        with pytest.raises((CaseFileError, FileNotFoundError), match=words):
            assess(tmp_path / "wrong.toml")


@pytest.mark.parametrize("acts", [None, "digs"])
def test_a_case_file_with_all_values_is_that_of_a_machine(tmp_path, acts):
    case_file = read_case(library.machines()["pc300lc"])
    if acts:
        cycle = MachineCycle.digging(case_file.case.gear.car_body)
        case_file = case_file.with_(duration=30.0, case=case_file.case.with_(machine=cycle))
    asked = read_assessment(write_case(case_file, tmp_path / "whole.toml"))
    assert asked.machine == case_file
    assert asked.settings == AssessmentSettings(name="whole")


def test_one_resistance_for_all_items_of_travel():
    """An excavator on sand: pull on the level and up the limits of both grades, power, turn."""
    case = read_case(library.machines()["pc300lc"]).case
    case = case.with_({"gear.rolling_resistance": 0.03, "track.pin.kind": "ideal"})
    settings = AssessmentSettings(mesh=None, drive={"power": 50e3})
    found = assessment_of(case, settings)
    numbers = found.numbers
    assert numbers.ground.compaction is not None
    pull = item(found, "pull of a track, travels straight on the level").number
    power = item(found, "power of travel")
    assert power.number == pytest.approx(2.0 * pull * numbers.chain.speed)
    drive = item(found, "permitted grade over grade that the drive climbs").limit
    ground = item(found, "permitted grade over grade that the ground bears").limit
    assert drive == pytest.approx(1.0126, abs=1e-4)
    climbs = "pull of a track, travels up the permitted grade"
    at_drive = item(assessment_of(case, settings.with_({"work.grade": drive})), climbs)
    assert at_drive.number == pytest.approx(numbers.drive.pull / 1e3, rel=1e-6)
    at_ground = item(assessment_of(case, settings.with_({"work.grade": ground})), climbs)
    assert at_ground.utilisation == pytest.approx(1.0, rel=1e-6)


def test_what_is_not_stated_is_not_known_and_never_within():
    """An excavator without payload, bank and wind, on ground of which no pressure is known."""
    case = read_case(library.machines()["pc300lc"]).case
    found = assessment_of(case, AssessmentSettings(mesh=None))
    tipping = item(found, "tipping")
    assert tipping.verdict == "not known (needs work.payload, work.reach, work.digging, work.wind_area)"
    assert np.isnan(tipping.utilisation)
    # no force overturns: the edge is that of the least angle
    level = next(row for row in found.loads if row.name == "stands and slews with payload")
    assert level.margin == np.inf
    over = found.over_slew
    first = over.loc[over["tips at in deg"].idxmin()]
    assert level.edge == level.tilt_edge == first["edge"] == first["tips about"]
    assert np.degrees(level.tilt) == pytest.approx(first["tips at in deg"])
    assert "rated load in t" not in over
    assert item(found, "payload over rated load").needs == ("work.payload", "work.reach")
    for name in ("greatest ground pressure", "even equivalent of the pressure"):
        assert "ground.name or ground.allowed_pressure" in item(found, name).verdict
    assert next(line for line in found.lines if line.startswith("not known")).count("tipping") == 1
    # pins of a chain do not depend on what the upper structure does
    assert item(found, "pin, bending").verdict == "yes"
    work = {"payload": 0.0, "digging": (0.0, 0.0), "wind_area": 0.0}
    stated = assessment_of(case, AssessmentSettings(mesh=None, work=work, ground={"name": "dense sand"}))
    assert item(stated, "tipping").verdict == "yes"
    assert not any(one.needs for one in stated.governing)
    assert not any(one.item == "payload over rated load" for one in stated.governing)
    lifting = assessment_of(case, AssessmentSettings(mesh=None, work=work | {"payload": 2000.0}))
    assert item(lifting, "tipping").needs == ("work.reach",)
    heavy = AssessmentSettings(mesh=None, work={"payload": 5e4, "reach": 8.0})
    assert item(assessment_of(case, heavy), "tipping").verdict == "no"


def test_one_ground_gives_pressure_friction_and_cohesion():
    """A named ground gives all of them, else the case's ground; none is of another."""
    case = read_case(library.machines()["pc300lc"]).case
    law = case.contact.law
    own = numbers_of(case, AssessmentSettings()).ground
    assert np.isnan(own.allowed)
    assert own.friction == pytest.approx(np.tan(np.radians(law.friction_angle)))
    assert own.cohesion == law.cohesion
    assert own.compaction == (law.k_c, law.k_phi, law.exponent)
    sand = numbers_of(case, AssessmentSettings(ground={"name": "dense sand"})).ground
    named = ground("dense sand")
    assert sand[:4] == ("dense sand", named.allowed_pressure, named.friction, named.rolling)
    assert (sand.cohesion, sand.compaction, sand.law) == (0.0, None, None)
    # a coefficient of traction that is given has the cohesion in it
    given = numbers_of(case, AssessmentSettings(ground={"friction": 0.5})).ground
    assert (given.friction, given.cohesion) == (0.5, 0.0)
    with pytest.raises(
        ValueError, match=r"undrained_strength must be left out for ground that is not clay, got 'dense sand'"
    ):
        AssessmentSettings(ground={"name": "dense sand", "undrained_strength": 5e4})


def test_number_limit_and_utilisation_are_of_one_place(found):
    """Utilisation is number times factor over limit; of tipping the limit over the number."""
    case = read_case(library.machines()["pc300lc"]).case
    excavator = assessment_of(case, AssessmentSettings(mesh=None))
    for one in [*found.found, *excavator.found]:
        if not np.isfinite(one.utilisation):
            continue
        used = one.limit / one.number if one.item == "tipping" else one.factor * one.number / one.limit
        assert one.utilisation == pytest.approx(used, rel=1e-12), one.item
    bearing = item(excavator, "pin and lug, bearing")
    assert (bearing.number, bearing.limit) == (pytest.approx(28.70, abs=0.01), pytest.approx(825.0))
    assert "outer lugs" in bearing.formula
