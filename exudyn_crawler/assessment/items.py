"""Items of an assessment: a number, its limit and utilisation each, with formula and source."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment.states import FORMULA, CaseLoads

MEGA = 1e6
KILO = 1e3


class AssessedItem(NamedTuple):
    """Number of an assessment beside its limit; NaN for a limit that there is none of."""

    item: str
    load_case: str
    group: str
    number: float
    limit: float
    unit: str
    factor: float
    """On the load or the stress, of the group; 1 where the limit has it."""
    utilisation: float
    basis: str
    """Formula, or the run whose forces it takes."""
    formula: str
    source: str
    mark: str
    """S seen, D derived, R remembered."""
    factor_source: str = ""
    """Source of the factor with its mark; nothing where the factor is 1."""

    @property
    def verdict(self) -> str:
        """Word "yes" where it is at most 1, "no" where it is not, nothing without a limit."""
        if np.isnan(self.utilisation):
            return ""
        return "yes" if self.utilisation <= 1.0 else "no"


def governing(items: Iterable[AssessedItem]) -> list[AssessedItem]:
    """Item with the greatest utilisation of each name, the greatest first.

    Those without a limit come last, of each name the one with the greatest number.
    """
    worst: dict[str, AssessedItem] = {}
    for item in items:
        before = worst.get(item.item)
        if before is None or _rank(item) > _rank(before):
            worst[item.item] = item
    return sorted(worst.values(), key=lambda item: -_rank(item)[0])


def _rank(item: AssessedItem) -> tuple[float, float]:
    """Utilisation, -1 without a limit, and number."""
    return float(np.nan_to_num(item.utilisation, nan=-1.0)), item.number


def case_item(
    row: CaseLoads,
    name: str,
    number: float,
    limit: float,
    unit: str,
    *,
    formula: str,
    source: str,
    mark: str,
    factor: float = 1.0,
    basis: str | None = None,
) -> AssessedItem:
    """Item of a load case, whose factor is on the number; the `basis` is that of its forces if none."""
    used = factor * number / limit if limit else np.inf
    return AssessedItem(
        name,
        row.name,
        row.group,
        number,
        limit,
        unit,
        factor,
        used,
        row.basis if basis is None else basis,
        formula,
        source,
        mark,
        "" if factor == 1.0 else row.factors,
    )


def by_run(row: CaseLoads, formula: str, of_run: str) -> str:
    """Words of a formula, or of what a run's number is where the case has a run's forces."""
    return formula if row.basis == FORMULA else of_run
