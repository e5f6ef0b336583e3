"""Two runs on one page: what differs in their cases, in their results, and their main curves together."""

import base64
import io
from collections.abc import Mapping
from pathlib import Path

import pandas as pd
import xarray as xr
from markupsafe import Markup
from matplotlib.figure import Figure

from exudyn_crawler.case.files.changes import parameter_differences
from exudyn_crawler.files import whole_file
from exudyn_crawler.results.history.catalogue import select
from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.results.history.tables import compared, difference_table
from exudyn_crawler.views.curves import Panel, panel_figure
from exudyn_crawler.views.report.templating import rendered_page
from exudyn_crawler.views.series import Series, history_series

MAIN = sorted(
    (one for one in select(compared=True).values() if one.compared != "table"), key=lambda one: one.compared
)
"""Quantities that the page draws, as far as both runs have them."""
SAME_CASES = "Nothing differs in the cases."
SAME_RESULTS = "Nothing that both runs have differs in the results, beyond rounding."
"""What stands in place of tables without rows."""
ITEMS = 3
"""Shoes that a figure draws at most: the ends and the middle of those that both runs have."""


def comparison_figures(
    histories: Mapping[str, History], stresses: Mapping[str, xr.Dataset]
) -> dict[str, Figure]:
    """Overlays of the main curves of two runs by name, by the label of the quantity."""
    first, second = (history_series(one, stresses.get(name)) for name, one in histories.items())
    both = [one.label for one in MAIN if one.label in first and one.label in second]
    panels = {
        label: _overlay(dict(zip(histories, (first[label], second[label]), strict=True))) for label in both
    }
    phases = common_phases(*histories.values())
    return {label: panel_figure(label, one, phases) for label, one in panels.items()}


def _overlay(series: Mapping[str, Series]) -> list[Panel]:
    """Panel an axis, with the curves of each run."""
    one, other = series.values()
    both = [item for item in one.values["item"].values.tolist() if item in other.values["item"].values]
    chosen = sorted({both[round(k * (len(both) - 1) / (ITEMS - 1))] for k in range(ITEMS)}, key=both.index)
    return [
        Panel(
            f"{axis} {one.label}".strip(),
            one.unit,
            {
                f"{item}, {name}".removeprefix("track, "): found.values.sel(item=item, axis=axis)
                for item in chosen
                for name, found in series.items()
            },
        )
        for axis in one.values.axis.values
    ]


def comparison_tables(
    histories: Mapping[str, History], stresses: Mapping[str, xr.Dataset]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """What differs in the cases and in the results of two runs by name, the first A and the second B."""
    first, second = histories.values()
    results = difference_table(*(compared(one, stresses.get(name)) for name, one in histories.items()))
    differences = parameter_differences(first.case, second.case)
    return pd.DataFrame(differences, columns=["key", "A", "B", "unit"]), results


def write_comparison(
    histories: Mapping[str, History],
    path: Path,
    stresses: Mapping[str, xr.Dataset] | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a page, to be read offline, of two runs: differences of cases and results, and main curves.

    Parameters
    ----------
    histories : mapping
        Two histories by name; the first is A, the second B.
    path : Path
        File to write (`.html`).
    stresses : mapping, optional
        Datasets of `StressResults` by the same names.

    Raises
    ------
    ValueError
        If there are not two histories.
    FileExistsError
        If the file exists and `overwrite` is false.
    """
    if len(histories) != 2:
        raise ValueError(f"histories must be two, got {list(histories)}")
    parameters, results = comparison_tables(histories, stresses or {})
    a, b = histories
    page = rendered_page(
        "comparison.html",
        title=f"{a} and {b}",
        lead=[
            f"{letter} is {name}: case {one.case.name!r}, {one.duration:.4g} s"
            for letter, (name, one) in zip("AB", histories.items(), strict=True)
        ],
        parameters=_html(parameters),
        results=_html(results),
        same_cases=SAME_CASES,
        same_results=SAME_RESULTS,
        figures=[
            {"title": label, "uri": _embedded(figure)}
            for label, figure in comparison_figures(histories, stresses or {}).items()
        ],
    )
    with whole_file(path, overwrite) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return path


def _html(table: pd.DataFrame) -> Markup | None:
    """Table for the page; None where it has no rows."""
    if table.empty:
        return None
    return Markup(table.to_html(index=False, border=0, na_rep="", float_format=lambda value: f"{value:.4g}"))


def _embedded(figure: Figure) -> str:
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=110)
    return f"data:image/png;base64,{base64.b64encode(memory.getvalue()).decode('ascii')}"
