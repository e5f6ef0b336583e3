"""Gaps between the teeth of a tumbler, for a case and for compiled code.

The file has nothing else, because a change of a file recompiles all code that uses a class of it.
"""

import math
from typing import NamedTuple


class ToothProfile(NamedTuple):
    """Gaps of a tumbler, the first at its x axis, and the radius of the lugs; m.

    A gap is an arc. Straight flanks continue the arc if the teeth reach beyond it.
    """

    gaps: float  # number of gaps
    center: float  # radius of the circle of the arcs' centres
    arc: float  # radius of the arcs
    addendum: float  # radius of the teeth's tips
    lug: float  # radius of the lugs
    rim: float  # radius at the ends of the arcs; without flanks that of the addendum
    flank: float  # length of the straight flanks

    @property
    def flank_angle(self) -> float:
        """Angle (rad) about the arc's centre from the gap's middle to the end of the arc; NaN: no end."""
        cosine = (self.center**2 + self.arc**2 - self.rim**2) / (2.0 * self.center * self.arc)
        return math.acos(cosine) if -1.0 < cosine < 1.0 else math.nan

    @property
    def half_width(self) -> float:
        """Half of a gap's width between the tips of its teeth, m."""
        angle = self.flank_angle
        return self.arc * math.sin(angle) + self.flank * math.cos(angle)

    def with_flanks(self, angle: float) -> "ToothProfile":
        """Return the profile with arcs up to an angle (rad) from the gap's middle, and flanks to the tips."""
        along, aside = self.center - self.arc * math.cos(angle), self.arc * math.sin(angle)
        rim = math.hypot(along, aside)
        if not rim < self.addendum:
            return self
        way = along * math.sin(angle) + aside * math.cos(angle)
        return self._replace(rim=rim, flank=math.sqrt(way**2 + self.addendum**2 - rim**2) - way)
