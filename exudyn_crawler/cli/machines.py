"""Commands on machines: what follows from a datasheet, and the machines that there are."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

import exudyn_crawler as crawler
from exudyn_crawler.cli import application, datasheets
from exudyn_crawler.cli.commands import app
from exudyn_crawler.views.tables import print_rows

command = partial(application.command, app)
FIGURES = ("figure", "of the machine", "of the datasheet", "verdict")


@command("exudyn-crawler machine mine.toml")
def machine(
    file: Annotated[Path, typer.Argument(help="case file with a datasheet", metavar="FILE")],
    changes: application.Changes = None,
) -> None:
    """Show what follows from a datasheet: its figures beside those of the machine, and what is assumed."""
    from exudyn_crawler.case.datasheet.figures import figures
    from exudyn_crawler.case.datasheet.provenance import sheet_rows

    case_file = crawler.read_case(file, changes or ())
    sheet = case_file.datasheet
    if sheet is None:
        raise ValueError(
            f"{file} must have a table [datasheet]; exudyn-crawler machines lists some to start from"
        )
    origins = sheet_rows(sheet)
    print_rows(datasheets.COLUMNS, origins, f"{file}: what is given, derived and assumed")
    rows = [
        (figure.name, _text(figure.value, figure.unit), _text(figure.printed, figure.unit), figure.verdict)
        for figure in figures(case_file.case, sheet)
    ]
    print_rows(FIGURES, rows, f"{case_file.case.name}: its figures")


def _text(value: float | None, unit: str) -> str:
    """Figure with four digits and its unit; empty for none."""
    from exudyn_crawler.case.parameters.fields import value_text

    return "" if value is None else value_text(float(f"{value:.4g}"), unit if unit != "1" else "")


@command("exudyn-crawler machines")
def machines() -> None:
    """List the machines of the library, which `init NAME --machine MACHINE` starts from."""
    from exudyn_crawler.case.datasheet import library

    rows = []
    for name, path in library.machines().items():
        case_file = crawler.read_case(path)
        sheet = case_file.datasheet
        assert sheet is not None
        weight = f"{1e-3 * sheet.operating_weight:.4g} t"
        rows.append((name, case_file.case.name, sheet.kind, weight, sheet.source))
    print_rows(("machine", "name", "kind", "weight", "source"), rows, "Machines")
