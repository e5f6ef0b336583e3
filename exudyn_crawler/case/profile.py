"""A quantity over time given at instants and joined by cubic STEPs."""

from functools import cached_property
from typing import Annotated, Self

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator
from scipy.interpolate import CubicHermiteSpline, PPoly

from exudyn_crawler.case.base import Parameters


class StepProfile(Parameters):
    """Values at increasing times, joined by cubic STEPs, constant before and after.

    With ``s = (t - t0) / (t1 - t0)`` the value runs as ``v0 + (v1 - v0) s**2 (3 - 2 s)``, so its rate
    is zero at every given time (ADAMS STEP).
    """

    times: Annotated[tuple[float, ...], Field(min_length=1, description="increasing times, s")]
    values: Annotated[
        tuple[Annotated[float, Ge(-1e12), Le(1e12)], ...],
        Field(min_length=1, description="value at each time"),
    ]

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.times) != len(self.values):
            raise ValueError(
                f"times and values must be equally many: {len(self.times)} != {len(self.values)}"
            )
        if np.any(np.diff(self.times) <= 0.0):
            raise ValueError(f"times must increase, got {self.times}")
        with np.errstate(all="ignore"):
            joined = np.isfinite(self._spline.c).all() and np.isfinite(self._antiderivative(self.times[-1]))
        if not joined:
            raise ValueError(f"times must be apart enough to be joined in numbers, got {self.times}")
        return self

    @classmethod
    def constant(cls, value: float) -> Self:
        """Same value at all times."""
        return cls(times=(0.0,), values=(value,))

    @cached_property
    def _spline(self) -> PPoly:
        """Cubic pieces with zero slope at every given time, which is what STEP is."""
        if len(self.times) == 1:
            return PPoly(np.array([[self.values[0]]]), np.array([self.times[0], self.times[0] + 1.0]))
        return CubicHermiteSpline(self.times, self.values, np.zeros(len(self.times)))

    @cached_property
    def _antiderivative(self) -> PPoly:
        return self._spline.antiderivative()

    def value(self, time: ArrayLike) -> NDArray:
        """Value at each time."""
        return self._spline(np.clip(time, self.times[0], self.times[-1]))

    def rate(self, time: ArrayLike) -> NDArray:
        """Time derivative at each time."""
        return self._spline.derivative()(np.clip(time, self.times[0], self.times[-1]))

    def integral(self, time: ArrayLike) -> NDArray:
        """Integral from the first given time to each time (negative before it)."""
        t = np.asarray(time, dtype=float)
        inside = np.clip(t, self.times[0], self.times[-1])
        return self._antiderivative(inside) + (t - inside) * self.value(t)
