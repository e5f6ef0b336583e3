"""Parameters: the papers' values and what derives from them, and refusal of what cannot be."""

import copy
import math
import pickle
import tomllib
import traceback
from itertools import product

import numpy as np
import pytest

import fem
from exudyn_crawler import Case, CaseFile, Drive, LoadCycle, PairContact, StepProfile, run_case, simulate
from exudyn_crawler.case import FlexibleShoes, Phase, Shoe, Solver, Terrain, Track
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.results.life.duty import DutyRun
from exudyn_crawler.settings.fields import entry_at
from exudyn_crawler.settings.parameters import Parameters
from exudyn_crawler.sweep.answers import Answer
from exudyn_crawler.sweep.vary import Vary
from meshes import shoe_mesh

CASE = Case.translation()
POSITIVE = (
    *("shoe.mass", "shoe.com_height", "shoe.length", "shoe.width", "track.pitch", "track.pin_ahead"),
    *("terrain.unit_length", "terrain.unit_width", "terrain.unit_height", "terrain.density"),
    *("terrain.spring_stiffness", "contact.stiffness", "contact.damping_depth", "contact.edge_width"),
    *("contact.stiction_speed", "contact.friction_speed", "solver.step", "solver.minimum_step"),
    *("solver.residual", "solver.output_interval", "solver.spectral_radius"),
)
NOT_NEGATIVE = (
    *("terrain.spring_damping", "terrain.spring_offset", "contact.damping"),
    *("contact.static_friction", "contact.dynamic_friction"),
)


def refusal(make, *words):
    """Message of the refusal, which must contain all words."""
    with pytest.raises(ParameterError) as caught:
        make()
    message = str(caught.value)
    for word in words:
        assert word in message
    return message


@pytest.mark.parametrize(
    ("path", "value", "allowed"),
    [
        *product(POSITIVE, [0.0, -1.0], ["greater than"]),
        *product(POSITIVE + NOT_NEGATIVE, [math.nan, math.inf], ["finite number"]),
        *product(NOT_NEGATIVE, [-0.5], ["greater than or equal to 0"]),
        ("track.shoe_count", 1, "greater than or equal to 2"),
        ("terrain.columns", 0, "greater than or equal to 1"),
        ("terrain.rows", -3, "greater than or equal to 1"),
        ("terrain.springs_per_unit", 3, "1 or 2"),
        ("terrain.tilt", "yaw", "'pitch' or 'roll'"),
        ("contact.exponent", 0.9, "greater than or equal to 1"),
        ("solver.maximum_iterations", 1, "greater than or equal to 2"),
        ("solver.spectral_radius", 1.0, "less than 1"),
    ],
)
def test_what_is_out_of_its_range_is_refused(path, value, allowed):
    refusal(lambda: CASE.with_({path: value}), f"{path}: ", allowed, f"got {value!r}")


def test_what_must_not_be_negative_may_be_zero():
    zeros = dict.fromkeys(NOT_NEGATIVE, 0.0)
    assert {path: entry_at(CASE.with_(zeros), (*path.split("."),)).value for path in zeros} == zeros


def test_an_unknown_field_is_refused_and_one_that_is_nearly_right_is_named():
    refusal(lambda: Shoe.ph4100c().with_(weight=3.0), "weight: unknown key; ")
    with pytest.raises(ParameterError) as refused:
        Terrain.stress().with_(spring_stifness=1e7, columns=19)
    assert str(refused.value) == "spring_stifness: unknown key; did you mean spring_stiffness?"


@pytest.mark.parametrize(
    "text",
    [
        "[terrain]\ndensity = -1.0",
        "[terrain]\ndensty = 1.0\nrow = 3",
        "[contact]\nstiffness = nan\nradius = 1",
        '[contact]\nmodel = "hertz"',
        "[solver]\nstep = [1.0]",
        'gravty = 1\nformulation = "exudyn"',
        "[solver]\nstep = 1.0\nminimum_step = 2.0",
    ],
)
def test_faults_in_python_are_told_as_those_of_a_file(refused, text):
    """Also those of parts that are given as tables, with the whole path."""
    whole = {
        name: value if not isinstance(value, dict) else getattr(CASE, name).model_dump() | value
        for name, value in tomllib.loads(text).items()
    }
    with pytest.raises(ParameterError) as in_python:
        CASE.with_(**whole)
    assert in_python.value.errors == refused(f'base = "translation"\n{text}\n')


