"""Answers of a sweep: numbers of each run in its table, one class for each kind, checked before any run."""

import difflib
from typing import Annotated, Any, ClassVar, Literal

import xarray as xr
from pydantic import Field, TypeAdapter

from exudyn_crawler.case import Case
from exudyn_crawler.case.gear.base import WheelKind
from exudyn_crawler.case_run import CaseRun
from exudyn_crawler.machines import CaseFile
from exudyn_crawler.results.history import catalogue
from exudyn_crawler.results.history.catalogue import QUANTITIES, select
from exudyn_crawler.results.history.quantities import DTYPES, Quantity
from exudyn_crawler.results.life.duty import DamageOptions, Duty, DutyRun, Often, Survival
from exudyn_crawler.results.life.life import life_of
from exudyn_crawler.results.measured.drawbar import drawbar_result
from exudyn_crawler.results.stress.hot_spots import HOT_SPOTS, Region, shoe_regions
from exudyn_crawler.run.folder.folder import SAME_TIME
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, Name, Parameters, option, quantity as measured

ANSWERABLE = {
    name: entry
    for name, entry in select(dimensions="time").items()
    if entry.numbers in DTYPES
    and "body_axis" not in entry.dimensions
    and (entry.by_shoe or entry.per not in ("pair", "terrain coordinate", "tread"))
}
"""Quantities over time with statistics: real numbers and vectors of bodies that all runs have."""
DIMENSIONS = ("shoe", "joint", "unit", "flexible_shoe", "roller")  # of the items of an answer

DRAWBAR_RESULTS = {
    "greatest_pull": ("N", "greatest drawbar pull"),
    "gradeability": ("rad", "grade whose tangent is the greatest drawbar pull over the weight"),
    "motion_resistance": ("N", "motion resistance without a pull"),
    "efficiency": ("1", "best work of the drawbar pull over that of the drive"),
}
"""Unit and meaning of the numbers of a drawbar test other than the pull at a slip."""

STATISTICS: dict[str, Any] = {
    "greatest": xr.DataArray.max,
    "least": xr.DataArray.min,
    "largest": lambda values: abs(values).max(),
    "mean": xr.DataArray.mean,
    "rms": lambda values: (values**2).mean() ** 0.5,
    "range": lambda values: values.max() - values.min(),
    "end": lambda values: values.isel(time=-1).mean(),
}


class AnyAnswer(Parameters):
    """Parameters that all answers have.

    A kind of answer adds a field `model` with its name; `_column`: name, unit and meaning of its column;
    ``_case_errors(case_file)``: errors for a case whose runs cannot give the answer; and ``of_run(run)``: its
    number, NaN if a run has none.
    """

    name: Name | None = option("column of the table; none: made from the other keys", None)
    better: Literal["less", "more"] = option("direction of better runs: less or more of the answer", "less")

    _column: ClassVar[Any]
    _case_errors: ClassVar[Any]

    @property
    def label(self) -> str:
        """Name of the column."""
        return self.name or self._column[0]

    @property
    def unit(self) -> str:
        """Unit of the column."""
        return self._column[1]

    @property
    def meaning(self) -> str:
        """Meaning, for readers."""
        return self._column[2]

    def check(self, case_file: CaseFile) -> None:
        """Raise `ValueError`, with the name of the answer, if runs of a case cannot give it."""
        for error in self._case_errors(case_file):
            raise ValueError(f"{self.label}: {error}")


