"""Tables of the report."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup

from exudyn_crawler.views.scales import MEGA

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


def hot_spot_table(path: Path, stress: xr.Dataset | None) -> dict[str, Any]:
    """Table of hot spots with stresses in MPa and places in the shoe's frame.

    Studies give places in the track at t = 0, as the S-paper does, which are kept beside.
    """
    table = pd.read_csv(path)
    for name in ("value", "jump"):
        if name in table:
            table[name] = table[name] / MEGA
    places = {"place in the shoe, m": table[list("xyz")].to_numpy()}
    if stress is not None:
        local = stress.node_position.transpose("node", "axis").values[table["node"]]
        if not np.allclose(local, places["place in the shoe, m"], atol=1e-6):
            places = {"place in the shoe, m": local, "place at t = 0, m": places["place in the shoe, m"]}
    at = table.columns.get_loc("x")
    table = table.drop(columns=list("xyz"))
    for offset, (name, values) in enumerate(places.items()):
        table.insert(at + offset, name, [", ".join(f"{value:.4f}" for value in row) for row in values])
    names = {"value": "von Mises, MPa", "jump": "jump, MPa", "time": "time, s"}
    title = path.stem.removeprefix("hot_spots_").replace("_", " ")
    return html_table(title, table.rename(columns=names))
