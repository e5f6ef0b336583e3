"""Figures of a datasheet that no machine has, alone or beside each other."""

from collections.abc import Iterator

from exudyn_crawler.case.case_file import CaseFile
from exudyn_crawler.case.datasheet import typical
from exudyn_crawler.case.datasheet.derive import derived
from exudyn_crawler.case.datasheet.provenance import provenance
from exudyn_crawler.case.datasheet.sheet import Datasheet
from exudyn_crawler.case.parameters.checks import implausible, out_of_range
from exudyn_crawler.case.ph4100c import GRAVITY

SHARES = {
    "drawbar_pull": (0.1, 2.0),
    "recoil_force": (0.05, 3.0),
    "chain_tension": (0.002, 1.0),
}
"""Forces over the weight that machines have: pulls of 0.4 to 1.5 (typical values); others chosen here."""
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
    """Lines about figures that no machine has, with the datasheet's keys."""
    lines = [*out_of_range(sheet)]
    yield from (f"datasheet.{line}" for line in lines)
    named = {line.split(":")[0] for line in lines}
    yield from _odd_sprocket(sheet)
    weight = sheet.operating_weight * GRAVITY
    for name, (least, greatest) in SHARES.items():
        force = getattr(sheet, name)
        if force is None or name in named or least <= force / weight <= greatest:
            continue
        share = f"{force / weight:.3g} of the weight of {1e-3 * weight:.4g} kN"
        yield f"datasheet.{name}: {1e-3 * force:.4g} kN are {share}, outside of {least:g} to {greatest:g}"
    length = sheet.length_on_ground or sheet.crawler_length
    if length is None:
        return
    area = 2.0 * sheet.shoe_width * length
    if sheet.contact_area is not None and "contact_area" not in named:
        least, greatest = AREA
        if not least <= sheet.contact_area / area <= greatest:
            printed = f"{sheet.contact_area:.4g} m2"
            by_length = f"width by length is {area:.4g} m2"
            yield f"datasheet.contact_area: {printed} is not the area of both tracks, {by_length}"
    if sheet.ground_pressure is None or "ground_pressure" in named:
        return
    mean = weight / area
    least, greatest = PRESSURE
    if not least <= sheet.ground_pressure / mean <= greatest:
        printed = f"{1e-3 * sheet.ground_pressure:.4g} kPa"
        by_area = f"weight over both tracks is {1e-3 * mean:.4g} kPa"
        yield f"datasheet.ground_pressure: {printed} is not the mean pressure, {by_area}"


def _odd_sprocket(sheet: Datasheet) -> Iterator[str]:
    """Line about a dozer whose chain is longer than one about a low sprocket: an elevated one lifts it."""
    if sheet.kind != "dozer" or sheet.shoes is None or sheet.sprocket_gaps is not None:
        return
    greatest = typical.row_of("sprocket_gaps", sheet.kind).high
    gaps = derived(sheet).chain.gaps
    if gaps > greatest:
        yield (
            f"datasheet.shoes: {sheet.shoes} leave a sprocket of {gaps:.3g} shoes a turn, dozers have up to "
            f"{greatest:g}; is it elevated? It is built low, on the ground's length"
        )
