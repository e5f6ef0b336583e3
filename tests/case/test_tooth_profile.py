"""Gaps between the teeth of a sprocket that follow from pitch, teeth and bush: every or every second one."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.case.parameters.closed_track import Tumbler
from exudyn_crawler.case.ph4100c import PITCH
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.model.forces.teeth import tooth

CHAIN = Case.closed().track
BUSH = 0.17 * PITCH
WHOLE = [(8, 1), (10, 1), (13, 1), (20, 1)]
HALF = [(19, 2), (21, 2), (23, 2), (27, 2)]


def sprocket(teeth, gaps_per_shoe, **changes):
    """Sprocket whose profile follows."""
    values = Case.closed().gear.tumbler.model_dump() | {"depth": None, "reach": None, "lug_radius": BUSH}
    return Tumbler(**(values | {"teeth": teeth, "gaps_per_shoe": gaps_per_shoe} | changes))


def profile_of(teeth, gaps_per_shoe):
    return sprocket(teeth, gaps_per_shoe).profile(CHAIN)


def test_pins_circle_of_a_half_pitch_sprocket_is_that_of_a_case_cx350b():
    """Its service manual: pitch 215.9 mm, 21 teeth, circle 732.5 mm, root 660.7 mm, tips 748 mm."""
    tumbler = sprocket(21, 2, lug_radius=0.0359)
    chain = CHAIN.with_(pitch=0.2159, pin_ahead=0.1, spherical_y=0.3, parallel_y=0.5)
    profile = tumbler.profile(chain)
    assert tumbler.shoes_per_turn == 10.5
    assert 2.0 * tumbler.radius(0.2159) == pytest.approx(0.7325, abs=5e-5)
    assert 2.0 * (profile.center - profile.arc) == pytest.approx(0.6607, abs=1e-4)
    assert 2.0 * profile.addendum == pytest.approx(0.748, abs=1e-4)


@pytest.mark.parametrize(("teeth", "gaps_per_shoe"), WHOLE + HALF)
def test_gap_seats_the_bush_ends_at_the_tips_and_leaves_a_tooth(teeth, gaps_per_shoe):
    tumbler = sprocket(teeth, gaps_per_shoe)
    profile = tumbler.profile(CHAIN)
    assert not list(tumbler.tooth_errors(CHAIN))
    radius = PITCH / (2.0 * math.sin(math.pi * gaps_per_shoe / teeth))
    for k in range(teeth):
        angle = 2.0 * math.pi * k / teeth
        place = radius * math.cos(angle), radius * math.sin(angle)
        assert tooth(profile, *place)[0] == pytest.approx(0.0, abs=1e-12)
    angle = 0.85 * (0.5 * math.pi - math.pi * gaps_per_shoe / teeth)
    assert profile.flank_angle == pytest.approx(angle, abs=1e-12)
    tip = profile.center - profile.arc * math.cos(angle) + profile.flank * math.sin(angle)
    assert math.hypot(tip, profile.half_width) == pytest.approx(profile.addendum, abs=1e-12)
    # a tooth of 0.09 pitches and more between the tips of two gaps
    left = 2.0 * (math.sin(math.pi / teeth) * profile.addendum - profile.half_width)
    assert left > 0.09 * PITCH


@pytest.mark.parametrize(("teeth", "gaps_per_shoe"), WHOLE + HALF)
def test_leaving_and_entering_bushes_are_free_of_undercut(teeth, gaps_per_shoe):
    """A shoe that turns about the pin in the next gap, away from its seat, meets no tooth."""
    profile = profile_of(teeth, gaps_per_shoe)
    radius = PITCH / (2.0 * math.sin(math.pi * gaps_per_shoe / teeth))
    turn = 2.0 * math.pi * gaps_per_shoe / teeth
    for side in (-1.0, 1.0):
        held = radius * np.array([math.cos(side * turn), math.sin(side * turn)])
        arm = np.array([radius, 0.0]) - held
        for angle in np.linspace(1e-4, turn, 200):
            c = math.cos(side * angle)
            s = math.sin(side * angle)
            place = held + np.array([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]])
            assert math.hypot(*place) > radius
            assert tooth(profile, *place)[0] < 1e-9


@pytest.mark.parametrize(("teeth", "gaps_per_shoe"), [(10, 1), (21, 2)])
def test_normal_of_straight_flanks_is_the_gradient_of_the_depth(teeth, gaps_per_shoe):
    """Depth and normal are continuous from arc to flank and from flank to corner."""
    profile = profile_of(teeth, gaps_per_shoe)
    rng = np.random.default_rng(1)
    compared = 0
    step = 1e-6
    while compared < 200:
        radius = rng.uniform(profile.center - profile.arc, profile.addendum + profile.lug)
        angle = rng.uniform(-math.pi, math.pi)
        place = np.array([radius * math.cos(angle), radius * math.sin(angle)])
        depth, nx, nz, _ = tooth(profile, *place)
        if not 1e-3 < depth < 0.05:
            continue
        above, below = (
            [tooth(profile, *(place + sign * e))[0] for e in step * np.eye(2)] for sign in (1, -1)
        )
        assert (np.array(above) - below) / (2.0 * step) == pytest.approx([-nx, -nz], abs=1e-4)
        compared += 1


def test_travel_a_turn_of_a_half_pitch_sprocket_is_half_of_its_teeth():
    tumbler = sprocket(21, 2, place=(-4.5, 1.0))
    gear = Case.closed().gear.model_copy(update={"tumbler": tumbler})
    assert 2.0 * math.pi * gear.travel_per_angle(CHAIN) == pytest.approx(10.5 * PITCH)


def test_sprockets_without_a_tooth_between_their_gaps_are_refused():
    """Arcs about centres beyond the pins' circle are too wide for every second gap."""
    tumbler = sprocket(21, 2, depth=0.2, reach=0.12)
    assert any("no tooth between them" in line for line in tumbler.tooth_errors(CHAIN))


def test_gaps_from_pin_to_pin_are_one_or_two():
    with pytest.raises(ParameterError, match="gaps_per_shoe"):
        sprocket(21, 3)


@pytest.mark.parametrize(("teeth", "gaps_per_shoe"), HALF)
def test_tooth_is_pointed_where_it_has_its_longest_reach(teeth, gaps_per_shoe):
    """Farther out gaps would overlap; a reach that leaves a tooth stays."""
    tumbler = sprocket(teeth, gaps_per_shoe, reach=0.4 * PITCH)
    longest = tumbler.longest_reach(CHAIN)
    assert longest < 0.4 * PITCH
    profile = tumbler.model_copy(update={"reach": longest}).profile(CHAIN)
    left = math.sin(math.pi / teeth) * profile.addendum - profile.half_width
    assert 0.0 <= left < 0.01 * PITCH
    short = tumbler.model_copy(update={"reach": 0.03 * PITCH})
    assert short.longest_reach(CHAIN) == pytest.approx(0.03 * PITCH)
