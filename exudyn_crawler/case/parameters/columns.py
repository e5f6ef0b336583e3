"""Text files of measurements, and columns of their tables: a unit in the head, as ``pressure in kPa``.

Spreadsheets and loggers write a table in many ways: in UTF-8 or UTF-16, with commas, semicolons or tabs
between cells, with a decimal point or comma and other marks between thousands, with units below the heads.
"""

import csv
import difflib
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from exudyn_crawler.settings import units

HEAD = re.compile(r"\s*(?P<name>.*?)\s*(?:\[(?P<a>.*)\]|\((?P<b>.*)\)|(?:,|/| in )\s*(?P<c>[^,]+?))?\s*")
"""Name of a column with its unit: ``force [N]``, ``force (N)``, ``force, N``, ``force/N``, ``force in N``."""
GREATEST = 1e15
"""Size of numbers beyond which nothing is measured, and sums of squares fail."""
MATLAB_HEAD = re.compile(r"(?P<name>.*[^_])_(?P<unit>[A-Za-z0-9]+)_")
"""Name of a variable that MATLAB makes of a head: ``Time_s_`` of ``Time (s)``."""
SEPARATOR_LINE = re.compile(r"sep=(.)\s*", re.IGNORECASE)
"""First line of a file that tells a spreadsheet what is between the cells."""
GROUPS = re.compile(rf"(?<=\d){units.PARTING}(?=\d{{3}}(?!\d))")
"""Mark between thousands that is no decimal mark anywhere."""
NUMBER = re.compile(r"[+-]?[\d.,]*\d[\d.,]*(?:e[+-]?\d+)?", re.IGNORECASE)
"""Number with whatever marks."""
MARKED = re.compile(r"[+-]?(?P<whole>\d{1,3})(?P<mark>[.,])\d{3}")
"""Number of which the mark may be that of decimals or of thousands."""
THOUSANDS = {mark: re.compile(rf"[+-]?\d{{1,3}}(?:\{mark}\d{{3}})+(?!\d)") for mark in ".,"}
"""Whole number with marks between thousands, by the mark."""
MISSING = {"", "-", "nan", "-nan", "null", "none", "na", "n/a", "#n/a", "nodata", "*"}
"""Words, and none, for a value that is missing."""
INDEX_HEAD = re.compile(r"|#|index|unnamed: ?0|row|no\.?|nr\.?", re.IGNORECASE)
"""Head of a column that counts rows."""


def head_parts(head: str) -> tuple[str, str]:
    """Name and unit of a column's head; the unit is empty where it has none."""
    match = HEAD.fullmatch(head)
    assert match is not None  # the name takes whatever is there
    unit = next((match[group] for group in "abc" if match[group]), "")
    name = match["name"]
    made = None if unit else MATLAB_HEAD.fullmatch(name)
    if made is not None and units.is_unit(made["unit"]):
        name, unit = made["name"], made["unit"]
    return name.lower(), unit.strip()


def factor_of(unit: str, wanted: str, name: str = "") -> float:
    """Size of a unit in the `wanted` one; ValueError if it is no unit, or one of something else.

    With the `name` of its column the error says how its head is written.
    """
    if unit == wanted or (wanted == "1" and not unit):
        return 1.0
    if not unit and name:
        raise ValueError(f"its head has no unit, such as '{name} in {wanted}' or '{name} [{wanted}]'")
    factor = units.number_of(f"1 {unit}", wanted)
    if not isinstance(factor, float):
        raise ValueError(f"unit must be one of {wanted}, got {unit or 'none'!r}")
    return factor


def read_text(path: Path) -> str:
    """Return the text of a file in UTF-8, or in UTF-16 as spreadsheets write "Unicode text".

    FileNotFoundError if there is no such file, ValueError if it is no text.
    """
    content = path.read_bytes()
    coding = "utf-8-sig"
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        coding = "utf-16"
    elif b"\0" in content[:2]:
        # some programs leave the mark out before the first letter
        coding = "utf-16-be" if content[:1] == b"\0" else "utf-16-le"
        coding = coding if content[:2].strip(b"\0").isascii() else "utf-8"
    try:
        return content.decode(coding)
    except UnicodeDecodeError as error:
        book = "; it looks like a workbook: save the sheet as CSV" if content.startswith(b"PK") else ""
        raise ValueError(f"{path} is no text in UTF-8 or UTF-16: {error.reason}{book}") from error


