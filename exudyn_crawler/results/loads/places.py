"""Places at which something acts on a shoe or a side frame, as data, and the words of tables for them."""

from enum import StrEnum
from typing import Literal, NamedTuple

from exudyn_crawler.case import SIDES
from exudyn_crawler.case.gear.base import WheelLabel

End = Literal["front", "rear"]
ENDS: tuple[End, End] = ("front", "rear")


class Point(StrEnum):
    """Point of a body, or the ground as a whole, by its words."""

    CENTER = "COM"
    ORIGIN = "origin"
    TOP = "top"
    CELLS = "cells"
    FRAME = "frame"
    COM_NODE = "com node"
    FRONT_PINS = "front pins"


class Pin(NamedTuple):
    """Pin of a shoe, or the middle of both pins of an end."""

    end: End
    side: str  # of `SIDES`, or `MIDWAY`


class GroundUnit(NamedTuple):
    """Unit of the ground that a shoe stands on."""

    number: int


class OnTread(NamedTuple):
    """Tread of a wheel on one of the rails, or the flange beside it."""

    wheel: WheelLabel
    side: str
    flange: bool = False


class PinsOfShoe(NamedTuple):
    """Front pins of a shoe, for what acts on the side frame there."""

    shoe: int


Place = Point | Pin | GroundUnit | OnTread | PinsOfShoe


def words(place: Place) -> str:
    """Words of tables for a place, such as "front right", "unit 12" or "flange of roller 3 left"."""
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
