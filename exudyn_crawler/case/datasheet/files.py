"""Datasheets in case files: the table ``[datasheet]``, of which the rest of the file changes what follows."""

from pydantic import ValidationError

from exudyn_crawler.case.datasheet import library
from exudyn_crawler.case.datasheet.derive import derived
from exudyn_crawler.case.datasheet.sheet import Datasheet
from exudyn_crawler.case.parameters import faults, fields, reading
from exudyn_crawler.errors import ParameterError

KEY = "datasheet"


def has_datasheet(content: reading.Content) -> bool:
    """True where a file has a datasheet, and not the word for none."""
    return content.get(KEY, fields.NONE) != fields.NONE


def with_machine(content: reading.Content) -> reading.Content:
    """Content over that of the library's machine that its datasheet names as `base`, if it does."""
    table = content[KEY]
    if not isinstance(table, dict):
        raise ParameterError(f"{KEY} must be a table with what its maker prints, got {fields.shown(table)}")
    if fields.BASE in content:
        raise ParameterError(f"{fields.BASE} must be left out beside a {KEY}, from which all values follow")
    if fields.BASE not in table:
        return content
    below = library.machine_content(table[fields.BASE])
    given = {name: value for name, value in table.items() if name != fields.BASE}
    return library.over(content | {KEY: given}, below)


def datasheet_of(table: reading.Content) -> Datasheet:
    """Datasheet of a table; a ParameterError with a line for each value at fault."""
    try:
        return reading.from_content(Datasheet, table)
    except ValidationError as error:
        lines = faults.error_lines(error, Datasheet)
        raise ParameterError("\n".join(f"{KEY}.{line}" for line in lines)) from None
    except ValueError as error:
        raise ParameterError(f"{KEY}: {error}") from error


def case_values(sheet: Datasheet) -> reading.Content:
    """Values of the case of a datasheet, as a file has them."""
    with fields.errors_at(KEY):
        return derived(sheet).case.model_dump(mode="json")