def test_what_is_missing_is_named_with_the_constructors_that_have_it():
    with pytest.raises(ParameterError) as refused:
        Terrain(origin=(0.0,))
    required = [name for name, field in Terrain.model_fields.items() if field.is_required()]
    lacking = f"{', '.join(required[:5])} and {len(required) - 5} more are missing"
    assert refused.value.errors == [
        "origin[1]: missing, got (0.0,)",
        f'{lacking}; give them, or start from "kinematics" or "stress"',
    ]


def test_a_part_of_another_class_is_refused():
    with pytest.raises(ParameterError) as refused:
        CASE.with_(terrain=Track.ph4100c(), contact=5)
    assert [one[: one.index(", got")] for one in refused.value.errors] == [
        "terrain: must be a table (Terrain or CellTerrain)",
        "contact: must be a table (PairContact or SphereContact or CellContact)",
    ]


def test_errors_of_parameters_are_value_errors_without_words_of_the_library():
    with pytest.raises(ValueError, match=r"^step: ") as refused:
        Solver(step="fast", residual=-1.0)
    assert len(str(refused.value).splitlines()) == 2
    shown = "".join(traceback.format_exception(refused.value))
    assert "pydantic.dev" not in shown
    assert "validation error" not in shown
    again = pickle.loads(pickle.dumps(refused.value))
    assert (type(again), again.errors) == (ParameterError, refused.value.errors)


def test_cases_are_copied_and_sent_as_they_are():
    case = Case.stress("coarse")
    assert pickle.loads(pickle.dumps(case)) == case
    assert copy.deepcopy(case) == case


@pytest.mark.parametrize("duration", ["a", None, 0.0, -1.0, math.nan, math.inf])
def test_a_duration_that_is_none_is_refused_before_anything_runs(duration):
    if isinstance(duration, float):
        told = f"duration must be positive and finite, got {duration!r} s"
        refusal(lambda: CaseFile(case=CASE, duration=duration), told)
    else:
        told = f"^duration must be a number in s, got {duration!r}$"
    with pytest.raises(ValueError, match=told):
        simulate(CASE, duration)


def test_what_is_no_case_is_answered_with_how_to_get_one():
    with pytest.raises(TypeError, match=r"^case must be a Case, .*, got 'translation'$"):
        simulate("translation", 1)
    with pytest.raises(TypeError, match=r"^case_file must be a CaseFile, .*\(path\), got Case\("):
        run_case(CASE)


@pytest.mark.parametrize("name", ["out", "reuse"])
def test_an_empty_path_is_no_folder(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=r"^out and reuse must name folders, or be none, got ''$"):
        run_case(CaseFile(case=CASE, duration=0.01), **{name: ""})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a\0b", "two\nlines"])
def test_names_that_no_table_can_show_are_refused(name):
    for make in (
        lambda: CASE.with_(name=name),
        lambda: Phase(name=name, end=0.0, loads=(4e5,)),
        lambda: DutyRun(name=name, folder="run", share=0.1),
        lambda: Vary(key="gravity", name=name, values=(9.8,)),
        lambda: Answer(quantity="joint_force", name=name),
    ):
        refusal(make, f"name: must be printable, got {name!r}")


def test_parameters_cannot_be_changed_in_place():
    shoe = Shoe.ph4100c()
    with pytest.raises(ValueError, match="frozen"):
        shoe.mass = 1.0
    assert shoe.with_(mass=1.0).mass == 1.0
    assert shoe.mass == 4681.67


def test_the_stress_studys_shoes_weigh_what_its_table_says():
    """Of the same shape as those of the rigid studies: the inertia goes with the mass."""
    light, shoe = Case.stress("coarse").shoe, Shoe.ph4100c()
    assert light.mass == 4489.63
    assert light.inertia_tensor / light.mass == pytest.approx(shoe.inertia_tensor / shoe.mass, rel=1e-12)
    refusal(lambda: shoe.of_mass(0.0), "mass")


PAIR, SHOE, FLEXIBLE = PairContact.oil_sand(), Shoe.kinematics(), FlexibleShoes.ph4100c("coarse")
PROFILE = StepProfile(times=(0.0, 5.0, 6.0), values=(0.0, 1.0, 2.0))
MOVING = StepProfile(times=(0.0, 1.0), values=(0.2, 0.3))


