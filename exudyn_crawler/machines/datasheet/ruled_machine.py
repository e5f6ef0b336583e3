"""Machine of a datasheet with its rules (`rules.csv`): the inputs of each value."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from exudyn_crawler.case.case import Case
from exudyn_crawler.machines.datasheet import library, typical
from exudyn_crawler.machines.datasheet.sheet import FIGURES, Datasheet
from exudyn_crawler.origins import Entry, Ledger, Origin, Rule, Ruled, read_rules
from exudyn_crawler.settings import fields

KEY = "datasheet"
TYPICAL = f"{KEY}.typical."
FILE = "the file"
"""Source of values in a user's file."""
REMEMBERED = "remembered: not seen in a source"
OF_MESH = ("plate_depth", "grouser_height")
"""Typical values that a mesh replaces."""


@cache
def rules() -> tuple[Rule, ...]:
    """Return the rules for values of a machine, in the order of trial."""
    return read_rules(Path(__file__).with_name("rules.csv"))


@cache
def case_paths() -> dict[str, str]:
    """Return the paths of figures of a datasheet that enter the case unchanged."""
    return {rule.made_of[0]: rule.paths[0] for rule in rules() if rule.origin is None and not rule.text}


def figure_entry(sheet: Datasheet, name: str) -> Entry:
    """Return the entry of a datasheet's figure: given, of the library's machine, or remembered."""
    field = type(sheet).model_fields[name]
    value = getattr(sheet, name)
    machine = library.beginning(sheet)
    is_remembered = name in sheet.remembered
    origin, how = Origin.GIVEN, sheet.source or FILE
    if machine is not None and getattr(machine.sheet, name) == value:
        origin, how = Origin.LIBRARY, machine.source
        if is_remembered:
            origin, how = Origin.ASSUMED, f"of the library's {machine.title}, {REMEMBERED}"
    # values remembered of that machine are not those of this file
    elif is_remembered and (machine is None or name not in machine.sheet.remembered):
        origin, how = Origin.ASSUMED, REMEMBERED
    elif machine is not None and sheet.source == machine.sheet.source:
        how = FILE
    return Entry(f"{KEY}.{name}", value, fields.unit_of(field), origin, how, field.description or "")


@dataclass(frozen=True)
class RuledMachine:
    """Machine of a datasheet with the rules of its values."""

    printed: Datasheet
    filled: Datasheet
    """Datasheet completed by its mesh or by a vehicle's running gear."""
    case: Case
    ruled: dict[str, Ruled]
    """Values by their paths: derived figures, and results of one of several rules."""

    @cached_property
    def ledger(self) -> Ledger:
        """Ledger of figures (printed or derived), of the case's values with a rule, and of typical values."""
        entries = [*self._figures(), *self._case_values(), *self._typical_values()]
        return Ledger(entries)

    @cached_property
    def typical(self) -> tuple[typical.TypicalValue, ...]:
        """Typical values of the table that the machine uses, in the order of the table."""
        names = {name for path in self._followed() for name in self._made_of(path) if self._is_typical(name)}
        own = self.printed.typical
        return tuple(
            typical.row_of(name, self.printed.kind)
            for name in typical.names()
            if name in names and getattr(own, name) is None
        )

    def figures_of(self, *paths: str) -> set[str]:
        """Return the figures of the datasheet that determine the values at these paths."""
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
        """Return the rule of a value: the named one, that of a figure, or the unnamed one."""
        name = self.ruled[path].rule if path in self.ruled else ""
        plain = ".".join(fields.names_of(fields.parse_path(path)))
        for rule in rules():
            if rule.gives(plain) and (rule.name in ("", name) or _is_given(self.filled, rule.name)):
                return rule
        return None

    def _made_of(self, path: str) -> list[str]:
        """Return names and paths of the direct inputs of a value."""
        rule = self._rule(path)
        if rule is None:
            return []
        if self.printed.shoe_mesh is not None:
            return ["shoe_mesh" if name in OF_MESH else name for name in rule.made_of]
        # a missing figure is derived
        known = type(self.printed).model_fields
        return [
            f"{KEY}.{name}"
            if name in known and not self._is_printed(name) and name not in typical.names()
            else name
            for name in rule.made_of
        ]

    def _followed(self) -> list[str]:
        """Return the paths of all derived values."""
        of_case = [item.path for item in fields.values_of(self.case) if item.value is not None]
        return [path for path in self.ruled if not self._is_printed(path.removeprefix(f"{KEY}."))] + of_case

    def _figures(self) -> Iterator[Entry]:
        """Yield the entries of figures: those of the datasheet, then the derived ones."""
        for name in type(self.printed).model_fields:
            path = f"{KEY}.{name}"
            if self._is_printed(name) and name in FIGURES:
                yield figure_entry(self.printed, name)
            elif path in self.ruled:
                field = type(self.printed).model_fields[name]
                value = self.ruled[path].value
                yield from self._entry(path, value, fields.unit_of(field), field.description or "")

    def _case_values(self) -> Iterator[Entry]:
        """Yield the entries of the case's values with a rule."""
        for item in fields.values_of(self.case):
            if item.value is not None:
                yield from self._entry(item.path, item.value, item.unit, item.meaning)

    def _typical_values(self) -> Iterator[Entry]:
        """Yield the entries of typical values: those of the file, then those of the table."""
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
        """Yield the entry of a value with a rule."""
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
        """Yield the entry of a value that is a figure of the datasheet, printed or derived."""
        (name,) = rule.made_of
        figures = [figure_entry(self.printed, name)] if self._is_printed(name) else []
        figure_path = f"{KEY}.{name}"
        if not figures and figure_path in self.ruled:
            figures = list(self._entry(figure_path, self.ruled[figure_path].value, unit, meaning))
        for figure in figures:
            how = "; ".join(filter(None, (figure.how, rule.text)))
            yield Entry(path, value, unit, figure.origin, how, meaning)


def _is_given(sheet: Datasheet, name: str) -> bool:
    """Return True if a datasheet has a value of this name other than the default."""
    field = type(sheet).model_fields.get(name)
    return field is not None and getattr(sheet, name) not in (None, field.default)


def _range_text(name: str, kind: str, value: Any, unit: str) -> str:
    """Return the range and the source of a typical value, scaled to its size."""
    row = typical.row_of(name, kind)
    size = value[-1] if isinstance(value, tuple) else value
    low, high = (
        float(f"{size * bound / row.value:.4g}") if row.value else bound for bound in (row.low, row.high)
    )
    span = fields.value_text((low, high), unit).replace(", ", " to ")
    return f"{name} {row.value:g}, {span}; {row.source} [{row.known}]"