class Answer(AnyAnswer):
    """Quantity of the catalogue over a time, reduced to one number by a statistic.

    A vector counts by its length or by one axis. With several shoes, links or units the statistic is that of
    all of them; contacts count by shoe.
    """

    model: Literal["quantity"] = "quantity"
    quantity: str = option("name of a quantity in the catalogue, such as joint_force")
    statistic: Literal["greatest", "least", "largest", "mean", "rms", "range", "end"] = option(
        "statistic over time: greatest, least, largest (in magnitude), mean, rms, range, or end (mean"
        " at the end)",
        "greatest",
    )
    axis: Literal["x", "y", "z"] | None = option("global component of a vector; none: its magnitude", None)
    of: tuple[int, ...] | None = option("numbers of shoes, links or units; none: all", None, min_length=1)
    wheels: WheelKind | None = option("kind of wheels of a closed track; none: all", None)
    start: float = measured("s", "first counted time", ge=0, default=0.0)
    end: float | None = measured("s", "last counted time; none: the run's end", default=None)

    def _errors(self) -> Errors:
        if self.quantity not in ANSWERABLE:
            near = difflib.get_close_matches(self.quantity, ANSWERABLE, n=1, cutoff=0.0)
            of = "a number or a vector over time, of a shoe, link, unit, roller or the track"
            yield f"quantity must be {of}, got {self.quantity!r}; the nearest is {near[0]!r}"
        if self.axis is not None and "axis" not in QUANTITIES[self.quantity].dimensions:
            yield f"axis must be left out with {self.quantity}, which is not a vector"
        if self.wheels is not None and "wheel" not in QUANTITIES[self.quantity].dimensions:
            yield f"wheels must be left out with {self.quantity}, which is not of wheels"
        if self.end is not None and self.end <= self.start:
            yield f"end must be greater than start = {self.start:g} s, got {self.end:g} s"

    @property
    def _column(self) -> tuple[str, str, str]:
        quantity = QUANTITIES[self.quantity]
        axis = f", {self.axis}" if self.axis else ""
        parts = [self.quantity, self.axis, self.statistic, self.wheels, *map(str, self.of or ())]
        name = "_".join(filter(None, parts))
        kind = f", {self.wheels}" if self.wheels else ""
        return name, quantity.unit, f"{self.statistic} of {quantity.meaning}{axis}{kind}"

    def _case_errors(self, case_file: CaseFile) -> Errors:
        case = case_file.case
        quantity = QUANTITIES[self.quantity]
        if lacking := catalogue.lacking(quantity, case):
            yield f"{self.quantity} needs {lacking}"
        yield from _beyond(case_file, start=self.start, end=self.end)
        kinds = {label.kind for label in case.gear.wheel_labels}
        if self.wheels is not None and not lacking and self.wheels not in kinds:
            yield f"wheels must be {' or '.join(sorted(kinds))}, got {self.wheels!r}"
        what, numbers = _counted(quantity, case)
        wrong = [number for number in self.of or () if number not in numbers]
        if wrong and not numbers:
            yield f"of must be left out, {self.quantity} is of the whole {what}"
        if wrong:
            yield f"of must be {what}s of {fields.shown(numbers)}, got {wrong}"

    def of_run(self, run: CaseRun) -> float:
        """Return the number of a run."""
        stress = run.recovered().dataset if "stress" in QUANTITIES[self.quantity].files else None
        window = slice(self.start - SAME_TIME, None if self.end is None else self.end + SAME_TIME)
        values = run.history.over_time([self.quantity], stress)[self.quantity].sel(time=window)
        if "axis" in values.dims:
            values = ((values**2).sum("axis") ** 0.5) if self.axis is None else values.sel(axis=self.axis)
        if self.wheels is not None:
            labels = run.history.case.gear.wheel_labels
            values = values.sel(wheel=[label.words for label in labels if label.kind == self.wheels])
        item = next((dim for dim in DIMENSIONS if dim in values.dims), None)
        if item is not None and self.of is not None:
            values = values.sel({item: list(self.of)})
        return float(STATISTICS[self.statistic](values)) if values.notnull().any() else float("nan")


class HotSpot(AnyAnswer):
    """Von Mises stress at a hot spot of a flexible shoe over the run."""

    model: Literal["hot_spot"] = "hot_spot"
    shoe: int = option("number of the shoe")
    rank: int = option("rank of the hot spot; 1: highest stress", 1, ge=1, le=HOT_SPOTS)

    @property
    def _column(self) -> tuple[str, str, str]:
        meaning = f"von Mises stress of hot spot {self.rank} of shoe {self.shoe}"
        return f"hot_spot_{self.rank}_shoe_{self.shoe}", "Pa", meaning

    def _case_errors(self, case_file: CaseFile) -> Errors:
        flexible = case_file.case.flexible
        if flexible is None or self.shoe not in flexible.shoes:
            there = "none" if flexible is None else ", ".join(map(str, flexible.shoes))
            yield f"shoe must be a flexible one ({there}), got {self.shoe}"

    def of_run(self, run: CaseRun) -> float:
        """Return the stress in a run (Pa)."""
        by_rank = run.recovered().hot_spots[self.shoe].set_index("rank")["value"]
        return float(by_rank.get(self.rank, float("nan")))


