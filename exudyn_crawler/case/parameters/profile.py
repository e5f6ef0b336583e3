"""A quantity over time given at instants and joined by cubic STEPs."""

from functools import lru_cache
from typing import Annotated, Self

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from exudyn_crawler.case.parameters.base import Parameters


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
            cubes = np.diff(self.times) ** 3
            joined = np.isfinite(cubes) & np.isfinite(np.diff(self.values) / cubes)
        if not joined.all():
            raise ValueError(f"times must be apart enough to be joined in numbers, got {self.times}")
        return self

    @classmethod
    def constant(cls, value: float) -> Self:
        """Same value at all times."""
        return cls(times=(0.0,), values=(value,))

    def _at(self, time: ArrayLike) -> tuple[NDArray, NDArray]:
        """Number of the STEP that each time lies in, and the share of it that is over; 0 before the first."""
        times, _, lengths, _ = _steps(self.times, self.values)
        inside = np.minimum(np.maximum(time, times[0]), times[-1])
        step = times.searchsorted(inside, side="right") - 1
        return step, (inside - times[step]) / lengths[step]

    def value(self, time: ArrayLike) -> NDArray:
        """Value at each time."""
        _, values, _, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        return values[step] + rises[step] * s**2 * (3.0 - 2.0 * s)

    def rate(self, time: ArrayLike) -> NDArray:
        """Time derivative at each time."""
        _, _, lengths, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        return 6.0 * rises[step] / lengths[step] * s * (1.0 - s)

    def integral(self, time: ArrayLike) -> NDArray:
        """Integral from the first given time to each time (negative before it)."""
        times, values, lengths, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        before = np.append(0.0, np.cumsum(lengths * (values + 0.5 * rises))[:-1])
        within = lengths[step] * s * (values[step] + rises[step] * s**2 * (1.0 - 0.5 * s))
        beyond = time - np.minimum(np.maximum(time, times[0]), times[-1])
        return before[step] + within + beyond * self.value(time)


@lru_cache(maxsize=256)
def _steps(times: tuple[float, ...], values: tuple[float, ...]) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Start (s), first value, length (s) and rise of every STEP, a flat one last."""
    starts, firsts = np.array(times), np.array(values)
    return starts, firsts, np.append(np.diff(starts), 1.0), np.append(np.diff(firsts), 0.0)
