"""Wear of a machine into a folder: residual hours by inspections, tables, drawings and a page."""

from pathlib import Path

from exudyn_crawler import files
from exudyn_crawler.case.parameters import checks
from exudyn_crawler.results.wear.forecast import forecast
from exudyn_crawler.results.wear.inspections import read_inspections
from exudyn_crawler.results.wear.plan import WearPlan, read_wear
from exudyn_crawler.results.wear.results import WearResults
from exudyn_crawler.views import style, tables, wear as drawings
from exudyn_crawler.views.pages import wear as pages

WEAR_PAGE = "wear.html"
DUE = "due.csv"
READINGS = "readings.csv"
WORN = "percent_worn.png"
WEAR_FILES = (WEAR_PAGE, DUE, READINGS, WORN)


def wear(
    plan: WearPlan | str | Path, out: str | Path | None = None, *, overwrite: bool = False
) -> WearResults:
    """Forecast the wear of a machine, or that of its file: percent worn, residual hours, what is due first.

    Tables, drawings and page go into the folder `out` if it is given.

    Raises before anything is computed: FileNotFoundError if there is no such file; FileExistsError if the
    folder has results and `overwrite` is false; ValueError if the file or its inspections are refused, see
    `read_wear` and `read_inspections`.
    """
    plan = plan if isinstance(plan, WearPlan) else read_wear(plan)
    checks.warn_of(checks.out_of_range(plan))
    folder = None if out is None else Path(out)
    if folder is not None:
        for name in WEAR_FILES:
            files.refuse_existing(folder / name, overwrite)
    found = WearResults(
        plan, None if plan.inspections is None else forecast(plan, read_inspections(plan.inspections))
    )
    if folder is not None:
        write_wear(found, files.writable_folder(folder), overwrite)
    return found


def write_wear(found: WearResults, folder: Path, overwrite: bool = False) -> None:
    """Write all tables, drawings and the page of a wear forecast into a folder."""
    drawn = {}
    if found.forecast is not None:
        tables.write_table(found.forecast.table, folder / DUE, overwrite)
        tables.write_table(found.forecast.readings, folder / READINGS, overwrite)
        drawn["percent worn"] = drawings.forecast_figure(found.forecast)
        style.save_figure(drawn["percent worn"], folder / WORN, overwrite)
    pages.write_wear_page(found, drawn, folder / WEAR_PAGE, overwrite)
