"""Dragged gear: the drive moves a point of the front shoe, and loads on the shoes represent the machine."""

from typing import ClassVar, Literal

from exudyn_crawler.case.gear.base import Gear, Whole
from exudyn_crawler.settings.parameters import Errors, option


class Dragged(Gear):
    """Open track without a side frame: the drive moves the front shoe, loads press on the shoes."""

    kind: Literal["dragged"] = option("dragged front shoe, with loads in place of the machine", "dragged")

    quantities: ClassVar[frozenset[str]] = frozenset({"dragged"})

    def errors(self, case: Whole) -> Errors:
        """Yield an error for each contradiction to the rest of the case."""
        if case.drive.slip is not None:
            yield "drive.slip must be none: only closed tracks on the ground have a drawbar that holds it"
        if case.machine is not None:
            yield "machine must be none with gear.kind 'dragged', which has no side frame"
