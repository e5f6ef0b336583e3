"""A case with the duration of its run and what the run leaves."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.parameters.base import Parameters, quantity
from exudyn_crawler.case.parameters.checks import check_duration, check_size
from exudyn_crawler.case.parameters.paths import BESIDE


class Outputs(Parameters):
    """What a run leaves beside its history, whose interval is `solver.output_interval`."""

    figures: bool = Field(default=True, description="whether curves of kinematics and forces are drawn")
    pictures: bool = Field(
        default=True, description="whether flexible shoes are drawn with their stress at the chosen times"
    )
    paraview: bool = Field(
        default=True,
        description="whether their stress is written for ParaView, at the chosen times and highest",
    )
    figure_format: Literal["png", "pdf", "svg"] = Field(
        default="png", description="of the figures; pictures of stress are png"
    )
    tables: bool = Field(default=True, description="whether extremes and loads are written as CSV")
    animation: bool = Field(default=False, description="whether the track is animated (mp4)")
    forces: bool = Field(default=True, description="whether forces derived from the history are written")
    picture_times: tuple[float, ...] | None = quantity(
        "s",
        "times at which the stress of flexible shoes is kept whole and drawn, beside that of the highest; "
        "none: begin and ends of the load cycle's phases, as far as the run goes",
        min_length=1,
        default=None,
    )
    shoes: tuple[int, ...] | None = Field(
        default=None,
        description="numbers of the shoes that are drawn; none: five along the track",
        min_length=1,
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.shoes is not None and list(self.shoes) != sorted(set(self.shoes)):
            raise ValueError(f"shoes must be different numbers in rising order, got {self.shoes}")
        times = self.picture_times
        if times is not None and (times[0] < 0.0 or list(times) != sorted(set(times))):
            raise ValueError(f"picture_times must be from 0 s and increase, got {times}")
        return self

    def drawn_shoes(self, shoe_count: int) -> tuple[int, ...]:
        """Shoes to draw of a track: those asked for, else up to five, the ends included."""
        if self.shoes is not None:
            return self.shoes
        count = min(5, shoe_count)
        return tuple(1 + round(k * (shoe_count - 1) / (count - 1)) for k in range(count))


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
