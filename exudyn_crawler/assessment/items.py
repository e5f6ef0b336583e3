"""Items of an assessment: a number, its limit and utilisation each, with formula and source."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment.states import FORMULA, CaseLoads

MEGA = 1e6
KILO = 1e3
NOT_KNOWN = "not known"


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
    needs: tuple[str, ...] = ()
    """Keys of the settings that are not stated, without which the number or its limit is not known."""

    @property
    def verdict(self) -> str:
        """Return "yes" up to a utilisation of 1, "no" above it, and nothing without a limit.

        An item that lacks an input is "not known" unless it exceeds its limit without it.
        """
        if self.utilisation > 1.0:
            return "no"
        if self.needs:
            return f"{NOT_KNOWN} (needs {', '.join(self.needs)})"
        return "" if np.isnan(self.utilisation) else "yes"


def governing(items: Iterable[AssessedItem]) -> list[AssessedItem]:
    """Return the item with the greatest utilisation of each name, the greatest first.

    Those without a limit come last, of each name the one with the greatest number. An item is not known if
    one of its load cases is not.
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
    """Return an item with what it needs; a utilisation of 0 for lack of an input is no number."""
    if needs and item.utilisation == 0.0:
        item = item._replace(number=np.nan, utilisation=np.nan)
    return item._replace(needs=needs)


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
    needs: tuple[str, ...] = (),
) -> AssessedItem:
    """Return the item of a load case, whose factor is on the number."""
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
        row.basis,
        formula,
        source,
        mark,
        "" if factor == 1.0 else row.factors,
        needs,
    )


def by_run(row: CaseLoads, formula: str, of_run: str) -> str:
    """Words of a formula, or of what a run's number is where the case has a run's forces."""
    return formula if row.basis == FORMULA else of_run
