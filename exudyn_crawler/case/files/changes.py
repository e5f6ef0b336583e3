"""Single values of a case file changed from outside, as ``terrain.spring_stiffness=1e7``."""

import re
import tomllib
from collections.abc import Iterable
from typing import Any, NamedTuple

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile
from exudyn_crawler.case.parameters.kinds import Place, key_path, key_paths

NAME = r"[A-Za-z_]\w*(\[\d+\])*"
KEY = re.compile(rf"{NAME}(\.{NAME})*", re.ASCII)
PART = re.compile(r"([A-Za-z_]\w*)|\[(\d+)\]", re.ASCII)
"""Name, or number of an item."""


class Change(NamedTuple):
    """A value and its place in a case file; `key` is the place as it was given."""

    key: str
    place: Place
    value: Any

    @property
    def is_of_item(self) -> bool:
        """Whether the value is an item of a list, or in one: lists may come from a base."""
        return any(isinstance(part, int) for part in self.place)


def parsed(changes: Iterable[str]) -> list[Change]:
    """Changes from text.

    Parameters
    ----------
    changes : iterable of str
        Each a key, "=" and a value as TOML writes it; text needs no quotes. A key is the path of a value, or
        its last names where no other value of a case has them. Items of lists count from 0: `phases[0].end`.

    Raises
    ------
    ValueError
        If a change is none, or its key could be several.
    """
    return [_parsed(change) for change in changes]


def _parsed(change: str) -> Change:
    key, equals, text = change.partition("=")
    key = key.strip()
    if not equals or not KEY.fullmatch(key):
        raise ValueError(
            f"a change must be like terrain.spring_stiffness=1e7 or loads.phases[0].end=15, got {change!r}"
        )
    parts = PART.findall(_whole_path(key))
    return Change(key, tuple(name or int(number) for name, number in parts), _value(text.strip()))


def changed(content: dict[str, Any], changes: Iterable[Change]) -> dict[str, Any]:
    """Content of a case file with some values changed, to be checked like the file.

    Parameters
    ----------
    content : dict
        Tables of the file.
    changes : iterable of Change
        None of them of an item.

    Raises
    ------
    ValueError
        If a value is to be changed in what is no table.
    """
    for change in changes:
        *tables, name = change.place
        table = content
        for one in tables:
            below = table.setdefault(str(one), {})
            if not isinstance(below, dict):
                raise ValueError(
                    f"{change.key}: {one} must be a table to change a value of it, got {below!r}"
                )
            table = below
        table[str(name)] = change.value
    return content


def change_item(content: dict[str, Any], change: Change) -> None:
    """Change an item of a list in the content of a case, with what bases give.

    Raises
    ------
    ValueError
        If there is no such list or item.
    """
    parent: Any = content
    for done, part in enumerate(change.place):
        is_last = done == len(change.place) - 1
        before = change.place[:done]
        if isinstance(part, int):
            if parent == [] and not _is_known(before):
                return  # the check of the content tells of the unknown key
            if not isinstance(parent, list):
                raise ValueError(f"{change.key}: there is no list {key_path(before)} to change an item of")
            if part >= len(parent):
                raise ValueError(
                    f"{change.key}: {key_path(before)} has {len(parent)} items, counted from 0, no [{part}]"
                )
        elif not isinstance(parent, dict):
            raise ValueError(f"{change.key}: {key_path(before)} must be a table to change a value of it")
        if is_last:
            parent[part] = change.value
        elif isinstance(part, int):
            parent = parent[part]
        else:
            of_list = isinstance(change.place[done + 1], int)
            unknown = of_list and not _is_known((*before, part))
            parent = parent.setdefault(part, [] if unknown else None if of_list else {})


def _is_known(place: Place) -> bool:
    """Whether a case file may have a value or a table at a place."""
    wanted = ".".join(part for part in place if isinstance(part, str))
    return any(f"{path}.".startswith(f"{wanted}.") for path in key_paths(CaseFile))


def _whole_path(key: str) -> str:
    """Path of the one value that last names alone mean; any other key as it is."""
    names = re.sub(r"\[\d+\]", "", key)
    top = {"base", *Case.model_fields, *CaseFile.model_fields}
    if names.partition(".")[0] in top:
        return key
    paths = [path for path in key_paths(CaseFile) if path.endswith(f".{names}")]
    if len(paths) > 1:
        raise ValueError(f"{key}: which one is meant? {', '.join(paths)}")
    return f"{paths[0].removesuffix(names)}{key}" if paths else key


def _value(text: str) -> Any:
    try:
        content = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    # a line break could hide more
    return content["value"] if len(content) == 1 else text
