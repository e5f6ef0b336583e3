"""File of a wear forecast (TOML): parts with their sizes and laws, inspections, duties with their runs."""

import math
from pathlib import Path
from typing import Literal

from exudyn_crawler.results.wear.laws import PowerLaw, TwoRates, WearLaw
from exudyn_crawler.results.wear.parts import PartName, limit_fraction, limit_source, limit_words, parts
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, File, Name, Parameters, Several, option, quantity
from exudyn_crawler.settings.reading import read_parameters

FREE = "fitted"
SAME_SHARE = 1e-6
"""Greatest difference of a sum of shares from 1."""


class WearPart(Parameters):
    """Wearing part: its sizes and its law of wear."""

    part: PartName = option("wearing part")
    new: float = quantity(
        "m", "size of the new part: height or diameter, or the pitch of one link", (5e-3, 1.5), gt=0, le=10
    )
    limit: float | None = quantity(
        "m", "size at 100 % worn; none: makers' mean where they agree", (5e-3, 1.5), gt=0, le=10, default=None
    )
    exponent: float | Literal["fitted"] | None = quantity(
        "1",
        "exponent k of percent worn over hours, W = a x^k; none: Komatsu's",
        (0.8, 3.0),
        in_place=f"{FREE!r}: fitted, from four inspections on",
        default=None,
    )
    case: float | None = quantity(
        "1",
        "percent worn at which the hardened case ends, for a law of two rates in place of a power",
        (20.0, 100.0),
        gt=0,
        lt=100,
        default=None,
    )
    factor: float = quantity(
        "1", "rate of wear below the case over that in it", (1.0, 10.0), ge=1, le=100, default=3.0
    )
    coefficient: float | None = quantity(
        "m2/N",
        "worn volume over work, for hours without an inspection; W grows as the work",
        (1e-17, 1e-12),
        gt=0,
        le=1e-8,
        default=None,
    )
    volume: float | None = quantity(
        "m3",
        "worn volume at the limit, for the coefficient; none: of a pitch, its growth x diameter x length of "
        "the pin",
        (1e-8, 1e-2),
        gt=0,
        le=1.0,
        default=None,
    )
    reading_error: float | None = quantity(
        "m",
        "standard deviation of a reading; none: from the scatter of the readings",
        (1e-5, 2e-3),
        gt=0,
        le=0.1,
        default=None,
    )

    def _errors(self) -> Errors:
        fraction = limit_fraction(self.part)
        if self.limit is None and fraction is None:
            known = limit_words(self.part)
            makers = f"makers differ: {known}" if known else "no maker's limit is known here"
            yield f"limit must be given for a part {self.part!r}: {makers}"
        grows = self.part == "pitch"
        if self.limit is not None and not (self.limit > self.new if grows else self.limit < self.new):
            side = "above" if grows else "below"
            yield f"limit must be {side} new = {self.new:g} m, got {self.limit:g} m"
        if self.exponent is not None and self.case is not None:
            yield "exponent and case must not be given together: each is a law of wear"
        if self.coefficient is not None and self.volume is None and self.part != "pitch":
            yield f"volume must be given with a coefficient of a part {self.part!r}: worn volume at the limit"
        if self.volume is not None and self.coefficient is None:
            yield "coefficient must be given with a volume"
        if isinstance(self.exponent, float) and not 0.2 <= self.exponent <= 5.0:
            yield f"exponent must be from 0.2 to 5, got {self.exponent:g}"

    @property
    def size_at_limit(self) -> float:
        """Size at 100 % worn, m."""
        return self.new * (1.0 + (limit_fraction(self.part) or 0.0)) if self.limit is None else self.limit

    @property
    def law(self) -> WearLaw | None:
        """Law of wear; None: a power law whose exponent is fitted."""
        if self.case is not None:
            return TwoRates(self.case, self.factor)
        if self.exponent == FREE:
            return None
        return PowerLaw(parts()[self.part].exponent if self.exponent is None else float(self.exponent))

    @property
    def limit_source(self) -> str:
        """Source of the limit."""
        return limit_source(self.part) if self.limit is None else "wear file"

    @property
    def law_source(self) -> str:
        """Source of the law."""
        if self.exponent is not None or self.case is not None:
            return "wear file"
        found = parts()[self.part].field_exponent
        return f"Komatsu's exponent; {found:g} found in a coal mine (D375A-5)"


