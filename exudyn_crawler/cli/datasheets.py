"""Datasheets on the command line: copies of the library's machines, and tables of origins of values."""

from pathlib import Path

import typer

import exudyn_crawler as crawler
from exudyn_crawler.cli import application
from exudyn_crawler.run.folder.progress import heartbeat
from exudyn_crawler.views.tables import ORIGIN_COLUMNS, origin_rows, print_rows, print_table


def copy_machine(machine: str, path: Path, overwrite: bool) -> None:
    """Copy a machine of the library to a path, under its name.

    Raises ValueError if there is no such machine.
    """
    from exudyn_crawler.files import whole_file
    from exudyn_crawler.machines.datasheet import library

    known = library.machines()
    if machine not in known:
        hint = f"; {machine} is a study: --study {machine}" if machine in application.study_names() else ""
        raise ValueError(f"machine must be one of {', '.join(sorted(known))}, got {machine!r}{hint}")
    with whole_file(path, overwrite) as temporary:
        temporary.write_text(library.text_of(machine, path.stem), encoding="utf-8")


def fit_shoe(file: Path, size: str, out: Path, overwrite: bool) -> None:
    """Fit the ready shoe to the datasheet of a case file, and write it with a case of this flexible shoe."""
    from exudyn_crawler.shoe_file import datasheet_shoe

    with heartbeat(f"shoe of {file}"):
        table, paths = datasheet_shoe(file, size, out, overwrite)
    print_table(table, f"{paths['mesh']}: ready shoe of {file}")
    case = paths["case"]
    typer.echo(f"{paths['picture']}: its surfaces; its stress: exudyn-crawler run {case}")
    typer.echo(f"its cycles to a crack, without a run: exudyn-crawler check {case}")


def show_keys() -> None:
    """Print all figures of a datasheet: key, unit and meaning."""
    from exudyn_crawler.machines.datasheet.sheet import Datasheet
    from exudyn_crawler.settings import fields

    rows = []
    for name, field in Datasheet.model_fields.items():
        words = fields.literals(field.annotation)
        meaning = ": ".join(filter(None, (field.description, ", ".join(words))))
        rows.append((name, fields.unit_of(field), meaning))
    print_rows(("key", "unit", "meaning"), rows, 'Keys of [datasheet]; values may have any unit: "35.4 t"')


def show_values(case_file: "crawler.CaseFile", title: str) -> None:
    """Print every value of a machine's case with its origin."""
    from exudyn_crawler.machines.datasheet.ledger import case_ledger

    ledger = case_ledger(case_file)
    heading = f"{title}: {ledger.summary}; exudyn-crawler machine {title} has the datasheet's figures"
    rows = origin_rows(ledger, short=True)
    print_rows(ORIGIN_COLUMNS, rows, heading, keys=ORIGIN_COLUMNS[:3], whole="in the datasheet's page")


def show_machine(history: "crawler.History") -> None:
    """Print the answers of a run on its machine, in terms of undercarriages."""
    from exudyn_crawler.results.history.machine import evaluated_from, machine_answers, together

    title = f"{history.case.name}: the machine, from {evaluated_from(history):.4g} s on"
    print_table(together(machine_answers(history)), title)
