"""Self-contained pages for reading offline in a browser: text, tables, plots, pictures and 3D views."""

import base64
import io
import json
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import plotly
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure
from PIL import Image

from exudyn_crawler.files import whole_file
from exudyn_crawler.views.tables import cell_text

TEMPLATES = Path(__file__).with_name("templates")
SCRIPTS = ("data.js", "camera.js", "scene.js", "phases.js", "page.js")
PICTURE_WIDTH = 1500  # pixels of a picture on a page
FLAGS = {"flag": {"in spider": "held by a pin coupling", "beside spider": "next to a pin coupling"}}
"""Words for the flags of nodes in tables, by their column."""
GRID = "rgba(176, 176, 176, 0.3)"  # colour of a plot's grid


class Section(NamedTuple):
    """Part of a page below a heading; a section with an empty body is left out."""

    anchor: str
    heading: str
    body: Markup


class Cell(NamedTuple):
    """Cell of a table: text, True for a number, and target of a link."""

    text: str
    number: bool = False
    link: str | None = None


def page(
    title: str,
    lead: list[str],
    sections: list[Section],
    data: dict[str, Any] | None = None,
    top: str = "",
) -> str:
    """Return the HTML of a page: lead lines, `top`, sections, and `data` for the scripts of the page."""
    shown = [section for section in sections if section.body]
    has_plots = any("plotly-graph-div" in section.body for section in shown) or bool(data and data["scenes"])
    # no text in the data, such as a name with <!--<script>, may begin or end a script
    packed = "" if data is None else json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    parts = {"title": title, "lead": lead, "top": top, "sections": shown, "data": Markup(packed)}
    parts |= {"style": _text("page.css"), "scripts": [_text(name) for name in SCRIPTS]}
    library = Markup(plotly.offline.get_plotlyjs() if has_plots else "")
    return ENVIRONMENT.get_template("page.html").render(parts, plotly=library)


def write_page(html: str, path: Path, overwrite: bool = False) -> Path:
    """Write a page; the file appears whole or not at all; raises as `whole_file`."""
    with whole_file(path, overwrite) as temporary:
        temporary.write_text(html, encoding="utf-8")
    return path


def part(name: str, *values: object) -> Markup:
    """Return a part of a section, rendered by the macro `name`."""
    return Markup(getattr(ENVIRONMENT.get_template("parts.html").module, name)(*values))


def paragraph(text: str) -> Markup:
    """Return a text as a paragraph."""
    return part("paragraph", text)


def together(*parts: Markup) -> Markup:
    """Return parts one below the other."""
    return Markup("\n").join(parts)


def table(
    frame: pd.DataFrame,
    *,
    digits: int = 4,
    kinds: list[str] | None = None,
    anchor: str = "",
    compact: bool = False,
    headed: bool = True,
) -> Markup:
    """Return a frame as a table, with cells of values or `Cell`; `kinds` are the CSS classes of its rows."""
    rows = [
        {"kind": kind, "cells": [_cell(value, digits) for value in row]}
        for kind, row in zip(kinds or [""] * len(frame), frame.itertuples(index=False), strict=True)
    ]
    return part("table", list(frame.columns) if headed else [], rows, anchor, compact)


def _cell(value: Any, digits: int) -> Cell:
    if isinstance(value, Cell):
        return value
    if pd.api.types.is_float(value):
        return Cell(cell_text(float(value), digits), True)
    return Cell(str(value), pd.api.types.is_integer(value))


def plot(figure: plotly.graph_objects.Figure) -> Markup:
    """Return a Plotly figure in the style of all figures (`views.style`); the page holds the library once."""
    figure.update_layout(template="simple_white")
    if figure.data[0].type in ("scatter", "bar"):
        figure.update_xaxes(showgrid=True, gridcolor=GRID).update_yaxes(showgrid=True, gridcolor=GRID)
    return Markup(figure.to_html(full_html=False, include_plotlyjs=False))


def picture_file(path: Path) -> str:
    """Return the data address of a picture file, no wider than a page needs."""
    with Image.open(path) as opened:
        image = opened.convert("RGB")
    if image.width > PICTURE_WIDTH:
        size = (PICTURE_WIDTH, round(image.height * PICTURE_WIDTH / image.width))
        image = image.resize(size, Image.Resampling.LANCZOS)
    memory = io.BytesIO()
    # method 4 would take twice as long and save 5 %
    image.save(memory, format="webp", quality=85, method=2)
    return _address(memory, "webp")


def figure_picture(title: str, figure: Figure) -> Markup:
    """Return a figure of matplotlib as a picture."""
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=110)
    return part("picture", title, _address(memory, "png"))


def _address(picture: io.BytesIO, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(picture.getvalue()).decode('ascii')}"


HOW: dict[str, Any] = {"undefined": StrictUndefined, "trim_blocks": True}
ENVIRONMENT = Environment(loader=FileSystemLoader(TEMPLATES), autoescape=True, **HOW)


def _text(name: str) -> Markup:
    """Return the text of a file beside the templates, unescaped."""
    return Markup((TEMPLATES / name).read_text(encoding="utf-8"))
