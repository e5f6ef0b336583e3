"""Single values of a case file changed from outside, as ``terrain.spring_stiffness=1e7``."""

import tomllib
from collections.abc import Iterable
from typing import Any, NamedTuple

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile
from exudyn_crawler.case.files.paths import EVERY, KeyPath, parse_path, with_value_at
from exudyn_crawler.case.parameters.kinds import BASE, key_paths, with_value_in


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
