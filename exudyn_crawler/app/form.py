"""Form of a case, made from its parameters: each field has unit, meaning, bounds, origin and its errors."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from nicegui import ui
from pydantic.fields import FieldInfo

from exudyn_crawler.app.document import Document
from exudyn_crawler.case.case_file import typed_text
from exudyn_crawler.case.datasheet.provenance import Provenance
from exudyn_crawler.case.parameters import fields

COLOURS = {"given": "primary", "derived": "grey-7", "assumed": "orange-9"}
"""Of the origins of values."""
FOLLOWS = "follows from the rest"
BOUNDS = {Gt: ("gt", "above"), Ge: ("ge", "at least"), Lt: ("lt", "below"), Le: ("le", "at most")}
"""Attributes of what bounds a number, and the words for them."""
TRUTH = {"true": True, "false": False}


def in_words(name: object) -> str:
    """Name of a field or a table for reading."""
    return str(name).replace("_", " ")


def choices(annotation: Any) -> list[str]:
    """Words among which a field has to be, in a file's spelling; empty for any other field."""
    if get_origin(annotation) is Literal:
        return [str(choice) for choice in get_args(annotation)]
    if annotation is bool:
        return [*TRUTH]
    held = [part for part in get_args(annotation) if part is not type(None)]
    several = [choices(part) for part in held]
    return [word for words in several for word in words] if held and all(several) else []


def range_words(field: FieldInfo) -> str:
    """Say between what values of a field are plausible, else allowed; empty for any."""
    unit = fields.unit_of(field)
    if (span := fields.plausible_range(field)) is not None:
        low, high = (fields.value_text(float(value), unit) for value in span)
        return f"{low} to {high} as a rule"
    parts = []
    for bound in field.metadata:
        if type(bound) in BOUNDS:
            attribute, words = BOUNDS[type(bound)]
            parts.append(f"{words} {fields.value_text(float(getattr(bound, attribute)), unit)}")
    return ", ".join(parts)


def presets(field: FieldInfo) -> dict[str, dict[str, str]]:
    """Tables of a file that give a part of a case ready values, by their names."""
    kinds = fields.models_of(field.annotation)
    found = {}
    for kind in kinds:
        tag = {fields.tag_field(kind): fields.tag_of(kind)} if len(kinds) > 1 else {}
        for name in fields.named_values(kind):
            found[" ".join([*tag.values(), in_words(name)])] = tag | {fields.BASE: name}
    return found


class Field:
    """Value of a case in the form, which takes what is typed when the field is left or Enter is pressed."""

    def __init__(self, document: Document, entry: fields.Entry) -> None:
        self.document = document
        self.path = entry.path
        unit = f", {entry.unit}" if entry.unit and "exponent" not in entry.unit else ""
        label = f"{in_words(entry.place[-1])}{unit}"
        words = choices(entry.field.annotation)
        self.element: Any
        if words:
            self.element = ui.select([*words, ""] if self._may_follow(entry) else words, label=label)
            self.element.on_value_change(self._taken)
        else:
            self.element = ui.input(label)
            # a browser's own event of a change fails to come where the value was set meanwhile
            self.element.on("blur", self._taken)
            self.element.on("keydown.enter", self._taken)
        hint = "; ".join(filter(None, (entry.meaning, range_words(entry.field))))
        self.element.props["hint"] = hint
        self.element.props(f'dense outlined hide-bottom-space data-path="{self.path}"').classes("field")
        self.element.props["title"] = f"{self.path}: {hint}"
        if len(words) == 1:
            self.element.disable()
        with self.element.add_slot("append"):
            self.badge = ui.badge().props("outline")
            with self.badge:
                self.how = ui.tooltip("")
        self.shown = ""

    @staticmethod
    def _may_follow(entry: fields.Entry) -> bool:
        return fields.allows_none(entry.field.annotation) or not entry.field.is_required()

    def _taken(self) -> None:
        text = str(self.element.value or "")
        if text == self.shown and self.path not in self.document.errors:
            return
        if text == self.shown:
            self.document.forget(self.path)
        else:
            self.document.type(self.path, text)

    def show(self, entry: fields.Entry, origin: Provenance | None) -> None:
        """Show the value that the case has, and what was refused beside it."""
        lines = self.document.errors.get(self.path, [])
        self.element.error = "\n".join(lines) or None
        self.element.props(remove="error-message") if not lines else None
        follows = entry.value is None and origin is not None and origin.origin != "given"
        self.badge.set_text("" if origin is None else origin.origin)
        self.badge.set_visibility(origin is not None)
        if origin is not None:
            self.badge.props(f"color={COLOURS[origin.origin]}")
            self.how.set_text(origin.how or origin.origin)
        if not lines:
            self.shown = typed_text(entry)
            self.element.set_value(self.shown)
        if isinstance(self.element, ui.input):
            self.element.props["placeholder"] = f"{origin.value}, {FOLLOWS}" if follows and origin else ""
            self.element.props["stack-label"] = follows
        self.element.update()


