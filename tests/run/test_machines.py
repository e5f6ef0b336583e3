"""Machines of the library in motion: straight and on the spot."""

import numpy as np
import pytest

from exudyn_crawler import read_case, simulate
from exudyn_crawler.case.datasheet.library import machines

OPEN = (
    "rolling resistance has the sign of the commanded speed, not of the rolling: it pushes a machine back as "
    "it starts (21 mm of the 4100C; none without resistance), and its surge lasts"
)


@pytest.mark.slow
@pytest.mark.xfail(reason=OPEN, strict=False)
@pytest.mark.parametrize("name", machines())
def test_machines_of_the_library_travel_as_they_are_driven(name):
    case = read_case(machines()[name]).case
    history = simulate(case, 2.0, progress=False)
    way = history.side_frame_position.values[-1] - history.side_frame_position.values[0]
    # what the track slips and takes up is missing
    assert way[0] == pytest.approx(case.drive.travel(2.0), rel=0.1)
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