class Life(AnyAnswer, DamageOptions, Often):
    """Shortest life of the flexible shoes if all machine hours, or a share of them, are like the run."""

    model: Literal["life"] = "life"
    better: Literal["less", "more"] = option("direction of better runs: less or more of the answer", "more")
    region: Region | None = option("region of the shoe whose shortest life counts; none: all", None)
    survival: Survival = option("probability of survival of the life", 0.975)

    def _errors(self) -> Errors:
        self.duty()
        yield from ()

    @property
    def _column(self) -> tuple[str, str, str]:
        name = f"life_{self.region}".replace(" ", "_") if self.region else "life"
        where = f" of {self.region}" if self.region else ""
        return name, "h", f"machine hours to a crack{where}, {100 * self.survival:g} % survive"

    def duty(self) -> Duty:
        """Return the duty of the run alone.

        Raises `ParameterError` if the duty is not allowed.
        """
        repeated = {name: getattr(self, name) for name in Often.model_fields}
        if self.an_hour is None and self.share is None:
            repeated["share"] = 1.0
        run = DutyRun(name="run", folder=".", **repeated)
        damage = {name: getattr(self, name) for name in DamageOptions.model_fields}
        return Duty(runs=(run,), survivals=(self.survival,), plane_nodes=0, **damage)

    def _case_errors(self, case_file: CaseFile) -> Errors:
        if case_file.case.flexible is None:
            yield "life needs flexible shoes, the case has none"
        yield from _beyond(case_file, begin=self.begin, end=self.end)

    def of_run(self, run: CaseRun) -> float:
        """Return the shortest life of a run (h); 1e9 stands for all longer lives."""
        result = life_of(self.duty(), [run.history])
        lives = result.dataset.life.isel(survival=0)
        if self.region is not None:
            lives = lives[shoe_regions(result.whole, run.history.case.track) == self.region]
        return float(lives.min())


class Drawbar(AnyAnswer):
    """Number of a drawbar test: of a case whose drive holds slips, made by the command `drawbar`."""

    model: Literal["drawbar"] = "drawbar"
    better: Literal["less", "more"] = option("direction of better runs: less or more of the answer", "more")
    result: Literal["pull", "greatest_pull", "gradeability", "motion_resistance", "efficiency"] = option(
        "pull at the given slip, or over all slips the greatest pull, gradeability, resistance "
        "without a pull, best efficiency",
        "pull",
    )
    slip: float = measured("1", "slip of the pull", ge=0, le=1, default=0.2)

    @property
    def _column(self) -> tuple[str, str, str]:
        if self.result == "pull":
            return f"pull_at_slip_{self.slip:g}", "N", f"drawbar pull at a slip of {self.slip:g}"
        return self.result, *DRAWBAR_RESULTS[self.result]

    def _case_errors(self, case_file: CaseFile) -> Errors:
        slip = case_file.case.drive.slip
        if slip is None:
            yield "drawbar needs a drive.slip, as the command drawbar sets it"
        elif self.result == "pull" and max(slip.values) < self.slip:
            yield f"slip must be at most the greatest held slip, {max(slip.values):g}, got {self.slip:g}"

    def of_run(self, run: CaseRun) -> float:
        """Return the number of a run."""
        result = drawbar_result(run.history, self.slip)
        return {
            "pull": result.pull_at_slip,
            "greatest_pull": result.greatest_pull,
            "gradeability": result.gradeability,
            "motion_resistance": result.motion_resistance,
            "efficiency": result.best_efficiency,
        }[self.result]


Answers = Annotated[Answer | HotSpot | Life | Drawbar, Field(discriminator="model")]
"""All kinds of answers; a new kind is a class like these and stands here."""

ANSWERS: TypeAdapter[tuple[Answers, ...]] = TypeAdapter(tuple[Answers, ...])
"""Reader and writer of answers as JSON."""


def _beyond(case_file: CaseFile, **times: float | None) -> Errors:
    """Yield an error for each of `times` after the end of the run."""
    for name, time in times.items():
        if time is not None and time > case_file.duration:
            yield f"{name} must lie within the run of {case_file.duration:g} s, got {time:g} s"


def _counted(quantity: Quantity, case: Case) -> tuple[str, list[int]]:
    """Return the kind of a quantity's items and their numbers.

    Contacts count by shoe, since pairs differ from run to run.
    """
    flexible = [] if case.flexible is None else [*case.flexible.shoes]
    links = case.gear.joints(case.track).tolist()
    counted = {
        "shoe": case.track.shoes.tolist(),
        "flexible shoe": flexible,
        "link": links,
        # a link has two pins where one of its shoes is flexible
        "pin": [link for link in links if {link, link % case.track.shoe_count + 1} & {*flexible}],
        "unit": case.terrain.units.tolist(),
        "roller": [*range(1, len(case.gear.wheel_names) + 1)],
    }
    what = "shoe" if quantity.by_shoe else quantity.per
    return what, counted.get(what, [])
