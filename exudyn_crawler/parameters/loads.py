"""Machine and dipper loads on the shoes over time."""

from collections.abc import Sequence
from typing import Annotated, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from exudyn_crawler.parameters.base import Parameters, quantity
from exudyn_crawler.parameters.profile import StepProfile


class Phase(Parameters):
    """Part of a load cycle: the load on every shoe at its end."""

    name: Annotated[str, Field(min_length=1)]
    end: float = quantity("s", "time at which the phase ends", ge=0)
    loads: Annotated[tuple[float, ...], Field(min_length=1, json_schema_extra={"unit": "N"})]
    """Downward load on shoes 1..n at the end of the phase."""


class LoadCycle(Parameters):
    """Downward loads on the shoes: phases whose end values are joined by cubic STEPs.

    Before the end of the first phase the loads are constant at its values.
    """

    phases: Annotated[tuple[Phase, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _check(self) -> Self:
        ends = [phase.end for phase in self.phases]
        if np.any(np.diff(ends) <= 0.0):
            raise ValueError(f"the phases' ends must increase, got {ends}")
        counts = {phase.name: len(phase.loads) for phase in self.phases}
        if len(counts) != len(self.phases):
            raise ValueError(f"the phases' names must differ, got {[p.name for p in self.phases]}")
        if len(set(counts.values())) != 1:
            raise ValueError(f"every phase needs a load for every shoe, got counts {counts}")
        return self

    @classmethod
    def constant(cls, loads: Sequence[float]) -> Self:
        """Same loads (N, shoes 1..n) at all times."""
        return cls(phases=(Phase(name="constant", end=0.0, loads=tuple(loads)),))

    @classmethod
    def propel(cls, shoe_count: int = 13) -> Self:
        """Machine weight spread evenly (F-paper): 386.4 kN on each shoe."""
        return cls.constant([386.4e3] * shoe_count)

    @property
    def shoe_count(self) -> int:
        """Number of shoes that the cycle loads."""
        return len(self.phases[0].loads)

    def profile(self, shoe: int) -> StepProfile:
        """Load on a shoe (1..n) over time, N."""
        if not 1 <= shoe <= self.shoe_count:
            raise ValueError(f"shoe must be in 1..{self.shoe_count}, got {shoe}")
        return StepProfile(
            times=tuple(phase.end for phase in self.phases),
            values=tuple(phase.loads[shoe - 1] for phase in self.phases),
        )

    def loads(self, time: ArrayLike) -> NDArray:
        """Loads at each time: array (times, shoes), N downward."""
        t = np.atleast_1d(np.asarray(time, dtype=float))
        return np.column_stack([self.profile(s).value(t) for s in range(1, self.shoe_count + 1)])
