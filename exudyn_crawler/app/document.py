"""Case file that is worked on: its text is all that there is, the form shows the case that is read of it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit

from exudyn_crawler.case import CaseFile
from exudyn_crawler.case.case_file import case_text
from exudyn_crawler.case.datasheet import library
from exudyn_crawler.case.datasheet.derive import PLACES
from exudyn_crawler.case.datasheet.files import KEY
from exudyn_crawler.case.datasheet.provenance import Provenance, origins, sheet_rows
from exudyn_crawler.case.files import case_of_text, typed_value
from exudyn_crawler.case.parameters import fields
from exudyn_crawler.files import whole_file

FIRST = "pc300lc"
"""Machine of the library that the page begins with."""
Change = Any  # value of a file; None leaves the key out, so that its value follows from the rest


class Document:
    """Case file in a folder, as it is worked on.

    A change that is refused stays beside the text, with the lines that say why, and is tried again with each
    later one: values that must change together are typed one after the other.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.version = 0  # rises with every change, so that all open pages see it
        self.refused: dict[str, Change] = {}
        self.errors: dict[str, list[str]] = {}
        self.start_from(FIRST)

    def start_from(self, machine: str) -> None:
        """Begin with a machine of the library."""
        self._begin(library.machines()[machine].read_text(encoding="utf-8"), machine)

    def load(self, path: Path) -> None:
        """Begin with a case file; raises as `read_case`."""
        self._begin(path.read_text(encoding="utf-8-sig"), path.stem, path.parent)

    def start_with(self, case_file: CaseFile, name: str) -> None:
        """Begin with a case, of which the text has every value."""
        self._begin(case_text(case_file, by_hand=True), name)

    def _begin(self, text: str, name: str, folder: Path | None = None) -> None:
        case_file = case_of_text(text, folder or self.folder, name)
        if folder is not None and folder != self.folder:
            # paths in it count from its own folder
            text = case_text(case_file, by_hand=True)
        self.name = name
        self.saved = ""
        self._accept(text, case_file)
        self.refused.clear()
        self.errors.clear()

    def _accept(self, text: str, case_file: CaseFile) -> None:
        self.text = text
        self.case_file = case_file
        self.version += 1

    @property
    def is_saved(self) -> bool:
        """True where the text is that of its file."""
        return self.text == self.saved

    def take_text(self, text: str) -> None:
        """Take a whole text in place of the one that is there; raises as `read_case`."""
        self._accept(text, case_of_text(text, self.folder, self.name))
        self.refused.clear()
        self.errors.clear()

    def type(self, path: str, text: str) -> bool:
        """Take what was typed for the value at a path; nothing lets it follow. True if it is accepted."""
        text = text.strip()
        return self.change({path: typed_value(text) if text else None})

    def change(self, values: Mapping[str, Change]) -> bool:
        """Take values at paths, with what was refused before if that makes them fit; True if accepted."""
        self.refused |= values
        failed: Exception | None = None
        tried = [dict(self.refused)] if len(self.refused) > len(values) else []
        for changes in (*tried, dict(values)):
            try:
                text = self._changed(changes)
                self._accept(text, case_of_text(text, self.folder, self.name))
            except (ValueError, OSError) as error:
                failed = error
                continue
            for path in changes:
                self.refused.pop(path, None)
                self.errors.pop(path, None)
            return True
        lines = getattr(failed, "errors", None) or str(failed).splitlines()
        self.errors |= {path: list(lines) for path in values}
        self.version += 1
        return False

    def forget(self, path: str) -> None:
        """Drop what was refused at a path."""
        self.refused.pop(path, None)
        if self.errors.pop(path, None):
            self.version += 1

    def _changed(self, values: Mapping[str, Change]) -> str:
        """Text with other values at paths; comments stay."""
        toml = tomlkit.parse(self.text)
        for path, value in values.items():
            self._set(toml, fields.parse_path(path), value)
        return tomlkit.dumps(toml)

    def _set(self, toml: Any, path: fields.KeyPath, value: Change) -> None:
        """Put a value at a path of a file's content; tables and lists are made where they are missing."""
        *above, last = path
        table = toml
        for depth, part in enumerate(above):
            if isinstance(part, str) and part not in table:
                if value is None:
                    return
                follows = path[depth + 1]
                table[part] = (
                    self._resolved(path[: depth + 1]) if isinstance(follows, int) else tomlkit.table()
                )
            table = table[part]
        if value is not None and isinstance(last, int) and last == len(table):
            table.append(value)
        elif value is not None:
            table[last] = value
        elif isinstance(last, int) or last in table:
            del table[last]

    def _resolved(self, path: fields.KeyPath) -> Any:
        """List at a path as the case has it, as a file says it."""
        whole = self.case_file.model_dump(mode="json")
        values: Any = whole | whole["case"]
        for part in path:
            values = values[part]
        return tomlkit.item(said(values))

    def save(self, name: str, overwrite: bool = False) -> Path:
        """Write the text as NAME.toml; FileExistsError if there is another one and `overwrite` is false."""
        path = self.folder / f"{name}.toml"
        is_same = path.is_file() and path.read_text(encoding="utf-8") == self.text
        with whole_file(path, overwrite or is_same) as temporary:
            temporary.write_text(self.text, encoding="utf-8")
        self.name = name
        self.saved = self.text
        self.version += 1
        return path

    def entries(self) -> dict[str, fields.Entry]:
        """Tables and values of the case file by their paths."""
        return {entry.path: entry for entry in fields.walk(self.case_file)}

    def origins(self) -> dict[str, Provenance]:
        """Where values of a machine with a datasheet come from, by their paths, those it leaves out, too."""
        sheet = self.case_file.datasheet
        if sheet is None:
            return {}
        rows = {row.key: row for row in sheet_rows(sheet)}
        of_sheet = {f"{KEY}.{name}": rows[place] for name, place in PLACES.items() if place in rows}
        return rows | origins(self.case_file) | of_sheet


def said(values: Any) -> Any:
    """Values of a dump as a file has them."""
    if isinstance(values, dict):
        return {name: said(value) for name, value in values.items()}
    if isinstance(values, list):
        return [said(value) for value in values]
    return fields.NONE if values is None else values
