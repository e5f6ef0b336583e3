"""Lines of a deck of Abaqus or CalculiX: keywords with their options and data, over all files it includes.

Syntax: Abaqus, "Input syntax rules". Keywords, options and names are the same in upper and lower case, blanks
in names of options do not count, comments may stand between any two lines, a keyword that ends with a comma
goes on in the next line.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from fem.body.mesh import MeshError
from fem.files.mesh_content import LARGEST_FILE

DEEPEST = 20
"""Files that include each other."""
WITH_FILES = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE")
"""Keywords of a mesh whose data may stand in a file of their own."""
_FIELD = re.compile(r'(?:[^,"]|"[^"]*"?)+')


@dataclass
class Keyword:
    """Keyword of a deck.

    Attributes
    ----------
    name : str
        In capitals, without its star: "ELEMENT".
    options : dict of str to str
        By their names in capitals; empty where an option has no value.
    place : str
        File and line, for messages.
    lines : list of str
        Its data, without comments and empty lines.
    """

    name: str
    options: dict[str, str]
    place: str
    lines: list[str] = field(default_factory=list)

    def rows(self) -> Iterator[list[str]]:
        """Fields of each line of data."""
        for line in self.lines:
            yield [entry.strip() for entry in line.rstrip(",").split(",")]


def label(name: str) -> str:
    """Name as the program compares it: without quotes and blanks, upper and lower case the same."""
    return "".join(unquoted(name).split()).casefold()


def unquoted(name: str) -> str:
    """Name without quotes and without blanks around it."""
    return name.strip().strip("\"'").strip()


def text_of(content: bytes, name: str) -> str:
    """Text of a file of a deck; a MeshError if it is none."""
    if b"\0" in content:
        raise MeshError(f"a deck must be text, got zero bytes in {name}")
    return content.decode("utf-8-sig", errors="replace")


def _deck_text(path: Path) -> str:
    size = path.stat().st_size
    if size > LARGEST_FILE:
        raise MeshError(f"{path.name} must be at most {LARGEST_FILE >> 20} MiB large, got {size >> 20} MiB")
    return text_of(path.read_bytes(), path.name)


def keywords(path: Path, text: str | None = None) -> list[Keyword]:
    """Keywords of a deck and of the files that it includes, in their order.

    Parameters
    ----------
    path : Path
        Deck, beside which included files are looked for.
    text : str, optional
        Its text, if it is already read.

    Raises
    ------
    MeshError
        If an included file is missing, or files include each other.
    """
    collected: list[Keyword] = []
    _collect(path, _deck_text(path) if text is None else text, (path,), collected)
    return collected


def _collect(path: Path, text: str, chain: tuple[Path, ...], collected: list[Keyword]) -> None:
    """Append the keywords of a file and of those that it includes."""
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
    """Keywords of one file; data before its first one belong to the last keyword so far."""
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
    """Path of the file that a keyword includes, beside its own file or beside the deck."""
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
    raise MeshError(f"{name!r}, which the deck includes, must be beside it ({keyword.place})")
