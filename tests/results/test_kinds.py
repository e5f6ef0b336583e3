"""Kinds of actions and their places: one table, of which readers' words are made."""

from typing import get_args

import pytest

from exudyn_crawler import Case
from exudyn_crawler.case.gear.base import WheelKind, WheelLabel
from exudyn_crawler.case.parameters.track import MIDWAY
from exudyn_crawler.results.loads.actions import ON_RAILS
from exudyn_crawler.results.loads.kinds import Kind
from exudyn_crawler.results.loads.locations import (
    PINS,
    GroundUnit,
    OnTread,
    Pin,
    PinsOfShoe,
    Point,
    words,
)

SLIDE = WheelLabel("slide", 1, line=2)


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        (Pin("front", "right"), "front right"),
        (Pin("rear", MIDWAY), "rear middle"),
        (GroundUnit(12), "unit 12"),
        (Point.CELLS, "cells"),
        (OnTread(WheelLabel("roller", 3), "left"), "roller 3 left"),
        (OnTread(WheelLabel("idler", track="right"), "left", flange=True), "flange of right idler left"),
        (OnTread(SLIDE, "right"), "slide 1, line 2 right"),
        (PinsOfShoe(4), "pins of shoe 4"),
    ],
)
def test_words_of_a_place_name_body_number_and_side(place, expected):
    assert words(place) == expected


def test_pins_are_the_joint_centers_of_a_track():
    assert list(PINS) == list(Case.translation().track.joint_centers)


def test_every_kind_of_wheel_presses_with_a_kind_of_its_own():
    assert set(ON_RAILS) == set(get_args(WheelKind))
    assert [kind.gear for kind in ON_RAILS.values()] == ["wheel"] * len(ON_RAILS)
    assert len(set(ON_RAILS.values())) == len(ON_RAILS)


def test_loads_that_act_for_the_same_cause_are_one_share():
    assert Kind.CHAIN.load == Kind.DRIVE.load == "drive"
    assert Kind("joint").load == "pins"
