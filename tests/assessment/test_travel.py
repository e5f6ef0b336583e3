"""Travel: resistance, grades and turns against hand calculations and closed forms."""

import numpy as np
import pytest

from exudyn_crawler.assessment import chain, travel
from exudyn_crawler.assessment.pressure import Footprints

SLIPS = {0.8: 0.145, 1.0: 0.201, 1.2: 0.261, 1.4: 0.326, 1.6: 0.393, 1.8: 0.462}
MOMENTS = {0.8: 0.955, 1.0: 0.927, 1.2: 0.894, 1.4: 0.856, 1.6: 0.817, 1.8: 0.778}
PULLS = {0.8: 0.382, 1.0: 0.463, 1.2: 0.536, 1.4: 0.599, 1.6: 0.654, 1.8: 0.700}
"""Of turns on the spot by L / B, worked out apart from the program."""


@pytest.mark.parametrize("ratio", SLIPS)
def test_turn_of_lines(ratio):
    found = travel.turn_of_lines(1.0, ratio, 1.0, 1.0)
    assert found.slip == pytest.approx(SLIPS[ratio], abs=5e-4)
    assert found.moment / (0.25 * ratio) == pytest.approx(MOMENTS[ratio], abs=6e-4)
    assert found.pull / 0.5 == pytest.approx(PULLS[ratio], abs=6e-4)


def test_turn_of_narrow_footprints_is_that_of_lines():
    lines = travel.turn_of_lines(14e6, 7.8, 9.3, 0.3)
    narrow = travel.turn_of_footprints(14e6, Footprints(9.3, 7.8, 0.01), 0.3)
    assert narrow.moment == pytest.approx(lines.moment, rel=1e-4)
    assert narrow.slip == pytest.approx(lines.slip, rel=1e-3)
    wide = travel.turn_of_footprints(14e6, Footprints(9.3, 7.8, 3.5), 0.3)
    assert 1.05 * lines.moment < wide.moment < 1.15 * lines.moment


def test_a_turn_with_the_weight_off_the_middle():
    """The pole goes to the middle of the pressure, where half of the load is on either side of it."""
    footprint = Footprints(9.3, 7.8, 0.01)
    even = travel.turn_of_footprints(14e6, footprint, 0.3)
    off = travel.turn_of_footprints(14e6, footprint, 0.3, ahead=1.0)
    # trapezoid p ~ 1 + 12 e x / L^2: its median by the quadratic equation
    slope = 12.0 / 7.8**2
    x = (-1.0 + np.sqrt(1.0 + slope**2 * 3.9**2)) / slope
    assert off.pole == pytest.approx(x, rel=0.02)
    assert off.moment < even.moment


def test_a_light_track_limits_the_turn():
    """By what it bears: mu V (1/2 - y / B)."""
    footprint = Footprints(9.3, 7.8, 0.01)
    lighter = 0.3 * 14e6 * (0.5 - 3.0 / 9.3)
    assert 0.98 * lighter < travel.turn_of_footprints(14e6, footprint, 0.3, aside=3.0).pull < lighter
    with pytest.raises(ValueError, match=r"lighter track slips at 6\.774e\+04"):
        travel.turn_of_footprints(14e6, footprint, 0.3, aside=4.5)


def test_cohesion_adds_to_the_friction_of_a_turn():
    """Even pressure p with c = 0.1 p turns as hard as friction that is greater by 0.1."""
    footprint = Footprints(9.3, 7.8, 3.5)
    cohesion = 0.1 * 14e6 / footprint.area
    with_it = travel.turn_of_footprints(14e6, footprint, 0.3, cohesion=cohesion)
    assert with_it.pull == pytest.approx(travel.turn_of_footprints(14e6, footprint, 0.4).pull, rel=1e-6)


def test_straight_and_uphill():
    """10 % grade, f = 0.05, 2 kN of each chain (idler, pins), sinkage in 5 m2: b p^2 / k of p = k z."""
    slope = np.arctan(0.1)
    footprints = Footprints(3.0, 5.0, 0.5)
    law = travel.Compaction(0.0, 1e6, 1.0)
    sinks = travel.TravelResistance(0.05, 1.5e3, 0.5e3, footprints, law)
    firm = sinks._replace(compaction=None)
    by_hand = 1e6 * (0.1 + 0.05) / np.hypot(1.0, 0.1) + 4e3
    assert firm.on_grade(1e6, slope) == pytest.approx(by_hand)
    pressure = 1e6 * np.cos(slope) / 5.0
    assert sinks.on_grade(1e6, slope) == pytest.approx(by_hand + 0.5 * pressure**2 / 1e6)
    for resistance in (firm, sinks):
        needed = resistance.on_grade(1e6, slope)
        assert travel.greatest_slope(resistance, 1e6, lambda _, pull=needed: pull) == pytest.approx(slope)
        assert travel.greatest_slope(resistance, 1e6, lambda _: 2e6) == 0.5 * np.pi
        assert travel.greatest_slope(resistance, 1e6, lambda _: 5e4) == 0.0
    ground = travel.greatest_slope(firm._replace(idler=0.0, pins=0.0), 1e6, lambda load: 0.5 * load)
    assert np.tan(ground) == pytest.approx(0.45)


def test_ends_by_what_is_less():
    assert travel.ends_by(1.0, 2.0, 3.0) == "goes"
    assert travel.ends_by(4.0, 2.0, 3.0) == "stalls"
    assert travel.ends_by(4.0, 3.0, 2.0) == "slips"


def test_traction_and_sinkage():
    assert travel.traction(1e6, 0.5, 2e3, 10.0) == pytest.approx(0.52e6)
    # 2 b k z^2 / 2 with p = k z: b p^2 / k
    assert travel.sinkage_resistance(1e5, travel.Compaction(0.0, 1e6, 1.0), 0.5) == pytest.approx(
        0.5 * 1e10 / 1e6
    )


def test_drive_by_hand():
    """10 teeth of 0.655742 m: 1.0437 m a radian; 1 MN m pulls 0.862 MN at 0.9."""
    radius = 10 * 0.655742 / (2.0 * np.pi)
    assert travel.TrackDrive(1e6, radius, 0.9).pull == pytest.approx(0.9e6 / 1.04365, rel=1e-5)


def test_a_blocked_track():
    found = travel.blocked_track(3e6, 0.5e6, 2e6, 9.3)
    assert found == (3.5e6, 9.3e6, 7e6, 2e6)


def test_tension():
    """70 kN/m over 1.8 m with 45 mm of sag, and m v2 of 1 t/m at 2 m/s."""
    weight = 70e3
    tension = chain.tension_of_sag(weight, 1.8, 0.045)
    assert tension == pytest.approx(70e3 * 3.24 / 0.36)
    assert chain.tension_of_sag(weight, 1.8, 0.045, 0.6) == pytest.approx(4.0 / 9.0 * tension)
    found = chain.travel_tension(1e6, -2e6, mass=1000.0, speed=2.0)
    assert found == (1e6, pytest.approx(3.004e6), pytest.approx(1.004e6))
    assert chain.end_roller_push(1e6, 0.3, 0.4) == pytest.approx(0.6e6)
