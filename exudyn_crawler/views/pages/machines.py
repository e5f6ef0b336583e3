"""Page of the library's machines: each at its start, with its main figures and their sources."""

from collections.abc import Sequence
from dataclasses import replace

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler.machines import CaseFile
from exudyn_crawler.machines.datasheet.figures import Figure as MachineFigure, figures
from exudyn_crawler.machines.datasheet.ledger import GENERAL, ledger_of
from exudyn_crawler.origins import Ledger
from exudyn_crawler.settings.fields import value_text
from exudyn_crawler.views import style
from exudyn_crawler.views.pages import page
from exudyn_crawler.views.pages.page import Section, table, together
from exudyn_crawler.views.scenes import gear, pictures, start, track

TITLE = "Machines"
COLUMNS = ("figure", "of the machine", "of its datasheet", "verdict")
WIDTH, HEIGHT = 9.0, 3.2  # inches of a drawing
COUNT = 2  # drawings beside each other where all of them are one picture
GROUND = 0.15  # drawn ground below the track, fraction of the height above it
SEEN_THROUGH = 0.5  # opacity of shoes beside the wheels


def draw_machine(ax: Axes, case_file: CaseFile) -> None:
    """Draw the right track of a machine at its start, seen from the right, with its weight; axes in m."""
    case = case_file.case
    now = start.with_ground(start.start_of(case.of_track("right")))
    shoes = [replace(solid, opacity=SEEN_THROUGH) for solid in track.shoe_boxes(now)]
    ground = pictures.ground_section(now, at_rest=True)
    solids = [ground, *gear.gear_solids(now), *shoes, pictures.link_pins(now)]
    left, right, _, top = pictures.windows(now)[1]
    window = left, right, -GROUND * top, top
    pictures.paint(ax, [solid.at() for solid in solids], pictures.FROM_THE_RIGHT, window)
    sheet = case_file.datasheet
    assert sheet is not None
    ax.set_title(f"{case.name}, {1e-3 * sheet.operating_weight:.4g} t", fontsize=9, loc="left")
    ax.tick_params(labelsize=7)


def machine_figure(case_file: CaseFile) -> Figure:
    """Draw one machine alone."""
    with style.titled_figure("", WIDTH, HEIGHT) as figure:
        draw_machine(figure.subplots(), case_file)
    return figure


def library_figure(case_files: Sequence[CaseFile]) -> Figure:
    """Draw all machines, each in its own scale."""
    rows = -(-len(case_files) // COUNT)
    with style.titled_figure("", COUNT * 6.0, rows * 2.7) as figure:
        axes = figure.subplots(rows, COUNT, squeeze=False).ravel()
        for ax, case_file in zip(axes, case_files, strict=False):
            draw_machine(ax, case_file)
        for ax in axes[len(case_files) :]:
            ax.set_axis_off()
    return figure


def figure_rows(case_file: CaseFile) -> list[tuple[str, str, str, str]]:
    """Return the figures of a machine beside those of its datasheet, for reading."""
    assert case_file.datasheet is not None
    return [
        (one.name, _text(one.value, one), _text(one.printed, one), one.verdict)
        for one in figures(case_file.case, case_file.datasheet)
    ]


def _text(value: float | None, figure: MachineFigure) -> str:
    """Return a value with four digits and its unit; empty for None."""
    return "" if value is None else value_text(float(f"{value:.4g}"), figure.unit.replace("1", ""))


def origins_line(case_file: CaseFile) -> str:
    """Describe how many values of a machine have each origin."""
    ledger = Ledger(entry for entry in ledger_of(case_file) if entry.how != GENERAL)
    return f"Of its {len(ledger)} values {ledger.summary}."


def machines_page(case_files: dict[str, CaseFile]) -> str:
    """Return the HTML of a page with a section for each machine, by its name for `init --machine`."""
    sections = []
    for name, case_file in case_files.items():
        sheet = case_file.datasheet
        assert sheet is not None
        rows = pd.DataFrame(figure_rows(case_file), columns=COLUMNS)
        remembered = f" Remembered, not seen: {', '.join(sheet.remembered)}." if sheet.remembered else ""
        body = together(
            page.figure_picture(f"{case_file.case.name} as it will start", machine_figure(case_file)),
            table(rows, compact=True),
            page.paragraph(f"Source: {sheet.source}.{remembered} {origins_line(case_file)}"),
            page.paragraph(f"exudyn-crawler init mine --machine {name}"),
        )
        sections.append(Section(name, f"{case_file.case.name}, {sheet.kind}", body))
    lead = ["Each is a datasheet with its sources; all other values follow by a rule or are typical."]
    return page.page(TITLE, lead, sections)