class FormPart:
    """Values and tables of a case below some paths; it is filled when it is first seen."""

    def __init__(
        self,
        document: Document,
        paths: Iterable[str],
        title: str = "",
        only: bool = False,
        keeps: Callable[[fields.Entry], bool] = lambda _entry: True,
    ) -> None:
        self.document = document
        self.keeps = keeps
        self.paths = tuple(paths)
        self.only = only  # the values at the paths themselves, not all that is below
        self.rows: dict[str, Field] = {}
        self.seen = not title
        self.outlined: list[str] = []
        if title:
            self.outer = ui.expansion(title).classes("section").on_value_change(self._opened)
            with self.outer:
                self.box = ui.column().classes("fields")
        else:
            self.box = ui.column().classes("fields")

    def _opened(self) -> None:
        self.seen = True
        self.refresh()

    def _entries(self) -> Iterator[fields.Entry]:
        for entry in self.document.entries().values():
            inside = (
                entry.path == path or entry.path.startswith((f"{path}.", f"{path}[")) for path in self.paths
            )
            if (entry.path in self.paths if self.only else any(inside)) and self.keeps(entry):
                yield entry

    def refresh(self) -> None:
        """Show the case again; fields are made where there are others than before."""
        if not self.seen:
            return
        entries = list(self._entries())
        outline = [
            f"{entry.path}: {type(entry.value).__name__}" for entry in entries if fields.is_table(entry.value)
        ]
        outline += [entry.path for entry in entries if not fields.is_table(entry.value)]
        if outline != self.outlined:
            self.outlined = outline
            self._fill(entries)
        origins = self.document.origins()
        for entry in entries:
            if entry.path in self.rows:
                self.rows[entry.path].show(entry, origins.get(entry.path))

    def _fill(self, entries: list[fields.Entry]) -> None:
        self.box.clear()
        self.rows.clear()
        with self.box:
            for entry in entries:
                if fields.models_of(entry.field.annotation) and not self.only:
                    self._head(entry)
                if not fields.is_table(entry.value) and not self._is_absent(entry):
                    self.rows[entry.path] = Field(self.document, entry)

    @staticmethod
    def _is_absent(entry: fields.Entry) -> bool:
        """True for a part that the case does not have."""
        return entry.value in (None, ()) and bool(fields.models_of(entry.field.annotation))

    def _head(self, entry: fields.Entry) -> None:
        """Head of a part: its name and meaning, ready values for it, and a button that takes it away."""
        offered = presets(entry.field) if not isinstance(entry.place[-1], int) else {}
        if self._is_absent(entry) and not offered:
            return
        with ui.row().classes("part-head items-center"):
            ui.label(in_words(entry.path)).classes("part").props(f'title="{entry.path}"')
            if offered:
                select = (
                    ui.select([*offered], label="start from").props("dense options-dense").classes("preset")
                )
                select.on_value_change(
                    lambda event, path=entry.path: self.document.change({path: offered[event.value]})
                )
            if isinstance(entry.place[-1], int):
                ui.button(
                    icon="delete", on_click=lambda path=entry.path: self.document.change({path: None})
                ).props(f'flat dense aria-label="take {entry.path} away"')
