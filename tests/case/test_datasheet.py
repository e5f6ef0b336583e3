"""Machines from datasheets: the library, what follows, where values come from, and what is refused."""

import re

import numpy as np
import pytest

from exudyn_crawler.errors import CaseFileError, ParameterError
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet import figures, library
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.discrepancies import datasheet_discrepancies, implausible_values
from exudyn_crawler.machines.datasheet.ledger import case_ledger, sheet_ledger
from exudyn_crawler.machines.datasheet.library import machines
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.settings import fields

PC300 = {
    "operating_weight": 35371.0,
    "gauge": 2.59,
    "length_on_ground": 4.03,
    "crawler_length": 4.955,
    "shoe_width": 0.8,
    "shoes": 48,
}


@pytest.fixture
def written(tmp_path):
    """Write a case file with a datasheet, and give its path."""

    def write(text):
        path = tmp_path / "mine.toml"
        path.write_text(text)
        return path

    return write


SHORT = """
duration = 2.0
[datasheet]
operating_weight = "35.371 t"
gauge = "2590 mm"
length_on_ground = "4.03 m"
crawler_length = "4955 mm"
shoe_width = "800 mm"
shoes = 48
"""


@pytest.mark.parametrize("name", library.machines())
def test_machines_of_the_library_have_their_weight_pressure_and_length(name):
    case_file = read_case(library.machines()[name])
    case, sheet = case_file.case, case_file.datasheet
    assert sheet.source
    assert figures.machine_mass(case) == pytest.approx(sheet.operating_weight, rel=1e-3)
    if sheet.ground_pressure is not None:
        assert figures.mean_pressure(case, sheet) == pytest.approx(sheet.ground_pressure, rel=0.03)
    on_ground, over_shoes = figures.lengths(case, sheet)
    if sheet.length_on_ground is not None:
        assert on_ground == pytest.approx(sheet.length_on_ground, rel=0.01)
    if sheet.crawler_length is not None:
        assert over_shoes == pytest.approx(sheet.crawler_length, rel=0.05)
    if sheet.shoes is not None:
        assert case.gear.loop(case.track).shoe_count == sheet.shoes


def test_pitch_of_a_komatsu_pc300lc_follows_and_is_that_of_its_chain():
    case = derived(Datasheet(**PC300, grouser_height=0.036)).case
    assert case.track.pitch == pytest.approx(0.2159, rel=1e-3)
    assert case.track.shoe_count == 96
    # known of this chain: 10.5 shoes a turn
    assert (case.gear.tumbler.teeth, case.gear.tumbler.gaps_per_shoe) == (21, 2)


def test_parts_weigh_what_the_datasheet_says_and_com_is_where_it_says():
    case = derived(Datasheet(**PC300, upper_weight=16e3, com_ahead=-0.3)).case
    parts = case.gear.frame_parts
    assert parts[3].mass == 16e3
    moment = sum(part.mass * part.com[0] for part in parts)
    # shoes and sprockets are even about the middle but for the sprockets, at the rear
    assert moment / 35371.0 == pytest.approx(-0.3, abs=1e-9)


def test_sprocket_in_front_turns_the_machine_round():
    rear, front = (
        derived(Datasheet(**PC300, com_ahead=-0.3, sprocket=end)).case for end in ("rear", "front")
    )
    assert front.gear.car_body.upper_com[0] == -rear.gear.car_body.upper_com[0]
    assert front.drive.speed.values[-1] == -rear.drive.speed.values[-1]


@pytest.mark.parametrize(
    ("kind", "pins"), [("excavator", "greased"), ("dozer", "sealed"), ("shovel", "ideal")]
)
def test_pins_are_those_of_the_kind_of_machine_and_marked_assumed(kind, pins):
    machine = derived(Datasheet(**(PC300 | {"kind": kind, "speed": 0.5})))
    case = machine.case
    assert case.track.pin.kind == pins
    # a tenth of the rate at which the sprocket turns
    assert case.track.pin.friction_rate == pytest.approx(
        0.05 / case.gear.tumbler.radius(case.track.pitch), rel=0.02
    )
    entry = next(entry for entry in machine.ledger if entry.path == "track.pin.kind")
    assert entry.value == pins
    assert entry.origin == "assumed"


