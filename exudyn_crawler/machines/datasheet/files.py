"""Datasheets in case files: the table ``[datasheet]``; the rest of the file changes derived values."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines.case_file import CaseFile
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.sheet import OF_RUN, Datasheet
from exudyn_crawler.machines.datasheet.shoe_mesh import flexible_of
from exudyn_crawler.settings import error_lines, fields, reading

KEY = "datasheet"


def has_datasheet(content: reading.Content) -> bool:
    """Return True if a file has a datasheet other than the word for none."""
    return content.get(KEY, fields.NONE) != fields.NONE


def with_machine(content: reading.Content) -> reading.Content:
    """Return the content over that of the library's machine that its datasheet names as `base`, if any."""
    table = content[KEY]
    if not isinstance(table, dict):
        raise ParameterError(f"{KEY} must be a table of the maker's figures, got {fields.shown(table)}")
    if fields.BASE in content:
        raise ParameterError(
            f"{fields.BASE} must be left out beside a {KEY}: all values follow from the {KEY}"
        )
    content = with_own_mesh(content)
    table = content[KEY]
    if fields.BASE not in table:
        return content
    below = dict(library.machine_content(table[fields.BASE]))
    given = {name: value for name, value in table.items() if name != fields.BASE}
    if any(name not in OF_RUN for name in given):
        # a changed machine takes the name of the file
        del below["name"]
    return library.over(content | {KEY: {"began_as": table[fields.BASE]} | given}, below)


def datasheet_of(table: reading.Content, folder: Path | None = None) -> Datasheet:
    """Return the datasheet of a file's table in a folder; raise `ParameterError`, a line per wrong value."""
    try:
        sheet = reading.from_content(Datasheet, table, folder)
        if sheet.began_as is not None:
            library.machine_content(sheet.began_as)
        return sheet
    except ValidationError as error:
        lines = error_lines.error_lines(error, CaseFile, {KEY: table}, (KEY,))
        raise ParameterError("\n".join(lines)) from None
    except ValueError as error:
        raise ParameterError("\n".join(f"{KEY}.{line}" for line in fields.lines_of(error))) from error


def followed(content: reading.Content, before: reading.Content) -> reading.Content:
    """Return the content of a case file after a change of its datasheet; `before` is the content before it.

    Values of the case that did not follow from the datasheet before stay unchanged.
    """
    if content.get(KEY) is None or content[KEY] == before[KEY]:
        return content
    old, new = (case_values(datasheet_of(file[KEY])) for file in (before, content))
    return content | {"case": _replaced(content["case"], old, new)}


def _replaced(values: Any, old: Any, new: Any) -> Any:
    """Return the new values in place of those equal to the old ones."""
    if values == old:
        return new
    if isinstance(values, dict) and isinstance(old, dict) and isinstance(new, dict):
        return {name: _replaced(value, old.get(name), new.get(name)) for name, value in values.items()}
    return values


def assumed_ranges(sheet: Datasheet) -> list[reading.Content]:
    """Return the typical values used by a datasheet's machine as entries of a sweep over their ranges."""
    path = f"{KEY}.typical"
    rows = derived(sheet).ruled.typical
    return [{"key": f"{path}.{row.name}", "low": row.low, "high": row.high} for row in rows]


def case_values(sheet: Datasheet, flexible: bool = False) -> reading.Content:
    """Return the values of a datasheet's case as written in a file, on request with flexible shoes."""
    try:
        case = derived(sheet).case
        values = case.model_dump(mode="json")
        if flexible:
            values["flexible"] = flexible_of(sheet, passed_shoe(case)).model_dump(mode="json")
        return values
    except ValueError as error:
        raise ParameterError("\n".join(_keyed(line) for line in fields.lines_of(error))) from error


def _keyed(line: str) -> str:
    """Return a line of a datasheet's error with the table's name before it."""
    key = re.match(r"\w*(?=[\w.\[\]]*: )", line)
    return f"{KEY}.{line}" if key and key[0] in Datasheet.model_fields else f"{KEY}: {line}"


def passed_shoe(case: Case) -> int:
    """Return the number of the shoe below the foremost wheel in travel, which all other wheels pass over."""
    gear = case.part(Closed)
    start = gear.assembled(case)
    rollers = start.frame[0] + np.array(gear.rollers)
    foremost = rollers.max() if case.drive.speed.values[-1] >= 0.0 else rollers.min()
    x = start.shoes[:, 0]
    z = start.shoes[:, 2]
    return 1 + int(np.argmin(np.abs(x - foremost) + np.abs(z - z.min())))


def with_own_mesh(content: reading.Content) -> reading.Content:
    """Return the content with `[shoe] mesh` moved to the datasheet's `shoe_mesh`; the machine follows it."""
    shoe = content.get("shoe")
    if not isinstance(shoe, dict) or "mesh" not in shoe:
        return content
    rest = {name: value for name, value in shoe.items() if name != "mesh"}
    return content | {"shoe": rest, KEY: content[KEY] | {"shoe_mesh": shoe["mesh"]}}
