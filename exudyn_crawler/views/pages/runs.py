"""Runs read from their folders, and a page that compares two runs."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import h5py
import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from exudyn_crawler.machines.case_file import differences
from exudyn_crawler.results.history import History, catalogue, common_phases, summary
from exudyn_crawler.views.figures import history_series, overlay, panel_figure
from exudyn_crawler.views.pages import page
from fem.interrupts import interrupts_wait

T = TypeVar("T")

STRESSES = "stress.nc"
MAIN = sorted(catalogue.select(figure=True).values(), key=lambda quantity: quantity.figure or 0)
"""Quantities that the page draws if both runs have them."""
SAME_CASES = "Nothing differs in the cases."
SAME_RESULTS = "Nothing that both runs have differs in the results, beyond rounding."
"""Sentences in place of empty tables."""
ITEMS = 3  # greatest number of shoes in a figure: the ends and the middle of those in both runs


def contents(path: Path, read: Callable[[Path], T]) -> T:
    """Return the content of a file; raise ValueError with its name if it cannot be read."""
    try:
        return read(path)
    # readers of tables, pictures and NetCDF raise all kinds of errors for damaged files
    except Exception as error:
        reason = " ".join(str(error).split()) or repr(error)
        named = reason if reason.startswith(f"{path} ") else f"{path} cannot be read: {reason}"
        raise ValueError(named) from error


def histories_in(
    folders: list[Path], loaded: Mapping[Path, History]
) -> tuple[dict[str, History], dict[str, Path]]:
    """Return the histories in folders by case, and the folder of each; `loaded` are histories by file."""
    histories: dict[str, History] = {}
    places: dict[str, Path] = {}
    for folder in folders:
        for path in sorted(folder.glob("history*.nc")):
            history = loaded.get(path) or History.load(path)
            name = history.case.name
            if name in histories:
                name = f"{folder.name}, {path.stem}"
            histories[name] = history
            places[name] = folder
    return histories, places


def stress_of(folder: Path) -> xr.Dataset | None:
    """Return the stresses in a run's folder; None if it has none.

    Raises ValueError if the file cannot be read.
    """
    path = folder / STRESSES
    return contents(path, _stresses) if path.is_file() else None


@interrupts_wait()
def _stresses(path: Path) -> xr.Dataset:
    # without h5netcdf first, which floods the terminal for a file that HDF5 cannot read
    with h5py.File(path, "r"):
        pass
    dataset = xr.load_dataset(path, engine="h5netcdf")
    catalogue.check_dimensions(dataset)
    return dataset


def comparison_figures(
    histories: Mapping[str, History], stresses: Mapping[str, xr.Dataset]
) -> dict[str, Figure]:
    """Return overlaid main curves of two runs, by the label of the quantity."""
    first, second = (history_series(history, stresses.get(name)) for name, history in histories.items())
    figures = {}
    phases = common_phases(*histories.values())
    for label in (
        quantity.label for quantity in MAIN if quantity.label in first and quantity.label in second
    ):
        names = [item for item in first[label].items if item in second[label].items]
        items = [names[round(place)] for place in np.linspace(0, len(names) - 1, min(ITEMS, len(names)))]
        if items:
            panels = overlay(dict(zip(histories, (first[label], second[label]), strict=True)), items)
            is_of_one = len(items) == 1 and items != ["track"]
            figures[label] = panel_figure(f"{items[0]}: {label}" if is_of_one else label, panels, phases)
    return figures


def comparison_tables(
    histories: Mapping[str, History], stresses: Mapping[str, xr.Dataset]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return tables of the differences between the cases and the results of two runs, first A, then B."""
    first, second = histories.values()
    results = summary.difference_table(
        *(summary.compared(history, stresses.get(name)) for name, history in histories.items())
    )
    parameters = differences(first.case, second.case.with_(name=first.case.name))
    return pd.DataFrame(parameters, columns=["key", "A", "B"]), results


def write_comparison(
    histories: Mapping[str, History],
    path: Path,
    stresses: Mapping[str, xr.Dataset] | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a page on two runs for reading offline: differences of cases and results, and main curves.

    `histories` are two runs by name, first A, then B; `stresses` are their datasets of `StressResults`.

    Raises ValueError if `histories` are not two, FileExistsError if the file exists and `overwrite` is false.
    """
    if len(histories) != 2:
        raise ValueError(f"histories must be two, got {list(histories)}")
    parameters, results = comparison_tables(histories, stresses or {})
    a, b = histories
    lead = [
        f"{letter} is {name}: case {history.case.name!r}, {history.duration:.4g} s"
        for letter, (name, history) in zip("AB", histories.items(), strict=True)
    ]
    said = "Greatest magnitudes of A and B, and of B less A over the time that both have."
    in_cases = page.paragraph(SAME_CASES) if parameters.empty else page.table(parameters)
    in_results = page.paragraph(SAME_RESULTS)
    if not results.empty:
        in_results = page.together(page.paragraph(said), page.table(results))
    drawn = [page.figure_picture(*pair) for pair in comparison_figures(histories, stresses or {}).items()]
    sections = [
        page.Section("parameters", "What differs in the cases", in_cases),
        page.Section("results", "What differs in the results", in_results),
        page.Section("curves", "Main curves", page.together(*drawn)),
    ]
    return page.write_page(page.page(f"{a} and {b}", lead, sections), path, overwrite)
