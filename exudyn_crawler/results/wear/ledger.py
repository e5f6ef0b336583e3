"""Ledger of the inputs of a wear forecast: given, derived or assumed, each with its source."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from exudyn_crawler.case import Case
from exudyn_crawler.origins import Entry, Ledger, Origin, Rule, read_rules
from exudyn_crawler.results.wear.duty_work import pin_size
from exudyn_crawler.results.wear.forecast import STATED, propel_share
from exudyn_crawler.results.wear.inspections import Inspections
from exudyn_crawler.results.wear.plan import WearPlan
from exudyn_crawler.settings import fields

GIVEN = "wear file"
OF_ALL = ("pin.radius", "pin.length", "pin.state", "sweep", "grouser_measure")
"""Paths of the values that work needs."""


@cache
def rules() -> tuple[Rule, ...]:
    """Return the rules for inputs of a wear forecast."""
    return read_rules(Path(__file__).with_name("rules.csv"))


def inputs_ledger(plan: WearPlan, case: Case | None, inspections: Inspections | None) -> Ledger:
    """Return the ledger of a forecast's inputs; `case` is that of its runs."""
    return Ledger(_entries(plan, case, inspections))


def _entries(plan: WearPlan, case: Case | None, inspections: Inspections | None) -> Iterator[Entry]:
    """Yield the entries of parts, then those of inspections, then those of work."""
    for number, part in enumerate(plan.parts):
        path = f"parts[{number}]"
        yield Entry(f"{path}.new", part.new, "m", Origin.GIVEN, GIVEN, part.part)
        limit = None if part.limit is not None else "makers"
        yield _entry("parts.limit", part.size_at_limit, "m", limit, f"{path}.limit", part.limit_source)
        if part.case is not None:
            yield Entry(f"{path}.case", part.case, "1", Origin.GIVEN, GIVEN, part.part)
        else:
            exponent = getattr(part.law, "exponent", part.exponent)
            name = None if part.exponent is not None else "komatsu"
            yield _entry("parts.exponent", exponent, "1", name, f"{path}.exponent", part.law_source)
        if part.coefficient is not None:
            yield Entry(f"{path}.coefficient", part.coefficient, "m2/N", Origin.GIVEN, GIVEN, part.part)
    if plan.propel_share is not None or inspections is not None:
        share = propel_share(plan, inspections)
        yield _entry("propel_share", share.value, "1", None if share.rule == STATED else share.rule)
    if case is not None:
        radius, length = pin_size(plan, case)
        values = dict(
            zip(OF_ALL, (radius, length, plan.pin.state, plan.sweep, plan.grouser_measure), strict=True)
        )
        items = {item.path: item for item in fields.values_of(plan)}
        for path, value in values.items():
            item = items[path]
            yield _entry(path, value, item.unit, None if item.value != item.field.default else "")


def _entry(rule_path: str, value: Any, unit: str, name: str | None, path: str = "", how: str = "") -> Entry:
    """Return the entry of a value by the rule of a name; None: the wear file gives it."""
    if name is None:
        return Entry(path or rule_path, value, unit, Origin.GIVEN, GIVEN)
    rule = next(rule for rule in rules() if rule.gives(rule_path) and rule.name == name)
    return Entry(
        path or rule_path,
        value,
        unit,
        rule.origin or Origin.DERIVED,
        "; ".join(filter(None, (rule.how(), how))),
    )