def test_states_of_fast_chains_are_stored_often_enough_for_peaks_of_links():
    case = derived(Datasheet(**(PC300 | {"speed": 0.5}))).case
    assert case.solver.output_interval == pytest.approx(0.01, rel=0.05)
    fast = derived(Datasheet(**(PC300 | {"speed": 3.0}))).case
    assert fast.solver.output_interval == pytest.approx(fast.track.pitch / 60.0, rel=0.15)


def test_bushes_are_about_the_front_pins_of_chains_that_have_bushes():
    case = derived(Datasheet(**PC300)).case
    assert case.gear.tumbler.lugs == ((case.track.pin_ahead, case.track.pin_height),)
    assert derived(Datasheet(**(PC300 | {"kind": "shovel"}))).case.gear.tumbler.lugs == ()


def test_tension_asked_for_is_that_of_the_idler():
    assert derived(Datasheet(**PC300, sag=0.02)).case.gear.idler.sag == 0.02
    assert derived(Datasheet(**PC300, chain_tension=5e4)).case.gear.idler.pretension == 5e4


def test_turning_on_the_spot_moves_tracks_against_each_other_at_the_speed_asked_for():
    drive = derived(Datasheet(**PC300, travel="on the spot", speed=0.5)).case.drive
    assert drive.turn_rate.values[-1] * 0.5 * 2.59 == pytest.approx(0.5)
    assert max(drive.speed.values) == 0.0


@pytest.mark.parametrize(
    ("changes", "grade"),
    [
        ({}, 0.2),
        ({"sprocket": "front"}, -0.2),
        ({"travel": "backward"}, -0.2),
        ({"travel": "on the spot"}, 0.2),
    ],
)
def test_a_grade_goes_uphill_as_the_machine_travels(changes, grade):
    case = derived(Datasheet(**PC300, grade=0.2, **changes)).case
    assert case.terrain.grade == grade
    assert case.drive.speed.values[-1] * grade >= 0.0


def test_case_file_with_a_datasheet_has_units_in_words_and_changes_of_what_follows(written):
    path = written(
        SHORT + '[gear]\nrolling_resistance = 0.05\n[drive]\nspeed = {times=[0, 1], values=[0, "2 km/h"]}\n'
    )
    case_file = read_case(path)
    assert case_file.datasheet == Datasheet(**PC300)
    assert case_file.case.gear.rolling_resistance == 0.05
    assert case_file.case.drive.speed.values[-1] == pytest.approx(2.0 / 3.6)
    assert case_file.case.track == derived(Datasheet(**PC300)).case.track
    narrow = read_case(path, ["datasheet.shoe_width='600 mm'"])
    assert narrow.case.shoe.width == 0.6


def test_file_of_a_library_machine_with_another_shoe(written):
    case_file = read_case(written('duration = 1.0\n[datasheet]\nbase = "pc300lc"\nshoe_width = "700 mm"\n'))
    assert case_file.case.shoe.width == 0.7
    assert case_file.case.gear.car_body.gauge == 2.59


def test_every_value_says_where_it_comes_from(written):
    case_file = read_case(written(SHORT + "[gear]\nrolling_resistance = 0.05\n"))
    rows = case_ledger(case_file)
    assert {row.path for row in rows} == {entry.path for entry in fields.values_of(case_file.case)}
    assert rows["shoe.width"].origin == "given"
    assert rows["gear.rolling_resistance"].origin == "given"
    assert rows["gear.rolling_resistance"].how == "the file"
    assert rows["track.pitch"].origin == "derived"
    assert "closes" in rows["track.pitch"].how
    assert rows["gear.roller_radius"].origin == "assumed"
    assert "remembered" in rows["gear.roller_radius"].how
    assert rows["gravity"].origin == "assumed"
    assert rows["drive.speed"].origin == "assumed"
    assert rows["drive.speed"].how == "slow_travel, no faster than travel_speed; reached in 1 s"
    assert "LETE sand" in rows["contact.law.k_phi"].how
    assert rows["track.first_com"].origin == "derived"
    assert "root of the pitch" in rows["solver.step"].how


