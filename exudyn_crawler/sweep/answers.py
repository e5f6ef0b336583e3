"""Answers of a sweep: what of every run stands in its table.

An answer is a class with the field `model`, checked against the case before anything runs; `Answers` names
all of them.
"""

import difflib
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
import xarray as xr
from pydantic import Field, TypeAdapter, model_validator

from exudyn_crawler.case import Case, CaseFile
from exudyn_crawler.case.parameters.base import Name, Parameters
from exudyn_crawler.case.parameters.base import quantity as measured
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.results.history.catalogue import QUANTITIES, Quantity, select
from exudyn_crawler.results.life.duty import Duty, DutyRun, Survival
from exudyn_crawler.results.life.fatigue_material import FatigueMaterial
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.results.stress.hot_spots import HOT_SPOTS, Region, shoe_regions
from exudyn_crawler.run.folder.folder import SAME_TIME
from fem.fatigue import Miner

COUNTED = {
    "shoe": "shoes",
    "flexible shoe": "flexible shoes",
    "link": "links",
    "pin": "links",
    "unit": "units",
    "roller": "rollers",
    "side frame": "",
    "track": "",
}
"""What an answer can be of, and how several are called; nothing where there is one of it."""
DIMENSIONS = ("shoe", "joint", "unit", "flexible_shoe", "roller")
"""Of what an answer is of."""

Statistic = Literal["greatest", "least", "largest", "mean", "rms", "range", "end"]


class AnyAnswer(Parameters):
    """What all answers have.

    A kind of answer adds a field `model` with its name, `label`, `unit` and `meaning` of its column,
    ``check(case_file)``, which refuses what runs of a case cannot give, and ``of_run(run)``, its number.
    """

    name: Name | None = Field(default=None, description="column of the table; made of the rest, if not given")
    better: Literal["less", "more"] = Field(
        default="less", description="which runs are the best ones: those with less or with more of it"
    )


class Answer(AnyAnswer):
    """A quantity of the catalogue over a time, made one number by a statistic.

    Vectors count by their length, or by one axis. Of several shoes, links or units, contacts by shoe, the
    statistic is that of all of them together.
    """

    model: Literal["quantity"] = "quantity"
    quantity: str = Field(description="name in the catalogue, such as joint_force")
    statistic: Statistic = Field(
        default="greatest",
        description="greatest, least, largest (in magnitude), mean, rms, range, or end: the mean at the end",
    )
    axis: Literal["x", "y", "z"] | None = Field(
        default=None, description="component of a vector, global; its length, if not given"
    )
    of: tuple[int, ...] | None = Field(
        default=None, description="numbers of the shoes, links or units; all, if not given", min_length=1
    )
    start: float = measured("s", "first time that counts", ge=0, default=0.0)
    end: float | None = measured("s", "last time that counts; the run's end, if not given", default=None)

    @model_validator(mode="after")
    def _check(self) -> Self:
        over_time = select(dimensions="time")
        if self.quantity not in over_time:
            near = difflib.get_close_matches(self.quantity, over_time, n=1, cutoff=0.0)
            raise ValueError(
                f"quantity must be one over time, got {self.quantity!r}; the nearest is {near[0]!r}"
            )
        if not _is_answer(over_time[self.quantity]):
            raise ValueError(
                "quantity must be a number or a vector of a shoe, link, unit, roller or the whole track, "
                f"got {self.quantity!r}: {over_time[self.quantity].meaning}"
            )
        if self.axis is not None and "axis" not in QUANTITIES[self.quantity].dimensions:
            raise ValueError(f"axis must be left out with {self.quantity}, which is no vector")
        if self.end is not None and self.end <= self.start:
            raise ValueError(f"end must be greater than start = {self.start:g} s, got {self.end:g} s")
        return self

    @property
    def label(self) -> str:
        """Name of the column."""
        parts = [self.quantity, self.axis, self.statistic, *map(str, self.of or ())]
        return self.name or "_".join(part for part in parts if part)

    @property
    def unit(self) -> str:
        """Unit of the column."""
        return QUANTITIES[self.quantity].unit

    @property
    def meaning(self) -> str:
        """What it is, for reading."""
        axis = f", {self.axis}" if self.axis else ""
        return f"{self.statistic} of {QUANTITIES[self.quantity].meaning}{axis}"

    def check(self, case_file: CaseFile) -> None:
        """Refuse what runs of a case cannot give.

        Raises
        ------
        ValueError
            Naming the answer.
        """
        case, quantity = case_file.case, QUANTITIES[self.quantity]
        if lacking := quantity.lacking(case):
            near = " (joint_force is that of whole links)" if self.quantity == "pin_force" else ""
            raise ValueError(f"{self.label}: {self.quantity} needs {lacking}{near}")
        _check_within(self.label, case_file, start=self.start, end=self.end)
        what, numbers = COUNTED[_per(quantity)], _numbers(quantity, case)
        wrong = [one for one in self.of or () if one not in numbers]
        if wrong and not what:
            raise ValueError(
                f"{self.label}: of must be left out, {self.quantity} is of the whole {quantity.per}"
            )
        if wrong:
            raise ValueError(f"{self.label}: of must be {what} of {_span(numbers)}, got {wrong}")

    @property
    def _window(self) -> slice:
        return slice(self.start - SAME_TIME, None if self.end is None else self.end + SAME_TIME)

    def of_run(self, run: CaseRun) -> float:
        """Number of a run; NaN where it is of nothing."""
        stress = run.recovered().dataset if "stress" in QUANTITIES[self.quantity].files else None
        values = run.history.over_time([self.quantity], stress)[self.quantity].sel(time=self._window)
        if "axis" in values.dims:
            values = ((values**2).sum("axis") ** 0.5) if self.axis is None else values.sel(axis=self.axis)
        item = next((dim for dim in DIMENSIONS if dim in values.dims), None)
        if item is not None and self.of is not None:
            values = values.sel({item: list(self.of)})
        return _reduced(values, self.statistic)


