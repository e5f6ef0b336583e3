"""A closed track: its assembly by construction, and what is refused."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.case import SIDES, Drive, LoadCycle, MachineCycle, StepProfile, outline
from exudyn_crawler.case.parameters import assembly
from exudyn_crawler.case.parameters.closed_track import Tensioner
from exudyn_crawler.case.parameters.machine_cycle import Pose
from exudyn_crawler.case.ph4100c import MACHINE_MASS, PROPEL_END
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet.library import machines

CLOSED, SHOVEL = Case.closed(), Case.shovel()
RATES = {"speed": 0.3, "turn_rate": 0.05}
"""m/s and rad/s of a machine that turns as it goes."""


def start_of(case):
    """Return the start of a case's closed track."""
    return case.gear.assembled(case)


def openings(case):
    """By how much the front pin of every shoe is apart from the rear pin of the next one, m."""
    shoes, track = case.gear.shoe_reference(case), case.track
    turn, pitch = rotation_matrices(shoes[:, 3:]), case.gear.chain_pitch(track)
    front = shoes[:, :3] + turn @ [track.pin_ahead, 0.0, track.pin_height]
    rear = shoes[:, :3] + turn @ [track.pin_ahead - pitch, 0.0, track.pin_height]
    behind, ahead = case.gear.links(case.track).T - 1
    return np.linalg.norm(front[behind] - rear[ahead], axis=1)


@pytest.mark.parametrize("changes", [
    {},
    {"gear.idler.slack": 0.0},
    {"gear.idler.slack": 0.005},
    {"gear.idler.sag": 0.06},
    {"gear.idler.pretension": 500e3},
    {"gear.idler.take_up": 0.03},
    {"gear.pitch_growth": 0.01},
    {"gear.carriers": ()},
])  # fmt: skip
def test_chain_closes_to_rounding(changes):
    case = Case.closed().with_(changes)
    assert openings(case).max() < 1e-12
    # pitch falls by a turn round the loop, from a shoe that lies flat and has its given place
    angles = case.gear.shoe_reference(case)[:, 4]
    assert angles[0] == pytest.approx(0.0, abs=0.01)
    assert np.ptp(angles) == pytest.approx(2.0 * math.pi, abs=0.7)
    assert case.gear.shoe_reference(case)[0, 0] == pytest.approx(case.track.first_com[0], abs=1e-12)


TAUT = {"gear.idler.slack": 0.0}


def with_slides(**changes):
    """Slides where the carriers are, the first from the first to the second of them."""
    closed = Case.closed().gear
    (x, z), top = closed.carriers[0], closed.carriers[0][1] + closed.carrier_radius
    values = {"carriers": (), "slides": ((x, x + 1.8, top), (x + 3.6, x + 5.4, top))} | changes
    assert z < top
    return Case.closed().with_({f"gear.{name}": value for name, value in values.items()})


def test_slides_are_lines_that_do_not_turn_at_even_steps():
    """Between the outer lines the belt is that over carriers at the same places."""
    case = with_slides().with_(TAUT)
    closed, wheels = case.gear, case.gear.wheels(0.0)
    assert openings(case).max() < 1e-12
    assert start_of(case).take_up == pytest.approx(start_of(Case.closed().with_(TAUT)).take_up, abs=1e-12)
    first = [name.startswith("slide 1, line ") for name in case.gear.wheel_names]
    lines = wheels[first]
    assert lines[:, 0] == pytest.approx(np.linspace(-2.7, -0.9, 5))
    assert lines[:, 1] + lines[:, 2] == pytest.approx(closed.slides[0][2])
    assert np.unique(closed.resistances[first]) == closed.slide_friction
    assert set(closed.resistances) == {closed.slide_friction, closed.rolling_resistance}
    assert len(wheels) == len(case.gear.wheel_names) == len(closed.resistances)


def test_slides_that_rails_lie_on_three_lines_of_or_that_overlap_are_refused():
    with pytest.raises(ParameterError, match=r"must leave every rail, which is .* m long, on two"):
        with_slides(slide_step=0.2)
    with pytest.raises(ParameterError, match="slides must have a positive length and be in order"):
        with_slides(slides=((0.0, 1.0, 2.0), (0.5, 1.5, 2.0)))


@pytest.mark.parametrize("count", [37, 39])
def test_other_numbers_of_shoes_move_the_idler(count):
    case = Case.closed(count)
    assert openings(case).max() < 1e-12
    way = start_of(case).take_up - start_of(Case.closed()).take_up
    # both runs become longer by half of a shoe
    assert way == pytest.approx(0.5 * (count - 38) * case.track.pitch, rel=0.05)


