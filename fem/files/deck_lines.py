"""Lines of an Abaqus or CalculiX deck and its included files: keywords with their options and data.

Syntax: Abaqus, "Input syntax rules". Keywords, options and names are case-insensitive; blanks in option names
do not count. Comments may stand between any two lines. A keyword that ends with a comma continues in the next
line.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from fem.body.mesh import MeshError
from fem.files.mesh_content import LARGEST_FILE

DEEPEST = 20
"""Greatest depth of files that include each other."""
WITH_FILES = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE")
"""Keywords of a mesh with data that may be in a separate file."""
_FIELD = re.compile(r'(?:[^,"]|"[^"]*"?)+')


@dataclass
class Keyword:
    """Keyword of a deck.

    Attributes
    ----------
    name : str
        Name in capitals without the star: "ELEMENT".
    options : dict of str to str
        Values by option names in capitals; empty for an option without a value.
    place : str
        File and line, for messages.
    lines : list of str
        Data, without comments and empty lines.
    """

    name: str
    options: dict[str, str]
    place: str
    lines: list[str] = field(default_factory=list)

    def rows(self) -> Iterator[list[str]]:
        """Yield the fields of each line of data."""
        for line in self.lines:
            yield [entry.strip() for entry in line.rstrip(",").split(",")]


def label(name: str) -> str:
    """Return a name as the program compares it: without quotes, blanks and case."""
    return "".join(unquoted(name).split()).casefold()


def unquoted(name: str) -> str:
    """Return a name without quotes and without blanks around it."""
    return name.strip().strip("\"'").strip()


def text_of(content: bytes, name: str) -> str:
    """Return the text of a file of a deck; raise `MeshError` if it is not text."""
    if b"\0" in content:
        raise MeshError(f"a deck must be text, got zero bytes in {name}")
    return content.decode("utf-8-sig", errors="replace")


def _deck_text(path: Path) -> str:
    size = path.stat().st_size
    if size > LARGEST_FILE:
        raise MeshError(f"{path.name} must be at most {LARGEST_FILE >> 20} MiB large, got {size >> 20} MiB")
    return text_of(path.read_bytes(), path.name)


def keywords(path: Path, text: str | None = None) -> list[Keyword]:
    """Return the keywords of a deck and of its included files, which are beside it, in their order.

    `text` is that of the deck if it is already read. Raise `MeshError` if an included file is missing, or
    files include each other.
    """
    collected: list[Keyword] = []
    _collect(path, _deck_text(path) if text is None else text, (path,), collected)
    return collected


def _collect(path: Path, text: str, chain: tuple[Path, ...], collected: list[Keyword]) -> None:
    """Append the keywords of a file and of its included files."""
    for keyword in _keywords_of(path, text, collected):
        if keyword.name == "INCLUDE":
            included = _included(keyword, chain)
            _collect(included, _deck_text(included), (*chain, included), collected)
            continue
        collected.append(keyword)
        if keyword.name in WITH_FILES and keyword.options.get("INPUT"):
            included = _included(keyword, chain)
            keyword.lines += [
                line for line in map(str.strip, _deck_text(included).splitlines()) if _is_data(line)
            ]


def _keywords_of(path: Path, text: str, collected: list[Keyword]) -> Iterator[Keyword]:
    """Yield the keywords of one file; data before its first keyword belong to the last one so far."""
    begun = ""
    place = ""
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.strip()
        if not line or line.startswith("**"):
            continue
        if begun.endswith(",") and line[0].isalpha():
            begun += line
            continue
        if begun:
            yield _keyword(begun, place)
            begun = ""
        if line.startswith("*"):
            begun = line
            place = f"{path.name}, line {number}"
        elif collected:
            collected[-1].lines.append(line)
    if begun:
        yield _keyword(begun, place)


def _is_data(line: str) -> bool:
    return bool(line) and not line.startswith("*")


def _keyword(line: str, place: str) -> Keyword:
    name, *entries = _FIELD.findall(line)
    options = {}
    for entry in entries:
        key, _, value = entry.partition("=")
        options["".join(key.split()).upper()] = value.strip()
    return Keyword(" ".join(name.strip("* ").split()).upper(), options, place)


def _included(keyword: Keyword, chain: tuple[Path, ...]) -> Path:
    """Return the path of the file that a keyword includes, beside its own file or beside the deck."""
    name = unquoted(keyword.options.get("INPUT", ""))
    if not name:
        raise MeshError(f"*{keyword.name} must have INPUT=file ({keyword.place})")
    for folder in (chain[-1].parent, chain[0].parent):
        path = folder / name.replace("\\", "/")
        if path.is_file():
            if path.resolve() in {other.resolve() for other in chain} or len(chain) > DEEPEST:
                raise MeshError(
                    f"files of a deck must not include each other, got {name!r} ({keyword.place})"
                )
            return path
    raise MeshError(f"{name!r}, which the deck includes, must be in the same folder ({keyword.place})")