def test_speed_of_a_run_is_derived_where_the_datasheet_asks_for_it(written):
    case_file = read_case(written(SHORT + 'speed = "2 km/h"\ntravel = "on the spot"\n'))
    rows = case_ledger(case_file)
    assert rows["drive.turn_rate"].origin == "derived"
    assert rows["drive.turn_rate"].how == "speed of the datasheet; reached in 1 s"
    assert "the machine stays" in rows["drive.speed"].how


def test_values_that_no_file_has_are_not_shown_as_given(written):
    case_file = read_case(written(SHORT))
    keys = {row.path for row in sheet_ledger(case_file.datasheet) if row.origin == "given"}
    assert "datasheet.length_on_ground" in keys
    assert "datasheet.bogies" not in keys


def test_values_that_were_not_seen_are_shown_as_assumed(written):
    case_file = read_case(written(SHORT + 'remembered = ["gauge"]\n'))
    rows = case_ledger(case_file)
    assert rows["gear.car_body.gauge"].origin == "assumed"
    assert rows["shoe.width"].origin == "given"


def test_typical_values_can_be_given():
    sheet = Datasheet(**PC300, typical={"roller_diameter": 0.78})
    case = derived(sheet).case
    assert case.gear.roller_radius == pytest.approx(0.39 * case.track.pitch)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"shoes": 55, "pitch": 0.29, "length_on_ground": 7.6, "crawler_length": None},
            "55 shoes of 290 mm are 2.3 m too short for a length on ground of 7.6 m; 63 fit, or a pitch",
        ),
        (
            {"shoes": 40, "pitch": 0.2159},
            r"40 shoes of 215.9 mm are 1.7 m too short for a length on ground of 4.03 m and 4.96 m over the "
            r"shoes; 48 fit, or a pitch of 259.2 mm",
        ),
        ({"lower_rollers": 25}, r"25 lower rollers do not fit beside each other .*: \d+ of 177 mm do"),
        ({"shoe_weight": 400.0}, r"96 shoes of 400 kg with sprockets weigh 38.8 t, which leaves"),
        ({"sag": 0.25}, r"a sag of 250 mm lets the idler back into the wheel next to it; \d+ mm do"),
        ({"gauge": 0.7}, r"gauge must be greater than shoe_width, .* got 0.7 m with shoes of 0.8 m"),
        ({"gauge": None}, "gauge or width_over_shoes must be given"),
        ({"motor_speed": 200.0}, "gear_ratio must be given with motor_speed"),
        ({"sag": 0.02, "chain_tension": 1e4}, "sag and chain_tension must not be given together"),
        ({"remembered": ("gage",)}, r"remembered must contain keys of the datasheet, got \['gage'\]"),
    ],
)
def test_what_contradicts_itself_is_refused_in_the_datasheets_words(changes, words):
    with pytest.raises(ParameterError, match=words) as refusal:
        derived(Datasheet(**(PC300 | changes)))
    *odd, line = str(refusal.value).splitlines()
    assert re.search(words, line)
    assert all("is outside of" in other for other in odd)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('base = "closed"\n' + SHORT, "base must be left out beside a datasheet"),
        ('[datasheet]\nbase = "pc30"\n', "no 'pc30'; did you mean 'pc300lc'?"),
        ('datasheet = "pc300lc"\n', "datasheet must be a table"),
        (SHORT + 'weight = "3 t"\n', "datasheet.weight"),
        (SHORT + 'pitch = "3 kg"\n', "datasheet.pitch"),
    ],
)
def test_files_with_wrong_datasheets_are_refused_by_name(written, text, words):
    with pytest.raises(CaseFileError, match=words):
        read_case(written(text))


