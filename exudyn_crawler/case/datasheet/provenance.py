"""Where every value of a case with a datasheet comes from."""

from typing import NamedTuple

from pydantic import BaseModel

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.datasheet.chain import SHOES
from exudyn_crawler.case.datasheet.derive import derived
from exudyn_crawler.case.datasheet.notes import Note, Origin
from exudyn_crawler.case.datasheet.sheet import Datasheet
from exudyn_crawler.case.datasheet.shoe_mesh import flexible_of
from exudyn_crawler.case.parameters import fields

FLEXIBLE = "steel, and modes and damping of the papers' flexible shoes"
ORIGINS_FILE = "origins.csv"
"""Name of the table of all origins in a run's folder."""
GENERAL = "of all machines, chosen: no datasheet says it"


class Provenance(NamedTuple):
    """Origin of a value of a case, or of one that stands for it in a datasheet."""

    key: str
    value: str  # with its unit
    origin: Origin
    how: str


def provenance(case: Case, sheet: Datasheet) -> list[Provenance]:
    """Origin of every value of a case: the file gives what differs from what follows of its datasheet."""
    notes = {note.path: note for note in derived(sheet).notes}
    follows = {entry.path: entry.value for entry in fields.values_of(derived(sheet).case)}
    flexible: dict[str, object] = {}
    if case.flexible is not None and sheet.shoe_mesh is not None:
        usual = case.with_(flexible=flexible_of(sheet, case.flexible.shoes[0]))
        flexible = {
            kept.path: kept.value for kept in fields.values_of(usual) if kept.path.startswith("flexible.")
        }
    rows = []
    for entry in fields.values_of(case):
        origin, how = _origin(entry, notes, follows)
        if entry.path in flexible and flexible[entry.path] == entry.value:
            origin, how = "assumed", FLEXIBLE
        rows.append(Provenance(entry.path, fields.value_text(entry.value, entry.unit), origin, how))
    return rows


def _origin(entry: fields.Entry, notes: dict[str, Note], follows: dict[str, object]) -> tuple[Origin, str]:
    if entry.path not in follows or follows[entry.path] != entry.value:
        return "given", "the file"
    path = SHOES if entry.path == "track.shoe_count" else entry.path
    note = notes.get(path)
    return ("assumed", GENERAL) if note is None else (note.origin, note.how)


def sheet_rows(sheet: Datasheet) -> list[Provenance]:
    """Origin of what a datasheet says and of the typical values that the case has taken."""
    notes = derived(sheet).notes
    return [
        Provenance(note.path, fields.value_text(note.value, note.unit), note.origin, note.how)
        for note in notes
        if note.value is not None
    ]


def all_rows(case: Case, sheet: Datasheet) -> list[Provenance]:
    """Origin of every value of a case, then of what stands in none: of the datasheet and typical values."""
    rows = provenance(case, sheet)
    keys = {row.key for row in rows}
    return [*rows, *(row for row in sheet_rows(sheet) if row.key not in keys)]


def origins(case_file: BaseModel) -> dict[str, Provenance]:
    """Provenance of the values of a case file by their keys; empty for a file without a datasheet."""
    sheet = getattr(case_file, "datasheet", None)
    if sheet is None:
        return {}
    return {row.key: row for row in provenance(case_file.case, sheet)}  # type: ignore[attr-defined]
