"""Gaps between the teeth of a tumbler, as a case and compiled code have them.

In a file of its own: compiled code is compiled again where a file changes that it takes a class of.
"""

import math
from typing import NamedTuple


class ToothProfile(NamedTuple):
    """Gaps of a tumbler, the first at its x axis, and the radius of the lugs; m.

    A gap is an arc, on which straight flanks follow where the teeth are longer.
    """

    gaps: float
    center: float  # radius of the circle of the arcs' centres
    arc: float  # radius of the arcs
    addendum: float  # radius of the teeth's tips
    lug: float  # radius of the lugs
    rim: float  # radius where the arcs end: the addendum's where nothing follows
    flank: float  # length of the straight flanks that follow

    @property
    def flank_angle(self) -> float:
        """Angle (rad) beside a gap's middle, about its arc's centre, where the arc ends; NaN: nowhere."""
        cosine = (self.center**2 + self.arc**2 - self.rim**2) / (2.0 * self.center * self.arc)
        return math.acos(cosine) if -1.0 < cosine < 1.0 else math.nan

    @property
    def half_width(self) -> float:
        """Half of a gap's width between the tips of its teeth."""
        angle = self.flank_angle
        return self.arc * math.sin(angle) + self.flank * math.cos(angle)

    def with_flanks(self, angle: float) -> "ToothProfile":
        """Profile whose arcs end at an angle (rad) beside the gap's middle and go on straight to the tips."""
        along, aside = self.center - self.arc * math.cos(angle), self.arc * math.sin(angle)
        rim = math.hypot(along, aside)
        if not rim < self.addendum:
            return self
        way = along * math.sin(angle) + aside * math.cos(angle)
        return self._replace(rim=rim, flank=math.sqrt(way**2 + self.addendum**2 - rim**2) - way)
