"""A machine on two closed tracks: straight it is one track twice, on the spot it turns."""

import numpy as np
import pytest

from exudyn_crawler import Case, StepProfile, simulate
from exudyn_crawler.case import CarBody, Drive, LoadCycle
from exudyn_crawler.ground.cells.laws.rock import RockFloor

pytestmark = [pytest.mark.simulation, pytest.mark.slow]


PINS = 0.7
"""m, of the pins' middles beside that of the shoe."""


def twice(case):
    """Two of a closed track, whose side frames have the machine between them."""
    com, tensor = case.closed_track.com, (1e3, 1e3, 1e3, 0.0, 0.0, 0.0)
    body = CarBody(
        track_distance=9.0,
        mass=1e3,
        inertia=tensor,
        com=com,
        upper_mass=1e3,
        upper_inertia=tensor,
        upper_com=com,
    )
    return case.with_(
        {"track.shoe_count": 76, "closed_track.mass": case.closed_track.mass - 1e3},
        loads=LoadCycle.constant([0.0] * 76),
        car_body=body,
    )


def test_straight_each_of_two_tracks_is_a_single_one():
    """On rock, which moves under neither of them for the other."""
    drive = Drive(speed=StepProfile(times=(0.0, 0.2), values=(0.0, 0.2)))
    # cells lie evenly about the middle of each track
    places = {"track.first_com[1]": 9.3, "track.spherical_y": 9.3 - PINS, "track.parallel_y": 9.3 + PINS}
    case = Case.closed().with_({"terrain.rows": 6, **places}, drive=drive)
    one, two = (
        simulate(each.on_cells(RockFloor.hard_floor()), 0.2, progress=False) for each in (case, twice(case))
    )
    single, tension = one.link_tension.values, two.link_tension.values.reshape(-1, 2, 38)
    scale = single.max()
    assert np.abs(tension[:, 0] - tension[:, 1]).max() < 1e-7 * scale
    # the small bodies between them change the pitching inertia
    assert np.abs(tension[:, 0] - single).max() < 1e-5 * scale
    torque = two.drive_moment.sel(track="left").values
    assert torque == pytest.approx(one.drive_moment.values, abs=1e-5 * torque.max())
    assert np.abs(two.side_frame_angles.values[:, [0, 2]]).max() < 1e-9
