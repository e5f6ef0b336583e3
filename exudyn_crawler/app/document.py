"""Case file that is worked on: its text is all that there is, the form shows the case that is read of it."""

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
"""Machine of the library that the page begins with."""


class Document:
    """Case file in a folder, as it is worked on.

    A change that is refused stays beside the text, with the lines that say why, and is tried again with each
    later one: values that must change together are typed one after the other.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.version = 0  # rises with every change, so that all open pages see it
        self.refused: dict[str, Any] = {}
        self.errors: dict[str, list[str]] = {}
        self.saved = ""
        self.copies: dict[Path, bytes] = {}  # of files that were dropped, as they were then
        self.start_from(FIRST)

    def start_from(self, machine: str) -> None:
        """Begin with a machine of the library."""
        self.take_text(library.text_of(machine, machine), machine)

    def load(self, path: Path) -> None:
        """Begin with a case file; raises as `read_case`."""
        text = path.read_text(encoding="utf-8-sig")
        if path.parent != self.folder:
            # paths in it count from its own folder
            text = case_text(case_of_text(text, path.parent, path.stem), by_hand=True)
        self.take_text(text, path.stem)
        if path.parent == self.folder:
            self.saved = self.text

    def store(self, name: str, content: bytes) -> Path:
        """Write a file that was dropped into the folder, and return its path.

        Its name gets a number where the folder has another file of the name, unless that is the copy of an
        earlier drop: a file that was corrected takes the place of its own copy.
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
        """Return True for a file with a content, or with that of an earlier drop."""
        return path.is_file() and path.read_bytes() in (content, self.copies.get(path))

    def take_text(self, text: str, name: str = "") -> None:
        """Take a whole text in place of the one that is there; raises as `read_case`."""
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
        """Take what was typed for the value at a path; nothing lets it follow. True if it is accepted."""
        text = text.strip()
        return self.change({path: typed_value(text) if text else None})

    def change(self, values: Mapping[str, Any]) -> bool:
        """Take values at paths, with what was refused before if that makes them fit; True if accepted.

        None leaves a key out, so that its value follows from the rest.
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
        """Drop what was refused at a path."""
        self.refused.pop(path, None)
        if self.errors.pop(path, None):
            self.version += 1

    def save(self, name: str) -> Path:
        """Write the text as NAME.toml; FileExistsError if that is the file of another case."""
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
        """Tables and values of the case file by their paths."""
        return {entry.path: entry for entry in fields.walk(self.case_file)}

    def origins(self) -> Ledger:
        """Return the ledger of a machine with a datasheet, with the figures that it leaves out."""
        return ledger_of(self.case_file)
