"""File of a wear forecast (TOML): parts with their sizes and laws, inspections, duties with their runs."""

from pathlib import Path
from typing import Literal

from exudyn_crawler.results.wear.laws import PowerLaw, TwoRates, WearLaw
from exudyn_crawler.results.wear.parts import PartName, limit_fraction, limit_words, makers_limits, parts
from exudyn_crawler.settings.parameters import Errors, File, Name, Parameters, option, quantity
from exudyn_crawler.settings.reading import read_parameters

FREE = "fitted"


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
        if self.limit is not None:
            return "wear file"
        rows = [row for row in makers_limits() if row.part == self.part]
        return f"mean of {', '.join(f'{row.machine} ({row.source})' for row in rows)}"

    @property
    def law_source(self) -> str:
        """Source of the law."""
        if self.exponent is not None or self.case is not None:
            return "wear file"
        found = parts()[self.part].field_exponent
        return f"Komatsu's exponent; {found:g} found in a coal mine (D375A-5)"


class WearPlan(Parameters):
    """Forecast of wear: parts, inspections and duties."""

    name: Name = option("name of the forecast", "wear")
    inspections: File | None = option("CSV file of inspections; none: no hours without a coefficient", None)
    parts: tuple[WearPart, ...] = option("wearing parts with their sizes", ())
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
        if self.inspections is None:
            yield "inspections must be given"
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
