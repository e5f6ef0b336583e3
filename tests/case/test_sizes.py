"""What fits in size: refused, or warned of, with the right bound."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.case.parameters import sizes
from exudyn_crawler.case.parameters.checks import implausible
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines import read_case

CLOSED = Case.closed()
SHOVEL = Case.shovel()
TUMBLER = CLOSED.gear.tumbler


@pytest.mark.parametrize(
    ("case", "changes", "message"),
    [
        (
            SHOVEL,
            {"track.spherical_y": 8680.0},
            r"track\.spherical_y must lie within .* from 7\.538 to 11\.04",
        ),
        (CLOSED, {"shoe.width": 0.9}, r"track\.spherical_y must lie within the shoe's width of 0\.9 m"),
        (Case.translation(), {"track.parallel_y": 11.3}, r"track\.parallel_y must lie within"),
        (CLOSED, {"track.pin_height": -0.3}, r"pin_height must be above the shoe's underside at -0\.2025 m"),
        (
            SHOVEL,
            {"gear.car_body.gauge": 2.8},
            r"gauge must be at least the shoes' width of 3\.505",
        ),
        (
            CLOSED,
            {"gear.rollers": (-4.4, 0.0, 4.4)},
            "tumbler and roller 1 must not overlap, they do by 728 mm",
        ),
        (
            CLOSED,
            {"gear.rollers": (-2.0, 0.0, 3.6)},
            r"roller 3 and idler must not overlap, they do by \d+ mm",
        ),
        (
            Case.translation(),
            {"terrain.spring_offset": 3.6},
            r"spring_offset must be at most 3\.5 m, half of a unit's side of 7 m",
        ),
    ],
)
def test_what_does_not_fit_in_size_is_refused(case, changes, message):
    with pytest.raises(ParameterError, match=message):
        case.with_(changes)


@pytest.mark.parametrize(
    ("case", "changes", "words"),
    [
        (CLOSED, {"gear.tumbler.mass": 2.5e3}, "Iyy is 11260 kg m2, more than the 6974 of 2.5 t"),
        (CLOSED, {"shoe.mass": 1000.0}, "shoe.inertia: Ixx is 3996 kg m2, more than the 3501 of 1 t"),
        (CLOSED, {"gear.tumbler.mass": 2e5}, "tumbler.inertia: Ixx + Iyy + Izz is 2.477e+04 kg m2"),
        (
            CLOSED,
            {"gear.mass": 15e3},
            "gear.inertia: it gives a radius of gyration of 25.9 m",
        ),
        (
            SHOVEL,
            {"gear.car_body.upper_mass": 1e4},
            "upper structure.inertia: it gives a radius of gyration of 52.4",
        ),
        (
            CLOSED,
            {"gear.tumbler.pitch_radius": 0.9},
            "its pitch, 2 pitch_radius sin(pi / teeth), is 0.5562 m, the chain's 0.6557 m",
        ),
        (
            CLOSED,
            {"gear.tumbler.pitch_radius": 1.061, "gear.tumbler.teeth": 9},
            "is 0.7258 m, the chain's 0.6557 m",
        ),
        (CLOSED, {"shoe.rails.left": 0.0003}, "the middle between them is 0.12 m beside that of the shoe"),
        (CLOSED, {"shoe.rails.rear": -0.0003}, "they leave a gap of 0.351 m, into which rollers of"),
        (Case.rolled(), {"shoe.rails.rear": -0.0003}, "they leave a gap of 0.351 m, into which rollers of"),
    ],
)
def test_what_hardly_fits_in_size_is_warned_of(case, changes, words):
    lines = list(implausible(case.with_(changes)))
    assert words in lines[0]
    assert {line.split(":")[0] for line in lines} == {lines[0].split(":")[0]}


@pytest.mark.parametrize("case", [CLOSED, SHOVEL, Case.rolled(), Case.translation(), Case.stress()])
def test_shipped_cases_fit(case):
    assert list(implausible(case)) == []


def test_second_machine_fits():
    assert list(implausible(read_case("studies/m113.toml").case)) == []


def test_worn_chain_on_a_tumbler_of_its_pitch_fits():
    worn = CLOSED.with_({"gear.pitch_growth": 0.02})
    assert list(implausible(worn)) == []
    radius = worn.gear.chain_pitch(worn.track) / (2.0 * math.sin(math.pi / TUMBLER.teeth))
    assert list(implausible(worn.with_({"gear.tumbler.pitch_radius": radius}))) == []


def test_ball_of_steel_has_the_least_inertia():
    mass = 1000.0
    radius = (0.75 * mass / (math.pi * sizes.DENSEST)) ** (1.0 / 3.0)
    ball = 0.4 * mass * radius**2
    assert not list(sizes.thin_inertia("ball", mass, (1.001 * ball,) * 3 + (0.0,) * 3))
    assert list(sizes.thin_inertia("ball", mass, (0.999 * ball,) * 3 + (0.0,) * 3))


def test_mass_at_the_corners_of_its_extent_has_the_greatest_inertia():
    reach = np.array([1.0, 2.0, 3.0])
    corners = 5.0 * (np.sum(reach**2) - reach**2)
    assert not list(sizes.wide_inertia("body", 5.0, (*corners, 0.0, 0.0, 0.0), reach))
    assert len(list(sizes.wide_inertia("body", 5.0, (*1.01 * corners, 0.0, 0.0, 0.0), reach))) == 3


def test_teeth_that_do_not_do_are_refused_with_values_that_do():
    with pytest.raises(
        ParameterError, match=r"hook under it; reach = 0\.1424 m or depth = 0\.2649 m would do"
    ):
        CLOSED.with_({"gear.tumbler.reach": 0.199})
    CLOSED.with_({"gear.tumbler.reach": 0.1424})
    CLOSED.with_({"gear.tumbler.reach": 0.199, "gear.tumbler.depth": 0.2649})
    with pytest.raises(ParameterError, match=r"meet the arcs .*, got 0\.5; reach = 0\.1423 m would do"):
        CLOSED.with_({"gear.tumbler.reach": 0.5})
    with pytest.raises(ParameterError, match=r"gaps overlap .*; backlash = 0\.0998 m would do"):
        CLOSED.with_({"gear.tumbler.backlash": 0.2})
    CLOSED.with_({"gear.tumbler.backlash": 0.0998})


def test_wheel_within_the_chain_is_named_with_the_height_that_fits():
    carriers = list(CLOSED.gear.carriers)
    carriers[0] = (carriers[0][0], 1.24)
    with pytest.raises(ParameterError, match=r"carrier 1 at .* lies 38 mm within .* at z = 1\.278 m"):
        CLOSED.with_({"gear.carriers": tuple(carriers)})
    carriers[0] = (carriers[0][0], 1.279)
    CLOSED.with_({"gear.carriers": tuple(carriers)})
    teeth = {"gear.tumbler.teeth": 12}
    with pytest.raises(ParameterError, match=r"roller 1 .* 43 mm within .* tumbler\.place at z = 0\.6908 m"):
        CLOSED.with_(teeth)
