"""Paths of values: ``loads.phases[2].end``, one grammar for files, changes, sweeps and errors."""

import json
import re
from collections.abc import Callable
from typing import Any

from pydantic import BaseModel

KeyPath = tuple[int | str, ...]
"""Names and numbers on the way to a value: ("loads", "phases", 2, "end")."""
EVERY = "*"
"""In place of a number: all items of a list."""
NAME = re.compile(r"([A-Za-z_]\w*)((?:\[(?:\d+|\*)\])*)", re.ASCII)
NUMBER = re.compile(r"\[(\d+|\*)\]")


def parse_path(text: str) -> KeyPath:
    """Names and numbers of a path: ("loads", "phases", "*", "end") of ``loads.phases[*].end``.

    Raises
    ------
    ValueError
        If the text is not a path.
    """
    path: list[int | str] = []
    for part in text.split("."):
        match = NAME.fullmatch(part)
        if match is None:
            raise ValueError(
                f"a path must be like terrain.spring_stiffness or loads.phases[0].end, got {text!r}"
            )
        path.append(match[1])
        path += [number if number == EVERY else int(number) for number in NUMBER.findall(match[2])]
    return tuple(path)


def path_text(path: KeyPath) -> str:
    """Path as it is written: ``loads.phases[2].end``."""
    text = ""
    for part in path:
        if isinstance(part, int) or part == EVERY:
            text += f"[{part}]"
        else:
            # keys that need quotes in TOML have them here, and cannot break the line
            text += "." + (part if re.fullmatch(r"[\w-]+", part, re.ASCII) else json.dumps(part))
    return text.lstrip(".")


def with_value_at(values: Any, path: KeyPath, value: Any) -> Any:
    """Copy with another value at a path; see `with_change_at`."""
    return with_change_at(values, path, lambda _before: value)


def with_change_at(values: Any, path: KeyPath, change: Callable[[Any], Any], above: KeyPath = ()) -> Any:
    """Copy in which the value at a path, or each of those that ``*`` means, went through a function.

    Parameters
    ----------
    values : dict, list, tuple or parameters
        Parameters on the way become tables of their fields, to be validated again. A table that does not
        have a name gets it; the value before is None then.
    above : tuple
        Path of `values` itself, for errors.

    Raises
    ------
    ValueError
        If the path leads to an item that a list does not have, or into what is no table or list.
    """
    if not path:
        return change(values)
    part, below = path[0], path[1:]
    if isinstance(part, int) or part == EVERY:
        if not isinstance(values, list | tuple):
            raise ValueError(f"there is no list {path_text(above)} to change an item of")
        numbers = range(len(values)) if part == EVERY else [int(part)]
        items = list(values)
        for number in numbers:
            if number >= len(items):
                raise ValueError(f"{path_text(above)} has {len(items)} items, counted from 0, no [{number}]")
            items[number] = with_change_at(items[number], below, change, (*above, number))
        return type(values)(items)
    table = fields_of(values) if isinstance(values, BaseModel) else values
    if not isinstance(table, dict):
        raise ValueError(f"{path_text(above)} must be a table to change a value of it, got {values!r}")
    before = table.get(part, {} if below and isinstance(below[0], str) and below[0] != EVERY else None)
    return {**table, part: with_change_at(before, below, change, (*above, part))}


def fields_of(model: BaseModel) -> dict[str, Any]:
    """Values of a parameter object by name."""
    return {name: getattr(model, name) for name in type(model).model_fields}
