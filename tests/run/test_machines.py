"""Machines of the library in motion: straight and on the spot."""

import numpy as np
import pytest

from exudyn_crawler import read_case, simulate
from exudyn_crawler.machines.datasheet.library import machines

LEAST_WAY = 0.5
"""m."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.simulation,
    # military ones are faster than others, of which such numbers are more likely in km/h and deg/s
    pytest.mark.filterwarnings("ignore:drive.speed. -2 m/s is outside"),
    pytest.mark.filterwarnings("ignore:drive.turn_rate. 1"),
]


@pytest.mark.parametrize("name", machines())
def test_machines_of_the_library_travel_as_they_are_driven(name):
    case = read_case(machines()[name]).case
    # slower ones take longer: what the chain takes up at the start, and a surge, are centimetres on any way
    duration = 2.0 if abs(case.drive.travel(2.0)) > LEAST_WAY else 6.0
    assert abs(case.drive.travel(duration)) > LEAST_WAY
    history = simulate(case, duration, progress=False)
    ways = history.side_frame_position.values - history.side_frame_position.values[0]
    way = ways[-1]
    # treads and ground are elastic; nothing pushes a machine back as it starts
    assert (np.sign(way[0]) * ways[:, 0] > -1e-4).all()
    # what the track slips and takes up is missing
    assert way[0] == pytest.approx(case.drive.travel(duration), rel=0.1)
    assert abs(way[1]) < 0.01
    assert (history.quantity("link_tension").values > 0.0).all()


@pytest.mark.parametrize("name", machines())
def test_machines_of_the_library_turn_on_the_spot(name):
    case = read_case(machines()[name], ["datasheet.travel='on the spot'"]).case
    history = simulate(case, 2.0, progress=False)
    commanded = case.drive.turn_rate.integral(2.0)
    turned = history.side_frame_angles.values[-1, 2]
    # tracks slip as they turn the machine
    assert 0.3 * commanded < turned < commanded
    middle = history.side_frame_position.values
    assert np.abs(middle[-1, :2] - middle[0, :2]).max() < 0.1 * case.gear.car_body.gauge
    right, left = history.drive_moment.values[-1]
    assert right > 0.0 > left