def test_take_up_of_a_slack_chain_is_short_of_that_of_a_taut_one():
    taut = start_of(Case.closed().with_(TAUT))
    slack = start_of(Case.closed().with_({"gear.idler.slack": 0.01}))
    assert taut.sag == 0.0
    assert taut.take_up - slack.take_up == pytest.approx(0.01, abs=1e-12)
    assert slack.sag > 0.05


def test_pins_along_arcs_lines_and_a_sagging_one_are_a_pitch_apart():
    """Within a piece their places are by formulas, across its ends by a search."""
    wheels = [(0.0, 0.5, 0.6), (1.0, 0.0, 0.4), (6.0, 0.0, 0.4), (7.0, 0.5, 0.5), (3.5, 1.2, 0.2)]
    pieces = assembly.belt(wheels, sag=0.15)
    pitch = 0.21
    places = assembly.pins_along(pieces, pitch, 110)
    assert places == sorted(places)
    assert places[-1] > len(pieces) + 2.0  # round it and on
    points = np.array([assembly.point_at(pieces, place) for place in places])
    np.testing.assert_allclose(np.hypot(*np.diff(points, axis=0).T), pitch, rtol=0.0, atol=1e-14)
    # none is left out: chords are as long as the way along the belt, within 3 % on arcs and the sagging line
    ways = [assembly.surplus(pieces, pitch, count) for count in range(1, 111)]
    np.testing.assert_allclose(np.diff(ways), pitch, rtol=0.03)


def test_tension_at_rest_is_a_sag_or_a_pretension_or_a_place_of_the_idler():
    """Estimates of where it stands: twice the sag takes four times the slack, and pulls half as hard."""

    def stands_back(**idler):
        taut = start_of(Case.closed().with_(TAUT)).take_up
        changes = {f"gear.idler.{name}": value for name, value in idler.items()}
        return taut - start_of(Case.closed().with_(changes)).take_up

    assert stands_back(sag=0.06) == pytest.approx(4.0 * stands_back(sag=0.03), rel=1e-9)
    # makers' sag of the span between idler and carrier, 1.8 m
    assert stands_back() == pytest.approx(stands_back(sag=0.045), rel=1e-9)
    assert stands_back(pretension=2e5) > 2.0 * stands_back(pretension=4e5)
    weight = Case.closed().shoe.mass * 9.81 / Case.closed().track.pitch
    pull = weight * 1.8**2 / (8.0 * 0.06)
    even = pull - weight * Case.closed().gear.idler.radius
    assert stands_back(pretension=even) == pytest.approx(stands_back(sag=0.06), rel=1e-9)


def test_belt_about_two_equal_circles_has_its_length():
    pieces = assembly.belt([(0.0, 0.0, 1.0), (5.0, 0.0, 1.0)])
    assert sum(piece.length for piece in pieces) == pytest.approx(10.0 + 2.0 * math.pi, rel=1e-14)


def test_chain_that_does_not_fit_is_refused_with_the_missing_length():
    with pytest.raises(ParameterError, match=r"36 shoes.*too short by 0\.3743 m.*37 shoes fit"):
        Case.closed(36)
    with pytest.raises(ParameterError, match=r"40 shoes.*too long by 0\.6627 m.*38 shoes fit"):
        Case.closed(40)
    # what is named does fit
    Case.closed(37)
    Case.closed(38)


