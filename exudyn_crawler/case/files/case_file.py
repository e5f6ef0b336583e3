"""A case with the duration of its run and what the run leaves."""

import math
import os
from functools import partial
from typing import Annotated, Literal, Self, SupportsFloat

from pydantic import Field, model_validator

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.parameters.base import Parameters, quantity
from exudyn_crawler.case.parameters.fields import BESIDE, in_units

_bytes = partial(in_units, units={"PB": 1e15, "TB": 1e12, "GB": 1e9, "MB": 1e6, "B": 1.0})
NUMBER = 8
"""Bytes."""
FALLBACK_MEMORY = 64e9
"""Bytes, taken for the machine's memory where the system does not tell it."""
GREATEST_HISTORY = 1e12
"""Bytes of a history on disk."""
MOST_STAGES = 1_000_000
"""Stages of a run, which begin at its checkpoints."""
COPIES_OF_MODES = 6
"""Arrays as large as a basis that a reduction and the stresses of its modes hold at a time."""
A_UNIT = 20e3
"""Bytes of a unit that is a body of the multibody system with its joints."""


def check_duration(duration: object) -> None:
    """Refuse, by a `ValueError`, a duration that is no number of seconds above zero."""
    if not isinstance(duration, SupportsFloat):
        raise ValueError(f"duration must be a number in s, got {duration!r}")
    if not 0.0 < float(duration) < math.inf:
        raise ValueError(f"duration must be positive and finite, got {duration!r} s")


def check_size(case: Case, duration: float) -> None:
    """Refuse, by a `ValueError`, a run (s) that no memory of this machine or no disk would hold."""
    terrain, units = case.terrain, case.terrain.unit_count
    if case.terrain_formulation == "constrained" or case.contact.model == "spheres":
        needed = A_UNIT * units
    else:
        # singular value decomposition of the joints' equations in the heave and tilt of every unit
        needed = 4.0 * NUMBER * (2.0 * units) ** 2
    _check_memory(f"terrain: {terrain.columns} x {terrain.rows} units", needed)
    solver = case.solver
    times = solver.stored_times(duration)
    needed = times * stored_numbers(case) * NUMBER
    if needed > GREATEST_HISTORY:
        raise ValueError(
            f"duration: {duration:g} s would leave {times:.3g} stored states of {_bytes(needed)}, allowed is "
            f"{_bytes(GREATEST_HISTORY)}; a greater solver.output_interval stores fewer"
        )
    stages = duration / solver.checkpoint_interval
    if stages > MOST_STAGES:
        raise ValueError(
            f"solver.checkpoint_interval: {solver.checkpoint_interval:g} s in {duration:g} s make "
            f"{stages:.3g} stages, allowed are {MOST_STAGES}"
        )


def stored_numbers(case: Case) -> int:
    """Numbers of a stored state in a history, about: coordinates with two rates, units and contacts."""
    shoes, units = case.track.shoe_count, case.terrain.unit_count
    modes = 0 if case.flexible is None else case.flexible.mode_count * len(case.flexible.shoes)
    return 60 * shoes + 6 * units + 3 * modes


def check_modes(nodes: int, modes: int) -> None:
    """Refuse a basis of so many modes of a mesh that the machine cannot hold; see `check_size`."""
    needed = float(COPIES_OF_MODES * NUMBER * 3 * nodes * modes)
    _check_memory(f"flexible.recovered_modes: {modes} modes of {nodes} nodes", needed)


def _check_memory(what: str, needed: float) -> None:
    allowed = machine_memory()
    if needed > allowed:
        raise ValueError(
            f"{what} would take {_bytes(needed)} of memory, more than the {_bytes(allowed)} of this machine"
        )


def machine_memory() -> float:
    """Memory of this machine, bytes."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return FALLBACK_MEMORY


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
