"""Prescribed motion of the front shoe."""

import math
from typing import Literal, Self

from pydantic import Field, model_validator

from exudyn_crawler.case.base import Parameters, quantity
from exudyn_crawler.case.profile import StepProfile


class Drive(Parameters):
    """Velocity of a point of the front shoe along x and, in a turn, the shoe's rate about its own z axis.

    `LoadCycle.drive_on` tells when it acts.
    """

    speed: StepProfile = quantity("m/s", "velocity along global x")
    turn_rate: StepProfile | None = quantity(
        "rad/s", "angular velocity about the shoe's z axis; None leaves it free", default=None
    )
    point: Literal["com node", "front pins", "frame"] = Field(
        default="com node",
        description="what of the front shoe has the speed. com node: the mesh node nearest to "
        "`flexible.com_node`, or the COM of a rigid shoe; front pins: the middle of its two front joint "
        "centres; frame: the shoe as a whole, which spreads the force over a flexible shoe like a weight",
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.speed.times[0] != 0.0 or self.speed.values[0] != 0.0:
            raise ValueError(
                f"speed must start from rest at t = 0, got {self.speed.values[0]} at {self.speed.times[0]} s"
            )
        if self.turn_rate is not None and (self.turn_rate.times[0] != 0.0 or self.turn_rate.values[0] != 0.0):
            raise ValueError(
                f"turn_rate must start from zero at t = 0, got {self.turn_rate.values[0]} at "
                f"{self.turn_rate.times[0]} s"
            )
        return self

    @classmethod
    def translation(cls) -> Self:
        """Straight propel (K-chapter eq. 27 to 29): 0.012 t2 - 0.0016 t3 up to 0.1 m/s at 5 s."""
        return cls(speed=StepProfile(times=(0.0, 5.0), values=(0.0, 0.1)))

    @classmethod
    def turning(cls) -> Self:
        """Propel and turn (K-chapter): the rate rises as 0.12 t2 - 0.016 t3 deg/s to 1 deg/s at 5 s."""
        return cls(
            speed=StepProfile(times=(0.0, 5.0), values=(0.0, 0.1)),
            turn_rate=StepProfile(times=(0.0, 5.0), values=(0.0, math.radians(1.0))),
        )

    @classmethod
    def to_rest(cls) -> Self:
        """Propel of the S-paper: as in translation up to 10 s, then to rest at 15 s."""
        return cls(speed=StepProfile(times=(0.0, 5.0, 10.0, 15.0), values=(0.0, 0.1, 0.1, 0.0)))
