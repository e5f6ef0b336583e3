"""Tables on a terminal and in CSV files; printing rows loads no heavy library."""

import re
from collections.abc import Iterable, Sequence
from numbers import Number
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    import pandas as pd

    from exudyn_crawler.origins import Entry

VERDICT_STYLES = {"yes": "green", "no": "red"}
BETWEEN = 3  # characters between columns: rule and margins
LARGE, BEYOND = 1e4, 1e9
"""Limits of number formats: thousands are grouped from the first on; from the second on a power of ten is
shorter."""
DECIMAL = re.compile(r"(?<![\w.])-?\d+\.\d+(?:e[+-]?\d+)?(?![\w.])")
ORIGIN_COLUMNS = ("key", "value", "origin", "how")
NUMBER = "%.10g"  # in a CSV file: the last of sixteen digits are rounding, 1.5860000000000005 for 1.586


def origin_rows(entries: Iterable["Entry"], short: bool = False) -> list[tuple[str, str, str, str]]:
    """Return the entries of a ledger for reading: path, value with unit, origin, source (`ORIGIN_COLUMNS`).

    Values are `short` with four digits, else exact as in case files.
    """
    from exudyn_crawler.settings.fields import value_text

    rows = []
    for entry in entries:
        value = value_text(entry.value, entry.unit)
        rows.append((entry.path, short_numbers(value) if short else value, str(entry.origin), entry.how))
    return rows


def short_numbers(text: str, digits: int = 4) -> str:
    """Return a text with few digits in its decimal numbers; whole numbers are unchanged."""
    return DECIMAL.sub(lambda found: f"{float(found[0]):.{digits}g}", text)


def print_rows(
    columns: Sequence[str],
    rows: Iterable[Sequence[object]],
    title: str,
    numeric: Iterable[str] = (),
    keys: Sequence[str] = (),
    whole: str | Path = "",
) -> None:
    """Print rows of cells under the names of their columns; `numeric` columns are aligned to the right.

    No word and no number is cut. If the columns do not fit side by side, only those of `keys` are shown, as
    many from the first on as fit, and a line tells where the `whole` table is. If not even two fit, or
    without keys, each row is a block of lines. Rows with a column `within` are coloured.
    """
    console = Console()
    if not console.is_terminal:
        console = Console(width=150)
    cells = [dict(zip(columns, map(cell_text, row), strict=True)) for row in rows]
    right = set(numeric)
    wanted = [name for name in keys if name in columns]
    shown = list(columns)
    widths = {
        name: max([_longest(name), *(_longest(row[name], name in right) for row in cells)])
        for name in columns
    }

    def spare() -> int:
        return console.width - 1 - sum(widths[name] + BETWEEN for name in shown)

    while spare() < 0 and len(wanted) > 1:
        shown = [name for name in columns if name in wanted]
        wanted.pop()
    if spare() < 0:
        _print_blocks(cells, title, console)
        return
    # columns that need the least extra width for one line get it first
    needs = {name: max(map(len, [name, *(row[name] for row in cells)])) - widths[name] for name in shown}
    for left, name in zip(range(len(shown), 0, -1), sorted(shown, key=lambda name: needs[name]), strict=True):
        widths[name] += min(needs[name], spare() // left)
    table = Table(title=escape(title), title_justify="left")
    for name in shown:
        table.add_column(escape(name), justify="right" if name in right else "left", width=widths[name])
    for row in cells:
        style = VERDICT_STYLES.get(row.get("within", ""), "")
        table.add_row(*(escape(row[name]) for name in shown), style=style)
    console.print(table)
    if len(shown) < len(columns):
        console.print(f"all columns: {whole}", soft_wrap=True, highlight=False, markup=False)


def _longest(text: str, whole: bool = False) -> int:
    """Return the length of the longest unbreakable part: a whole number, or the longest word."""
    return len(text) if whole else max(map(len, text.split()), default=0)


def _print_blocks(cells: Sequence[dict[str, str]], title: str, console: Console) -> None:
    """Print a block of lines for each row: names of the columns and their cells."""
    console.print(f"[italic]{escape(title)}[/italic]")
    for row in cells:
        shown = Table(show_header=False, style=VERDICT_STYLES.get(row.get("within", ""), ""))
        shown.add_column()
        shown.add_column(overflow="fold")
        for name, text in row.items():
            if text:
                shown.add_row(escape(name), escape(text))
        console.print(shown)


def cell_text(value: object, digits: int = 4) -> str:
    """Return a cell of a table for reading: few digits of a number, thousands grouped up to a billion."""
    if not isinstance(value, float):
        return str(value)
    if value != value:
        return ""
    short = f"{value:.{digits}g}"
    return f"{float(short):,.0f}".replace(",", " ") if LARGE <= abs(float(short)) < BEYOND else short


def print_table(table: "pd.DataFrame", title: str, keys: Sequence[str] = (), whole: str | Path = "") -> None:
    """Print a table with `print_rows`; a column with any number is numeric, whatever words it also has."""
    numeric = [str(name) for name in table.columns if any(isinstance(cell, Number) for cell in table[name])]
    rows = table.itertuples(index=False, name=None)
    print_rows([*map(str, table.columns)], rows, title, numeric, keys, whole)


def write_table(table: "pd.DataFrame", path: Path, overwrite: bool = False) -> Path:
    """Write a table as CSV; the file appears whole or not at all."""
    from exudyn_crawler.files import whole_file

    with whole_file(path, overwrite) as temporary:
        table.to_csv(temporary, index=False, float_format=NUMBER)
    return path


def within_by_class(table: "pd.DataFrame") -> "pd.DataFrame":
    """Return the number of rows within limits, and of rows with yes or no, by class: class, within, of."""
    judged = table[table["within"].isin(["yes", "no"])]
    is_within = judged.assign(within=judged["within"] == "yes").groupby("class", sort=False)["within"]
    return is_within.agg(["sum", "size"]).set_axis(["within", "of"], axis=1).reset_index()
