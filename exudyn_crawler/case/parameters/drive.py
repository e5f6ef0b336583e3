"""Values over time: a quantity, the drive of the front shoe, and the steps of the integration."""

import math
from functools import lru_cache
from typing import ClassVar, Literal, Self

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import Component
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, Parameters, option, quantity

SAME_TIME = 1e-9  # relative difference below which two times are equal
SHORTEST = 1e-9  # s, least length of a STEP, so that its rates are finite
FASTEST = 100.0  # m/s and rad/s, above any track and any motion that can be integrated


SETTLING = 1.0
"""Time (s) from the end of the drive until the track is quiet; its shoes swing at 8 Hz and more."""


class StepProfile(Parameters):
    """Values at increasing times, joined by cubic STEPs, constant before and after.

    With ``s = (t - t0) / (t1 - t0)`` the value runs as ``v0 + (v1 - v0) s**2 (3 - 2 s)``, so its rate
    is zero at every given time (ADAMS STEP).
    """

    is_value: ClassVar[bool] = True

    times: tuple[Component, ...] = option("rising times, s", min_length=1)
    values: tuple[Component, ...] = option("value at each time", min_length=1)

    def _errors(self) -> Errors:
        if len(self.times) != len(self.values):
            yield f"times and values must be equally many: {len(self.times)} != {len(self.values)}"
        if np.any(np.diff(self.times) < SHORTEST):
            yield f"times must increase, got {fields.shown(self.times)}"

    def __str__(self) -> str:
        return ", ".join(f"{v:.8g} at {t:g}" for t, v in zip(self.times, self.values, strict=True))

    @classmethod
    def constant(cls, value: float) -> Self:
        """Return a profile with one value at all times."""
        return cls(times=(0.0,), values=(value,))

    def _at(self, time: np.typing.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return the index of the STEP at each time, and the elapsed fraction of it; 0 before the first."""
        times, _, lengths, _ = _steps(self.times, self.values)
        inside = np.minimum(np.maximum(time, times[0]), times[-1])
        step = times.searchsorted(inside, side="right") - 1
        return step, (inside - times[step]) / lengths[step]

    @property
    def first_constant(self) -> float:
        """Time from which the value is constant after its first change, s; 0 if it never changes."""
        changes = np.diff(self.values) != 0.0
        if not changes.any():
            return 0.0
        first = int(changes.argmax())
        still = np.flatnonzero(~changes[first:])
        return self.times[first + int(still[0]) if len(still) else -1]

    def value(self, time: np.typing.ArrayLike) -> np.ndarray:
        """Return the value at each time."""
        _, values, _, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        return values[step] + rises[step] * s**2 * (3.0 - 2.0 * s)

    def rate(self, time: np.typing.ArrayLike) -> np.ndarray:
        """Return the time derivative at each time."""
        _, _, lengths, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        return 6.0 * rises[step] / lengths[step] * s * (1.0 - s)

    def integral(self, time: np.typing.ArrayLike) -> np.ndarray:
        """Return the integral from the first given time to each time (negative before it)."""
        times, values, lengths, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        before = np.append(0.0, np.cumsum(lengths * (values + 0.5 * rises))[:-1])
        within = lengths[step] * s * (values[step] + rises[step] * s**2 * (1.0 - 0.5 * s))
        beyond = time - np.minimum(np.maximum(time, times[0]), times[-1])
        return before[step] + within + beyond * self.value(time)


@lru_cache(maxsize=256)
def _steps(
    times: tuple[float, ...], values: tuple[float, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return start (s), first value, length (s) and rise of every STEP; the last one is flat."""
    starts = np.array(times)
    firsts = np.array(values)
    return starts, firsts, np.append(np.diff(starts), 1.0), np.append(np.diff(firsts), 0.0)


class Drive(Parameters):
    """Velocity of a point of the front shoe along x, in a turn the rate about its z axis, and when.

    On closed tracks it is the speed of the chains relative to the frame. The speeds of two tracks differ by
    the turn rate times the tracks' distance.
    """

    speed: StepProfile = quantity("m/s", "velocity along global x", (-2.5, 2.5))
    turn_rate: StepProfile | None = quantity(
        "rad/s", "angular velocity about the shoe's z axis; none: free", (-1.0, 1.0), default=None
    )
    on: tuple[tuple[float, float], ...] | None = quantity(
        "s",
        "times between which the drive moves the front shoe, which is free otherwise; none: always",
        default=None,
    )
    slip: StepProfile | None = quantity(
        "1",
        "slip held on closed tracks: a drawbar holds the frame at (1 - slip) times the speed, and the"
        " drive keeps the chain's speed with any torque; none: no drawbar",
        (0.0, 1.0),
        default=None,
    )
    drawbar_height: float = quantity(
        "m", "height of the drawbar above the ground, for a held slip", default=0.0
    )
    point: Literal["com node", "front pins", "frame"] = option(
        "driven point of the front shoe. com node: mesh node nearest to `flexible.com_node`, or COM "
        "of a rigid shoe; front pins: middle of their centres; frame: the whole shoe, with a force "
        "distributed like its weight",
        "com node",
    )

    def _errors(self) -> Errors:
        for name, rate in (("speed", self.speed), ("turn_rate", self.turn_rate)):
            if rate is None:
                continue
            if rate.times[0] != 0.0 or rate.values[0] != 0.0:
                yield f"{name} must start from zero at t = 0, got {rate.values[0]} at {rate.times[0]} s"
            if max(map(abs, rate.values)) > FASTEST:
                yield f"{name} must not exceed {FASTEST:g} in size, got {fields.shown(rate.values)}"
        if self.slip is not None and (min(self.slip.values) < 0.0 or max(self.slip.values) > 1.0):
            yield f"slip must be between 0 and 1, got {fields.shown(self.slip.values)}"
        times = [time for window in self.on or () for time in window]
        if times and (times[0] < 0.0 or np.any(np.diff(times) <= 0.0)):
            yield f"on must be increasing times from 0 s, got {fields.shown(self.on)}"
        for start in times[::2]:
            if abs(speed := float(self.speed.value(start))) > 1e-9:
                yield f"speed must be zero at {start:g} s, when the drive is switched on, got {speed:.4g} m/s"

    @classmethod
    def translation(cls) -> Self:
        """Return a straight propel (K-chapter eq. 27 to 29): 0.012 t2 - 0.0016 t3 up to 0.1 m/s at 5 s."""
        return cls(speed=_risen(ph4100c.PROPEL_SPEED))

    @classmethod
    def turning(cls) -> Self:
        """Return propel with turn (K-chapter); the rate is 0.12 t2 - 0.016 t3 deg/s up to 1 deg/s at 5 s."""
        return cls(speed=_risen(ph4100c.PROPEL_SPEED), turn_rate=_risen(ph4100c.TURN_RATE))

    @classmethod
    def to_rest(cls) -> Self:
        """Return the propel of the S-paper: as in translation up to 10 s, to rest at 15 s, then off."""
        speed = ph4100c.PROPEL_SPEED
        rest = ph4100c.REST_START
        times = (0.0, ph4100c.PROPEL_RISE, ph4100c.BRAKE_START, rest)
        return cls(speed=StepProfile(times=times, values=(0.0, speed, speed, 0.0)), on=((0.0, rest),))

    @property
    def switch_times(self) -> tuple[float, ...]:
        """Times after 0 at which the drive switches on or off, s."""
        return tuple(time for window in self.on or () for time in window if time > 0.0)

    @property
    def start_ends(self) -> float:
        """Time at which the drive first reaches constant speed and rate of turning, s; 0 without a start."""
        profiles = [self.speed] if self.turn_rate is None else [self.speed, self.turn_rate]
        return max(profile.first_constant for profile in profiles)

    def off_since(self, time: float) -> float:
        """Return the time (s) since the drive went off, just after `time` (s); zero while it is on."""
        if self.drives_after(time):
            return 0.0
        return time - max((end for _, end in self.on or () if end <= time * (1.0 + SAME_TIME)), default=0.0)

    def quiet_time(self, duration: float) -> float:
        """Return the quiet time (s) of a run's duration (s); it starts `SETTLING` after the drive's end."""
        if self.on is None:
            return 0.0
        starts = [0.0, *(end for _, end in self.on)]
        ends = [*(start for start, _ in self.on), math.inf]
        gaps = zip(starts, ends, strict=True)
        return sum(max(0.0, min(end, duration) - start - SETTLING) for start, end in gaps)

    def drives_after(self, time: float) -> bool:
        """Return whether the drive is on just after a time (s)."""
        return self.on is None or any(start <= time * (1.0 + SAME_TIME) < end for start, end in self.on)

    def travel(self, time: np.typing.ArrayLike) -> np.ndarray:
        """Return the distance that the drive has moved the front shoe up to each time (s), m."""
        return self._driven(self.speed, time)

    def turn(self, time: np.typing.ArrayLike) -> np.ndarray:
        """Return the angle that the drive has turned the front shoe up to each time (s), rad."""
        return np.zeros(np.shape(time)) if self.turn_rate is None else self._driven(self.turn_rate, time)

    def _driven(self, rate: StepProfile, time: np.typing.ArrayLike) -> np.ndarray:
        """Return the integral of a rate, up to each `time` (s), over the periods with the drive on."""
        if self.on is None:
            return rate.integral(time)
        driven = np.zeros(np.shape(time))
        for window in self.on:
            driven += rate.integral(np.clip(time, *window)) - rate.integral(window[0])
        return driven


def _risen(value: float) -> StepProfile:
    return StepProfile(times=(0.0, ph4100c.PROPEL_RISE), values=(0.0, value))


class Solver(Parameters):
    """Implicit generalized-alpha integration; `docs/validation.md` shows what the defaults cost."""

    step: float = quantity("s", "time step", (1e-5, 0.02), ge=1e-9, le=10, default=2.0e-3)
    quiet_step: float = quantity(
        "s",
        f"time step from {SETTLING:g} s after the drive is switched off",
        (1e-5, 0.1),
        ge=1e-9,
        le=10,
        default=0.01,
    )
    minimum_step: float = quantity(
        "s", "smallest time step before the run gives up", ge=1e-15, le=10, default=1.0e-6
    )
    residual: float = quantity(
        "N", "rms residual at which Newton's method ends", (1e-6, 50.0), ge=1e-12, le=1e9, default=0.2
    )
    maximum_iterations: int = quantity(
        "1", "iterations of Newton's method before a step is halved", ge=2, le=10_000, default=40
    )
    spectral_radius: float = quantity(
        "1",
        "spectral radius of the time integration at infinite frequency; a smaller one damps more",
        gt=0,
        lt=1,
        default=0.6,
    )
    output_interval: float = quantity(
        "s", "time between stored states; at least a step", ge=1e-9, le=1e9, default=2.0e-3
    )
    checkpoint_interval: float = quantity(
        "s", "time between checkpoints, from which a run can be continued", ge=1e-3, le=1e9, default=1.0
    )

    def _errors(self) -> Errors:
        if self.minimum_step > self.step:
            yield f"minimum_step must not exceed step = {self.step}, got {self.minimum_step}"

    def steps(self, duration: float, quiet: float) -> float:
        """Return the approximate number of steps of a run with a `duration` and `quiet` time, s."""
        return (duration - quiet) / self.step + quiet / max(self.step, self.quiet_step)

    def stored_times(self, duration: float, quiet: float) -> float:
        """Return the approximate number of stored states of a run with a `duration` and `quiet` time, s."""
        driven = (duration - quiet) / max(self.output_interval, self.step)
        return driven + quiet / max(self.output_interval, self.step, self.quiet_step)
