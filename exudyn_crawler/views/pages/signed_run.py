"""Report to sign of a run: the numbers of the first screen, from the run's folder."""

from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from exudyn_crawler.case.parameters import checks
from exudyn_crawler.files import HISTORY, refuse_existing
from exudyn_crawler.machines.datasheet.ledger import ORIGINS_FILE
from exudyn_crawler.results.history import History, catalogue, summary
from exudyn_crawler.settings.fields import case_rows
from exudyn_crawler.views import figures, style
from exudyn_crawler.views.pages import first_screen, report, runs, signed
from exudyn_crawler.views.pages.signed import Rows, SignedReport
from exudyn_crawler.views.scenes import pictures, track

CASE = "case.toml"
COLUMNS = ("answer", "value", "where and when", "limit or comparison")
ASKED = "Which forces, pressures and torques does the undercarriage see in this run?"
OF_THIS_RUN = (
    "The answers are computed, not measured, and are those of this machine with this drive on this ground: "
    "another ground, grade, turn or load is another run."
)
COMPARED = (
    "The program is compared with published computations and closed forms (docs/validation.md), "
    "not with measurements of this machine."
)
PLAUSIBLE = "All values of the case are within the plausible ranges of known machines and grounds."
NO_LEDGER = "The case keeps no ledger of origins: its {count} values are those of its file (case.toml)."
CURVES, ACROSS = 4, 2
"""Number of drawn answers over time, and of those beside each other."""
SIZE = (10.0, 4.4)  # inches, of the curves


def write_signed(folder: str | Path, out: str | Path | None = None, overwrite: bool = False) -> Path:
    """Write the report to sign of a folder as PDF and return its path, `out` or `report.pdf` in the folder.

    The folder is that of a run, or of an assessment, a life or a wear forecast, which keep their report.

    Raises NotADirectoryError if the folder does not exist, FileNotFoundError if it holds none of them,
    FileExistsError if the file exists and `overwrite` is false, ValueError that names a file that cannot be
    read, ModuleNotFoundError if typst is not installed.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise NotADirectoryError(f"there is no folder {folder}")
    out = folder / signed.PDF if out is None else Path(out)
    refuse_existing(out, overwrite)
    if (folder / HISTORY).is_file():
        return signed.write_pdf(run_report(folder), out, overwrite)
    if (folder / signed.STORED).is_file():
        return signed.write_pdf(signed.stored(folder), out, overwrite)
    raise FileNotFoundError(
        f"{folder} holds neither {HISTORY} of a finished run nor {signed.STORED} of an assessment, a life or "
        "a wear forecast; compute one of an older version again with --overwrite"
    )


def run_report(folder: Path) -> SignedReport:
    """Return the report to sign of a run's folder; raises as `write_signed`."""
    path = folder / HISTORY
    history = History.load(path)
    stress = runs.stress_of(folder)
    results = summary.key_results(history, stress)
    case = history.case
    inputs = [folder / name for name in (CASE, ORIGINS_FILE, HISTORY) if (folder / name).is_file()]
    warning = next(checks.implausible(case, history.duration), None)
    checksums = tuple((file.name, signed.file_sum(file)) for file in inputs)
    facts = [("machine", case.gear.words(case)), ("case", case.name), signed.revision(checksums)]
    facts += zip(("run", "program"), report.provenance(folder, {case.name: history}), strict=False)
    return SignedReport(
        kind="Run",
        title=case.name,
        facts=tuple(facts),
        question=ASKED,
        lines=(first_screen.sentence(history, results),),
        answers=Rows(COLUMNS, tuple(first_screen.answers(history, results, stress))),
        validity=(OF_THIS_RUN, f"Warning: {warning}." if warning else PLAUSIBLE, COMPARED),
        checksums=checksums,
        figures=_figures(history, results),
        **_origins(folder, len(case_rows(case))),
    )


def _origins(folder: Path, count: int) -> dict[str, Any]:
    """Return the fields on what is given and what is assumed."""
    path = folder / ORIGINS_FILE
    if not path.is_file():
        said = NO_LEDGER.format(count=count)
        return {"given_words": said, "given": (), "assumed_words": signed.NOT_VARIED, "assumed": ()}
    table = runs.contents(path, lambda one: pd.read_csv(one, dtype=str, keep_default_na=False))
    return signed.ledger_parts(list(table.itertuples(index=False, name=None)), ORIGINS_FILE)


def _figures(history: History, results: pd.DataFrame) -> dict[str, bytes]:
    """Return the side view of the first screen, the first answers over time, and the ground pressure."""
    now = track.instants(history, [results["at"].iloc[0]])
    pressure = pictures.pressure_figure(history)
    pressure.suptitle("")  # the caption says it
    drawn = {
        "Side view with the forces of the ground on the shoes": first_screen.machine_figure(now),
        "First answers over time, greatest over the machine": _curves(history, results),
        "Ground pressure below the shoes": pressure,
    }
    return {caption: signed.picture(figure) for caption, figure in drawn.items()}


def _curves(history: History, results: pd.DataFrame) -> Figure:
    """Draw the first answers over time."""
    series = summary.greatest_over_time(history, catalogue.select(key_result=True))
    names = [name for name, *_ in first_screen.answers(history, results) if name in series]
    with style.titled_figure("", *SIZE) as figure:
        axes = figure.subplots(CURVES // ACROSS, ACROSS, sharex=True).ravel()
        for ax, name in zip(axes, names, strict=False):
            values = series[name]
            figures.Panel(name.removeprefix("greatest "), values.attrs["units"], {name: values}).draw(ax)
            ax.set_xlabel("time in s")
        for ax in axes[len(names) :]:
            ax.set_axis_off()
    return figure