def test_wheels_of_a_derived_machine_carry_the_chain_evenly():
    case = derived(Datasheet(**PC300)).case
    gear = case.gear
    gaps = np.diff(gear.rollers)
    assert gaps == pytest.approx(gaps[0])
    assert gaps[0] > 2.0 * gear.roller_radius
    # the chain closes where the datasheet has its idler: within what its slack takes
    assert abs(case.gear.assembled(case).take_up) < 0.1 * case.track.pitch


def test_bogies_carry_two_rollers_each_from_the_front_and_are_part_of_the_weight():
    sheet = Datasheet(**PC300, lower_rollers=7, bogies=3)
    case = derived(sheet).case
    assert [bogie.rollers for bogie in case.gear.bogies] == [(2, 3), (4, 5), (6, 7)]
    for bogie in case.gear.bogies:
        rear, front = (case.gear.rollers[number - 1] for number in bogie.rollers)
        assert bogie.pivot[0] == pytest.approx(0.5 * (rear + front))
    assert figures.machine_mass(case) == pytest.approx(35371.0)
    assert len(derived(sheet.with_(lower_rollers=None, bogies=5)).case.gear.rollers) == 10
    with pytest.raises(ParameterError, match="4 bogies take 8 lower rollers, a track has 7: 3 bogies do"):
        derived(sheet.with_(bogies=4))


@pytest.mark.parametrize(
    ("kind", "gaps", "built"),
    [
        ("excavator", None, (21, 2)),
        ("dozer", 13.5, (27, 2)),
        ("excavator", 11.0, (11, 1)),
        ("vehicle", 12.0, (12, 1)),
        ("crane", 10.7, (21, 2)),
    ],
)
def test_sprockets_of_half_gaps_have_an_odd_number_of_teeth(kind, gaps, built):
    values = PC300 | {"kind": kind, "sprocket_gaps": gaps, "crawler_length": None}
    tumbler = derived(Datasheet(**values, suspension="rigid")).case.gear.tumbler
    assert (tumbler.teeth, tumbler.gaps_per_shoe) == built


def test_idlers_of_excavators_give_way_on_a_spring_of_half_the_weight():
    gear = derived(Datasheet(**PC300)).case.gear
    recoil = gear.idler.recoil
    assert recoil.preload == pytest.approx(0.5 * 35371.0 * 9.81)
    assert recoil.stiffness == pytest.approx(recoil.preload / (0.64 * 0.2159), rel=1e-2)
    assert figures.machine_mass(derived(Datasheet(**PC300)).case) == pytest.approx(35371.0)
    assert derived(Datasheet(**PC300, recoil_force=1e5)).case.gear.idler.recoil.preload == 1e5
    assert derived(Datasheet(**PC300, recoil_spring=False)).case.gear.idler.recoil is None
    assert derived(Datasheet(**PC300 | {"kind": "crane"})).case.gear.idler.recoil is None


M113 = {
    "kind": "vehicle",
    "operating_weight": 11400.0,
    "gauge": 2.159,
    "length_on_ground": 2.667,
    "sprocket_to_idler": 3.83,
    "sprocket_height": 0.58,
    "idler_height": 0.46,
    "first_roller": 0.655,
    "roller_diameter": 0.61,
    "idler_diameter": 0.51,
    "lower_rollers": 5,
    "carrier_rollers": 0,
    "shoe_width": 0.38,
    "shoes": 63,
    "pitch": 0.154,
    "shoe_weight": 18.02,
    "sprocket_gaps": 10,
}


