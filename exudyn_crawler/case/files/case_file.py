"""A case with the duration of its run and what the run leaves."""

from typing import Annotated, Self

from pydantic import model_validator

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.parameters.base import Parameters, quantity
from exudyn_crawler.case.parameters.kinds import BESIDE
from exudyn_crawler.case.parameters.outputs import Outputs
from exudyn_crawler.case.parameters.size import check_duration, check_size


class CaseFile(Parameters):
    """Case with the duration of its run and what the run leaves.

    Raises
    ------
    ParameterError
        Where the duration or the outputs do not fit the case.
    """

    case: Annotated[Case, BESIDE]
    duration: float = quantity("s", "simulated time", default=10.0, allow_inf_nan=True)
    outputs: Outputs = Outputs()

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_duration(self.duration)
        beyond = [shoe for shoe in self.outputs.shoes or () if not 1 <= shoe <= self.case.track.shoe_count]
        if beyond:
            raise ValueError(f"outputs.shoes must be in 1..{self.case.track.shoe_count}, got {beyond}")
        times = self.outputs.picture_times
        if times is not None and times[-1] > self.duration:
            raise ValueError(f"outputs.picture_times must lie in 0..{self.duration:g} s, got {list(times)}")
        check_size(self.case, self.duration)
        self.case.check_support(self.duration)
        return self
