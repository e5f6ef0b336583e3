"""Page of a sweep: its runs in parallel coordinates, response curves, effects, best and worst runs."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Self

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup
from plotly.subplots import make_subplots

from exudyn_crawler.case.parameters.fields import PREFIXES, prefix_of
from exudyn_crawler.results.history.catalogue import READ_IN
from exudyn_crawler.views.pages import page
from exudyn_crawler.views.tables import cell_text

LONGEST_TABLE, MOST_DRAWN, MOST_CURVES = 500, 5000, 12
"""Runs in the table, runs that are drawn, and levels of what is not on the axis that have a curve each."""
QUANTILES = ["value", "least", "most", "of a quarter", "of half"]
"""Columns of a table of quantiles that have the unit of its answer."""
HEIGHT, ACROSS = 420, 6  # pixels of a row of panels, and panels in it at most
FEW_TICKS = {"nticks": 4, "tickangle": 0}


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

    `table` has a row a run and `attrs` "units" and "meanings" of its columns, of which some are `varied` or
    `answers`, or on `logarithmic` axes. On a grid every value of what varies is with every other. `effects`
    have the columns answer, varied, level, mean, least and greatest, `indices`, which may be empty, answer,
    varied, first, first_conf, total and total_conf; `method` says how they were found, or why there are none.
    `links` has the address of a run by its folder, `scatter` the tables of a sample's by name.
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
    scatter: Mapping[str, pd.DataFrame] = field(default_factory=dict)

    def label(self, name: str) -> str:
        """Column with its unit."""
        unit = self.table.attrs["units"].get(name, "")
        return f"{name} in {unit}" if unit else name

    def is_life(self, name: str) -> bool:
        """Whether a column is of hours, which span decades."""
        return self.table.attrs["units"].get(name) == "h"

    def in_units_for_reading(self) -> Self:
        """Same with forces in kN, stresses in MPa and angles in degrees, all else by prefixes: MN/m."""
        units = self.table.attrs["units"]
        prefixes = {name: prefix_of(self.table[name].dropna().tolist(), unit) for name, unit in units.items()}
        by_prefix = {name: (one + units[name], 1.0 / PREFIXES[one]) for name, one in prefixes.items()}
        read = {name: READ_IN.get(unit, by_prefix[name]) for name, unit in units.items()}
        factors = {name: factor for name, (_, factor) in read.items() if factor != 1.0}
        table = self.table.assign(**{name: factor * self.table[name] for name, factor in factors.items()})
        table.attrs = self.table.attrs | {"units": units | {name: unit for name, (unit, _) in read.items()}}
        effects, values = self.effects.copy(), ["mean", "least", "greatest"]
        for name, factor in factors.items():
            effects.loc[effects["answer"] == name, values] *= factor
            effects.loc[effects["varied"] == name, "level"] *= factor
        best = [one._replace(value=one.value * factors.get(one.answer, 1.0)) for one in self.best]
        scatter = dict(self.scatter)
        if "quantiles" in scatter:
            factor = scatter["quantiles"]["answer"].map(factors).fillna(1.0)
            scaled = scatter["quantiles"][QUANTILES].mul(factor, axis=0)
            named = scatter["quantiles"]["answer"].map(table.attrs["units"])
            scatter["quantiles"] = scatter["quantiles"].assign(unit=named, **scaled.to_dict("series"))
        return replace(self, table=table, effects=effects, best=best, scatter=scatter)

    @property
    def done(self) -> pd.DataFrame:
        """Runs that have all answers; of very many, some that lie evenly among them."""
        done = self.table.dropna(subset=list(self.answers))
        return done.iloc[:: -(-len(done) // MOST_DRAWN) or 1]


def sweep_page(view: SweepView) -> str:
    """HTML of the page; it needs no other file but the runs it links to."""
    view = view.in_units_for_reading()
    indices = [page.paragraph(f"None: {view.method}.")]
    if not view.indices.empty:
        said = f"Shares of the variance that each makes alone (first) and in all (total): {view.method}."
        indices = [page.paragraph(said), page.plot(index_figure(view))]
    sections = [
        page.Section("best", "Best and worst runs", _best(view)),
        page.Section("indices", "Sobol indices", page.together(*indices)),
        page.Section("runs", "Runs", _runs(view)),
    ]
    if not view.done.empty:
        lines = page.paragraph("A line a run; draw along an axis to choose some of them.")
        means = page.paragraph("Means over all else that varies; bars reach to the least and the greatest.")
        responses = [page.plot(response_curves(view, answer)) for answer in view.answers]
        effects = [page.plot(effect_figure(view, answer)) for answer in view.answers]
        sections[1:1] = [
            page.Section("parallel", "All runs", page.together(lines, page.plot(parallel_coordinates(view)))),
            page.Section("responses", "Response curves", page.together(*responses)),
            page.Section("effects", "Main effects", page.together(means, *effects)),
        ]
    if view.scatter:
        sections[1:1] = [page.Section("scatter", "Scatter", _scatter(view))]
    return page.page(view.title, view.lead, sections)


SCATTER = {
    "quantiles": "Quantiles of the finished runs; least and most hold at 95 % for independent "
    "draws. Where those of a quarter and of half of the runs lie beyond them, draw more.",
    "failures": "Shoes that crack, by answers of life: every run is a shoe.",
    "sensitivities": "Rank correlations (Spearman): 1 or -1 where one thing decides. How often chance alone "
    "would show as much is in sensitivities.csv.",
}


def _scatter(view: SweepView) -> Markup:
    tables, quantiles = dict(view.scatter), view.scatter["quantiles"]
    ranks = tables["sensitivities"].pivot(index="varied", columns="answer", values="rank correlation")
    order = ranks.abs().max(axis=1).sort_values(ascending=False).index
    answers = [one for one in view.answers if one in ranks]
    tables["sensitivities"] = (ranks.loc[order, answers].round(2) + 0.0).reset_index()  # without -0
    shown = [(said, tables[name]) for name, said in SCATTER.items() if not tables[name].empty]
    parts = [part for said, one in shown for part in (page.paragraph(said), page.table(one))]
    if not quantiles.empty:
        parts.insert(0, page.plot(distribution_figure(view)))
    return page.together(*parts)


def distribution_figure(view: SweepView) -> go.Figure:
    """Portion of the runs below each value of an answer, a panel each, with bounds of its quantiles."""
    quantiles = view.scatter["quantiles"]
    known = [name for name in view.answers if name in set(quantiles["answer"])]
    figure = make_subplots(cols=len(known), shared_yaxes=True)
    for k, name in enumerate(known, 1):
        values, own = view.done[name].sort_values(), quantiles[quantiles["answer"] == name]
        portions = np.arange(1, len(values) + 1) / len(values)
        figure.add_scatter(x=values, y=portions, mode="lines", row=1, col=k, showlegend=False)
        upper, lower = own["most"] - own["value"], own["value"] - own["least"]
        bars = {"type": "data", "symmetric": False, "array": upper, "arrayminus": lower, "thickness": 1}
        how = {"mode": "markers", "error_x": bars, "marker_color": "#444", "showlegend": False}
        figure.add_scatter(x=own["value"], y=own["portion below"], row=1, col=k, **how)
        kind = "log" if view.is_life(name) else None
        figure.update_xaxes(title_text=view.label(name), type=kind, row=1, col=k, **FEW_TICKS)
    figure.update_yaxes(title_text="portion of the runs below", row=1, col=1)
    return figure.update_layout(height=HEIGHT, margin={"t": 30})


def _best(view: SweepView) -> Markup:
    if not view.best:
        return page.paragraph("No run has finished.")
    units, meanings = view.table.attrs["units"], view.table.attrs["meanings"]
    rows = {
        "answer": [one.answer for one in view.best],
        "": [one.which for one in view.best],
        "run": [page.Cell(str(one.run), True, view.links.get(one.folder)) for one in view.best],
        "value": [page.Cell(f"{one.value:.4g} {units[one.answer]}", True) for one in view.best],
        " ": [meanings[one.answer] for one in view.best],
    }
    return page.table(pd.DataFrame(rows), compact=True)


def _runs(view: SweepView) -> Markup:
    shown = view.table.head(LONGEST_TABLE)
    rows = shown[[*view.varied, *view.answers, "status", "reason"]].rename(columns=view.label)
    pairs = zip(shown["run"], shown["folder"], strict=True)
    rows.insert(0, "run", [page.Cell(str(number), True, view.links.get(folder)) for number, folder in pairs])
    left_out = len(view.table) - len(shown)
    more = [page.paragraph(f"{left_out} more are in results.csv.")] if left_out else []
    return page.together(*more, page.table(rows))


def parallel_coordinates(view: SweepView) -> go.Figure:
    """A line a run through what varies and the answers, coloured by the first of these."""
    done = view.done
    dimensions: list[dict[str, Any]] = []
    for name in (*view.varied, *view.answers):
        dimensions.append({"label": view.label(name), "values": done[name]})
        if view.is_life(name):
            decades = np.log10(done[name])
            ticks = np.arange(np.ceil(decades.min()), decades.max() + 1e-9)
            dimensions[-1] |= {"values": decades, "tickvals": ticks, "ticktext": [f"1e{k:g}" for k in ticks]}
        if not pd.api.types.is_numeric_dtype(done[name]) or pd.api.types.is_bool_dtype(done[name]):
            places, texts = pd.factorize(done[name].astype(str))
            dimensions[-1] |= {"values": places, "tickvals": list(range(len(texts))), "ticktext": texts}
    first = next(one for one in dimensions if one["label"] == view.label(view.answers[0]))
    bar = {name: first[name] for name in ("tickvals", "ticktext") if name in first}
    colour = {"color": first["values"], "colorscale": "Viridis", "showscale": True, "colorbar": bar}
    figure = go.Figure(go.Parcoords(line=colour, dimensions=dimensions, labelangle=-25))
    return figure.update_layout(height=HEIGHT, margin={"t": 110, "b": 30})


def response_curves(view: SweepView, answer: str) -> go.Figure:
    """An answer over all that varies: on a grid with a curve a level of what varies next, else points."""
    done, panels = view.done, []
    for k, name in enumerate(view.varied):
        others = (*view.varied[k + 1 :], *view.varied[:k])
        if not (view.is_grid and others and done[others[0]].nunique() <= MOST_CURVES):
            how = {"mode": "markers", "showlegend": False}
            panels.append([go.Scatter(x=done[name], y=done[answer], name=answer, **how)])
            continue
        unit = view.table.attrs["units"].get(others[0], "")
        levels = {
            f"{others[0]} = {cell_text(level)} {unit}".rstrip(): part.groupby(name, sort=True)[answer].mean()
            for level, part in done.groupby(others[0], sort=True)
        }
        lines = {"mode": "lines+markers", "legendgroup": others[0]}
        panels.append([go.Scatter(x=one.index, y=one, name=curve, **lines) for curve, one in levels.items()])
    return _panels(view, answer, panels)


def effect_figure(view: SweepView, answer: str) -> go.Figure:
    """Main effects on an answer, a panel for everything that varies: means, and extremes as bars."""
    panels = []
    for name in view.varied:
        rows = view.effects[(view.effects["answer"] == answer) & (view.effects["varied"] == name)]
        upper, lower = rows["greatest"] - rows["mean"], rows["mean"] - rows["least"]
        bars = {"type": "data", "symmetric": False, "array": upper, "arrayminus": lower, "thickness": 1}
        line = {"mode": "lines+markers", "showlegend": False, "error_y": bars}
        panels.append([go.Scatter(x=rows["level"], y=rows["mean"], **line)])
    return _panels(view, answer, panels)


def index_figure(view: SweepView) -> go.Figure:
    """Sobol indices: bars of first order and total, with their confidence, a panel an answer."""
    answers = list(dict.fromkeys(view.indices["answer"]))
    figure = make_subplots(cols=len(answers), shared_yaxes=True, subplot_titles=answers)
    for k, answer in enumerate(answers):
        own = view.indices[view.indices["answer"] == answer]
        for kind, colour in (("first", "#1c5fb0"), ("total", "#c98a1b")):
            if own[kind].isna().all():
                continue
            known = own[f"{kind}_conf"].notna().any()
            error = {"type": "data", "array": own[f"{kind}_conf"]} if known else None
            how = {"marker_color": colour, "error_y": error, "showlegend": k == 0}
            figure.add_trace(go.Bar(x=own["varied"], y=own[kind], name=kind, **how), row=1, col=k + 1)
    shown = {"height": HEIGHT, "barmode": "group", "margin": {"t": 40}}
    return figure.update_layout(yaxis_title="share of the variance", **shown)


def _panels(view: SweepView, answer: str, panels: list[list[go.Scatter]]) -> go.Figure:
    """Traces in rows of panels, one for everything that varies; lives on logarithmic axes."""
    rows, across = -(-len(panels) // ACROSS), min(len(panels), ACROSS)
    figure = make_subplots(rows, across, shared_yaxes="all", vertical_spacing=0.3 / rows)
    for k, (name, traces) in enumerate(zip(view.varied, panels, strict=True)):
        place = {"row": k // ACROSS + 1, "col": k % ACROSS + 1}
        figure.add_traces(traces, rows=place["row"], cols=place["col"])
        axis: dict[str, Any] = {"title_text": view.label(name)}
        if name in view.logarithmic:
            axis |= {"type": "log", **FEW_TICKS}
            levels = np.unique(view.done[name])
            if len(levels) <= MOST_CURVES:
                axis |= {"tickvals": levels, "ticktext": [cell_text(one, 3) for one in levels]}
        figure.update_xaxes(**axis, **place)
    figure.update_yaxes(title_text=view.label(answer), col=1)
    figure.update_yaxes(type="log" if view.is_life(answer) else None)
    return figure.update_layout(height=HEIGHT if rows == 1 else 280 * rows, margin={"t": 30})