@pytest.mark.parametrize(
    ("values", "end"),
    [((0.0, 0.0, 0.0), 0.0), ((0.0, 1.0, 1.0), 5.0), ((0.0, 0.0, 1.0), 6.0), ((0.0, 1.0, 2.0), 6.0)],
)
def test_a_drive_starts_until_its_speed_is_constant(values, end):
    profile = PROFILE.with_(values=values)
    assert profile.first_constant == end
    assert Drive(speed=profile, turn_rate=StepProfile.constant(0.0)).start_ends == end
    assert Drive(speed=profile, turn_rate=PROFILE).start_ends == 6.0


@pytest.mark.parametrize(
    ("base", "changes", "told"),
    [
        (PAIR, {"dynamic_friction": 0.41}, "dynamic_friction must not exceed static_friction = 0.4 ... 0.41"),
        (PAIR, {"friction_speed": 0.01}, "friction_speed must exceed stiction_speed = 0.01, got 0.01"),
        (PAIR, {"friction_speed": 0.005}, "friction_speed must exceed stiction_speed = 0.01, got 0.005"),
        (SHOE, {"inertia": (1, 1, 3, 0, 0, 0)}, "inertia: must be ... principal moments [1.0, 1.0, 3.0]"),
        (SHOE, {"inertia": (1.0, 1.0, 1.0, 2.0, 0, 0)}, "inertia: must be"),
        (Track.ph4100c(), {"pin_ahead": 0.7}, "pin_ahead must be less than the pitch 0.655742, got 0.7"),
        (Solver(step=1e-3), {"minimum_step": 2e-3}, "minimum_step must not exceed step = 0.001, got 0.002"),
        (PROFILE, {"times": (0.0, 5.0, 5.0)}, "times must increase, got (0.0, 5.0, 5.0)"),
        (PROFILE, {"times": (0.0, 5.0, 4.0)}, "times must increase, got (0.0, 5.0, 4.0)"),
        (MOVING, {"times": (0.0, 5e-203)}, "times must increase"),
        (MOVING, {"times": (0.0, 1e200)}, "times[1]: must be less than"),
        (MOVING, {"values": (0.0,)}, "times and values must be equally many: 2 != 1"),
        (MOVING, {"times": (), "values": ()}, "times: must have at least 1 item"),
        (Drive.turning(), {"speed": MOVING}, "speed must start from zero at t = 0, got 0.2 at 0.0 s"),
        (Drive.turning(), {"turn_rate": MOVING}, "turn_rate must start from zero at t = 0, got 0.2 at 0.0 s"),
        (Drive.to_rest(), {"on": ((15.0, 0.0),)}, "on must be increasing times from 0 s"),
        (CASE, {"loads": LoadCycle.propel(12)}, "loads must name every shoe ... (13) ... got loads for 12"),
        (CASE, {"loads": LoadCycle.propel(14)}, "loads must name every shoe ... (13) ... got loads for 14"),
        (CASE, {"shoe.length": 0.7}, "shoe.length must not exceed the track's pitch 0.655742, got 0.7"),
        (CASE, {"terrain.columns": 2}, "terrain must carry the track ... at t = 0 s ... 0..14 m"),
        (CASE, {"terrain": Terrain.stress()}, "contact.normal must be 'face' on units of 1 x 1 m, smaller"),
        (SHOE, {"finger_length": 0.0}, "finger_length must be positive with finger_sides"),
        (SHOE, {"finger_length": 0.7}, "finger_length must be less than the length 0.655742 m, got 0.7"),
        (
            SHOE,
            {"finger_sides": (-1, 0.5, 0.4, 1)},
            "sides must be two values for each finger, rise from right to left",
        ),
        (SHOE, {"finger_sides": (-1.0, 0.5, 1.0)}, "finger_sides must be two values for each finger"),
        (SHOE, {"finger_sides": (-1.0, 1.8)}, "stay within the underside from -1.7525 to 1.7525 m"),
        (FLEXIBLE, {"shoes": (7, 7)}, "shoes: must be different and rise"),
        (FLEXIBLE, {"poissons_ratio": 0.5}, "poissons_ratio"),
        (CASE, {"flexible": FLEXIBLE.with_(shoes=(7, 14))}, "flexible.shoes must be in 1..13, got (7, 14)"),
        (CASE, {"flexible": FLEXIBLE, "terrain_formulation": "constrained"}, "'reduced'"),
    ],
)
def test_values_that_do_not_go_together_are_refused(base, changes, told):
    refusal(lambda: base.with_(changes), *told.split(" ... "))


def test_friction_may_be_alike_at_any_speed():
    assert PAIR.with_(dynamic_friction=0.4).dynamic_friction == 0.4


