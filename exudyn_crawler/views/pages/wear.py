"""Page of a wear forecast: what is due first, percent worn over hours, readings, inputs with their origin."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from exudyn_crawler.results.wear.results import WearResults
from exudyn_crawler.settings.fields import case_rows
from exudyn_crawler.views.pages import page, signed
from exudyn_crawler.views.pages.signed import Pairs, SignedReport
from exudyn_crawler.views.tables import ORIGIN_COLUMNS, origin_rows

DUE = [
    *("part", "worn in %", "machine hours left", "at least", "at most", "about", "action"),
    *("law", "scatter in %", "readings", "limit in mm", "limit from", "law from"),
]
SIGNED = ["part", "worn in %", "machine hours left", "at least", "at most", "action", "limit in mm"]
ASKED = "Which part of the undercarriage is worn out first, and after how many machine hours?"
FITTED = "A law is fitted to the readings: beyond the last of them the hours are an extrapolation."
RATIOS = (
    "The work of wear is computed by runs of the duties.",
    "It gives ratios between duties, machines and parts, and hours only by a stated coefficient.",
    "It holds if duty and ground stay as they are in these runs.",
)
SIGNED_FIGURES = {"Percent worn over hours": "percent worn", "Work of wear round the loop": "loop"}
"""Columns, question, validity and drawings of the report to sign."""
BANDS = (
    "A band holds the hours to 100 % worn with 90 % confidence, from the scatter of the readings about the "
    "law. It holds if duty and ground stay as they were. Dotted: the last inspection."
)
PINS = (
    "Pins of the model have no friction: the chain rattles, and the raw integral (sweeps from 0 deg) counts "
    "that. Whole sweeps of 20 deg and more are the bends over tumbler and idler, which the closed form "
    "r (a_t (T1 + T2) + a_i (T3 + T4)) has, too; smaller ones add the bends over carriers, and rattle."
)
GROUSERS = (
    "Two measures of a grouser's wear are shown, load times slip and work of friction. They differ much "
    "where a shoe hardly moves: a coefficient belongs to one of them."
)


def write_wear_page(
    found: WearResults, drawn: Mapping[str, Figure], path: Path, overwrite: bool = False
) -> Path:
    """Write one self-contained page of a wear forecast; raises as `write_page`."""
    sections = []
    if found.forecast is not None:
        curves = page.figure_picture("percent worn over hours", drawn["percent worn"])
        table = page.table(found.forecast.table[DUE])
        parts = [page.paragraph(BANDS), table, curves]
        if len(found.forecast.by_run):
            parts.append(
                page.part("titled", "If all hours were of one run", page.table(found.forecast.by_run))
            )
        body = page.together(*parts)
        sections.append(page.Section("due", "What is due, and when", body))
        readings = page.table(found.forecast.readings)
        sections.append(page.Section("readings", "Readings", readings))
    if found.duties:
        sections += _duty_sections(found, drawn)
    inputs = pd.DataFrame(origin_rows(found.inputs), columns=ORIGIN_COLUMNS)
    sections.append(page.Section("inputs", f"Inputs: {found.inputs.summary}", page.table(inputs)))
    sections.append(page.Section("plan", "Wear file", page.table(pd.DataFrame(case_rows(found.plan)))))
    title = f"Wear: {found.plan.name}"
    return page.write_page(page.page(title, found.lines, sections), path, overwrite)


def signed_wear(found: WearResults, machine: str, checksums: Pairs, program: str) -> SignedReport:
    """Return the report to sign of a wear forecast; `machine` are its words, `program` the program's line."""
    forecast = found.forecast
    table = found.by_duty if forecast is None else forecast.table[SIGNED]
    band, holds, _ = BANDS.split(". ", 2)
    return SignedReport(
        kind="Wear",
        title=found.plan.name,
        facts=(
            *([("machine", machine)] if machine else []),
            signed.revision(checksums),
            ("program", program),
        ),
        question=ASKED,
        lines=tuple(found.lines),
        answers=signed.rows_of(table),
        validity=RATIOS if forecast is None else (f"{band}.", f"{holds}.", FITTED),
        checksums=checksums,
        **signed.ledger_parts(origin_rows(found.inputs), "inputs.csv"),
    )


def _duty_sections(found: WearResults, drawn: Mapping[str, Figure]) -> list[page.Section]:
    """Return the sections on the work of duties."""
    loop = page.figure_picture("work round the loop", drawn["loop"])
    bars = page.figure_picture("work by part", drawn["work by part"])
    take_up = page.figure_picture("take-up over growth", drawn["take-up"])
    by_place = page.together(loop, page.table(found.regions))
    work = page.together(
        page.paragraph(GROUSERS), bars, page.part("folded", "All pairs", page.table(found.work))
    )
    pins = page.together(page.paragraph(PINS), page.table(found.sweeps))
    return [
        page.Section("duties", "Work and hours by duty", page.table(found.by_duty)),
        page.Section("growth", "Limits of the pitch", page.together(page.table(found.growth), take_up)),
        page.Section("loop", "Where it wears", by_place),
        page.Section("work", "What wears", work),
        page.Section("pins", "Pins: sweeps and closed form", pins),
    ]
