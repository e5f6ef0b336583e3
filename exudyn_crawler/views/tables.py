"""Tables on a terminal and in CSV files."""

from pathlib import Path

import pandas as pd
from rich.console import Console

from exudyn_crawler.files import whole_file
from exudyn_crawler.views.terminal import print_rows

DIGITS = 10
"""Of a number in a CSV file: the last ones of sixteen are rounding alone, 1.5860000000000005 for 1.586."""
NUMBER = f"%.{DIGITS}g"


def print_table(table: pd.DataFrame, title: str, console: Console | None = None) -> None:
    """Print a table; a column `within` is coloured."""
    numeric = [str(name) for name in table.columns if pd.api.types.is_numeric_dtype(table[name])]
    rows = table.itertuples(index=False)
    print_rows([str(name) for name in table.columns], rows, title, numeric, console)


def write_table(table: pd.DataFrame, path: Path, overwrite: bool = False) -> Path:
    """Write a table as CSV, whole or not at all."""
    with whole_file(path, overwrite) as temporary:
        table.to_csv(temporary, index=False, float_format=NUMBER)
    return path


def within_by_class(table: pd.DataFrame) -> pd.DataFrame:
    """How many rows of a comparison are within, of those with a verdict: columns class, within, of.

    Parameters
    ----------
    table : pandas.DataFrame
        With the columns class and within: yes, no, or else without a verdict.
    """
    judged = table[table["within"].isin(["yes", "no"])]
    grouped = judged.groupby("class", sort=False)["within"]
    counts = pd.DataFrame({"within": grouped.agg(lambda w: int((w == "yes").sum())), "of": grouped.size()})
    return counts.reset_index()
