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
from exudyn_crawler.case.parameters.base import quantity as measured
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.results.history.catalogue import QUANTITIES
from exudyn_crawler.results.history.derived import contacts_of, terrain_deformation
from exudyn_crawler.results.stress.stresses import HOT_SPOTS
from exudyn_crawler.run.folder.histories import SAME_TIME
from exudyn_crawler.sweep.answer_base import AnyAnswer, check_within
from exudyn_crawler.sweep.life import Life

BY_SHOE = (
    "normal_force",
    "friction_force",
    "contact_force",
    "friction_torque",
    "penetration",
    "penetration_rate",
    "slip_velocity",
)
"""Quantities of contacts, which are told by shoe: two runs need not have the same pairs."""
FLEXIBLE = ("modal_coordinate", "modal_velocity", "pin_force", "pin_torque", "highest_von_mises")
"""Quantities that only runs with flexible shoes have."""
ROLLED = ("side_frame_", "drive_pull", "roller_", "tread_")
"""How those begin that only runs with an undercarriage have."""
NO_ANSWERS = ("area", "point", "displacement", "highest_node", "roller_shoe", "tread_foot")
"""Quantities over time that are no answers: of pairs, of figures, numbers and places of parts."""
QUANTITIES_OVER_TIME = tuple(
    name
    for name, one in QUANTITIES.items()
    if "time" in one.dimensions and "terrain_mode" not in one.dimensions and name not in NO_ANSWERS
)
ITEMS = ("shoe", "joint", "unit", "flexible_shoe", "roller")

Statistic = Literal["greatest", "least", "largest", "mean", "rms", "range", "end"]


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
        if self.quantity not in QUANTITIES_OVER_TIME:
            near = difflib.get_close_matches(self.quantity, QUANTITIES_OVER_TIME, n=1, cutoff=0.0)
            raise ValueError(
                f"quantity must be one over time, got {self.quantity!r}; the nearest is {near[0]!r}"
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
        return f"{self.statistic} of {QUANTITIES[self.quantity].long_name}{axis}"

    def check(self, case_file: CaseFile) -> None:
        """Refuse what runs of a case cannot give.

        Raises
        ------
        ValueError
            Naming the answer.
        """
        case = case_file.case
        if self.quantity.startswith(ROLLED) and case.undercarriage is None:
            raise ValueError(f"{self.label}: {self.quantity} needs an undercarriage, the case has none")
        if self.quantity in FLEXIBLE and case.flexible is None:
            near = " (joint_force is that of whole links)" if self.quantity == "pin_force" else ""
            raise ValueError(f"{self.label}: {self.quantity} needs flexible shoes, the case has none{near}")
        check_within(self.label, case_file, start=self.start, end=self.end)
        what, numbers = _items(self.quantity, case)
        wrong = [one for one in self.of or () if one not in numbers]
        if wrong and not what:
            raise ValueError(f"{self.label}: of must be left out, {self.quantity} is of the whole track")
        if wrong:
            raise ValueError(f"{self.label}: of must be {what} of {_span(numbers)}, got {wrong}")

    @property
    def _window(self) -> slice:
        return slice(self.start - SAME_TIME, None if self.end is None else self.end + SAME_TIME)

    def of_run(self, run: CaseRun) -> float:
        """Number of a run; NaN where it is of nothing."""
        values = _over_time(run, self.quantity).sel(time=self._window)
        if "axis" in values.dims:
            values = ((values**2).sum("axis") ** 0.5) if self.axis is None else values.sel(axis=self.axis)
        item = next((dim for dim in ITEMS if dim in values.dims), None)
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
        found = table.loc[table["rank"] == self.rank, "value"]
        return float(found.iloc[0]) if len(found) else float("nan")


Answers = Annotated[Answer | HotSpot | Life, Field(discriminator="model")]
"""Every kind of answer; another one is a class like these, and stands here."""

ANSWERS: TypeAdapter[tuple[Answers, ...]] = TypeAdapter(tuple[Answers, ...])
"""Reads and writes answers as JSON."""


def _items(name: str, case: Case) -> tuple[str, tuple[int, ...]]:
    """What a quantity is of, and the numbers that there are: shoes, links or units."""
    shoes = tuple(case.track.shoes.tolist())
    flexible = () if case.flexible is None else case.flexible.shoes
    if name in ("highest_von_mises", "modal_coordinate", "modal_velocity"):
        return "flexible shoes", flexible
    dimensions = QUANTITIES[name].dimensions
    if name in BY_SHOE or "shoe" in dimensions:
        return "shoes", shoes
    if "pin" in dimensions:
        # a link has two pins where one of its shoes is flexible
        return "links", tuple(one for one in case.track.joints.tolist() if {one, one + 1} & set(flexible))
    if "joint" in dimensions:
        return "links", tuple(case.track.joints.tolist())
    if "roller" in dimensions and case.undercarriage is not None:
        return "rollers", tuple(range(1, len(case.undercarriage.rollers) + 1))
    return ("units", tuple(case.terrain.units.tolist())) if "unit" in dimensions else ("", ())


def _span(numbers: tuple[int, ...]) -> str:
    """Numbers for reading: 1..13, or each."""
    if numbers == tuple(range(1, len(numbers) + 1)):
        return f"1..{len(numbers)}"
    return ", ".join(map(str, numbers))


def _over_time(run: CaseRun, name: str) -> xr.DataArray:
    """Quantity of a run over time."""
    if name == "highest_von_mises":
        return run.recovered().dataset[name]
    if name == "terrain_deformation":
        return terrain_deformation(run.history)
    return contacts_of(run.history.dataset)[name] if name in BY_SHOE else run.history.dataset[name]


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
