"""Page of a sweep: its runs in parallel coordinates, response curves, effects, best and worst runs."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup
from plotly.offline import get_plotlyjs
from plotly.subplots import make_subplots

from exudyn_crawler.views.report.templating import rendered_page

LONGEST_TABLE = 500
"""Runs that the page has in its table."""
MOST_DRAWN = 5000
"""Runs that are drawn."""
MOST_CURVES = 12
"""Levels of what is not on the axis that have a curve each."""
HEIGHT = 420
"""Pixels of a plot."""


class Best(NamedTuple):
    """Best or worst run of an answer."""

    answer: str
    which: str
    run: int
    folder: str
    value: float


@dataclass(frozen=True)
class SweepView:
    """What a page shows of a sweep.

    Attributes
    ----------
    title : str
    lead : tuple of str
        Lines below the title.
    table : pandas.DataFrame
        A row a run, with `attrs` "units" and "meanings" of its columns.
    varied, answers : tuple of str
        Columns of what varies and of the answers.
    logarithmic : frozenset of str
        Columns whose axes are.
    is_grid : bool
        Whether every value of what varies is with every other.
    effects : pandas.DataFrame
        Columns answer, varied, level, mean, least, greatest.
    indices : pandas.DataFrame
        Columns answer, varied, first, first_conf, total, total_conf; may be empty.
    method : str
        How the indices were found, or why there are none.
    best : list of Best
    links : mapping
        Address of a run by its folder, as far as it has one.
    """

    title: str
    lead: tuple[str, ...]
    table: pd.DataFrame
    varied: tuple[str, ...]
    answers: tuple[str, ...]
    logarithmic: frozenset[str]
    is_grid: bool
    effects: pd.DataFrame
    indices: pd.DataFrame
    method: str
    best: list[Best]
    links: Mapping[str, str]

    def label(self, name: str) -> str:
        """Column with its unit."""
        unit = self.table.attrs["units"].get(name, "")
        return f"{name} in {unit}" if unit else name

    @property
    def done(self) -> pd.DataFrame:
        """Runs that have all answers; of very many, some that lie evenly among them."""
        done = self.table.dropna(subset=list(self.answers))
        return done.iloc[:: -(-len(done) // MOST_DRAWN) or 1]


def sweep_page(view: SweepView) -> str:
    """HTML of the page; it needs no other file but the runs it links to."""
    drawn = not view.done.empty
    names = ["run", *view.varied, *view.answers, "status", "reason"]
    return rendered_page(
        "sweep.html",
        title=view.title,
        lead=view.lead,
        best=[
            one._asdict() | {"link": view.links.get(one.folder), "shown": f"{one.value:.4g}"}
            for one in view.best
        ],
        units=view.table.attrs["units"],
        meanings=view.table.attrs["meanings"],
        parallel=_html(parallel_coordinates(view)) if drawn else "",
        responses=[_html(response_curves(view, answer)) for answer in view.answers] if drawn else [],
        effects=[_html(effect_figure(view, answer)) for answer in view.answers] if drawn else [],
        indices="" if view.indices.empty else _html(index_figure(view)),
        method=view.method,
        heads=[view.label(name) for name in names],
        rows=[
            {"link": view.links.get(row["folder"]), "cells": [_cell(row[name]) for name in names]}
            for row in view.table.head(LONGEST_TABLE).to_dict("records")
        ],
        left_out=max(0, len(view.table) - LONGEST_TABLE),
        plotly=Markup(get_plotlyjs()) if drawn else "",
    )


def parallel_coordinates(view: SweepView) -> go.Figure:
    """A line a run through what varies and the answers, coloured by the first of these."""
    done = view.done
    dimensions: list[dict[str, Any]] = []
    for name in (*view.varied, *view.answers):
        column = done[name]
        if pd.api.types.is_numeric_dtype(column) and not pd.api.types.is_bool_dtype(column):
            dimensions.append({"label": view.label(name), "values": column})
        else:
            texts = list(dict.fromkeys(column.astype(str)))
            places = column.astype(str).map(texts.index)
            ticks = {"tickvals": list(range(len(texts))), "ticktext": texts}
            dimensions.append({"label": view.label(name), "values": places} | ticks)
    colour = {"color": done[view.answers[0]], "colorscale": "Viridis", "showscale": True}
    figure = go.Figure(go.Parcoords(line=colour, dimensions=dimensions))
    return figure.update_layout(height=HEIGHT, margin={"t": 80, "b": 30})


def response_curves(view: SweepView, answer: str) -> go.Figure:
    """An answer over everything that varies, a panel each.

    On a grid there is a curve a level of what varies next, means over the rest; else a point a run.
    """
    done = view.done
    figure = make_subplots(cols=len(view.varied), shared_yaxes=True)
    for k, name in enumerate(view.varied):
        others = (*view.varied[k + 1 :], *view.varied[:k])
        if view.is_grid and others and done[others[0]].nunique() <= MOST_CURVES:
            for level, part in done.groupby(others[0], sort=True):
                means = part.groupby(name, sort=True)[answer].mean()
                curve = f"{others[0]} = {_cell(level)}"
                lines = go.Scatter(
                    x=means.index, y=means, name=curve, mode="lines+markers", legendgroup=others[0]
                )
                figure.add_trace(lines, row=1, col=k + 1)
        else:
            points = go.Scatter(x=done[name], y=done[answer], mode="markers", showlegend=False, name=answer)
            figure.add_trace(points, row=1, col=k + 1)
    return _panels(view, figure, answer)


def effect_figure(view: SweepView, answer: str) -> go.Figure:
    """Main effects on an answer, a panel for everything that varies: means, and extremes as bars."""
    own = view.effects[view.effects["answer"] == answer]
    figure = make_subplots(cols=len(view.varied), shared_yaxes=True)
    for k, name in enumerate(view.varied):
        rows = own[own["varied"] == name]
        bars = {
            "type": "data",
            "symmetric": False,
            "array": rows["greatest"] - rows["mean"],
            "arrayminus": rows["mean"] - rows["least"],
            "thickness": 1,
        }
        line = go.Scatter(
            x=rows["level"], y=rows["mean"], error_y=bars, mode="lines+markers", showlegend=False
        )
        figure.add_trace(line, row=1, col=k + 1)
    return _panels(view, figure, answer)


def index_figure(view: SweepView) -> go.Figure:
    """Sobol indices: bars of first order and total, with their confidence, a panel an answer."""
    answers = list(dict.fromkeys(view.indices["answer"]))
    figure = make_subplots(cols=len(answers), shared_yaxes=True, subplot_titles=answers)
    for k, answer in enumerate(answers):
        own = view.indices[view.indices["answer"] == answer]
        for kind, colour in (("first", "#1c5fb0"), ("total", "#c98a1b")):
            if own[kind].notna().any():
                error = (
                    {"type": "data", "array": own[f"{kind}_conf"]}
                    if own[f"{kind}_conf"].notna().any()
                    else None
                )
                bar = go.Bar(
                    x=own["varied"],
                    y=own[kind],
                    error_y=error,
                    name=kind,
                    marker_color=colour,
                    showlegend=k == 0,
                )
                figure.add_trace(bar, row=1, col=k + 1)
    return figure.update_layout(
        height=HEIGHT, barmode="group", margin={"t": 40}, yaxis_title="share of the variance"
    )


def _panels(view: SweepView, figure: go.Figure, answer: str) -> go.Figure:
    """Name the axes of a row of panels."""
    for k, name in enumerate(view.varied):
        kind = "log" if name in view.logarithmic else None
        figure.update_xaxes(title_text=view.label(name), type=kind, row=1, col=k + 1)
    figure.update_yaxes(title_text=view.label(answer), row=1, col=1)
    return figure.update_layout(height=HEIGHT, margin={"t": 30})


def _html(figure: go.Figure) -> Markup:
    return Markup(figure.to_html(full_html=False, include_plotlyjs=False))


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.4g}"
    return str(value)
