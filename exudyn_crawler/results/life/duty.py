"""Duty of a shovel: which runs its hours are made of, and how often an hour each of them happens."""

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from exudyn_crawler.case.parameters.base import Name, Parameters, quantity
from exudyn_crawler.case.parameters.reading import Content, read_parameters, with_base
from exudyn_crawler.results.life.fatigue_material import FatigueMaterial
from fem.fatigue import Miner

HOUR = 3600.0
"""s."""
ROUNDING = 1e-9
Survival = Annotated[float, Field(gt=0.0, lt=1.0)]


class Often(Parameters):
    """Part of a run, and how often it happens: by its number in a machine hour, or by its share of all."""

    begin: float = quantity("s", "time in the run at which the repeated part begins", ge=0, default=0.0)
    end: float | None = quantity("s", "time at which it ends; none: the run's end", gt=0, default=None)
    an_hour: float | None = quantity(
        "1/h", "times a machine hour that it happens; or its share", gt=0, le=1e6, default=None
    )
    share: float | None = quantity(
        "1", "part of the machine hours that it takes; or how often an hour", gt=0, le=1, default=None
    )


class DutyRun(Often):
    """Run, or a part of one, that is repeated in a shovel's hours."""

    name: Name = Field(description="of what happens in it")
    folder: str = Field(
        min_length=1, description="folder of the run; in a file it counts from that of the file"
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.an_hour is None) == (self.share is None):
            raise ValueError("an_hour or share must be given, got neither or both")
        if self.end is not None and self.end <= self.begin:
            raise ValueError(f"end must be after begin = {self.begin:g} s, got {self.end:g} s")
        return self

    def times_an_hour(self, duration: float) -> float:
        """How often a machine hour it happens, at a duration in s."""
        return self.an_hour if self.an_hour is not None else (self.share or 0.0) * HOUR / duration


class Damage(Parameters):
    """Material of the shoes, and how the damage of its cycles is summed up."""

    material: FatigueMaterial = Field(description="of the shoes against cyclic stress")
    criterion: Literal["signed von mises", "signed principal"] = Field(
        default="signed von mises",
        description="stress whose cycles are counted at all nodes: von Mises with the sign of the "
        "hydrostatic stress, or the principal stress of the greatest magnitude",
    )
    miner: Miner = Field(
        default="elementary",
        description="what cycles below the knee do: elementary as much as the slope says (the safest), "
        "haibach less (slope 2 k - 1), original nothing",
    )


class Duty(Damage):
    """Mix of runs that a shovel's hours are made of, its shoes' material and how damage is summed up."""

    name: Name = Field(default="duty", description="of the duty")
    runs: Annotated[tuple[DutyRun, ...], Field(min_length=1)]
    survivals: tuple[Survival, ...] = Field(
        default=(0.5, 0.9, 0.975),
        min_length=1,
        description="parts of the shoes that survive the lives asked for",
    )
    plane_nodes: int = quantity(
        "1", "worst nodes whose critical plane is sought as well", ge=0, le=100_000, default=100
    )
    nodes: tuple[int, ...] = Field(
        default=(), description="surface nodes whose cycles are kept beside those of the worst of each region"
    )
    changes_an_hour: float | None = quantity(
        "1/h",
        "how often an hour the shovel goes from one of the runs through all others and back, a cycle between "
        "their extremes each; none: as often as the rarest of them",
        ge=0,
        le=1e6,
        default=None,
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        names = [run.name for run in self.runs]
        if len(set(names)) != len(names):
            raise ValueError(f"the runs' names must differ, got {names}")
        if list(self.survivals) != sorted(set(self.survivals)):
            raise ValueError(f"survivals must be different and rise, got {self.survivals}")
        check_shares({run.name: run.share for run in self.runs if run.share is not None})
        return self

    def times_an_hour(self, durations: list[float]) -> list[float]:
        """How often an hour each run happens, at durations in s; ValueError if all take more than an hour."""
        found = [run.times_an_hour(one) for run, one in zip(self.runs, durations, strict=True)]
        check_shares(
            {
                run.name: times * one / HOUR
                for run, times, one in zip(self.runs, found, durations, strict=True)
            }
        )
        return found


def check_shares(shares: dict[str, float]) -> None:
    """Refuse shares of the machine hours that are more than one together, by a ValueError."""
    whole = sum(shares.values())
    if whole > 1.0 + ROUNDING:
        taken = ", ".join(f"{name} {share:.4g}" for name, share in shares.items())
        raise ValueError(
            f"the runs must not take more than all machine hours, got {whole:.4g} of them: {taken}"
        )


def read_duty(path: str | Path) -> Duty:
    """Read a duty file (TOML); folders of runs count from the file's folder.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    CaseFileError
        Naming every key at fault by its path, and what is allowed there.
    """
    path = Path(path)

    def values(content: Content) -> Content:
        content.setdefault("name", path.stem)
        runs = content.get("runs")
        for run in runs if isinstance(runs, list) else []:
            if isinstance(run, dict) and isinstance(run.get("folder"), str):
                run["folder"] = str((path.parent / run["folder"]).resolve())
        return with_base(content, Duty)

    return read_parameters(path, Duty, "duty file", values)