def read_table(path: str | Path) -> tuple[list[str], list[list[str]]]:
    """Heads and rows of a CSV file with commas, semicolons or tabs; lines that begin with # are remarks.

    Units in a row below the heads go into the heads, a first column that counts rows is left out. Numbers
    have a decimal point and nothing between thousands. FileNotFoundError if there is no such file, ValueError
    if it has no rows, rows of another length, or marks in its numbers that may be of decimals or thousands.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no table {path}")
    lines = [line for line in read_text(path).splitlines() if not line.lstrip().startswith("#")]
    told = SEPARATOR_LINE.fullmatch(lines[0]) if lines else None
    lines = [line for line in lines[bool(told) :] if line.strip(" ,;\t")]
    if len(lines) < 2:
        raise ValueError(f"{path} must have a line of heads and rows below it, got {len(lines)} lines")
    delimiter = told[1] if told else next((mark for mark in ";\t" if mark in lines[0]), ",")
    heads, *rows = ([cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter))
    for number, row in enumerate(rows, start=1):
        if len(row) != len(heads):
            raise ValueError(
                f"{path}: row {number} must have {len(heads)} cells, as its head, got {len(row)}"
            )
    if has_units(rows[0]) and len(rows) > 1:
        heads = [
            f"{head} [{cell.strip('[]()')}]" if cell else head
            for head, cell in zip(heads, rows[0], strict=True)
        ]
        rows = rows[1:]
    if len(heads) > 1 and INDEX_HEAD.fullmatch(heads[0]) and counts_rows([row[0] for row in rows]):
        heads, rows = heads[1:], [row[1:] for row in rows]
    rows = [[GROUPS.sub("", cell).replace("\u2212", "-") for cell in row] for row in rows]
    if delimiter == "," and not any("," in cell for row in rows for cell in row):
        return heads, rows
    try:
        return heads, plain_numbers(rows)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def has_units(row: list[str]) -> bool:
    """Return whether a row has units alone, as some loggers write them below the heads."""
    cells = [cell.strip("[]()") for cell in row if cell not in MISSING]
    return bool(cells) and all(units.is_unit(cell) for cell in cells)


def counts_rows(cells: list[str]) -> bool:
    """Return whether cells are whole numbers, each one more than the one before."""
    return all(cell.isdecimal() for cell in cells) and bool(
        np.all(np.diff(np.array(cells, dtype=float)) == 1.0)
    )


def plain_numbers(rows: list[list[str]]) -> list[list[str]]:
    """Return cells whose numbers have a decimal point and nothing between thousands.

    One mark is that of decimals in a whole table, the other one that of thousands. ValueError, as a question,
    if nothing in the table says which.
    """
    numbered = [
        (number, cell) for number, row in enumerate(rows, start=1) for cell in row if NUMBER.fullmatch(cell)
    ]
    mark = decimal_mark(cell for _, cell in numbered)
    if mark is None:
        number, cell = next(pair for pair in numbered if MARKED.fullmatch(pair[1]))
        value = float(cell.replace(",", "."))
        raise ValueError(
            f"is {cell} in row {number} {value:g} or {1e3 * value:g}? All marks in the numbers of the table "
            f"are before three digits, as between thousands: write {1e3 * value:.0f}, or {value:.4f} with "
            "another number of decimals"
        )
    other = "," if mark == "." else "."
    return [[_plain(cell, mark, other) for cell in row] for row in rows]


def decimal_mark(cells: Iterable[str]) -> str | None:
    """Return the decimal mark of numbers, a point where none has a mark; None if it is open."""
    is_open = False
    for cell in cells:
        marks = [letter for letter in cell if letter in ".,"]
        match = MARKED.fullmatch(cell)
        if marks and (match is None or match["whole"] == "0"):
            last = marks[-1]
            if marks.count(last) == 1:
                return last
            # several ones of a kind are between thousands, or in no number
            if THOUSANDS[last].fullmatch(cell):
                return {".": ",", ",": "."}[last]
        is_open = is_open or match is not None
    return None if is_open else "."


def _plain(cell: str, mark: str, other: str) -> str:
    """Return a number with a decimal point and nothing between thousands; any other cell as it is."""
    if not NUMBER.fullmatch(cell):
        return cell
    match = THOUSANDS[other].match(cell)
    whole = match[0].replace(other, "") + cell[match.end() :] if match else cell
    return whole.replace(mark, ".")


def read_columns(
    path: str | Path, wanted: Mapping[str, str], labels: tuple[str, ...] = ()
) -> dict[str, np.ndarray]:
    """Columns of a table by name in the `wanted` units, those that it has; `labels` stay texts.

    ValueError, with the file, the column and the row, for what is no number, for a unit that does not fit,
    for a column of another name and for one that stands twice.
    """
    heads, rows = read_table(path)
    known = {**wanted, **dict.fromkeys(labels, "")}
    columns = {}
    for place, head in enumerate(heads):
        name, unit = head_parts(head)
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ValueError(f"{path}: columns must be of {', '.join(known)}, got {name!r}{hint}")
        if name in columns:
            raise ValueError(f"{path}: column {name!r} must stand once")
        cells = [row[place] for row in rows]
        if name in labels:
            columns[name] = np.array(cells)
            continue
        try:
            factor = factor_of(unit, wanted[name], name)
        except ValueError as error:
            swapped = _swapped(name, unit, wanted, heads)
            raise ValueError(f"{path}: column {name!r}: {error}{swapped}") from None
        columns[name] = factor * numbers(cells, f"{path}: {name}")
    return columns


def _swapped(name: str, unit: str, wanted: Mapping[str, str], heads: list[str]) -> str:
    """Return a question whether a column is swapped with another one, whose unit it has."""
    for other, its_unit in map(head_parts, heads):
        fits = unit and other != name and other in wanted and its_unit
        if fits and _is_of(unit, wanted[other]) and _is_of(its_unit, wanted[name]):
            return f"; are the columns {name!r} and {other!r} swapped?"
    return ""


def _is_of(unit: str, wanted: str) -> bool:
    try:
        return bool(factor_of(unit, wanted))
    except ValueError:
        return False


def numbers(cells: list[str], name: str, gaps: bool = False) -> np.ndarray:
    """Numbers of cells: array (rows,); ValueError, with the `name` and the row, for what is none.

    With `gaps`, missing values are not a number.
    """
    values = np.empty(len(cells))
    for row, cell in enumerate(cells):
        if gaps and cell.lower() in MISSING:
            values[row] = np.nan
            continue
        try:
            values[row] = float(cell)
        except ValueError:
            raise ValueError(f"{name} must be a number in row {row + 1}, got {cell[:40]!r}") from None
        if not abs(values[row]) <= GREATEST:
            size = f"finite and at most {GREATEST:g} in size"
            raise ValueError(f"{name} must be {size} in row {row + 1}, got {cell[:40]!r}")
    return values
