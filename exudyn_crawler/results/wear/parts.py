"""Wearing parts of an undercarriage: exponents of wear over hours, and makers' limits.

Komatsu's exponents and those that fit D375A-5 dozers of a coal mine are from an abstract (Batukajang, 2013 to
2014). Every limit of `limits.csv` names its manual.
"""

from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple

from exudyn_crawler.settings.rows import read_rows

PartName = Literal["pitch", "rail", "bush", "roller", "carrier", "idler", "sprocket", "grouser"]
SAME_LIMIT = 1.2
"""Greatest ratio of the worn fractions of different machines whose mean is a default. Chosen here."""


class WearingPart(NamedTuple):
    """Row of the table of parts."""

    part: str
    measure: str
    """Measured size."""
    each_place: bool
    """True if every place has a part of its own; else places are samples of one part."""
    exponent: float
    """Komatsu's exponent of percent worn over hours."""
    field_exponent: float
    """Exponent found in the field."""
    due: str
    """Action at 100 %."""
    due_turned: str
    """Action at 100 % after pins and bushes were turned."""


class MakersLimit(NamedTuple):
    """Row of the table of limits."""

    part: str
    machine: str
    new: float
    """mm."""
    limit: float
    """mm."""
    source: str
    mark: str
    """S: seen in a text of the source."""

    @property
    def fraction(self) -> float:
        """Change of the size at the limit, fraction of the new size; a chain grows, other parts shrink."""
        return (self.limit - self.new) / self.new


@cache
def parts() -> dict[str, WearingPart]:
    """Return the wearing parts by name."""
    rows = read_rows(Path(__file__).with_name("parts.csv"), WearingPart)
    return {row.part: row for row in rows}


@cache
def makers_limits() -> tuple[MakersLimit, ...]:
    """Return the limits of makers."""
    return tuple(read_rows(Path(__file__).with_name("limits.csv"), MakersLimit))


def limit_fraction(part: str) -> float | None:
    """Return the mean change of a part's size at the limit, fraction of the new size.

    None unless at least two machines of the table agree within `SAME_LIMIT`.
    """
    fractions = [row.fraction for row in makers_limits() if row.part == part]
    sizes = [abs(fraction) for fraction in fractions]
    if len(sizes) < 2 or max(sizes) > SAME_LIMIT * min(sizes):
        return None
    return sum(fractions) / len(fractions)


def limit_source(part: str) -> str:
    """Return the machines and manuals whose mean is `limit_fraction`."""
    rows = [row for row in makers_limits() if row.part == part]
    return f"mean of {', '.join(f'{row.machine} ({row.source})' for row in rows)}"


def limit_words(part: str) -> str:
    """Return the limits of makers for a part, for reading; empty without any."""
    rows = [row for row in makers_limits() if row.part == part]
    return "; ".join(f"{row.new:g} to {row.limit:g} mm ({row.machine})" for row in rows)