@pytest.mark.parametrize("sprocket", ["rear", "front"])
def test_road_wheels_of_a_vehicle_trail_on_arms_that_bear_an_even_share(sprocket):
    arm = {"arm_pivot": (0.288, 0.134), "torsion_bar": 2.5e4, "arm_weight": 110.8}
    case = derived(Datasheet(**M113, **arm, sprocket=sprocket)).case
    gear = case.gear
    assert [arm.roller for arm in gear.arms] == [1, 2, 3, 4, 5]
    # the machine goes towards its sprocket in front, or its idler
    ahead = 1.0 if sprocket == "rear" else -1.0
    for arm, roller in zip(gear.arms, gear.rollers, strict=True):
        assert arm.pivot == pytest.approx((roller + 0.288 * ahead, 0.134))
    # moments of 10 arms carry all but the shoes below the wheels
    on_ground = 2.0 * (1.0 + 2.667 / 0.154) * 18.02
    carried = sum(2.0 * (arm.torque / 9.81 / 0.288 + 0.34 * arm.mass) for arm in gear.arms)
    assert carried == pytest.approx(11400.0 - on_ground, rel=1e-9)
    assert figures.machine_mass(case) == pytest.approx(11400.0)
    assert not derived(Datasheet(**M113, suspension="rigid")).case.gear.arms


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"torsion_bar": 1e4}, "torsion_bar must be left out, or suspension must be 'arms'"),
        ({"suspension": "arms", "arm_pivot": (0.0, 0.1)}, "arm_pivot must be ahead of the wheel's axis or"),
        (
            {"suspension": "arms", "lower_rollers": 6, "bogies": 2},
            "2 bogies must be left out with suspension",
        ),
        ({"recoil_spring": False, "recoil_force": 1e5}, "recoil_force must be left out with recoil_spring"),
    ],
)
def test_suspensions_that_contradict_themselves_are_refused(changes, words):
    with pytest.raises(ParameterError, match=words):
        derived(Datasheet(**(PC300 | changes)))


@pytest.mark.parametrize(
    "lengths",
    [
        {"length_on_ground": 4.03},
        {"crawler_length": 4.955},
        {"ground_pressure": 50e3},
        {"contact_area": 6.95},
        {"crawler_length": 4.955, "ground_pressure": 50e3},
    ],
    ids=" ".join,
)
def test_pitch_of_a_number_of_shoes_follows_from_any_length(lengths):
    """Of a Komatsu PC300LC-8, within what 10.5 gaps and typical shoes leave open."""
    values = {name: value for name, value in PC300.items() if "length" not in name} | lengths
    case = derived(Datasheet(**values)).case
    assert case.gear.loop(case.track).shoe_count == 48
    assert case.track.pitch == pytest.approx(0.2159, rel=0.02)


def test_pitch_by_mass_that_leaves_no_sprocket_gives_way_to_the_lengths():
    """Of a machine whose ends are short for its weight."""
    values = PC300 | {"operating_weight": 90e3, "shoes": None}
    case = derived(Datasheet(**values)).case
    assert case.track.pitch == pytest.approx(0.2159, rel=0.02)
    assert case.gear.tumbler.shoes_per_turn == 10.5


def test_a_printed_contact_area_is_that_of_the_machine_that_follows():
    """Of a dozer of 71.6 t with 48 560 cm2 under shoes of 610 mm: its length on ground is 3.98 m."""
    values = {"kind": "dozer", "operating_weight": 71640.0, "gauge": 2.5, "shoe_width": 0.61}
    sheet = Datasheet(**values, shoes=41, contact_area=4.856)
    case = derived(sheet).case
    assert figures.contact_area(case, sheet) == pytest.approx(4.856, rel=0.01)
    assert figures.lengths(case, sheet)[0] == pytest.approx(0.5 * 4.856 / 0.61, rel=0.01)
    assert figures.mean_pressure(case, sheet) == pytest.approx(71640.0 * case.gravity / 4.856, rel=0.01)
    (figure,) = [figure for figure in figures.figures(case, sheet) if figure.name == "contact area"]
    # the pitch follows from it
    assert figure.verdict == figures.MADE
    sheet = sheet.with_(length_on_ground=3.98)
    built = figures.figures(derived(sheet).case, sheet)
    assert next(figure.verdict for figure in built if figure.name == "contact area") == "agrees"


