"""When the drive moves the front shoe, and how far the track travels with it."""

import pytest

from exudyn_crawler import Case, Drive, StepProfile
from exudyn_crawler.errors import ParameterError


def driven(*windows):
    speed = StepProfile(times=(0.0, 0.05, 0.1, 0.15, 0.2), values=(0.0, 0.01, 0.0, 0.0, 0.02))
    return Case.translation().with_(drive=Drive(speed=speed, on=windows))


def test_the_drive_takes_up_a_shoe_at_rest_only():
    with pytest.raises(ParameterError, match=r"speed must be zero where the drive goes on, at 0.05 s"):
        driven((0.05, 0.1))
    with pytest.raises(ParameterError, match="on must be times from 0 s that increase"):
        driven((0.1, 0.0))


def test_the_track_travels_only_while_driven():
    case = driven((0.0, 0.05))
    assert case.outline(0.2)[0, 0] - case.outline(0.0)[0, 0] == pytest.approx(0.05 * 0.01 / 2)