@pytest.mark.parametrize(
    ("case", "changes", "message"),
    [
        (CLOSED, {"gear.tumbler.reach": 0.199}, "leaving lugs hook under it"),
        (CLOSED, {"gear.tumbler.reach": 0.5}, "must let the addendum circle"),
        (CLOSED, {"shoe.rails": None}, "shoe.rails must be given with gear.kind 'closed'"),
        (CLOSED, {"gear.rollers": (0.0, 0.5)}, "rollers must be in order and at least a diameter"),
        (CLOSED, {"gear.idler.range": (0.2, 0.1)}, "least and greatest take-up in this order"),
        (CLOSED, {"loads.phases[0].loads": tuple([1e5] * 38)}, "loads must be zero"),
        (CLOSED, {"gear.idler.take_up": 0.3}, "too short by"),
        (CLOSED, {"gear.idler.sag": 0.5}, r"has no idler\.sag of 0\.5 m.*2\.5 % of the span, 0\.045 m"),
        (
            CLOSED,
            {"gear.idler.take_up": 0.03, "gear.idler.sag": 0.04},
            "sag and take_up must not be given together",
        ),
        (
            CLOSED,
            {
                "gear.idler.tensioner": Tensioner(mass=8e3, stiffness=2e8, preload=3e7),
                "gear.idler.pretension": 4e5,
            },
            "pretension must be none with a tensioner",
        ),
        (
            CLOSED,
            {"gear.fold_limit": 0.6},
            "fold_limit must be greater than 2 pi / teeth = 0.6283 rad",
        ),
        (
            CLOSED,
            {"drive": Drive.turning()},
            "drive.turn_rate must be none with gear.kind 'closed': one track",
        ),
        (
            SHOVEL,
            {"track.shoe_count": 75, "loads": LoadCycle.constant([0.0] * 75)},
            "track.shoe_count must be even",
        ),
        (SHOVEL, {"track.shoe_count": 72, "loads": LoadCycle.constant([0.0] * 72)}, "a chain of 36 shoes"),
        (SHOVEL, {"gear.support": "posts"}, "gear.support must be 'ground' with gear.kind 'machine'"),
    ],
)
def test_what_does_not_go_with_one_or_two_closed_tracks_is_refused(case, changes, message):
    with pytest.raises(ParameterError, match=message):
        case.with_(changes)


def test_case_file_with_base_closed(read, refused):
    found = read('base = "closed"\nduration = 1.0\n[gear]\nsupport = "posts"\n').case
    assert found == Case.closed().with_({"gear.support": "posts"})
    (fault,) = refused('base = "closed"\n[gear.tumbler]\nteeth = 12\n')
    assert "mm within the chain about the others" in fault


def test_travel_of_the_chain_is_that_of_its_pitches():
    case = Case.closed()
    radius = case.gear.tumbler.radius(case.track.pitch)
    travel = case.gear.travel_per_angle(case.track)
    # a polygon's side is shorter than its arc: 0.9836 of the radius at 10 gaps
    assert travel / radius == pytest.approx(math.sin(math.pi / 10) / (math.pi / 10), rel=1e-12)


def test_machine_has_two_closed_loops_side_by_side_and_its_parts_weigh_what_it_weighs():
    case = Case.shovel()
    assert openings(case).max() < 1e-12
    right, left = case.gear.shoe_reference(case).reshape(2, 38, 6)
    apart = [0.0, case.gear.car_body.gauge, 0.0, 0.0, 0.0, 0.0]
    assert left - right == pytest.approx(np.tile(apart, (38, 1)))
    assert case.gear.frame_start(case)[1] == pytest.approx(0.5 * (right + left)[0, 1])
    assert case.gear.links(case.track)[[37, 75]].tolist() == [[38, 1], [76, 39]]
    assert case.gear.wheel_names[0] == "right roller 1"
    mass = sum(part.mass for part in case.gear.frame_parts)
    assert mass + 76 * case.shoe.mass + 2 * case.gear.tumbler.mass == pytest.approx(MACHINE_MASS)


def test_upper_structure_takes_its_weight_and_inertia_along_as_it_slews():
    body = Case.shovel().gear.car_body
    com, inertia = body.upper_at(0.5 * math.pi)
    ahead, straight = body.upper_at(0.0)
    assert com == pytest.approx([0.0, ahead[0], ahead[2]])
    assert np.diag(inertia) == pytest.approx(straight[[1, 0, 2], [1, 0, 2]])


def test_machine_goes_where_it_heads():
    """At a constant rate of turn the middle of its tracks goes along an arc."""
    speeds = {name: StepProfile(times=(0.0, 1e-3), values=(0.0, value)) for name, value in RATES.items()}
    case = Case.shovel().with_(drive=Drive(**speeds))
    way = case.outline(20.0).mean(axis=0) - case.outline(0.0).mean(axis=0)
    radius, angle = RATES["speed"] / RATES["turn_rate"], 20.0 * RATES["turn_rate"]
    assert way == pytest.approx([radius * math.sin(angle), radius * (1.0 - math.cos(angle))], abs=0.01)
    case.check_support(20.0)
    with pytest.raises(ValueError, match="terrain must carry the track"):
        case.check_support(200.0)


def test_chain_is_assembled_once_for_all_times_of_a_drive(monkeypatch):
    """Sweeps check thousands of cases, and each drive at a hundred times."""
    calls = []
    place = type(CLOSED.gear).shoe_reference
    monkeypatch.setattr(
        type(CLOSED.gear), "shoe_reference", lambda *parts: calls.append(parts) or place(*parts)
    )
    CLOSED.check_support(5.0)
    assert len(calls) == 1