def test_speed_and_pull_are_those_of_the_motors_by_their_gears():
    """A motor of 1900 rpm and 800 N m by 52 to 1 gives a sprocket 3.83 rad/s and 41.6 kN m."""
    motor = {"motor_speed": 1900.0 * 2.0 * np.pi / 60.0, "motor_torque": 800.0, "gear_ratio": 52.0}
    sheet = Datasheet(**PC300, **motor, travel_speed=5.0 / 3.6)
    case = derived(sheet).case
    radius = 10.5 * case.track.pitch / (2.0 * np.pi)
    built = {figure.name: figure for figure in figures.figures(case, sheet)}
    assert built["speed by the motors"].value == pytest.approx(motor["motor_speed"] / 52.0 * radius)
    assert built["speed by the motors"].verdict == "agrees"
    # as rules have it: 0.925 of a sprocket's torque pulls
    pull = 2.0 * 0.925 * 800.0 * 52.0 / radius
    assert built["drawbar pull by the motors"].value == pytest.approx(pull)
    assert case.gear.torque_limit == pytest.approx(800.0 * 52.0)
    printed = sheet.with_(drawbar_pull=1.2 * pull)
    built = {figure.name: figure for figure in figures.figures(derived(printed).case, printed)}
    assert built["drawbar pull by the motors"].verdict == "differs by -16.7 %"


def test_an_unknown_figure_is_refused_with_the_command_that_lists_all(written):
    with pytest.raises(CaseFileError, match=r"boom: unknown key; allowed .* exudyn-crawler machine --keys"):
        read_case(written(SHORT + 'boom = "3 t"\n'))


def test_idler_makes_up_for_a_printed_sprocket():
    """Of a dozer with 41 shoes of 318 mm, 13.5 a turn, on 4.444 m: its idler is smaller than the sprocket."""
    values = {"kind": "dozer", "operating_weight": 112.7e3, "gauge": 2.896, "shoe_width": 0.71}
    values |= {"length_on_ground": 4.444, "pitch": 0.318, "shoes": 41, "sprocket_gaps": 13.5}
    gear = derived(Datasheet(**values)).case.gear
    assert gear.tumbler.shoes_per_turn == 13.5
    assert gear.idler.radius + 0.35 * 0.318 < 0.95 * gear.tumbler.radius(0.318)


@pytest.mark.parametrize(
    ("line", "name", "value"),
    [
        ('drawbar_pull = "20570 kg"', "drawbar_pull", 20570 * 9.80665),
        ('ground_pressure = "0.51 kg/cm2"', "ground_pressure", 0.51 * 98066.5),
        ('gradeability = "35 deg"', "gradeability", 0.70021),
        ('gradeability = "70 %"', "gradeability", 0.7),
        ('power = "260 PS"', "power", 260 * 735.49875),
        ('contact_area = "69 400 cm2"', "contact_area", 6.94),
        ('ground_clearance = "1 250.5 mm"', "ground_clearance", 1.2505),
        ('upper_weight = "15\'900 kg"', "upper_weight", 15900.0),
    ],
)
def test_units_are_taken_as_makers_print_them(written, line, name, value):
    assert getattr(read_case(written(SHORT + line)).datasheet, name) == pytest.approx(value, rel=1e-5)


@pytest.mark.parametrize(
    "line", ['gradeability = "35 kg"', 'ground_pressure = "3 kg"', 'drawbar_pull = "3 m"']
)
def test_other_units_are_refused(written, line):
    with pytest.raises(CaseFileError, match=f"datasheet.{line.split()[0]}: must be a number"):
        read_case(written(SHORT + line))


SHORT_M113 = {
    name: M113[name]
    for name in ("kind", "operating_weight", "gauge", "length_on_ground", "shoe_width", "shoes", "pitch")
}


@pytest.mark.parametrize(
    ("left_out", "by_pressure"),
    [
        (None, False),
        ("shoes", False),
        ("pitch", False),
        ("length_on_ground", True),
        ("length_on_ground", False),
    ],
)
def test_running_gear_of_a_vehicle_follows_where_its_datasheet_leaves_it_out(left_out, by_pressure):
    """Of an M113 by eight figures: road wheels, sprocket and idler stand within a tenth of their places."""
    values = {name: value for name, value in SHORT_M113.items() if name != left_out}
    if by_pressure:
        values["ground_pressure"] = 11400.0 * 9.81 / (2.0 * 0.38 * 2.667)
    case = derived(Datasheet(**values)).case
    gear = case.gear
    assert case.gear.loop(case.track).shoe_count == pytest.approx(63, abs=3)
    assert case.track.pitch == pytest.approx(0.154, rel=0.1)
    assert len(gear.rollers) == 5
    assert gear.rollers[-1] - gear.rollers[0] == pytest.approx(2.667, rel=0.1)
    assert gear.idler.place[0] - gear.tumbler.place[0] == pytest.approx(3.83 + 0.13, rel=0.1)
    # what is left for the idler's take-up is the sag
    assert abs(case.gear.assembled(case).take_up) < 0.02


