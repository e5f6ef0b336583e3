"""Tables of the report."""

from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

VERDICTS = {"yes": "within", "no": "outside"}
WITHOUT_VERDICT = "none"


def comparison_rows(table: pd.DataFrame) -> dict[str, Any]:
    """Columns and rows of the comparison, each row with its verdict."""
    words = {"": "no verdict", **VERDICTS}
    shown = table.assign(within=table["within"].map(lambda verdict: words.get(verdict, verdict)))
    rows = [
        {"verdict": VERDICTS.get(verdict, WITHOUT_VERDICT), "cells": [_cell(value) for value in row]}
        for verdict, row in zip(table["within"], shown.itertuples(index=False), strict=True)
    ]
    return {"columns": list(shown.columns), "rows": rows}


def _cell(value: object) -> dict[str, Any]:
    if isinstance(value, float | np.floating):
        return {"text": "" if np.isnan(value) else f"{value:.4g}", "number": True}
    return {"text": str(value), "number": isinstance(value, int | np.integer)}


def html_table(title: str, table: pd.DataFrame) -> dict[str, Any]:
    """Title and HTML of a table."""
    html = table.to_html(index=False, border=0, na_rep="", float_format=lambda value: f"{value:.5g}")
    return {"title": title, "html": Markup(html)}