@pytest.mark.parametrize(
    ("phases", "told"),
    [
        ([("a", 15, (1, 2)), ("b", 15, (3, 4))], "the phases' ends must increase, got [15.0, 15.0]"),
        ([("a", 15, (1, 2)), ("b", 12, (3, 4))], "the phases' ends must increase, got [15.0, 12.0]"),
        ([("a", 0, (1, 2)), ("b", 1, (3,))], "a load for every shoe, got counts {'a': 2, 'b': 1}"),
        ([("a", 0, (1, 2)), ("a", 1, (3, 4))], "names must differ, got ['a', 'a']"),
        ([], "phases: must have at least 1 item"),
    ],
)
def test_load_cycles_with_unlike_phases_are_refused(phases, told):
    made = tuple(Phase(name=name, end=end, loads=loads) for name, end, loads in phases)
    refusal(lambda: LoadCycle(phases=made), told)


def test_a_drive_tells_when_it_is_on():
    drive = Drive.to_rest()
    assert drive.on == ((0.0, 15.0),)
    assert drive.switch_times == (15.0,)
    again = StepProfile(times=(0.0, 5.0, 10.0, 15.0, 20.0, 25.0), values=(0.0, 0.1, 0.1, 0.0, 0.0, 0.1))
    twice = drive.with_(speed=again, on=((0.0, 15.0), (20.0, 30.0)))
    assert twice.switch_times == (15.0, 20.0, 30.0)
    on = {0.0: True, 14.9: True, 15.0: False, 20.0: True, 30.0: False}
    assert {time: twice.drives_after(time) for time in on} == on
    assert [twice.off_since(time) for time in (10.0, 15.0, 19.0, 25.0, 33.0)] == [0.0, 0.0, 4.0, 0.0, 3.0]
    assert twice.travel(20.0) == twice.travel(15.0) == pytest.approx(0.25 + 0.5 + 0.25, rel=1e-12)
    assert twice.travel(40.0) - twice.travel(20.0) == pytest.approx(0.25 + 0.5, rel=1e-12)
    assert [twice.quiet_time(end) for end in (15.5, 18.0, 30.0, 40.0)] == [0.0, 2.0, 4.0, 13.0]
    assert Drive.translation().quiet_time(100.0) == 0.0
    assert Drive.translation().drives_after(1e9)
    assert Drive.translation().switch_times == ()
    assert Drive.translation().turn(10.0) == 0.0
    assert Drive.turning().turn(10.0) == pytest.approx(math.radians(7.5), rel=1e-12)


def test_flexible_shoes_are_had_where_there_are_some():
    assert Case.stress().part(FlexibleShoes).shoes == (6, 7, 8, 11, 12, 13)
    with pytest.raises(ValueError, match="flexible must be given, got 'turning' without it"):
        Case.turning().part(FlexibleShoes)


def test_a_drive_off_the_terrain_is_refused_before_anything_runs():
    first = Track.ph4100c().with_(first_com=(61.7, 9.2901))  # front edge at 69.884 of 70 m
    case = CASE.with_(track=first)
    told = r"over the whole drive: at t = 3\.\d+ s .* x = .*, the terrain 0\.\.70 m"
    with pytest.raises(ValueError, match=told):
        simulate(case, 6.0)


def test_units_and_their_places_are_those_of_the_papers():
    coarse, fine = Terrain.kinematics(), Terrain.stress()
    assert (coarse.unit_count, fine.unit_count) == (50, 247)
    assert coarse.unit_mass == pytest.approx(1.568e5, rel=1e-12)
    for unit, place in {1: (3.5, 3.5), 7: (10.5, 10.5), 12: (17.5, 10.5), 50: (66.5, 31.5)}.items():
        assert coarse.centers[unit - 1].tolist() == [*place, -1.0]
    assert np.diff(fine.bounds).ravel().tolist() == pytest.approx([19.0, 13.0])
    assert fine.unit_mass == pytest.approx(1600.0, rel=1e-12)
    assert fine.heave_stiffness == pytest.approx(20e6, rel=1e-12)  # E A / L


def test_springs_at_the_gauss_points_resist_pitch_like_an_even_support():
    terrain = Terrain.kinematics().with_(spring_offset=7.0 / math.sqrt(12.0))
    assert terrain.tilt_stiffness == pytest.approx(terrain.heave_stiffness * 7.0**2 / 12.0, rel=1e-12)