class HotSpot(AnyAnswer):
    """Von Mises stress of a hot spot of a flexible shoe over the run."""

    model: Literal["hot_spot"] = "hot_spot"
    shoe: int = Field(description="number of the shoe")
    rank: int = Field(default=1, ge=1, le=HOT_SPOTS, description="1: the hottest")

    unit: ClassVar[str] = "Pa"

    @property
    def label(self) -> str:
        """Name of the column."""
        return self.name or f"hot_spot_{self.rank}_shoe_{self.shoe}"

    @property
    def meaning(self) -> str:
        """What it is, for reading."""
        return f"von Mises stress of hot spot {self.rank} of shoe {self.shoe}"

    def check(self, case_file: CaseFile) -> None:
        """Refuse what runs of a case cannot give; raises as `Answer.check`."""
        flexible = case_file.case.flexible
        if flexible is None or self.shoe not in flexible.shoes:
            there = "none" if flexible is None else ", ".join(map(str, flexible.shoes))
            raise ValueError(f"{self.label}: shoe must be a flexible one ({there}), got {self.shoe}")

    def of_run(self, run: CaseRun) -> float:
        """Number of a run; NaN where it has fewer hot spots."""
        table = run.recovered().hot_spots[self.shoe]
        stress = table.loc[table["rank"] == self.rank, "value"]
        return float(stress.iloc[0]) if len(stress) else float("nan")


