"""Page of a wear forecast: what is due first, percent worn over hours, readings, inputs with their origin."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from exudyn_crawler.results.wear.results import WearResults
from exudyn_crawler.settings.fields import case_rows
from exudyn_crawler.views.pages import page

DUE = [
    *("part", "worn in %", "machine hours left", "at least", "at most", "about", "action"),
    *("law", "scatter in %", "readings", "limit in mm", "limit from", "law from"),
]
BANDS = (
    "A band holds the hours to 100 % worn with 90 % confidence, from the scatter of the readings about the "
    "law. It holds if duty and ground stay as they were. Dotted: the last inspection."
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
    sections.append(page.Section("plan", "Wear file", page.table(pd.DataFrame(case_rows(found.plan)))))
    title = f"Wear: {found.plan.name}"
    return page.write_page(page.page(title, found.lines, sections), path, overwrite)
