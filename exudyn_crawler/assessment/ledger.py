"""Ledger of an assessment's inputs: values of the case, of the settings, and derived from both."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path

from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.case import Case
from exudyn_crawler.origins import Entry, Ledger, Origin, Rule, Ruled, read_rules
from exudyn_crawler.settings import fields

OF_CASE = (
    *("gravity", "gear.car_body.gauge", "shoe.width", "shoe.mass", "track.pitch", "gear.rollers"),
    *("gear.roller_radius", "gear.tread_width", "gear.car_body.upper_mass", "gear.car_body.upper_com"),
)
"""Paths of the case's values in every assessment."""
OF_SETTINGS = ("work.", "ground.", "drive.", "pins.", "length", "side_edges", "rated_part")
OF_MATERIAL = ("material.tensile_strength", "material.yield_strength")
DEFAULT = "default of the settings"


@cache
def rules() -> tuple[Rule, ...]:
    """Return the rules for numbers of an assessment, in the order of trial."""
    return read_rules(Path(__file__).with_name("rules.csv"))


def inputs_ledger(
    case: Case,
    settings: AssessmentSettings,
    numbers: AssessmentNumbers,
    given: tuple[str, ...] = (),
    origins: Ledger | None = None,
) -> Ledger:
    """Return the ledger of an assessment's inputs.

    Parameters
    ----------
    case, settings, numbers : Case, AssessmentSettings, AssessmentNumbers
        Case, settings and numbers of the assessment.
    given : tuple of str
        Paths of settings given by a file; others count as assumed.
    origins : Ledger, optional
        Ledger of the case; missing values count as given.
    """
    of_case = _case_ledger(case, origins or Ledger(()))
    entries = [of_case[path] for path in OF_CASE]
    entries += _of_settings(settings, numbers, given, of_case)
    for path, ruled in numbers.ruled.items():
        rule = _rule(path, ruled)
        if rule is not None and rule.unit:
            how = rule.how(ruled.detail)
            entries.append(Entry(path, ruled.value, rule.unit, rule.origin or Origin.DERIVED, how))
    return Ledger(entries)


def _case_ledger(case: Case, origins: Ledger) -> Ledger:
    """Return a ledger of all values of a case."""
    return Ledger(
        origins.get(item.path)
        or Entry(item.path, item.value, item.unit, Origin.GIVEN, f"case: {item.path}", item.meaning)
        for item in fields.values_of(case)
    )


def _of_settings(
    settings: AssessmentSettings, numbers: AssessmentNumbers, given: tuple[str, ...], of_case: Ledger
) -> Iterator[Entry]:
    """Yield the entries of the settings; derived values replace those that are None."""
    material = any(path.partition(".")[0] == "material" for path in given)
    for item in fields.values_of(settings):
        path = item.path
        if not (path.startswith(OF_SETTINGS) or path in OF_MATERIAL):
            continue
        value, origin, how = item.value, Origin.ASSUMED, DEFAULT
        ruled = numbers.ruled.get(path) if value is None else None
        rule = _rule(path, ruled)
        of_material = path in OF_MATERIAL
        changed = value is not None and value != item.field.default and not of_material
        if path in given or changed or (material and of_material):
            origin, how = Origin.GIVEN, f"settings: {path}"
        elif ruled is not None and ruled.rule in of_case:
            value, origin, how = ruled.value, of_case[ruled.rule].origin, of_case[ruled.rule].how
        elif rule is not None:
            value = ruled.value if ruled is not None else value
            origin, how = rule.origin or origin, rule.how(ruled.detail if ruled is not None else "")
        elif value is None:
            continue
        if of_material and origin is Origin.ASSUMED:
            how = settings.material.name
        yield Entry(path, value, item.unit, origin, how, item.meaning)


def _rule(path: str, ruled: Ruled | None) -> Rule | None:
    """Return the rule of a number: the named one, or the unnamed one."""
    name = "" if ruled is None else ruled.rule
    return next((rule for rule in rules() if rule.gives(path) and rule.name in ("", name)), None)