class Life(AnyAnswer):
    """Shortest life of the flexible shoes where all machine hours are like the run, or as a share of them."""

    model: Literal["life"] = "life"
    better: Literal["less", "more"] = Field(
        default="more", description="which runs are the best ones: those with less or with more of it"
    )
    material: FatigueMaterial = Field(description="of the shoes against cyclic stress")
    region: Region | None = Field(
        default=None, description="part of the shoe whose shortest life counts; all, if not given"
    )
    survival: Survival = Field(default=0.975, description="part of the shoes that survive it")
    begin: float = measured("s", "time at which the repeated part of the run begins", ge=0, default=0.0)
    end: float | None = measured("s", "time at which it ends; the run's end, if not given", default=None)
    an_hour: float | None = measured(
        "1/h", "times a machine hour that it happens; or its share", gt=0, le=1e6, default=None
    )
    share: float | None = measured(
        "1", "part of the machine hours that it takes; all, if neither is given", gt=0, le=1, default=None
    )
    criterion: Literal["signed von mises", "signed principal"] = Field(
        default="signed von mises", description="stress whose cycles are counted"
    )
    miner: Miner = Field(default="elementary", description="what cycles below the knee do")

    unit: ClassVar[str] = "h"

    @model_validator(mode="after")
    def _check(self) -> Self:
        self.duty()
        return self

    @property
    def label(self) -> str:
        """Name of the column."""
        return self.name or "_".join(filter(None, ("life", self.region and self.region.replace(" ", "_"))))

    @property
    def meaning(self) -> str:
        """What it is, for reading."""
        where = f" of {self.region}" if self.region else ""
        return f"machine hours to a crack{where}, {100 * self.survival:g} % survive"

    def duty(self) -> Duty:
        """Duty that is made of the run alone; raises `ParameterError` as that does."""
        often = {"an_hour": self.an_hour, "share": self.share}
        if often == {"an_hour": None, "share": None}:
            often["share"] = 1.0
        return Duty(
            runs=(DutyRun(name="run", folder=".", begin=self.begin, end=self.end, **often),),
            material=self.material,
            criterion=self.criterion,
            miner=self.miner,
            survivals=(self.survival,),
            plane_nodes=0,
        )

    def check(self, case_file: CaseFile) -> None:
        """Refuse what runs of a case cannot give.

        Raises
        ------
        ValueError
            Naming the answer.
        """
        if case_file.case.flexible is None:
            raise ValueError(f"{self.label}: life needs flexible shoes, the case has none")
        _check_within(self.label, case_file, begin=self.begin, end=self.end)

    def of_run(self, run: CaseRun) -> float:
        """Shortest life of a run, h; 1e9 stands for all beyond."""
        result = life_of(self.duty(), [run.history])
        lives = result.dataset.life.isel(survival=0)
        if self.region is not None:
            lives = lives[shoe_regions(result.whole, run.history.case.track) == self.region]
        return float(lives.min())


Answers = Annotated[Answer | HotSpot | Life, Field(discriminator="model")]
"""Every kind of answer; another one is a class like these, and stands here."""

ANSWERS: TypeAdapter[tuple[Answers, ...]] = TypeAdapter(tuple[Answers, ...])
"""Reads and writes answers as JSON."""


def _check_within(label: str, case_file: CaseFile, **times: float | None) -> None:
    """Refuse times that lie beyond a run.

    Raises
    ------
    ValueError
        Naming the answer and the time.
    """
    for name, time in times.items():
        if time is not None and time > case_file.duration:
            raise ValueError(
                f"{label}: {name} must lie within the run of {case_file.duration:g} s, got {time:g} s"
            )


def _is_answer(quantity: Quantity) -> bool:
    """Whether a quantity over time has statistics: real numbers of what is counted, no matrix."""
    is_real = quantity.numbers in ("double", "single") and "body_axis" not in quantity.dimensions
    return is_real and _per(quantity) in COUNTED


def _per(quantity: Quantity) -> str:
    """What an answer has one of: contacts count by shoe, since two runs need not have the same pairs."""
    return "shoe" if quantity.by_shoe else quantity.per


def _numbers(quantity: Quantity, case: Case) -> tuple[int, ...]:
    """Numbers of the shoes, links, units or rollers of a case that a quantity is of."""
    flexible = () if case.flexible is None else case.flexible.shoes
    joints = case.track.joints.tolist()
    rollers = () if case.undercarriage is None else case.undercarriage.rollers
    counted = {
        "shoe": case.track.shoes.tolist(),
        "flexible shoe": flexible,
        "link": joints,
        # a link has two pins where one of its shoes is flexible
        "pin": [one for one in joints if {one, one + 1} & set(flexible)],
        "unit": case.terrain.units.tolist(),
        "roller": range(1, len(rollers) + 1),
    }
    return tuple(counted.get(_per(quantity), ()))


def _span(numbers: tuple[int, ...]) -> str:
    """Numbers for reading: 1..13, or each."""
    if numbers == tuple(range(1, len(numbers) + 1)):
        return f"1..{len(numbers)}"
    return ", ".join(map(str, numbers))


def _reduced(values: xr.DataArray, statistic: Statistic) -> float:
    """One number of all values; NaN of none."""
    if not bool(values.notnull().any()):
        return float("nan")
    if statistic == "end":
        return float(values.isel(time=-1).mean())
    if statistic == "largest":
        return float(abs(values).max())
    if statistic == "rms":
        return float(np.sqrt((values**2).mean()))
    if statistic == "range":
        return float(values.max() - values.min())
    if statistic == "mean":
        return float(values.mean())
    return float(values.max() if statistic == "greatest" else values.min())