def test_a_vehicles_chain_that_closes_nowhere_is_refused_with_shoes_that_do():
    words = "40 shoes of 154 mm do not close about 5 road wheels on 2.67 m of ground .*: 5. to 7. do"
    with pytest.raises(ParameterError, match=words):
        derived(Datasheet(**SHORT_M113 | {"shoes": 40}))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"drawbar_pull": 264.0},
            "datasheet.drawbar_pull: 264 N is outside of 104.1 to 485.8 kN of an excavator of 35.37 t",
        ),
        ({"drawbar_pull": 2.64e3}, "datasheet.drawbar_pull: 2.64 kN is outside of 104.1 to 485.8 kN"),
        (
            {"recoil_force": 2e6},
            "datasheet.recoil_force: 2 MN is outside of 17.35 to 694 kN of an excavator of 35.37 t",
        ),
        ({"contact_area": 69.4}, "datasheet.contact_area: 69.4 m2 is not the area of both tracks, width by"),
        (
            {"ground_pressure": 2.5e5},
            "datasheet.ground_pressure: 250 kPa is not the mean pressure, weight over both tracks is",
        ),
        (
            {"travel_speed": 50.0},
            "datasheet.travel_speed: 50 m/s is outside of 0.25 to 2.2 m/s of an excavator",
        ),
    ],
)
def test_figures_of_no_machine_are_told_by_the_datasheets_keys(changes, words):
    sheet = read_case(machines()["pc300lc"]).datasheet
    assert next(iter(datasheet_discrepancies(sheet.with_(**changes)))).startswith(words)


def test_a_mini_excavator_is_plausible(written):
    """Of 1.7 t by eight figures: its shoes weigh less than any that a file would have by mistake in t."""
    mini = """
    [datasheet]
    operating_weight = "1735 kg"
    width_over_shoes = "1240 mm"
    shoe_width = "230 mm"
    length_on_ground = "1230 mm"
    crawler_length = "1590 mm"
    """
    assert list(implausible_values(read_case(written(mini)))) == []
    assert any(
        line.startswith("shoe.mass: 3 kg")
        for line in implausible_values(read_case(written(f"{mini}[shoe]\nmass = 3.0\n")))
    )


def test_a_dozer_with_an_elevated_sprocket_is_told_to_be_built_low():
    """Of 66 t with 44 shoes of 281 mm on 3.885 m, which go up to the sprocket."""
    values = {"kind": "dozer", "operating_weight": 66.5e3, "gauge": 2.55, "shoe_width": 0.61, "pitch": 0.281}
    sheet = Datasheet(**values, length_on_ground=3.885, shoes=44)
    (line,) = datasheet_discrepancies(sheet)
    assert line.startswith("datasheet: sprocket_gaps that follows: 16.")
    assert "is the sprocket elevated?" in line
    assert list(datasheet_discrepancies(sheet.with_(shoes=41))) == []


def test_tanks_with_short_shoes_are_built():
    """Of 97 shoes of 137 mm: 42 pitches from sprocket to idler."""
    values = {"kind": "vehicle", "operating_weight": 41.5e3, "gauge": 2.79, "length_on_ground": 4.27}
    case = derived(Datasheet(**values, shoe_width=0.58, shoes=97, pitch=0.137, lower_rollers=6)).case
    assert case.gear.rollers[-1] - case.gear.rollers[0] == pytest.approx(4.27)


@pytest.mark.parametrize("name", machines())
def test_figures_of_the_librarys_machines_are_plausible(name):
    assert list(implausible_values(read_case(machines()[name]))) == []
