"""Case file under work: its text is the only state; the form shows the case read from it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from exudyn_crawler.files import whole_file
from exudyn_crawler.machines import CaseFile
from exudyn_crawler.machines.case_file import case_text
from exudyn_crawler.machines.case_files import case_of_text, typed_value
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.machines.datasheet.ledger import ledger_of
from exudyn_crawler.machines.edited_text import changed_text
from exudyn_crawler.origins import Ledger
from exudyn_crawler.settings import fields

FIRST = "pc300lc"
"""Machine of the library at the start of the page."""


class Document:
    """Case file in a folder, under work.

    A refused change stays beside the text with its error lines. It is tried again with each later change,
    because values that must change together are typed one after the other.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.version = 0  # rises with every change, so that all open pages notice it
        self.refused: dict[str, Any] = {}
        self.errors: dict[str, list[str]] = {}
        self.saved = ""
        self.copies: dict[Path, bytes] = {}  # contents of dropped files at the time of the drop
        self.start_from(FIRST)

    def start_from(self, machine: str) -> None:
        """Start with a machine of the library."""
        self.take_text(library.text_of(machine, machine), machine)

    def load(self, path: Path) -> None:
        """Start with a case file; raises as `read_case`."""
        text = path.read_text(encoding="utf-8-sig")
        if path.parent != self.folder:
            # its paths are relative to its own folder
            text = case_text(case_of_text(text, path.parent, path.stem), by_hand=True)
        self.take_text(text, path.stem)
        if path.parent == self.folder:
            self.saved = self.text

    def store(self, name: str, content: bytes) -> Path:
        """Write a dropped file into the folder, and return its path.

        The name gets a number if the folder has another file of this name, unless that file is the copy of an
        earlier drop: a corrected file replaces its own copy.
        """
        path = first = self.folder / Path(name).name
        number = 1
        while path.exists() and not self._is_copy(path, content):
            number += 1
            path = first.with_name(f"{first.stem}_{number}{first.suffix}")
        with whole_file(path, overwrite=True) as temporary:
            temporary.write_bytes(content)
        self.copies[path] = content
        return path

    def _is_copy(self, path: Path, content: bytes) -> bool:
        """Return True if a file has a content, or that of an earlier drop."""
        return path.is_file() and path.read_bytes() in (content, self.copies.get(path))

    def take_text(self, text: str, name: str = "") -> None:
        """Replace the whole text; raises as `read_case`."""
        self._accept(text, name or self.name)
        if name:
            self.saved = ""
        self.refused.clear()
        self.errors.clear()

    def _accept(self, text: str, name: str) -> None:
        self.case_file: CaseFile = case_of_text(text, self.folder, name)
        self.text = text
        self.name = name
        self.version += 1

    def type(self, path: str, text: str) -> bool:
        """Take the text typed for the value at a path; an empty one removes it. Return True if accepted."""
        text = text.strip()
        return self.change({path: typed_value(text) if text else None})

    def change(self, values: Mapping[str, Any]) -> bool:
        """Take values at paths, with refused ones if they now fit; return True if accepted.

        None removes a key, so that its value follows from the rest.
        """
        self.refused |= values
        failed: Exception | None = None
        tried = [dict(self.refused)] if len(self.refused) > len(values) else []
        for changes in (*tried, dict(values)):
            try:
                self._accept(changed_text(self.text, changes, self.case_file), self.name)
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
        """Drop the refused value at a path."""
        self.refused.pop(path, None)
        if self.errors.pop(path, None):
            self.version += 1

    def save(self, name: str) -> Path:
        """Write the text as NAME.toml and return its path.

        Raises FileExistsError if that is the file of another case.
        """
        path = self.folder / f"{name}.toml"
        is_own = name == self.name and self.saved != ""
        is_own = is_own and path.is_file() and path.read_text(encoding="utf-8") == self.saved
        with whole_file(path, is_own) as temporary:
            temporary.write_text(self.text, encoding="utf-8")
        self.name = name
        self.saved = self.text
        self.version += 1
        return path

    def entries(self) -> dict[str, fields.Item]:
        """Return tables and values of the case file by path."""
        return {entry.path: entry for entry in fields.walk(self.case_file)}

    def origins(self) -> Ledger:
        """Return the ledger of a machine with a datasheet, including omitted figures."""
        return ledger_of(self.case_file)
