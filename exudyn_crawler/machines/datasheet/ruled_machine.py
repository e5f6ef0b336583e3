"""Machine of a datasheet with its rules, those of the table `rules.csv`: what each value is made of."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from exudyn_crawler.case.case import Case
from exudyn_crawler.machines.datasheet import library, typical
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.origins import Entry, Ledger, Origin, Rule, Ruled, read_rules
from exudyn_crawler.settings import fields

KEY = "datasheet"
TYPICAL = f"{KEY}.typical."
FILE = "the file"
"""Source of what a user's file has."""
RECALLED = "remembered: not seen in a source"
OF_MESH = ("plate_depth", "grouser_height")
"""Typical values in whose place a mesh has its own."""


@cache
def rules() -> tuple[Rule, ...]:
    """Return the rules by which values of a machine follow, in the order in which they are tried."""
    return read_rules(Path(__file__).with_name("rules.csv"))


@cache
def places() -> dict[str, str]:
    """Return the paths at which figures of a datasheet stand in the case as they are."""
    return {rule.made_of[0]: rule.paths[0] for rule in rules() if rule.origin is None and not rule.text}


def figure_entry(sheet: Datasheet, name: str) -> Entry:
    """Return the entry of a figure that a datasheet has: given, of the library's machine, or recalled."""
    field = type(sheet).model_fields[name]
    value = getattr(sheet, name)
    machine = library.beginning(sheet)
    origin, how = Origin.GIVEN, sheet.source or FILE
    recalled = name in sheet.remembered
    if machine is not None and getattr(machine.sheet, name) == value:
        origin, how = Origin.LIBRARY, machine.source
        if recalled:
            origin, how = Origin.ASSUMED, f"of the library's {machine.title}, {RECALLED}"
    elif machine is not None:
        how = FILE if sheet.source == machine.sheet.source else how
        # what was recalled of that machine is not what the file has now
        recalled = recalled and name not in machine.sheet.remembered
    if recalled and origin is Origin.GIVEN:
        origin, how = Origin.ASSUMED, RECALLED
    return Entry(f"{KEY}.{name}", value, fields.unit_of(field), origin, how, field.description or "")


