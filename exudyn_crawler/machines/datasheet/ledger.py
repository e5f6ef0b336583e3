"""Ledger of a case file with a datasheet: provenance of every value of the machine."""

from collections.abc import Iterator, Sequence
from typing import Any

from exudyn_crawler.case.case import Case
from exudyn_crawler.machines.case_file import CaseFile
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.ruled_machine import FILE, KEY
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.machines.datasheet.shoe_mesh import flexible_of
from exudyn_crawler.origins import Entry, Ledger, Origin
from exudyn_crawler.settings import fields, reading

FLEXIBLE = "steel, and modes and damping of the papers' flexible shoes"
DEFAULT = "default of the program"
NAMED_CASE = "named case or part that the file begins with, or a default of the program"
GENERAL = "of all machines, chosen: no datasheet says it"
"""Source of values without a rule."""
ORIGINS_FILE = "origins.csv"
"""Name of the table of all origins in a run's folder."""


def ledger_of(case_file: CaseFile) -> Ledger:
    """Return the entries of all values of a case, then of its datasheet and typical values.

    The ledger is empty without a datasheet.
    """
    sheet = case_file.datasheet
    return Ledger(()) if sheet is None else Ledger([*case_ledger(case_file), *sheet_ledger(sheet)])


def stated_ledger(case: Case, stated: Sequence[str]) -> Ledger:
    """Return the ledger of a case without a datasheet; a file states the values at some paths.

    All other values come from the named case or part at the start of the file, or are defaults.
    """
    above = tuple(f"{path}{end}" for path in stated for end in (".", "["))

    def entry(item: fields.Item) -> Entry:
        given = item.path in stated or item.path.startswith(above)
        origin, how = (Origin.GIVEN, FILE) if given else (Origin.LIBRARY, NAMED_CASE)
        return Entry(item.path, item.value, item.unit, origin, how, item.meaning)

    return Ledger(map(entry, fields.values_of(case)))


def sheet_ledger(sheet: Datasheet) -> Ledger:
    """Return the entries of a datasheet: printed and derived figures, and the typical values used."""
    return Ledger(entry for entry in derived(sheet).ledger if entry.path.startswith(f"{KEY}."))


def case_ledger(case_file: CaseFile) -> Ledger:
    """Return the entries of all values of the case of a case file with a datasheet."""
    assert case_file.datasheet is not None
    return Ledger(_case_entries(case_file.case, case_file.datasheet))


def _case_entries(case: Case, sheet: Datasheet) -> Iterator[Entry]:
    """Yield an entry for each value of a case; values not derived from the datasheet are the file's."""
    ledger = derived(sheet).ledger
    follows = {item.path: item.value for item in fields.values_of(derived(sheet).case)}
    machine = library.beginning(sheet)
    kept = {} if machine is None else _library_values(machine, case)
    usual: dict[str, object] = {}
    if case.flexible is not None and sheet.shoe_mesh is not None:
        flexible = flexible_of(sheet, case.flexible.shoes[0])
        usual = {f"flexible.{item.path}": item.value for item in fields.values_of(flexible)}
    for item in fields.values_of(case):
        path, value = item.path, item.value
        if path in follows and follows[path] == value:
            entry = ledger.get(path)
            origin, how = (entry.origin, entry.how) if entry else (Origin.ASSUMED, GENERAL)
        elif path in usual and usual[path] == value:
            origin, how = Origin.ASSUMED, FLEXIBLE
        elif machine is not None and path in kept and kept[path] == _plain(value):
            origin, how = Origin.LIBRARY, machine.source
        elif path not in follows and not item.field.is_required() and value == item.field.default:
            origin, how = Origin.ASSUMED, DEFAULT
        else:
            origin, how = Origin.GIVEN, FILE
        yield Entry(path, value, item.unit, origin, how, item.meaning)


def _library_values(machine: library.LibraryMachine, case: Case) -> dict[str, Any]:
    """Return the values beside the datasheet in the file of a library's machine, by path."""
    beside = {name: value for name, value in machine.content.items() if name not in (KEY, "duration")}
    filled = reading.filled(beside, Case, below=case.model_dump(mode="json"))
    values = {}
    for place in reading.stated(beside):
        value: Any = filled
        for name in place:
            value = value[name]
        values[fields.path_text(place)] = value
    return values


def _plain(value: Any) -> Any:
    """Return a value with lists in place of tuples, as in a file."""
    return [_plain(part) for part in value] if isinstance(value, tuple) else value
