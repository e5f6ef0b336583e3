"""Arms that carry road wheels on springs, as on the M113 and the Marder."""

import math
from collections.abc import Sequence

from exudyn_crawler.case.parameters import base
from exudyn_crawler.settings.parameters import Errors, Parameters, quantity


class Arm(Parameters):
    """Arm on a pivot of the side frame that carries a roller: a road wheel on a torsion bar.

    With the roller at its place in the frame, the spring presses the wheel down with `torque`. The wheel is
    behind the pivot (a trailing arm) or in front of it.
    """

    roller: int = quantity("1", "number of the arm's roller, counted from the rear", ge=1)
    pivot: base.Two = quantity("m", "x and z of the pivot's axis in the frame", (-10.0, 10.0))
    mass: base.Mass = quantity(
        "kg", "mass of the arm with its roller, not included in the frame's mass", (10.0, 2e3)
    )
    com: base.Two = quantity("m", "x and z of the arm's COM from the pivot", (-2.0, 2.0), default=(0.0, 0.0))
    inertia: base.Inertia = quantity(
        "kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy of the arm about its COM (tensor)"
    )
    torque: float = quantity(
        "N m", "moment of the spring in the roller's nominal position", (100.0, 1e6), ge=0, le=1e9
    )
    stiffness: base.Stiffness = quantity("N m/rad", "stiffness of the spring", (1e3, 1e7))
    damping: base.Damping = quantity(
        "N m s/rad", "damping coefficient of the damper", (0.0, 1e6), default=0.0
    )
    stop: float | None = quantity(
        "rad",
        "upward angle from the nominal position to the bump stop; none: no stop",
        (0.05, 1.0),
        gt=0,
        le=1.5,
        default=None,
    )
    stop_stiffness: base.Stiffness = quantity(
        "N m/rad", "stiffness of the bump stop, in addition to that of the spring", (1e4, 1e8), default=1e6
    )

    def lift(self, roller: float, angle: float) -> float:
        """Return the lift (m) of the roller at x (m) when the arm turns up by an angle (rad)."""
        length, elevation = self._stands(roller)
        return length * (math.sin(min(elevation + angle, 0.5 * math.pi)) - math.sin(elevation))

    def lifted(self, roller: float, height: float) -> tuple[float, float]:
        """Return displacement along x (m) and angle about y (rad) for a lift (m) of the roller at x (m)."""
        length, elevation = self._stands(roller)
        turned = math.asin(min(math.sin(elevation) + height / length, 1.0))
        side = math.copysign(1.0, roller - self.pivot[0])
        return side * length * (math.cos(turned) - math.cos(elevation)), -side * (turned - elevation)

    def _stands(self, roller: float) -> tuple[float, float]:
        """Return distance (m) and elevation (rad) of the roller at x (m), seen from the pivot."""
        x, z = self.pivot
        return math.hypot(roller - x, z), math.atan2(-z, abs(roller - x))


def arm_errors(arms: Sequence[Arm], rollers: Sequence[float], carried: set[int]) -> Errors:
    """Yield an error for each arm with a missing roller, a shared one, or one at the pivot's x.

    `carried` holds the numbers of the rollers on bogies.
    """
    taken = dict.fromkeys(carried, "a bogie")
    for number, arm in enumerate(arms):
        name = f"gear.arms[{number}]"
        if arm.roller > len(rollers):
            yield f"{name}.roller must be in 1..{len(rollers)}, got {arm.roller}"
            return
        if arm.roller in taken:
            yield f"{name}.roller must be free, {taken[arm.roller]} has roller {arm.roller}"
        taken[arm.roller] = name
        if arm.pivot[0] == rollers[arm.roller - 1]:
            beside = f"behind or ahead of its roller at x = {rollers[arm.roller - 1]:.4g} m"
            yield f"{name}.pivot must be {beside}, got {list(arm.pivot)}"
