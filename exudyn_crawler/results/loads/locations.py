"""Places of actions on a shoe or a side frame, as data, and their words in tables."""

from enum import StrEnum
from typing import Literal, NamedTuple

from exudyn_crawler.case import SIDES
from exudyn_crawler.case.gear.base import WheelLabel

End = Literal["front", "rear"]
ENDS: tuple[End, End] = ("front", "rear")


class Point(StrEnum):
    """Point of a body, or the ground as a whole, by its words in tables."""

    CENTER = "COM"
    ORIGIN = "origin"
    TOP = "top"
    CELLS = "cells"
    FRAME = "frame"
    COM_NODE = "com node"
    FRONT_PINS = "front pins"
    DRAWBAR = "drawbar"


class Pin(NamedTuple):
    """Pin of a shoe, or the middle of both pins of an end."""

    end: End
    side: str  # a word of `SIDES`, or `MIDWAY`


class GroundUnit(NamedTuple):
    """Unit of the ground below a shoe."""

    number: int


class OnTread(NamedTuple):
    """Tread of a wheel on one of the rails, or the flange beside it."""

    wheel: WheelLabel
    side: str
    flange: bool = False


class PinsOfShoe(NamedTuple):
    """Front pins of a shoe, as the place of an action on the side frame."""

    shoe: int


Location = Point | Pin | GroundUnit | OnTread | PinsOfShoe


def words(place: Location) -> str:
    """Return the words of a place in tables, such as "front right" or "flange of roller 3 left"."""
    match place:
        case Point():
            return place.value
        case Pin(end, side):
            return f"{end} {side}"
        case GroundUnit(number):
            return f"unit {number}"
        case OnTread(wheel, side, flange):
            return f"{'flange of ' if flange else ''}{wheel.words} {side}"
        case PinsOfShoe(shoe):
            return f"pins of shoe {shoe}"


PINS = {words(Pin(end, side)): Pin(end, side) for end in ENDS for side in SIDES}
"""Pins by the names of joint centres and of the interfaces of a mesh."""
