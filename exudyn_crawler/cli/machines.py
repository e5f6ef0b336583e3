"""Commands on machines: values that follow from a datasheet, and machines of the library."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

import exudyn_crawler as crawler
from exudyn_crawler.cli import application, datasheets
from exudyn_crawler.cli.commands import app
from exudyn_crawler.views.tables import ORIGIN_COLUMNS, origin_rows, print_rows, write_table

command = partial(application.command, app)
FIGURES = ("figure", "of the machine", "of the datasheet", "verdict")


@command("exudyn-crawler machine mine.toml")
def machine(
    file: Annotated[
        Path | None,
        application.file_argument(help="case file with a datasheet", metavar="FILE", show_default=False),
    ] = None,
    keys: Annotated[
        bool, typer.Option("--keys", help="list all keys of a datasheet with their units")
    ] = False,
    every: Annotated[
        bool, typer.Option("--all", help="list all derived values, each with its origin")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="CSV file to write: all values with all digits and their origins")
    ] = None,
    overwrite: application.Overwrite = False,
    changes: application.Changes = None,
) -> None:
    """Show what follows from a datasheet: its figures beside those of the machine, and assumed values."""
    from exudyn_crawler.case.parameters import checks
    from exudyn_crawler.machines.datasheet.discrepancies import implausible_values
    from exudyn_crawler.machines.datasheet.figures import figures
    from exudyn_crawler.machines.datasheet.ledger import sheet_ledger

    if keys:
        datasheets.show_keys()
        return
    if file is None:
        raise ValueError(
            "FILE must be given: a case file with a datasheet; --keys lists the keys of a datasheet"
        )
    case_file = crawler.read_case(file, changes or ())
    sheet = case_file.datasheet
    if sheet is None:
        raise ValueError(
            f"{file} must have a table [datasheet]; exudyn-crawler machines lists some to start from"
        )
    from exudyn_crawler.files import refuse_existing

    if out is not None:
        refuse_existing(out, overwrite)
    ledger = sheet_ledger(sheet)
    rows = [
        (figure.name, _text(figure.value, figure.unit), _text(figure.printed, figure.unit), figure.verdict)
        for figure in figures(case_file.case, sheet)
    ]
    print_rows(FIGURES, rows, f"{case_file.case.name}: its figures")
    checks.warn_of(implausible_values(case_file))
    if every:
        print_rows(ORIGIN_COLUMNS, origin_rows(ledger, short=True), f"{file}: {ledger.summary}")
    if out is not None:
        import pandas as pd

        write_table(pd.DataFrame(origin_rows(ledger), columns=ORIGIN_COLUMNS), out, overwrite)
        typer.echo(f"{out}: all values with their origins")
    if not every and out is None:
        listed = f"exudyn-crawler machine {file} --all lists them, --out FILE.csv writes them"
        typer.echo(f"{ledger.summary} values determine these figures: {listed}")


def _text(value: float | None, unit: str) -> str:
    """Return a figure with four digits and its unit; empty for None."""
    from exudyn_crawler.settings.fields import value_text

    return "" if value is None else value_text(float(f"{value:.4g}"), unit if unit != "1" else "")


@command("exudyn-crawler machines --page machines.html")
def machines(
    page: Annotated[
        Path | None, typer.Option(help="page to write, with drawing, figures and sources of each machine")
    ] = None,
    overwrite: application.Overwrite = False,
) -> None:
    """List the machines of the library, which `init NAME --machine MACHINE` starts from."""
    from exudyn_crawler.files import refuse_existing
    from exudyn_crawler.machines.datasheet import library

    if page is not None:
        refuse_existing(page, overwrite)
    case_files = {name: crawler.read_case(path) for name, path in library.machines().items()}
    rows = []
    for name, case_file in case_files.items():
        sheet = case_file.datasheet
        assert sheet is not None
        weight = f"{1e-3 * sheet.operating_weight:.4g} t"
        rows.append((name, case_file.case.name, sheet.kind, weight, sheet.source))
    print_rows(("machine", "name", "kind", "weight", "source"), rows, "Machines")
    if page is not None:
        from exudyn_crawler.views.pages.machines import machines_page
        from exudyn_crawler.views.pages.page import write_page

        typer.echo(f"{write_page(machines_page(case_files), page, overwrite)}: open it in a browser")
