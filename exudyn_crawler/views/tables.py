"""Tables on a terminal and in CSV files; nothing heavy is loaded to print rows."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from exudyn_crawler.files import whole_file

if TYPE_CHECKING:
    import pandas as pd

VERDICT_STYLES = {"yes": "green", "no": "red"}
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

    Rows with a column `within` are coloured.
    """
    console = console or Console()
    if not console.is_terminal:
        console = Console(width=150)
    shown, right = Table(title=escape(title), title_justify="left"), set(numeric)
    for name in columns:
        shown.add_column(escape(name), justify="right" if name in right else "left")
    verdict = columns.index("within") if "within" in columns else None
    for row in rows:
        style = "" if verdict is None else VERDICT_STYLES.get(str(row[verdict]), "")
        shown.add_row(*(escape(cell_text(value)) for value in row), style=style)
    console.print(shown)


def cell_text(value: object) -> str:
    """Cell of a table as a reader sees it."""
    if isinstance(value, float):
        return "" if value != value else f"{value:.4g}"
    return str(value)


def print_table(table: "pd.DataFrame", title: str, console: Console | None = None) -> None:
    """Print a table as of `print_rows`."""
    numeric = [str(name) for name in table.columns if table[name].dtype.kind in "biuf"]
    print_rows([*map(str, table.columns)], table.itertuples(index=False), title, numeric, console)


def write_table(table: "pd.DataFrame", path: Path, overwrite: bool = False) -> Path:
    """Write a table as CSV, whole or not at all."""
    with whole_file(path, overwrite) as temporary:
        table.to_csv(temporary, index=False, float_format=NUMBER)
    return path


def within_by_class(table: "pd.DataFrame") -> "pd.DataFrame":
    """How many rows of a comparison with a verdict (yes or no) are within: columns class, within, of."""
    judged = table[table["within"].isin(["yes", "no"])]
    is_within = judged.assign(within=judged["within"] == "yes").groupby("class", sort=False)["within"]
    return is_within.agg(["sum", "size"]).set_axis(["within", "of"], axis=1).reset_index()