def test_coms_and_pins_lie_where_the_papers_print_them():
    track = Track.ph4100c()
    coms = track.com_positions(0.2025)
    # the papers round to 0.1 mm, and a pitch to 1 um that twelve shoes sum up
    assert coms[0].tolist() == [10.1291, 9.2901, 0.2025]
    assert coms[-1, 0] == pytest.approx(17.9980, abs=1e-4)
    last_pin = coms[-2] + track.front_pin
    assert last_pin == pytest.approx((17.6511, 8.68, 0.25), abs=1e-4)
    assert coms[-1] + track.rear_pin == pytest.approx(last_pin, abs=1e-12)


def test_the_load_is_an_even_share_of_the_machine_and_sinks_a_shoe_by_the_papers_depth():
    share = (630_185.0 * 9.81) / 16.0  # N on each of 16 shoes
    load = LoadCycle.propel().loads(0.0)[0]
    assert load == pytest.approx(np.full(13, 386.4e3), rel=1e-12)
    assert load[0] == pytest.approx(share, rel=1e-3)
    weight = load[0] + Shoe.ph4100c().mass * 9.81
    assert weight == pytest.approx(432.3e3, rel=1e-3)
    # the paper cuts 6.575 cm off to 6.57
    assert math.sqrt(weight / PairContact.oil_sand().stiffness) == pytest.approx(0.0657, abs=1e-4)


@pytest.mark.simulation
def test_a_shoe_has_mass_inertia_underside_and_top_of_the_solid():
    shoe, mesh = Shoe.ph4100c(), shoe_mesh("study")
    solid = fem.ElasticBody(mesh, fem.Material(200e9, 0.3, 7847.25))
    assert shoe.mass == pytest.approx(0.5966 * 7847.25, rel=1e-4)
    scaled = solid.inertia * shoe.mass / solid.mass
    assert np.diag(shoe.inertia_tensor) == pytest.approx(np.diag(scaled), rel=1e-3)
    assert np.abs(solid.center_of_mass).max() < 2e-3  # m, in axes whose origin is the papers' COM
    under = mesh.nodes[mesh.nodes_of("underside")]
    low, high = under.min(axis=0), under.max(axis=0)
    assert shoe.footprint[[0, 2, 4]] == pytest.approx(low, abs=1e-9)
    assert shoe.footprint[[1, 3]] == pytest.approx(high[:2], abs=1e-9)
    top = solid.surface_weights("top")
    assert shoe.load_point[2] == pytest.approx(top @ mesh.nodes[:, 2] / top.sum(), abs=1e-4)


def test_the_outline_follows_the_drive():
    assert CASE.outline(10.0) - CASE.outline(0.0) == pytest.approx(np.tile([0.75, 0.0], (4, 1)), abs=1e-12)
    along = np.diff(Case.turning().outline(10.0)[:2], axis=0)[0]
    assert math.degrees(math.atan2(along[1], along[0])) == pytest.approx(7.5, rel=1e-9)


def test_the_fingers_are_where_the_papers_volumes_have_them():
    shoe = Shoe.kinematics()
    rear = Track.ph4100c().com_positions(shoe.com_height)[6, 0] + shoe.footprint[0]
    # of shoe 7: with the drive's 0.1626 m at 4.1 s and 0.28 m at 5.3 s it leaves unit 7 at x = 14 m
    assert rear + shoe.finger_length + 0.1626 == pytest.approx(14.0, abs=2e-3)
    assert rear + 0.28 == pytest.approx(14.0, abs=2e-3)
    assert shoe.fingers.shape == (3, 2)


def test_an_uneven_shoe_has_its_underside_beside_com_and_load():
    even, uneven = Shoe.kinematics(), Shoe.uneven(0.2)
    assert uneven.footprint - even.footprint == pytest.approx([0.0, 0.0, -0.2, -0.2, 0.0])
    assert uneven.fingers - even.fingers == pytest.approx(-0.2)
    assert uneven.load_point == even.load_point
    assert Case.turning("uneven").shoe == Shoe.uneven()


def test_a_bound_of_a_parameter_is_given_once():
    """Of two of one kind the validation keeps one, and not the narrower one."""
    kinds, seen = [Parameters], set()
    while kinds:
        kinds += (kind := kinds.pop()).__subclasses__()
        for name, field in kind.model_fields.items():
            bounds = [type(one) for one in field.metadata]
            assert len(bounds) == len(set(bounds)), f"{kind.__name__}.{name}: {field.metadata}"
            seen.add(name)
    assert len(seen) > 200
    with pytest.raises(ParameterError, match=r"must be greater than or equal to 0\.001 s, got 1e-06"):
        CASE.with_({"solver.checkpoint_interval": 1e-6})
