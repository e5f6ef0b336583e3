"""Form of a case, made from its parameters: fields with unit, meaning, bounds, origin and errors."""

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import events, ui

from exudyn_crawler.app.document import Document
from exudyn_crawler.machines.case_file import typed_text
from exudyn_crawler.origins import Entry, Origin
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.constraints import choices, presets, range_words

COLOURS = {
    Origin.GIVEN: "primary",
    Origin.LIBRARY: "teal-7",
    Origin.DERIVED: "grey-7",
    Origin.ASSUMED: "orange-9",
}
"""Colours of origins."""
FOLLOWS = "follows from the rest"


def in_words(name: object) -> str:
    """Return the name of a field or a table for reading."""
    return str(name).replace("_", " ")


class Field:
    """Field of a value in the form; it takes typed text when it loses the focus or Enter is pressed."""

    def __init__(self, document: Document, entry: fields.Item) -> None:
        self.document = document
        self.path = entry.path
        self.shown = ""
        unit = f", {entry.unit}" if entry.unit and "exponent" not in entry.unit else ""
        label = f"{in_words(entry.place[-1])}{unit}"
        words = choices(entry.field.annotation)
        self.element: Any
        if words:
            may_follow = fields.allows_none(entry.field.annotation) or not entry.field.is_required()
            self.element = ui.select([*words, ""] if may_follow else words, label=label)
            self.element.on_value_change(self._taken)
            self.element.set_enabled(len(words) > 1)
        else:
            self.element = ui.input(label)
            # the browser sends no change event if the value was set meanwhile
            self.element.on("blur", self._taken)
            self.element.on("keydown.enter", self._taken)
        hint = "; ".join(filter(None, (entry.meaning, range_words(entry.field))))
        self.element.props["hint"] = hint
        self.element.props["title"] = f"{self.path}: {hint}"
        self.element.props(f'dense outlined hide-bottom-space data-path="{self.path}"').classes("field")
        with self.element.add_slot("append"):
            self.badge = ui.badge().props("outline")
            with self.badge:
                self.how = ui.tooltip("")

    def _taken(self) -> None:
        text = str(self.element.value or "")
        if text != self.shown:
            self.document.type(self.path, text)
        else:
            self.document.forget(self.path)

    def show(self, entry: fields.Item, origin: Entry | None) -> None:
        """Show the value of the case, and its errors if a value was refused."""
        lines = self.document.errors.get(self.path, [])
        self.element.error = "\n".join(lines) or None
        if not lines:
            self.element.props(remove="error-message")
            self.shown = typed_text(entry)
            self.element.set_value(self.shown)
        self.badge.set_visibility(origin is not None)
        if origin is not None:
            self.badge.set_text(origin.origin)
            self.badge.props(f"color={COLOURS[origin.origin]}")
            self.how.set_text(origin.how or origin.origin)
            follows = entry.value is None and origin.origin is not Origin.GIVEN
            value = fields.value_text(origin.value, origin.unit)
            self.element.props["placeholder"] = f"{value}, {FOLLOWS}" if follows else ""
            self.element.props["stack-label"] = follows
        self.element.update()


class FormPart:
    """Selected values and tables of a case; a part with a title is filled when first opened."""

    def __init__(self, document: Document, picks: Callable[[fields.Item], bool], title: str = "") -> None:
        self.document = document
        self.picks = picks
        self.rows: dict[str, Field] = {}
        self.outline: list[tuple[str, str]] = []
        self.is_seen = not title
        if title:
            with ui.expansion(title).classes("section").on_value_change(self._opened):
                self.box = ui.column().classes("fields")
        else:
            self.box = ui.column().classes("fields")

    def _opened(self) -> None:
        self.is_seen = True
        self.refresh()

    def refresh(self) -> None:
        """Show the case again; make new fields if the set of fields has changed."""
        if not self.is_seen:
            return
        entries = [entry for entry in self.document.entries().values() if self.picks(entry)]
        # the set of fields depends on the classes of tables and on absent parts
        outline = [(entry.path, type(entry.value).__name__ if _is_part(entry) else "") for entry in entries]
        if outline != self.outline:
            self.outline = outline
            self._fill(entries)
        origins = self.document.origins()
        for entry in entries:
            if entry.path in self.rows:
                self.rows[entry.path].show(entry, origins.get(entry.path))

    def _fill(self, entries: list[fields.Item]) -> None:
        self.box.clear()
        self.rows.clear()
        with self.box:
            for entry in entries:
                if _is_part(entry):
                    self._head(entry)
                else:
                    self.rows[entry.path] = Field(self.document, entry)

    def _head(self, entry: fields.Item) -> None:
        """Add the head of a part: name, presets, and for an item of a list a button that deletes it."""
        is_item = isinstance(entry.place[-1], int)
        offered = {} if is_item else presets(entry.field)
        if not (offered or fields.is_table(entry.value)):
            return
        with ui.row().classes("part-head items-center"):
            ui.label(in_words(entry.path)).classes("part").props["title"] = entry.meaning
            if offered:
                ready = ui.select([*offered], label="start from").classes("preset")
                ready.props("dense options-dense")
                ready.on_value_change(lambda event: choose(self.document, {entry.path: offered[event.value]}))
            if is_item:
                button = ui.button(icon="delete", on_click=lambda: self.document.change({entry.path: None}))
                button.props(f'flat dense aria-label="take {entry.path} away"')


def _is_part(entry: fields.Item) -> bool:
    """Return True for a table, and for an absent part of a case that has tables."""
    is_absent = entry.value in (None, ()) and bool(fields.models_of(entry.field.annotation))
    return fields.is_table(entry.value) or is_absent


def below(*names: str) -> Callable[[fields.Item], bool]:
    """Return a predicate of entries at some paths or below them."""
    return lambda entry: any(f"{entry.path}.".startswith((f"{name}.", f"{name}[")) for name in names)


def pick_list(label: str, options: Any, take: Callable[[str], None]) -> ui.select:
    """Return a list that passes each picked option to `take` and then shows none."""

    def picked(event: events.ValueChangeEventArguments) -> None:
        if event.value is not None:
            select.set_value(None)
            take(event.value)

    select = ui.select(options, label=label, on_change=picked).classes("w-full")
    return select.props(f'outlined dense data-testid="{label}"')


def choose(document: Document, values: Mapping[str, Any]) -> None:
    """Take values that have no field of their own, or report why they are refused."""
    if not document.change(values):
        refuse("\n".join(document.errors[next(iter(values))]))
        for path in values:
            document.forget(path)


def refuse(why: object) -> None:
    """Show an error until it is closed."""
    ui.notify(str(why), type="negative", multi_line=True, timeout=0, close_button=True)
