"""Items of an assessment: number, limit, utilisation, formula and source."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment.states import FORMULA, CaseLoads

MEGA = 1e6
KILO = 1e3
NOT_KNOWN = "not known"


class Source(NamedTuple):
    """Source of an item, with its mark: S seen, D derived, R remembered."""

    text: str
    mark: str


STATICS = Source("statics", "D")
BALANCE = Source("balance of travel", "D")


class AssessedItem(NamedTuple):
    """Number of an assessment beside its limit; NaN for a missing limit."""

    item: str
    load_case: str
    group: str
    number: float
    limit: float
    unit: str
    formula: str
    source: Source
    factor: float = 1.0
    """Factor of the group on the load or the stress; 1 if the limit includes it."""
    factor_source: str = ""
    """Source of the factor with its mark; empty for a factor of 1."""
    basis: str = FORMULA
    """Formula, or the run that gives the forces."""
    needs: tuple[str, ...] = ()
    """Settings keys without a value that the number or its limit needs."""
    is_least: bool = False
    """True if the limit is the least allowed number and not the greatest."""

    @property
    def utilisation(self) -> float:
        """Number with its factor over the limit, or the least number over it; NaN without a limit."""
        if self.is_least:
            return self.limit / self.number
        return self.factor * self.number / self.limit if self.limit else np.inf

    @property
    def verdict(self) -> str:
        """Verdict: "yes" up to a utilisation of 1, "no" above it, empty without a limit.

        An item that lacks an input is "not known" unless it exceeds its limit even without this input.
        """
        if self.utilisation > 1.0:
            return "no"
        if self.needs:
            return f"{NOT_KNOWN} (needs {', '.join(self.needs)})"
        return "" if np.isnan(self.utilisation) else "yes"


def governing(items: Iterable[AssessedItem]) -> list[AssessedItem]:
    """Return the item with the greatest utilisation for each name, by falling utilisation.

    Items without a limit come last; for each name the one with the greatest number is chosen. An item is not
    known if one of its load cases is not.
    """
    worst: dict[str, AssessedItem] = {}
    needs: dict[str, dict[str, None]] = {}
    for item in items:
        before = worst.get(item.item)
        if before is None or _rank(item) > _rank(before):
            worst[item.item] = item
        needs.setdefault(item.item, {}).update(dict.fromkeys(item.needs))
    found = [_with_needs(item, tuple(needs[name])) for name, item in worst.items()]
    return sorted(found, key=lambda item: -_rank(item)[0])


def _with_needs(item: AssessedItem, needs: tuple[str, ...]) -> AssessedItem:
    """Return an item with its needs; a number of 0 becomes NaN if an input is missing."""
    if needs and item.utilisation == 0.0:
        item = item._replace(number=np.nan)
    return item._replace(needs=needs)


def _rank(item: AssessedItem) -> tuple[float, float]:
    """Return utilisation (-1 without a limit) and number."""
    return float(np.nan_to_num(item.utilisation, nan=-1.0)), item.number


def case_item(
    row: CaseLoads,
    name: str,
    number: float,
    limit: float,
    unit: str,
    formula: str,
    source: Source,
    *,
    of_run: str = "",
    factor: float = 1.0,
    needs: tuple[str, ...] = (),
) -> AssessedItem:
    """Return an item of a load case; `of_run` describes a number that a run gives in place of the formula."""
    if of_run and row.basis != FORMULA:
        formula, source = of_run, Source(row.basis, "D")
    factors = "" if factor == 1.0 else row.factors
    place = name, row.name, row.group
    return AssessedItem(*place, number, limit, unit, formula, source, factor, factors, row.basis, needs)
