"""Tables on a terminal."""

from functools import partial

import pandas as pd
import pytest
from rich.console import Console

from exudyn_crawler.views import tables
from exudyn_crawler.views.tables import cell_text, print_table

TABLE = pd.DataFrame(
    {
        "case": ["translation", "turning"],
        "quantity": ["normal force z of a shoe", "slip velocity y of shoe 10"],
        "statistic": ["mean greatest of shoes", "greatest"],
        "unit": ["N", "m/s"],
        "paper": [2.146e6, 0.0312],
        "computed": [432_149.7, -0.012345],
        "lower": [3.009e11, 1.0],
        "upper": [4.071e11, 2.0],
        "class": ["statics", "fluctuation"],
        "within": ["yes", "no"],
    }
)
CELLS = ["2 146 000", "432 100", "0.0312", "-0.01235", "3.009e+11", "4.071e+11"]


@pytest.mark.parametrize("width", [40, 80, 120])
def test_no_number_is_cut_at_any_width(width, capsys, monkeypatch):
    monkeypatch.setattr(tables, "Console", partial(Console, width=width, force_terminal=True, no_color=True))
    print_table(TABLE, "Paper against computed")
    said = capsys.readouterr().out
    assert all(text in said for text in [*CELLS, *TABLE.columns, "fluctuation"])
    assert "…" not in said


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (300_940.0, "300 900"),
        (99_996.0, "100 000"),
        (-2.146e6, "-2 146 000"),
        (12_345.6, "12 350"),
        (2.1e9, "2.1e+09"),
        (float("nan"), ""),
        (12, "12"),
    ],
)
def test_numbers_are_readable(value, text):
    assert cell_text(value) == text