@pytest.mark.parametrize("case", [CLOSED, SHOVEL, Case.rolled(), Case.turning(), Case.stress()])
def test_outlines_of_many_times_are_those_of_each(case):
    times = np.array([0.0, 0.3, 7.0, 22.0])
    each = [case.outline(time) for time in times]
    # to the rounding of lengths up to 21 m: numpy before 2.3 rounds arrays and single numbers differently
    np.testing.assert_allclose(outline.outlines(case, times), each, rtol=0.0, atol=1e-14)


def test_slewing_upper_structure_moves_the_weight_of_the_machine():
    case = Case.shovel()
    weight = case.gear.car_body.upper_mass * case.gravity
    pose = Pose("dump", 5.0, 0.5 * math.pi, reach=15.0, height=9.0, payload=9e4)
    (phase,) = MachineCycle.slewing(case.gear.car_body, [pose]).phases
    assert phase.force == pytest.approx([0.0, 0.0, -9e4 * case.gravity])
    # from 1 m behind the axis to 1 m beside it, and a payload 15 m to the left
    assert phase.moment == pytest.approx([weight - 15.0 * 9e4 * case.gravity, weight, 0.0])
    assert case.with_(machine=MachineCycle.slewing()).machine is not None
    far = MachineCycle.slewing(case.gear.car_body, [pose._replace(payload=6e5)])
    with pytest.raises(ParameterError, match=r"beside the middle of the track, more than 4\.648 m"):
        case.with_(machine=far)


def test_a_machine_of_half_the_size_digs_with_an_eighth_of_the_force():
    body = Case.shovel().gear.car_body
    whole = MachineCycle.slewing(body).phases[1:]
    digs = MachineCycle.digging(body).phases
    assert [phase.end + PROPEL_END for phase in digs] == pytest.approx([phase.end for phase in whole])
    smaller = body.with_(
        upper_mass=body.upper_mass / 8.0, upper_com=tuple(0.5 * place for place in body.upper_com)
    )
    for large, same, small in zip(whole, digs, MachineCycle.digging(smaller).phases, strict=True):
        assert (same.force, same.moment) == (pytest.approx(large.force), pytest.approx(large.moment))
        assert small.force == pytest.approx([force / 8.0 for force in large.force])
        assert small.moment == pytest.approx([moment / 16.0 for moment in large.moment])


@pytest.fixture(scope="module")
def m113():
    """One track of a machine on arms, whose chain just closes."""
    case = read_case(machines()["m113"]).case.of_track(SIDES[0])
    return case.with_({"gear.idler.pretension": None, "gear.idler.slack": 0.0})


def with_take_up(case, take_up):
    return case.with_({"gear.idler.take_up": take_up, "gear.idler.slack": None})


@pytest.mark.parametrize("further", [0.01, 0.03])
def test_frame_on_arms_sinks_for_a_chain_that_is_too_short(m113, further):
    """Its shoes lie as flat as before; wheels turn up about their pivots by what the frame sinks."""
    assert start_of(m113).sunk == 0.0
    assert not m113.gear.arm_reference(m113)[:, 3:].any()
    tight = with_take_up(m113, start_of(m113).take_up + further)
    sunk = start_of(tight).sunk
    assert further < sunk < 0.2
    assert openings(tight).max() < 1e-12
    assert m113.gear.frame_start(m113)[2] - tight.gear.frame_start(tight)[2] == pytest.approx(sunk, abs=1e-12)
    lowest = [case.gear.shoe_reference(case)[:, 2].min() for case in (m113, tight)]
    assert lowest[1] == pytest.approx(lowest[0], abs=1e-12)
    reference = tight.gear.arm_reference(tight)
    turns = rotation_matrices(reference[:, 3:])
    for start, turn, arm in zip(reference, turns, tight.gear.arms, strict=True):
        (x, z), roller = arm.pivot, tight.gear.rollers[arm.roller - 1]
        wheel = start[:3] + turn @ [roller - x, 0.0, -z]
        assert wheel[2] == pytest.approx(tight.gear.frame_start(tight)[2] + sunk, abs=1e-12)


def test_chain_that_no_arm_gives_way_enough_for_is_refused(m113):
    words = r"too short by [\d.]+ m with a take-up of 0.3 m and arms that give way by [\d.]+ m"
    with pytest.raises(ParameterError, match=words):
        with_take_up(m113, 0.3)
    with pytest.raises(ParameterError, match=r"too short by [\d.]+ m with a take-up of 0.3 m and a sag"):
        with_take_up(m113.with_({"gear.arms": ()}), 0.3)
