"""Text files of measurements, and columns of their tables: a unit in the head, as ``pressure in kPa``.

Spreadsheets and loggers write tables in many ways. The text is UTF-8 or UTF-16; commas, semicolons or tabs
separate cells. Decimal marks and thousands separators differ, and units may stand below the heads.
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
"""Greatest size of measured numbers; sums of squares of greater ones fail."""
MATLAB_HEAD = re.compile(r"(?P<name>.*[^_])_(?P<unit>[A-Za-z0-9]+)_")
"""Variable name that MATLAB derives from a head: ``Time_s_`` from ``Time (s)``."""
SEPARATOR_LINE = re.compile(r"sep=(.)\s*", re.IGNORECASE)
"""First line of a file that gives a spreadsheet the separator of cells."""
GROUPS = re.compile(rf"(?<=\d){units.PARTING}(?=\d{{3}}(?!\d))")
"""Thousands separator that no country uses as a decimal mark."""
NUMBER = re.compile(r"[+-]?[\d.,]*\d[\d.,]*(?:e[+-]?\d+)?", re.IGNORECASE)
"""Number with any decimal marks and thousands separators."""
MARKED = re.compile(r"[+-]?(?P<whole>\d{1,3})(?P<mark>[.,])\d{3}")
"""Number with a mark that may be a decimal mark or a thousands separator."""
THOUSANDS = {mark: re.compile(rf"[+-]?\d{{1,3}}(?:\{mark}\d{{3}})+(?!\d)") for mark in ".,"}
"""Whole number with thousands separators, by the separator."""
MISSING = {"", "-", "nan", "-nan", "null", "none", "na", "n/a", "#n/a", "nodata", "*"}
"""Texts for a missing value; the empty text is one of them."""
INDEX_HEAD = re.compile(r"|#|index|unnamed: ?0|row|no\.?|nr\.?", re.IGNORECASE)
"""Head of a column that counts rows."""


def head_parts(head: str) -> tuple[str, str]:
    """Return name and unit of a column's head; the unit is empty if the head has none."""
    match = HEAD.fullmatch(head)
    assert match is not None  # the name matches any text
    unit = next((match[group] for group in "abc" if match[group]), "")
    name = match["name"]
    made = None if unit else MATLAB_HEAD.fullmatch(name)
    if made is not None and units.is_unit(made["unit"]):
        name, unit = made["name"], made["unit"]
    return name.lower(), unit.strip()


def factor_of(unit: str, wanted: str, name: str = "") -> float:
    """Return the size of a unit in the `wanted` one; raises `ValueError` for a wrong or incompatible unit.

    With the `name` of its column, the error gives the right spelling of the head.
    """
    if unit == wanted or (wanted == "1" and not unit):
        return 1.0
    if not unit and name:
        raise ValueError(
            f"the unit is missing in its head, such as '{name} in {wanted}' or '{name} [{wanted}]'"
        )
    factor = units.number_of(f"1 {unit}", wanted)
    if not isinstance(factor, float):
        raise ValueError(f"unit must be one of {wanted}, got {unit or 'none'!r}")
    return factor


def read_text(path: Path) -> str:
    """Return the text of a file in UTF-8, or in UTF-16 as spreadsheets write "Unicode text".

    Raises `FileNotFoundError` if there is no such file, and `ValueError` if it is not a text.
    """
    content = path.read_bytes()
    coding = "utf-8-sig"
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        coding = "utf-16"
    elif b"\0" in content[:2]:
        # some programs omit the byte order mark
        coding = "utf-16-be" if content[:1] == b"\0" else "utf-16-le"
        coding = coding if content[:2].strip(b"\0").isascii() else "utf-8"
    try:
        return content.decode(coding)
    except UnicodeDecodeError as error:
        book = "; it looks like a workbook: save the sheet as CSV" if content.startswith(b"PK") else ""
        raise ValueError(f"{path} must be a text in UTF-8 or UTF-16: {error.reason}{book}") from error


def read_table(path: str | Path) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of a CSV file with commas, semicolons or tabs; lines with leading # are remarks.

    Units in a row below the heads go into the heads; a first column that counts rows is left out. Returned
    numbers have a decimal point and no thousands separators. Raises `FileNotFoundError` if there is no such
    file. Raises `ValueError` for a file without rows, for rows of another length, and for ambiguous marks in
    numbers.
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
    """Return whether a row has only units, as some loggers write them below the heads."""
    cells = [cell.strip("[]()") for cell in row if cell not in MISSING]
    return bool(cells) and all(units.is_unit(cell) for cell in cells)


def counts_rows(cells: list[str]) -> bool:
    """Return whether cells are whole numbers, each one more than the one before."""
    return all(cell.isdecimal() for cell in cells) and bool(
        np.all(np.diff(np.array(cells, dtype=float)) == 1.0)
    )


def plain_numbers(rows: list[list[str]]) -> list[list[str]]:
    """Return the cells with a decimal point in numbers, and without thousands separators.

    A whole table has one decimal mark; the other mark separates thousands. Raises `ValueError`, as a
    question, if the table does not tell the two apart.
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
    """Return the decimal mark of numbers, a point if they have no marks; None if it is ambiguous."""
    is_open = False
    for cell in cells:
        marks = [letter for letter in cell if letter in ".,"]
        match = MARKED.fullmatch(cell)
        if marks and (match is None or match["whole"] == "0"):
            last = marks[-1]
            if marks.count(last) == 1:
                return last
            # repeated marks separate thousands, or the cell is not a number
            if THOUSANDS[last].fullmatch(cell):
                return {".": ",", ",": "."}[last]
        is_open = is_open or match is not None
    return None if is_open else "."


def _plain(cell: str, mark: str, other: str) -> str:
    """Return a number with a decimal point and no thousands separators; any other cell unchanged."""
    if not NUMBER.fullmatch(cell):
        return cell
    match = THOUSANDS[other].match(cell)
    whole = match[0].replace(other, "") + cell[match.end() :] if match else cell
    return whole.replace(mark, ".")


def read_columns(
    path: str | Path, wanted: Mapping[str, str], labels: tuple[str, ...] = ()
) -> dict[str, np.ndarray]:
    """Return the columns of a table by name, in the `wanted` units; columns of `labels` stay texts.

    Columns may be missing. Raises `ValueError`, with the file and the column, for a wrong number (with its
    row), a wrong unit, an unknown name and a repeated column.
    """
    heads, rows = read_table(path)
    known = {**wanted, **dict.fromkeys(labels, "")}
    columns = {}
    for place, head in enumerate(heads):
        name, unit = head_parts(head)
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ValueError(f"{path}: columns must be among {', '.join(known)}, got {name!r}{hint}")
        if name in columns:
            raise ValueError(f"{path}: column {name!r} must occur once")
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
    """Return a question on a swap of two columns if each has a unit of the other; else an empty text."""
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
    """Return the numbers of cells: array (rows,); raises `ValueError`, with `name` and row, for other texts.

    With `gaps`, missing values become NaN.
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
