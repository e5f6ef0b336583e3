"""Machines of the library in motion: straight and on the spot."""

import numpy as np
import pytest

from exudyn_crawler import read_case, simulate
from exudyn_crawler.case.datasheet.library import machines


@pytest.mark.slow
@pytest.mark.parametrize("name", machines())
def test_machines_of_the_library_travel_as_they_are_driven(name):
    case = read_case(machines()[name]).case
    history = simulate(case, 2.0, progress=False)
    way = history.side_frame_position.values[-1] - history.side_frame_position.values[0]
    # the sand shears by some centimetres before it bears, and the track takes its slack up
    missing = np.sign(case.drive.travel(2.0)) * (case.drive.travel(2.0) - way[0])
    assert -0.005 < missing < 0.04 + 0.1 * abs(case.drive.travel(2.0))
    assert abs(way[1]) < 0.01
    assert (history.quantity("link_tension").values > 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", machines())
def test_machines_of_the_library_turn_on_the_spot(name):
    case = read_case(machines()[name], ["datasheet.travel='on the spot'"]).case
    history = simulate(case, 2.0, progress=False)
    commanded = case.drive.turn_rate.integral(2.0)
    turned = history.side_frame_angles.values[-1, 2]
    # tracks slip as they turn the machine
    assert 0.3 * commanded < turned < commanded
    middle = history.side_frame_position.values
    assert np.abs(middle[-1, :2] - middle[0, :2]).max() < 0.1 * case.gear.car_body.track_distance
    right, left = history.drive_moment.values[-1]
    assert right > 0.0 > left
