"""Text of a case file with other values, as a hand would write them: comments and all else stay."""

from collections.abc import Mapping
from typing import Any

import tomlkit

from exudyn_crawler.machines.case_file import CaseFile, case_text
from exudyn_crawler.settings import fields, units


def changed_text(text: str, values: Mapping[str, Any], case_file: CaseFile) -> str:
    """Text with other values at paths such as ``terrain.grade`` or ``terrain.relief.parts[0]``.

    None leaves a key out, and takes an item out of its list; the number behind the last item adds one.
    Tables are made where they are missing. Of a list that the text does not have, all items are taken from
    `case_file`, which is the text's.
    """
    toml = tomlkit.parse(text)
    for path, value in values.items():
        place = fields.parse_path(path)
        unit = fields.unit_at(CaseFile, place)
        table: Any = toml
        for depth, part in enumerate(place[:-1]):
            if isinstance(part, str) and part not in table:
                if value is None:
                    break
                is_list = isinstance(place[depth + 1], int)
                table[part] = table_of(case_file, place[: depth + 1]) if is_list else tomlkit.table()
            table = table[part]
        else:
            is_among_numbers = isinstance(place[-1], int) and any(map(fields.is_number, table))
            # one with a unit stands beside others with units only
            _put(table, place[-1], units.number_of(value, unit) if is_among_numbers and unit else value)
    return tomlkit.dumps(toml)


def table_of(case_file: CaseFile, place: fields.KeyPath) -> Any:
    """Table or list at a path of a case, as a file has it."""
    values: Any = tomlkit.parse(case_text(case_file, by_hand=True))
    for part in place:
        values = values.get(part, []) if isinstance(part, str) else values[part]
    return values


def _put(table: Any, key: int | str, value: Any) -> None:
    """Put a value into a table or a list, behind its end too; None takes out what is there."""
    if value is None:
        if isinstance(key, int) or key in table:
            del table[key]
    elif isinstance(key, int) and key == len(table):
        table.append(value)
    else:
        table[key] = value