class PinJoint(Parameters):
    """Joint of two links: pin and bush."""

    radius: float | None = quantity(
        "m",
        "of a pin; none: that of the runs' case",
        (5e-3, 0.15),
        gt=0,
        le=1,
        default=None,
    )
    length: float | None = quantity(
        "m",
        "of the bearing of pin and bush; none: that of the runs' case",
        (0.02, 0.6),
        gt=0,
        le=5,
        default=None,
    )
    state: Literal["dry", "greased", "sealed"] | None = option(
        "lubrication; none: not known, and no hours by a coefficient", None
    )
    sealed_hours: float | None = quantity(
        "h", "propel hours until a sealed joint is dry", (10.0, 1e4), ge=0, le=1e6, default=None
    )

    def _errors(self) -> Errors:
        if self.sealed_hours is not None and self.state != "sealed":
            yield f"sealed_hours must go with state 'sealed', got {self.state!r}"


class WearRun(Parameters):
    """Run of a duty, or part of one, with its share of the propel hours."""

    name: Name = option("name in tables")
    folder: File = option("folder of the run, or its history")
    begin: float = quantity("s", "time in the run at which the counted part begins", ge=0, default=0.0)
    end: float | None = quantity("s", "time at which it ends; none: the run's end", gt=0, default=None)
    share: float = quantity("1", "share of the propel hours", gt=0, le=1)

    def _errors(self) -> Errors:
        if self.end is not None and self.end <= self.begin:
            yield f"end must be after begin = {self.begin:g} s, got {self.end:g} s"


class WearDuty(Parameters):
    """Mix of runs that the propel hours consist of."""

    name: Name = option("name of the duty", "duty")
    runs: Several[WearRun] = option("runs with their shares of the propel hours, together 1")

    def _errors(self) -> Errors:
        names = [run.name for run in self.runs]
        if len(set(names)) != len(names):
            yield f"the runs' names must differ, got {fields.shown(names)}"
        whole = sum(run.share for run in self.runs)
        if abs(whole - 1.0) > SAME_SHARE:
            yield f"shares of the propel hours must add up to 1, got {whole:.4g}"


class WearPlan(Parameters):
    """Forecast of wear: parts, inspections and duties."""

    name: Name = option("name of the forecast", "wear")
    inspections: File | None = option("CSV file of inspections; none: no hours without a coefficient", None)
    parts: tuple[WearPart, ...] = option("wearing parts with their sizes", ())
    duties: tuple[WearDuty, ...] = option(
        "duties: the first is that of the inspections, others are forecast", ()
    )
    pin: PinJoint = option("joint of two links", PinJoint())
    sweep: float = quantity(
        "rad",
        "least turn of a hinge that counts; pins without friction rattle by up to about 10 deg",
        (0.03, 0.5),
        ge=0,
        le=1.5,
        default=math.radians(20.0),
    )
    grouser_measure: Literal["friction work", "load times slip"] = option(
        "measure of a grouser's wear; they differ by 2 to 26 times, and a coefficient belongs to one",
        "friction work",
    )
    by_run: bool = option(
        "fit a coefficient for each column `hours NAME` of the inspections, not one for all hours", False
    )
    propel_share: float | None = quantity(
        "1",
        "propel hours over machine hours; none: as counted by inspections",
        (0.01, 0.5),
        gt=0,
        le=1,
        default=None,
    )

    def _errors(self) -> Errors:
        names = [part.part for part in self.parts]
        if double := sorted({name for name in names if names.count(name) > 1}):
            yield f"parts must differ, got {double[0]!r} twice"
        duties = [duty.name for duty in self.duties]
        if len(set(duties)) != len(duties):
            yield f"the duties' names must differ, got {fields.shown(duties)}"
        if self.inspections is None and not self.duties:
            yield "inspections or duties must be given, got neither"
        by_coefficient = [part for part in self.parts if part.coefficient is not None]
        if by_coefficient and not self.duties:
            yield "duties must be given with a coefficient, which is worn volume over their work"
        if any(part.part == "pitch" for part in by_coefficient) and self.pin.state is None:
            yield "pin.state must be given with a coefficient of the pitch: dry, greased or sealed"
        if by_coefficient and self.pin.state == "sealed" and self.pin.sealed_hours is None:
            yield "pin.sealed_hours must be given with a coefficient and sealed pins"
        if self.inspections is not None and not self.parts:
            yield "parts must be given with inspections: new size and limit of each measured part"

    def part(self, name: str) -> WearPart | None:
        """Return a part by its name; None if the file does not have it."""
        return next((part for part in self.parts if part.part == name), None)


def read_wear(path: str | Path) -> WearPlan:
    """Read a file of a wear forecast (TOML); paths start at its folder; raise as `read_case`."""
    path = Path(path)
    return read_parameters(
        path, WearPlan, "file of a wear forecast", lambda content: {"name": path.stem} | content
    )
