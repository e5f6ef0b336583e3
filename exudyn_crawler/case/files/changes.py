"""Changes of a case by paths and values, and how two cases differ."""

import tomllib
from collections.abc import Iterable
from typing import Any, NamedTuple

from pydantic import BaseModel

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile
from exudyn_crawler.case.files.text import case_rows, value_text
from exudyn_crawler.case.parameters.fields import Entry, is_table, walk
from exudyn_crawler.case.parameters.paths import (
    BASE,
    EVERY,
    KeyPath,
    key_paths,
    named_values,
    parse_path,
    with_value_at,
    with_value_in,
)


class Change(NamedTuple):
    """A value and its path in a case file; `key` is the path as it was written."""

    key: str
    path: KeyPath
    value: Any

    @property
    def is_of_item(self) -> bool:
        """Whether the value is an item of a list, or in one: lists may come from a base."""
        return len(_names(self.path)) < len(self.path)

    def made_in(self, content: dict[str, Any], kind: type[CaseFile] | None = None) -> dict[str, Any]:
        """Content with the change: tables of a file or, of a `kind`, with what bases give.

        Raises
        ------
        ValueError
            If the path leads to an item that a list does not have, or into what is no table or list.
        """
        try:
            if kind is not None:
                return with_value_in(kind, content, self.path, self.value)
            changed: dict[str, Any] = with_value_at(content, self.path, self.value)
        except ValueError as error:
            raise ValueError(f"{self.key}: {error}") from error
        return changed


def parsed(changes: Iterable[str]) -> list[Change]:
    """Changes from text.

    Parameters
    ----------
    changes : iterable of str
        Each a key, "=" and a value as TOML writes it; text needs no quotes. A key is the path of a value, or
        its last names where no other value of a case has them. Items of lists count from 0: `phases[0].end`;
        `phases[*].end` means all of them.

    Raises
    ------
    ValueError
        If a change is none, or its key could be several.
    """
    return [_parsed(change) for change in changes]


def _parsed(change: str) -> Change:
    key, equals, text = change.partition("=")
    try:
        path = parse_path(key.strip())
    except ValueError:
        equals = ""
    if not equals:
        raise ValueError(
            f"a change must be like terrain.spring_stiffness=1e7 or loads.phases[0].end=15, got {change!r}"
        )
    return Change(key.strip(), _as_far_as_known(_whole(path, key.strip())), _value(text.strip()))


def _names(path: KeyPath) -> list[str]:
    return [part for part in path if isinstance(part, str) and part != EVERY]


def _whole(path: KeyPath, key: str) -> KeyPath:
    """Path of the one value that last names alone mean; any other as it is."""
    if path[0] in {BASE, *Case.model_fields, *CaseFile.model_fields}:
        return path
    end = "." + ".".join(_names(path))
    found = [one for one in key_paths(CaseFile) if one.endswith(end)]
    if len(found) > 1:
        raise ValueError(f"{key}: which one is meant? {', '.join(found)}")
    return (*parse_path(found[0].removesuffix(end)), *path) if found else path


def _as_far_as_known(path: KeyPath) -> KeyPath:
    """Path up to the first name that no case file has, of which the check of the content tells."""
    known = [f"{one}." for one in key_paths(CaseFile)]
    above = ""
    for done, part in enumerate(path, 1):
        if part in _names(path[:done]):
            above += f"{part}."
            if part != BASE and not any(one.startswith(above) for one in known):
                return path[:done]
    return path


def _value(text: str) -> Any:
    try:
        content = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    # a line break could hide more
    return content["value"] if len(content) == 1 else text


ABSENT = "-"
"""In place of a value that a case does not have."""


class Difference(NamedTuple):
    """A value in which two cases differ."""

    key: str
    first: str
    second: str
    unit: str

    def __str__(self) -> str:
        return f"{self.key} is {self.first}, not {self.second}"


class Beside(NamedTuple):
    """A value of a case beside that of its base, which is empty where it is the same."""

    key: str
    value: str
    in_the_base: str
    unit: str
    meaning: str


def differences(first: BaseModel, second: BaseModel) -> list[Difference]:
    """Values in which two cases or case files differ."""
    a, b = (
        {entry.path: entry for entry in walk(one) if not is_table(entry.value)} for one in (first, second)
    )
    found = []
    for key in dict.fromkeys([*a, *b]):
        one, other = a.get(key), b.get(key)
        if one is None or other is None or one.value != other.value:
            found.append(Difference(key, *_texts(one, other), (a.get(key) or b[key]).unit))
    return found


def _texts(*entries: Entry | None) -> tuple[str, str]:
    """Two values that differ for reading, with all digits where fewer would hide it."""
    one, other = (ABSENT if entry is None else value_text(entry.value) for entry in entries)
    if one == other:
        one, other = (ABSENT if entry is None else repr(entry.value) for entry in entries)
    return one, other


def parameter_differences(first: BaseModel, second: BaseModel) -> list[Difference]:
    """Values in which two cases differ but for their names."""
    return [one for one in differences(first, second) if one.key != "name"]


def rows_beside_base(case_file: CaseFile) -> tuple[str, list[Beside]]:
    """Every value of a case file beside that of the named case from which the fewest differ.

    Name, duration and outputs are not compared.

    Returns
    -------
    base : str
        Name of that case, as `base` in a case file.
    rows : list of Beside
    """
    from_bases = {
        name: {one.key: one.first for one in parameter_differences(make(), case_file.case)}
        for name, make in named_values(Case).items()
    }
    base = min(from_bases, key=lambda name: len(from_bases[name]))
    return base, [
        Beside(*row[:2], from_bases[base].get(row.key, ""), *row[2:]) for row in case_rows(case_file)
    ]
