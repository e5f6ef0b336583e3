"""Tables on a terminal and in CSV files; nothing heavy is loaded to print rows."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    import pandas as pd

VERDICT_STYLES = {"yes": "green", "no": "red"}
BETWEEN = 3
"""Characters beside a column: its rule and its margins."""
LARGE, BEYOND = 1e4, 1e9
"""From the first on numbers are grouped by thousands, from the second on powers of ten are shorter."""
NUMBER = "%.10g"
"""In a CSV file: the last digits of sixteen are rounding alone, 1.5860000000000005 for 1.586."""


def print_rows(
    columns: Sequence[str],
    rows: Iterable[Sequence[object]],
    title: str,
    numeric: Iterable[str] = (),
    console: Console | None = None,
) -> None:
    """Print rows of cells under the names of their columns; `numeric` ones stand to the right.

    No word and no number is cut: where the columns do not fit side by side, each row is a block of lines.
    Rows with a column `within` are coloured.
    """
    console = console or Console()
    if not console.is_terminal:
        console = Console(width=150)
    cells = [[cell_text(value) for value in row] for row in rows]
    right = set(numeric)
    widths = [
        max([_longest(name), *(_longest(row[k], name in right) for row in cells)])
        for k, name in enumerate(columns)
    ]
    verdict = columns.index("within") if "within" in columns else None
    styles = ["" if verdict is None else VERDICT_STYLES.get(row[verdict], "") for row in cells]
    if sum(widths) + BETWEEN * len(columns) + 1 > console.width:
        _print_blocks(columns, cells, styles, title, console)
        return
    shown = Table(title=escape(title), title_justify="left")
    for name, width in zip(columns, widths, strict=True):
        shown.add_column(escape(name), justify="right" if name in right else "left", min_width=width)
    for row, style in zip(cells, styles, strict=True):
        shown.add_row(*map(escape, row), style=style)
    console.print(shown)


def _longest(text: str, whole: bool = False) -> int:
    """Characters that stay together: of a number all, of words the longest."""
    return len(text) if whole else max(map(len, text.split()), default=0)


def _print_blocks(
    columns: Sequence[str],
    cells: Sequence[Sequence[str]],
    styles: Sequence[str],
    title: str,
    console: Console,
) -> None:
    """Print a block of lines for each row: names of the columns, and their cells."""
    console.print(f"[italic]{escape(title)}[/italic]")
    for row, style in zip(cells, styles, strict=True):
        shown = Table(show_header=False, style=style)
        shown.add_column()
        shown.add_column(overflow="fold")
        for name, text in zip(columns, row, strict=True):
            if text:
                shown.add_row(escape(name), escape(text), style=style)
        console.print(shown)


def cell_text(value: object) -> str:
    """Cell of a table as a reader sees it: four digits of a number, thousands apart up to a billion."""
    if not isinstance(value, float):
        return str(value)
    if value != value:
        return ""
    short = f"{value:.4g}"
    return f"{float(short):,.0f}".replace(",", " ") if LARGE <= abs(float(short)) < BEYOND else short


def print_table(table: "pd.DataFrame", title: str, console: Console | None = None) -> None:
    """Print a table as of `print_rows`."""
    numeric = [str(name) for name in table.columns if table[name].dtype.kind in "biuf"]
    print_rows([*map(str, table.columns)], table.itertuples(index=False), title, numeric, console)


def write_table(table: "pd.DataFrame", path: Path, overwrite: bool = False) -> Path:
    """Write a table as CSV, whole or not at all."""
    from exudyn_crawler.files import whole_file

    with whole_file(path, overwrite) as temporary:
        table.to_csv(temporary, index=False, float_format=NUMBER)
    return path


def within_by_class(table: "pd.DataFrame") -> "pd.DataFrame":
    """How many rows of a comparison with a verdict (yes or no) are within: columns class, within, of."""
    judged = table[table["within"].isin(["yes", "no"])]
    is_within = judged.assign(within=judged["within"] == "yes").groupby("class", sort=False)["within"]
    return is_within.agg(["sum", "size"]).set_axis(["within", "of"], axis=1).reset_index()
