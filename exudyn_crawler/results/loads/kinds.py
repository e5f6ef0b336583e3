"""Kinds of actions on shoes and side frames: one table, of which all sums, shares and tables are made."""

from enum import StrEnum
from typing import Literal, Self

Gear = Literal["wheel", "tooth"]


class Kind(StrEnum):
    """Kind of an action: its label in tables, the word of its load, and the gear whose contact makes it.

    Rows stand in the order in which balances add them. Loads of one word are one share of a hot spot. Gear of
    a closed track is its wheels or its teeth.
    """

    load: str
    gear: Gear | None

    def __new__(cls, label: str, load: str, gear: Gear | None = None) -> Self:
        """Row of the table."""
        kind = str.__new__(cls, label)
        kind._value_ = label
        kind.load = load
        kind.gear = gear
        return kind

    WEIGHT = "weight", "weight"
    LOAD = "load", "machine load"  # of the machine, on a shoe's top
    CONTACT = "contact", "ground"
    DRIVE = "drive", "drive"  # of an open track's front shoe
    JOINT = "joint", "pins"
    WHEEL = "wheel", "wheels", "wheel"  # all of them on a rigid shoe of a closed track, with their flanges
    TOOTH = "tooth", "tooth", "tooth"
    ROLLER = "roller", "rollers", "wheel"
    CHAIN = "chain", "drive"  # pulls for the drive of a rolled track, and at its ends
    IDLER = "idler", "idler", "wheel"
    CARRIER = "carrier", "carriers", "wheel"
    SLIDE = "slide", "slides", "wheel"
    GUIDE = "guide", "guide", "wheel"  # flanges of wheels and of the tumbler
    MACHINE = "machine", "machine load"  # on the side frame
    PULL = "pull", "drive"  # of the drive on the side frame
    # no actions: the rate of momentum that balances them, and statics without a run
    INERTIA = "inertia", "inertia"
    CHECK_CASES = "check cases", "check cases"
