"""Kinds of actions on shoes and side frames: one table for all sums, shares and tables."""

from enum import StrEnum
from typing import Literal, Self

Gear = Literal["wheel", "tooth"]


class Kind(StrEnum):
    """Kind of an action: its label in tables, the name of its load, and the gear whose contact causes it.

    Balances add the kinds in this order. Kinds with the same load form one share of a hot spot. The gear of a
    closed track is its wheels or its teeth.
    """

    load: str
    gear: Gear | None

    def __new__(cls, label: str, load: str, gear: Gear | None = None) -> Self:
        """Return the kind of a row of the table."""
        kind = str.__new__(cls, label)
        kind._value_ = label
        kind.load = load
        kind.gear = gear
        return kind

    WEIGHT = "weight", "weight"
    LOAD = "load", "machine load"  # weight of the machine on a shoe's top
    CONTACT = "contact", "ground"
    DRIVE = "drive", "drive"  # on an open track's front shoe
    JOINT = "joint", "pins"
    WHEEL = "wheel", "wheels", "wheel"  # all wheels on a rigid shoe of a closed track, with their flanges
    TOOTH = "tooth", "tooth", "tooth"
    ROLLER = "roller", "rollers", "wheel"
    CHAIN = "chain", "drive"  # pull of the drive of a rolled track, and tension of its ends
    IDLER = "idler", "idler", "wheel"
    CARRIER = "carrier", "carriers", "wheel"
    SLIDE = "slide", "slides", "wheel"
    GUIDE = "guide", "guide", "wheel"  # flanges of wheels and of the tumbler
    MACHINE = "machine", "machine load"  # on the side frame
    PULL = "pull", "drive"  # pull of the drive on the side frame
    # not actions: the rate of momentum that balances them, and static loads without a run
    INERTIA = "inertia", "inertia"
    CHECK_CASES = "check cases", "check cases"