@dataclass(frozen=True)
class RuledMachine:
    """Machine of a datasheet with the rules of its values."""

    printed: Datasheet
    filled: Datasheet
    """The same with what its mesh, or a vehicle's running gear, has."""
    case: Case
    ruled: dict[str, Ruled]
    """Values by their paths: figures that follow, and what one of several rules gave."""

    @cached_property
    def ledger(self) -> Ledger:
        """Ledger of figures, printed or followed, of the case's values with a rule, and of typical values."""
        entries = [*self._figures(), *self._case_values(), *self._typical_values()]
        return Ledger(entries)

    @cached_property
    def typical(self) -> tuple[typical.TypicalValue, ...]:
        """Typical values of the table that the machine takes, in the order of the table."""
        names = {name for path in self._followed() for name in self._made_of(path) if self._is_typical(name)}
        own = self.printed.typical
        return tuple(
            typical.row_of(name, self.printed.kind)
            for name in typical.names()
            if name in names and getattr(own, name) is None
        )

    def figures_of(self, *paths: str) -> set[str]:
        """Return the figures of the datasheet that values at some paths are made of."""
        found: set[str] = set()
        seen: set[str] = set()
        todo = list(paths)
        while todo:
            path = todo.pop()
            if path in seen:
                continue
            seen.add(path)
            name = path.removeprefix(f"{KEY}.")
            if self._is_printed(name):
                found.add(name)
            elif "." in path:
                todo += self._made_of(path)
        return found

    def _is_printed(self, name: str) -> bool:
        return _is_given(self.printed, name)

    def _is_typical(self, name: str) -> bool:
        return name in typical.names() and not self._is_printed(name)

    def _rule(self, path: str) -> Rule | None:
        """Return the rule that gives a value: the named one, that of a figure, or the one of all others."""
        name = self.ruled[path].rule if path in self.ruled else ""
        plain = ".".join(fields.names_of(fields.parse_path(path)))
        for rule in rules():
            if rule.gives(plain) and (rule.name in ("", name) or _is_given(self.filled, rule.name)):
                return rule
        return None

    def _made_of(self, path: str) -> list[str]:
        """Return names and paths of what a value is directly made of."""
        rule = self._rule(path)
        if rule is None:
            return []
        if self.printed.shoe_mesh is not None:
            return ["shoe_mesh" if name in OF_MESH else name for name in rule.made_of]
        # a figure that is left out follows
        known = type(self.printed).model_fields
        return [
            f"{KEY}.{name}"
            if name in known and not self._is_printed(name) and name not in typical.names()
            else name
            for name in rule.made_of
        ]

    def _followed(self) -> list[str]:
        """Return the paths of all values that follow."""
        of_case = [item.path for item in fields.values_of(self.case) if item.value is not None]
        return [path for path in self.ruled if not self._is_printed(path.removeprefix(f"{KEY}."))] + of_case

    def _figures(self) -> Iterator[Entry]:
        """Yield the entries of figures: those of the datasheet, then those that follow."""
        for name in type(self.printed).model_fields:
            path = f"{KEY}.{name}"
            if self._is_printed(name) and name not in library.NO_FIGURES:
                yield figure_entry(self.printed, name)
            elif path in self.ruled:
                field = type(self.printed).model_fields[name]
                value = self.ruled[path].value
                yield from self._entry(path, value, fields.unit_of(field), field.description or "")

    def _case_values(self) -> Iterator[Entry]:
        """Yield the entries of those values of the case that a rule gives."""
        for item in fields.values_of(self.case):
            if item.value is not None:
                yield from self._entry(item.path, item.value, item.unit, item.meaning)

    def _typical_values(self) -> Iterator[Entry]:
        """Yield the entries of typical values: those of the file, then those that are taken of the table."""
        machine = library.beginning(self.printed)
        for name, own in self.printed.typical:
            row = typical.row_of(name, self.printed.kind)
            unit = "" if row.unit == "1" else row.unit
            if own is not None:
                origin, how = Origin.GIVEN, FILE
                if machine is not None and getattr(machine.sheet.typical, name) == own:
                    origin, how = Origin.LIBRARY, machine.source
                yield Entry(TYPICAL + name, own, unit, origin, how, row.meaning)
        for row in self.typical:
            unit = "" if row.unit == "1" else row.unit
            span = f"{row.low:g} to {row.high:g} {unit}".rstrip()
            how = f"{row.meaning}; {span}; {row.source} [{row.known}]"
            yield Entry(TYPICAL + row.name, row.value, unit, Origin.ASSUMED, how, row.meaning)

    def _entry(self, path: str, value: Any, unit: str, meaning: str) -> Iterator[Entry]:
        """Yield the entry of a value that a rule gives."""
        rule = self._rule(path)
        if rule is None:
            return
        detail = self.ruled[path].detail if path in self.ruled else ""
        origin = rule.origin
        how = rule.how(detail)
        names = [name for name in self._made_of(path) if self._is_typical(name)]
        own = [name for name in names if getattr(self.printed.typical, name) is not None]
        if origin is None:
            yield from self._as_figure(path, rule, value, unit, meaning)
            return
        if own == names != [] and origin is Origin.ASSUMED:
            origin = Origin.DERIVED
        if not how:
            how = f"{names[0]} of the file" if own else _range_text(names[0], self.printed.kind, value, unit)
        yield Entry(path, value, unit, origin, how, meaning)

    def _as_figure(self, path: str, rule: Rule, value: Any, unit: str, meaning: str) -> Iterator[Entry]:
        """Yield the entry of a value that is a figure of the datasheet, printed or followed."""
        (name,) = rule.made_of
        figures = [figure_entry(self.printed, name)] if self._is_printed(name) else []
        figure_path = f"{KEY}.{name}"
        if not figures and figure_path in self.ruled:
            figures = list(self._entry(figure_path, self.ruled[figure_path].value, unit, meaning))
        for figure in figures:
            how = "; ".join(filter(None, (figure.how, rule.text)))
            yield Entry(path, value, unit, figure.origin, how, meaning)


def _is_given(sheet: Datasheet, name: str) -> bool:
    """True where a datasheet has a value of a name, other than that which all have."""
    field = type(sheet).model_fields.get(name)
    return field is not None and getattr(sheet, name) not in (None, field.default)


def _range_text(name: str, kind: str, value: Any, unit: str) -> str:
    """Return the range and the source of a typical value, as its size makes them."""
    row = typical.row_of(name, kind)
    size = value[-1] if isinstance(value, tuple) else value
    low, high = (
        float(f"{size * bound / row.value:.4g}") if row.value else bound for bound in (row.low, row.high)
    )
    span = fields.value_text((low, high), unit).replace(", ", " to ")
    return f"{name} {row.value:g}, {span}; {row.source} [{row.known}]"
