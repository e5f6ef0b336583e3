"""What runs over time: the drive of the front shoe, and the steps of the integration."""

from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import Parameters, StepProfile, quantity

SAME_TIME = 1e-9
"""Relative difference below which two times are the same."""

FASTEST = 100.0
"""m/s and rad/s: no track is as fast, and nothing of it could be integrated."""


class Drive(Parameters):
    """Velocity of a point of the front shoe along x, in a turn the rate about its z axis, and when."""

    speed: StepProfile = quantity("m/s", "velocity along global x", plausible=(-1.5, 1.5))
    turn_rate: StepProfile | None = quantity(
        "rad/s",
        "angular velocity about the shoe's z axis; None leaves it free",
        plausible=(-0.2, 0.2),
        default=None,
    )
    on: tuple[tuple[float, float], ...] | None = quantity(
        "s",
        "times from and to which the drive moves the front shoe, free otherwise; None: always",
        default=None,
    )
    point: Literal["com node", "front pins", "frame"] = Field(
        default="com node",
        description="what of the front shoe has the speed. com node: the mesh node nearest to "
        "`flexible.com_node`, or the COM of a rigid shoe; front pins: the middle of its two front joint "
        "centres; frame: the shoe as a whole, which spreads the force over a flexible shoe like a weight",
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name, rate in (("speed", self.speed), ("turn_rate", self.turn_rate)):
            if rate is None:
                continue
            if rate.times[0] != 0.0 or rate.values[0] != 0.0:
                got = f"{rate.values[0]} at {rate.times[0]} s"
                raise ValueError(f"{name} must start from zero at t = 0, got {got}")
            if max(map(abs, rate.values)) > FASTEST:
                raise ValueError(f"{name} must not exceed {FASTEST:g} in size, got {list(rate.values)}")
        times = [time for window in self.on or () for time in window]
        if times and (times[0] < 0.0 or np.any(np.diff(times) <= 0.0)):
            raise ValueError(f"on must be times from 0 s that increase, got {self.on}")
        for start, _ in self.on or ():
            speed = float(self.speed.value(start))
            if abs(speed) > 1e-9:
                raise ValueError(
                    f"speed must be zero where the drive goes on, at {start:g} s, got {speed:g} m/s: "
                    "the front shoe is at rest there"
                )
        return self

    @classmethod
    def translation(cls) -> Self:
        """Straight propel (K-chapter eq. 27 to 29): 0.012 t2 - 0.0016 t3 up to 0.1 m/s at 5 s."""
        return cls(speed=_risen(ph4100c.PROPEL_SPEED))

    @classmethod
    def turning(cls) -> Self:
        """Propel and turn (K-chapter): the rate rises as 0.12 t2 - 0.016 t3 deg/s to 1 deg/s at 5 s."""
        return cls(speed=_risen(ph4100c.PROPEL_SPEED), turn_rate=_risen(ph4100c.TURN_RATE))

    @classmethod
    def to_rest(cls) -> Self:
        """Propel of the S-paper: as in translation up to 10 s, then to rest at 15 s, and off."""
        speed, rest = ph4100c.PROPEL_SPEED, ph4100c.REST_START
        return cls(
            speed=StepProfile(
                times=(0.0, ph4100c.PROPEL_RISE, ph4100c.BRAKE_START, rest), values=(0.0, speed, speed, 0.0)
            ),
            on=((0.0, rest),),
        )

    @property
    def switch_times(self) -> tuple[float, ...]:
        """Times after 0 at which the drive goes on or off, s."""
        return tuple(time for window in self.on or () for time in window if time > 0.0)

    def off_since(self, time: float) -> float:
        """How long the drive has been off just after a time, s; zero while it is on."""
        if self.drives_after(time):
            return 0.0
        return time - max((end for _, end in self.on or () if end <= time * (1.0 + SAME_TIME)), default=0.0)

    def drives_after(self, time: float) -> bool:
        """Whether the drive is on just after a time (s)."""
        if self.on is None:
            return True
        return any(start <= time * (1.0 + SAME_TIME) < end for start, end in self.on)

    def travel(self, time: float) -> float:
        """Way that the drive has moved the front shoe by a time (s), m."""
        return self._driven(self.speed, time)

    def turn(self, time: float) -> float:
        """Angle that the drive has turned the front shoe by a time (s), rad."""
        return 0.0 if self.turn_rate is None else self._driven(self.turn_rate, time)

    def _driven(self, rate: StepProfile, time: float) -> float:
        """Integral of a rate over the times up to `time` at which the drive is on."""
        if self.on is None:
            return float(rate.integral(time))
        parts = [(start, min(end, time)) for start, end in self.on if start < time]
        return sum(float(rate.integral(end) - rate.integral(start)) for start, end in parts)


def _risen(value: float) -> StepProfile:
    return StepProfile(times=(0.0, ph4100c.PROPEL_RISE), values=(0.0, value))


class Solver(Parameters):
    """Implicit generalized-alpha integration; `docs/validation.md` shows what the defaults cost."""

    step: float = quantity("s", "time step", plausible=(1e-5, 0.02), ge=1e-9, le=10, default=2.0e-3)
    quiet_step: float = quantity(
        "s", "longer step, 1 s after the drive went off", plausible=(1e-5, 0.1), ge=1e-9, le=10, default=0.01
    )
    minimum_step: float = quantity("s", "least step tried before giving up", ge=1e-15, le=10, default=1.0e-6)
    residual: float = quantity(
        "N", "rms that ends Newton's method", plausible=(1e-6, 50.0), ge=1e-12, le=1e9, default=0.2
    )
    maximum_iterations: int = quantity(
        "1", "iterations before the step is halved", ge=2, le=10_000, default=40
    )
    spectral_radius: float = quantity(
        "1", "of the integration at infinite frequency: less damps more", gt=0, lt=1, default=0.6
    )
    output_interval: float = quantity(
        "s",
        "time between stored states; every step where it is not longer than one",
        ge=1e-9,
        le=1e9,
        default=2.0e-3,
    )

    checkpoint_interval: float = quantity(
        "s",
        "the integration starts anew from its state at every multiple of this, where a killed run goes on",
        ge=1e-3,
        le=1e9,
        default=1.0,
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.minimum_step > self.step:
            raise ValueError(f"minimum_step must not exceed step = {self.step}, got {self.minimum_step}")
        return self

    def stored_times(self, duration: float) -> float:
        """Stored states of a run (s), about."""
        return duration / max(self.output_interval, self.step)
