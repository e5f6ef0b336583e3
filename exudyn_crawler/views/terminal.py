"""Tables on a terminal; none of what figures and results need is loaded for them."""

from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

VERDICT_STYLES = {"yes": "green", "no": "red", "not reached": "", "": ""}


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
    shown = Table(title=escape(title), title_justify="left")
    right = set(numeric)
    for name in columns:
        shown.add_column(escape(name), justify="right" if name in right else "left")
    verdict = columns.index("within") if "within" in columns else None
    for row in rows:
        style = "" if verdict is None else VERDICT_STYLES.get(str(row[verdict]), "")
        shown.add_row(*(escape(_cell(value)) for value in row), style=style)
    console.print(shown)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.4g}"
    return str(value)
