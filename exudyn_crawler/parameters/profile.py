"""A quantity over time given at instants and joined by cubic STEPs."""

from typing import Annotated, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from exudyn_crawler.parameters.base import Parameters


class StepProfile(Parameters):
    """Values at increasing times, joined by cubic STEPs, constant before and after.

    With ``s = (t - t0) / (t1 - t0)`` the value runs as ``v0 + (v1 - v0) s**2 (3 - 2 s)``, so its rate
    is zero at every given time (ADAMS STEP).
    """

    times: Annotated[tuple[float, ...], Field(min_length=1, description="increasing times, s")]
    values: Annotated[tuple[float, ...], Field(min_length=1, description="value at each time")]

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.times) != len(self.values):
            raise ValueError(
                f"times and values must be equally many: {len(self.times)} != {len(self.values)}"
            )
        if np.any(np.diff(self.times) <= 0.0):
            raise ValueError(f"times must increase, got {self.times}")
        return self

    @classmethod
    def constant(cls, value: float) -> Self:
        """Same value at all times."""
        return cls(times=(0.0,), values=(value,))

    def _segment(self, time: ArrayLike) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
        """Start value, rise, duration, start time and local time s in [0, 1] of each time."""
        t = np.asarray(time, dtype=float)
        knots, values = np.asarray(self.times), np.asarray(self.values)
        if len(knots) == 1:
            zero = np.zeros_like(t)
            return zero + values[0], zero, zero + 1.0, zero + knots[0], zero
        index = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(knots) - 2)
        span = knots[index + 1] - knots[index]
        s = np.clip((t - knots[index]) / span, 0.0, 1.0)
        return values[index], values[index + 1] - values[index], span, knots[index], s

    def value(self, time: ArrayLike) -> NDArray:
        """Value at each time."""
        start, rise, _, _, s = self._segment(time)
        return start + rise * s**2 * (3.0 - 2.0 * s)

    def rate(self, time: ArrayLike) -> NDArray:
        """Time derivative at each time."""
        _, rise, span, _, s = self._segment(time)
        return rise / span * 6.0 * s * (1.0 - s)

    def integral(self, time: ArrayLike) -> NDArray:
        """Integral from the first given time to each time (negative before it)."""
        t = np.asarray(time, dtype=float)
        knots, values = np.asarray(self.times), np.asarray(self.values)
        areas = 0.5 * (values[1:] + values[:-1]) * np.diff(knots)
        before = np.concatenate(([0.0], np.cumsum(areas)))
        start, rise, span, begin, s = self._segment(t)
        index = np.searchsorted(knots, begin, side="left")
        inside = span * (start * s + rise * (s**3 - 0.5 * s**4))
        outside = np.where(t > knots[-1], values[-1] * (t - knots[-1]), 0.0)
        outside = np.where(t < knots[0], values[0] * (t - knots[0]), outside)
        return before[index] + inside + outside
