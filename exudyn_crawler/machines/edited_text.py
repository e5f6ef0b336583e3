"""Edited text of a case file: values change, comments and all else stay."""

from collections.abc import Mapping
from typing import Any

import tomlkit

from exudyn_crawler.machines.case_file import CaseFile, case_text
from exudyn_crawler.settings import fields, units


def changed_text(text: str, values: Mapping[str, Any], case_file: CaseFile) -> str:
    """Return a text with new values at paths such as ``terrain.grade`` or ``terrain.relief.parts[0]``.

    None removes a key, or an item from its list; the number after the last item adds one. Missing tables are
    created. For a list missing from the text, all items come from `case_file`, which is the case of the text.
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
            # a list has units on all of its items or on none
            _put(table, place[-1], units.number_of(value, unit) if is_among_numbers and unit else value)
    return tomlkit.dumps(toml)


def table_of(case_file: CaseFile, place: fields.KeyPath) -> Any:
    """Return the table or list at a path of a case, as written in a file."""
    values: Any = tomlkit.parse(case_text(case_file, by_hand=True))
    for part in place:
        values = values.get(part, []) if isinstance(part, str) else values[part]
    return values


def _put(table: Any, key: int | str, value: Any) -> None:
    """Put a value into a table, or into a list or at its end; None removes the entry."""
    if value is None:
        if isinstance(key, int) or key in table:
            del table[key]
    elif isinstance(key, int) and key == len(table):
        table.append(value)
    else:
        table[key] = value
