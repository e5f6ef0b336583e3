"""Page of an assessment: governing items, drawings, load cases, inputs with their origin, clauses."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from exudyn_crawler.assessment.assessment import Assessment
from exudyn_crawler.assessment.items import NOT_KNOWN
from exudyn_crawler.assessment.slewing import least_over_slew
from exudyn_crawler.origins import Origin
from exudyn_crawler.views.pages import page, signed
from exudyn_crawler.views.pages.signed import Pairs, SignedReport
from exudyn_crawler.views.tables import origin_rows

SHORT = ["item", "load case", "group", "utilisation", "number", "limit", "unit", "factor", "from", "within"]
SIGNED = ["item", "load case", "group", "utilisation", "within", "number", "limit", "unit"]
CLAUSES = "clauses.csv lists those followed and left out"
ASKED = "Are ground pressure, tipping, travel and the parts within their limits in the load cases of {}?"
SIGNED_FIGURES = ("utilisation", "ground pressure over slew", "stability over slew")
"""Columns, remark, question and drawings of the report to sign."""
HOW = ["item", "formula", "source", "mark", "factor", "factor from"]
MARKS = "Marks: S seen in a text of the source, D derived, R remembered: to be checked before it is used."
NO_CONFORMITY = (
    "These are formulas, with factors of named sources as far as they are known. They claim no conformity "
    "with any standard: the clauses that are followed and those left out are listed below."
)
DRAWN = {
    "pressure": ("Ground pressure", ("ground pressure over slew", "pressure along the tracks")),
    "stability": ("Tipping", ("stability over slew",)),
    "travel": ("Travel", ("travel",)),
    "rollers": ("Rollers and chain", ("roller loads", "chain tension")),
}
"""Sections and their drawings."""


def write_assessment_page(
    found: Assessment, drawn: Mapping[str, Figure], path: Path, overwrite: bool = False
) -> Path:
    """Write one self-contained page of an assessment; raises as `write_page`."""
    items = found.items
    kinds = [{"yes": "within", "no": "outside"}.get(verdict, "") for verdict in items["within"]]
    table = page.table(items[SHORT], kinds=kinds)
    bars = page.figure_picture("utilisation", drawn["utilisation"])
    sections = [
        page.Section("items", "Utilisation", page.together(page.paragraph(NO_CONFORMITY), table, bars))
    ]
    for anchor, (heading, names) in DRAWN.items():
        parts = [page.figure_picture(name, drawn[name]) for name in names]
        if anchor == "pressure":
            parts.append(page.part("titled", "Beams and one rigid plate", page.table(found.plate)))
        if anchor == "stability":
            least = page.table(least_over_slew(found.tipping))
            parts.append(page.part("titled", "Each edge at the angle at which it tips first", least))
        sections.append(page.Section(anchor, heading, page.together(*parts)))
    how = items[HOW]
    sections += [
        page.Section("cases", "Load cases", page.table(found.cases)),
        page.Section(
            "formulas", "Formulas and sources", page.together(page.paragraph(MARKS), page.table(how))
        ),
        page.Section("inputs", "Inputs", page.table(found.inputs)),
        page.Section("clauses", "Clauses followed and left out", page.table(found.clauses)),
    ]
    if found.compared is not None:
        beside = page.Section("run", "Beside runs", page.table(found.compared))
        sections.insert(1, beside)
    title = f"Assessment: {found.name}"
    return page.write_page(page.page(title, found.lines, sections), path, overwrite)


def signed_assessment(found: Assessment, machine: str, checksums: Pairs, program: str) -> SignedReport:
    """Return the report to sign of an assessment; `machine` are its words, `program` the program's line."""
    assumed = found.ledger.counts.get(Origin.ASSUMED, 0)
    formulas, conformity = NO_CONFORMITY.partition(":")[0].split(". ", 1)
    sure = f"{assumed} of {len(found.ledger)} inputs are assumed; an item is as sure as its inputs."
    return SignedReport(
        kind="Assessment",
        title=found.name,
        facts=(("machine", machine), signed.revision(checksums), ("program", program)),
        question=ASKED.format(found.load_cases.name),
        lines=tuple(found.lines),
        answers=signed.rows_of(printed(found)[SIGNED]),
        validity=(f"{formulas}.", f"{conformity} ({CLAUSES}).", sure),
        checksums=checksums,
        **signed.ledger_parts(origin_rows(found.ledger), "inputs.csv"),
    )


def printed(found: Assessment) -> pd.DataFrame:
    """Return the table of items for a terminal; the head of an assessment lists what unknown items need."""
    columns = ["item", "utilisation", "within", "load case", "group", "number", "limit", "unit", "from"]
    items = found.items[columns]
    unknown = items["within"].str.startswith(NOT_KNOWN)
    return items.assign(within=items["within"].mask(unknown, NOT_KNOWN))
