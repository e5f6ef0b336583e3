"""Ledger of origins: the source of every value of a datasheet, a case or an assessment.

A function that finds a value by one of several rules returns it as `Ruled`. All rules are rows of a table
(`read_rules`), so that no function passes a ledger through. Code that shows values builds a ledger from the
fields that hold them.
"""

import csv
from collections.abc import Iterable, Iterator
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple


class Origin(StrEnum):
    """Origin of a value."""

    GIVEN = "given"
    LIBRARY = "of the library's machine"
    DERIVED = "derived"
    ASSUMED = "assumed"


class Ruled(NamedTuple):
    """Value with the name of its rule."""

    value: Any
    rule: str
    detail: str = ""
    """Numbers of this case for the text of the rule."""


class Rule(NamedTuple):
    """Row of a table of rules."""

    paths: tuple[str, ...]
    """Paths of its values: without numbers of items; a trailing ``*`` stands for all below."""
    name: str
    """Name of the rule, or of the figure that it needs; empty: it needs none."""
    origin: Origin | None
    """Origin of its values; None: that of the figure that is the value."""
    made_of: tuple[str, ...]
    """Names of figures and typical values, and paths of other values."""
    text: str
    source: str
    unit: str = ""
    """Unit of a value that no field holds."""

    def gives(self, plain: str) -> bool:
        """Return True if the rule gives the value at a path without numbers of items."""
        return any(plain == key or (key[-1] == "*" and plain.startswith(key[:-1])) for key in self.paths)

    def how(self, detail: str = "") -> str:
        """Return text and source, with numbers of the case."""
        return "; ".join(filter(None, (f"{self.text}: {detail}" if detail else self.text, self.source)))


class Entry(NamedTuple):
    """Value with its origin."""

    path: str
    value: Any
    unit: str
    origin: Origin
    how: str
    """Rule or source."""
    meaning: str = ""


class Ledger:
    """Entries in order; of several entries with one path the first counts."""

    def __init__(self, entries: Iterable[Entry]) -> None:
        self.entries: dict[str, Entry] = {}
        for entry in entries:
            self.entries.setdefault(entry.path, entry)

    def __iter__(self) -> Iterator[Entry]:
        return iter(self.entries.values())

    def __len__(self) -> int:
        return len(self.entries)

    def __contains__(self, path: object) -> bool:
        return path in self.entries

    def __getitem__(self, path: str) -> Entry:
        return self.entries[path]

    def get(self, path: str) -> Entry | None:
        """Return the entry at a path; None without one."""
        return self.entries.get(path)

    @cached_property
    def counts(self) -> dict[Origin, int]:
        """Number of entries by origin, without absent origins."""
        counts = {origin: sum(entry.origin is origin for entry in self) for origin in Origin}
        return {origin: count for origin, count in counts.items() if count}

    @property
    def summary(self) -> str:
        """Counts for reading: ``12 given, 40 derived, 25 assumed``."""
        return ", ".join(f"{count} {origin}" for origin, count in self.counts.items())


def read_rules(path: Path) -> tuple[Rule, ...]:
    """Read a table of rules: CSV with columns paths, name, origin, made_of, rule, source, optionally unit."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return tuple(
        Rule(
            tuple(row["paths"].split()),
            row["name"],
            Origin(row["origin"]) if row["origin"] else None,
            tuple(row["made_of"].split()),
            row["rule"],
            row["source"],
            row.get("unit", ""),
        )
        for row in rows
    )
