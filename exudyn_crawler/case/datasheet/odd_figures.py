"""Figures of a datasheet that no machine has, alone or beside each other."""

from collections.abc import Collection, Iterator

from exudyn_crawler.case.case_file import CaseFile
from exudyn_crawler.case.datasheet import plausible
from exudyn_crawler.case.datasheet.derive import derived
from exudyn_crawler.case.datasheet.provenance import provenance
from exudyn_crawler.case.datasheet.sheet import Datasheet
from exudyn_crawler.case.parameters.checks import implausible, out_of_range
from exudyn_crawler.case.ph4100c import GRAVITY

PRESSURE = (0.4, 3.0)
"""Printed ground pressure over weight by width and length on ground of both tracks. Chosen here."""
AREA = 1.0 / 3.0, 2.5
"""Printed contact area over width by length on ground of both tracks: those of the pressure."""


def odd_values(case_file: CaseFile) -> Iterator[str]:
    """Lines about all values of a case file that no machine and no ground has, those of a datasheet first."""
    lines = implausible(case_file.case, case_file.duration)
    if case_file.datasheet is None:
        yield from lines
        return
    yield from odd_figures(case_file.datasheet)
    # what follows by a rule is in no wrong unit: shoes of a small machine weigh less than any of a file do
    by_rule = {row.key for row in provenance(case_file.case, case_file.datasheet) if row.origin != "given"}
    yield from (line for line in lines if line.split(":")[0] not in by_rule)


def odd_figures(sheet: Datasheet) -> Iterator[str]:
    """Yield lines about figures that no machine has, printed or following, with the datasheet's keys."""
    machine = derived(sheet)
    following = plausible.following(sheet, machine.chain, machine.case.shoe.mass)
    odd = dict(plausible.odd_printed(sheet, following))
    yield from (f"datasheet.{key}: {line}" for key, line in odd.items())
    for line in out_of_range(sheet):
        key = line.split(":")[0]
        if plausible.row_of(key, sheet.kind) is None:
            yield f"datasheet.{line}"
    yield from (f"datasheet: {line}" for line in plausible.odd_following(sheet, following))
    yield from _odd_sums(sheet, odd)


def _odd_sums(sheet: Datasheet, odd: Collection[str]) -> Iterator[str]:
    """Yield lines about an area or a pressure that is not that of weight, width and length."""
    length = sheet.length_on_ground or sheet.crawler_length
    if length is None or plausible.WEIGHT in odd:
        return
    area = 2.0 * sheet.shoe_width * length
    if sheet.contact_area is not None:
        least, greatest = AREA
        if not least <= sheet.contact_area / area <= greatest:
            printed = f"{sheet.contact_area:.4g} m2"
            by_length = f"width by length is {area:.4g} m2"
            yield f"datasheet.contact_area: {printed} is not the area of both tracks, {by_length}"
    if sheet.ground_pressure is None or "ground_pressure" in odd:
        return
    mean = sheet.operating_weight * GRAVITY / area
    least, greatest = PRESSURE
    if not least <= sheet.ground_pressure / mean <= greatest:
        printed = f"{1e-3 * sheet.ground_pressure:.4g} kPa"
        by_area = f"weight over both tracks is {1e-3 * mean:.4g} kPa"
        yield f"datasheet.ground_pressure: {printed} is not the mean pressure, {by_area}"
