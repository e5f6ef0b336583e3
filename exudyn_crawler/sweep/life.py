"""Life of the shoes as an answer of a sweep."""

from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from exudyn_crawler.case import CaseFile
from exudyn_crawler.case.parameters.base import quantity
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.results.life.duty import Duty, DutyRun, Survival
from exudyn_crawler.results.life.fatigue_material import FatigueMaterial
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.results.stress.regions import Region, shoe_regions
from exudyn_crawler.sweep.answer_base import AnyAnswer, check_within
from fem.fatigue import Miner


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
    begin: float = quantity("s", "time at which the repeated part of the run begins", ge=0, default=0.0)
    end: float | None = quantity("s", "time at which it ends; the run's end, if not given", default=None)
    an_hour: float | None = quantity(
        "1/h", "times a machine hour that it happens; or its share", gt=0, le=1e6, default=None
    )
    share: float | None = quantity(
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
        check_within(self.label, case_file, begin=self.begin, end=self.end)

    def of_run(self, run: CaseRun) -> float:
        """Shortest life of a run, h; 1e9 stands for all beyond."""
        found = life_of(self.duty(), [run.history])
        lives = found.dataset.life.isel(survival=0)
        if self.region is not None:
            lives = lives[shoe_regions(found.whole, run.history.case.track) == self.region]
        return float(lives.min())
