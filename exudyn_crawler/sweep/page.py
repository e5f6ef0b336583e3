"""Page of a sweep: response curves, main effects, Sobol indices, best and worst runs.

Tables are in units for reading (`results.for_reading`); `links` has the address of a run by its folder.
"""

import os
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup
from plotly.subplots import make_subplots

from exudyn_crawler.files import note_written
from exudyn_crawler.run.folder.record import note_file
from exudyn_crawler.sweep import results, worker
from exudyn_crawler.sweep.scatter import AnySweep
from exudyn_crawler.views.pages import page, report
from exudyn_crawler.views.tables import cell_text, write_table

LONGEST_TABLE, MOST_DRAWN, MOST_CURVES = 500, 5000, 12
"""Greatest number of rows in the table, of drawn runs, and of levels off the axis with a curve each."""
HEIGHT, ACROSS = 420, 6  # pixels of a row of panels, and panels in it at most
FEW_TICKS = {"nticks": 4, "tickangle": 0}
SCATTER = {
    "quantiles": "Quantiles of the finished runs, {finished} of {drawn} that were drawn; least and most are "
    "their 95 % bounds for independent draws. Where those of a quarter or of half of the runs lie beyond "
    "these bounds, draw more.",
    "failures": "Shoes that crack, by answers of life: every run is a shoe.",
    "sensitivities": "Rank correlations (Spearman): 1 or -1 where one value alone decides. The probability "
    "of as great a correlation by chance is in sensitivities.csv.",
}


def write_page(
    sweep: AnySweep, table: pd.DataFrame, folder: Path, runs: Path | None, say: Callable[[str], None]
) -> None:
    """Write page and scatter of a sweep into its folder, and reports of the best and worst of its `runs`."""
    for name, scatter_table in results.scatter_tables(sweep, table).items():
        write_table(scatter_table, folder / f"{name}.csv", overwrite=True)
    links = {}
    if runs is not None:
        for name in results.best_and_worst(sweep, table)["folder"].unique():
            _report_of(runs / name, say)
        links = {name: _link(folder, runs / name) for name in table["folder"] if name}
    page.write_page(sweep_page(sweep, table, links), folder / report.REPORT, overwrite=True)


def sweep_page(sweep: AnySweep, table: pd.DataFrame, links: Mapping[str, str]) -> str:
    """Return the HTML of the page of a `results_table`; it needs no other file except linked runs."""
    read = results.for_reading(table)
    sections = [
        page.Section("best", "Best and worst runs", _best(sweep, read, links)),
        page.Section("scatter", "Scatter", _scatter(sweep, read)),
        *([] if _drawn(sweep, read).empty else _figures(sweep, read)),
        page.Section("indices", "Sobol indices", _indices(sweep, read)),
        page.Section("runs", "Runs", _runs(sweep, read, links)),
    ]
    counts = ", ".join(f"{count} {status}" for status, count in table["status"].value_counts().items())
    drawn = f", {sweep.runs} points drawn with seed {sweep.seed}" if sweep.runs else ""
    lead = f"{len(table)} runs of {sweep.named}, design {sweep.design}{drawn}: {counts}"
    return page.page(f"Sweep of {sweep.named}", [lead], sections)


def _label(table: pd.DataFrame, name: str) -> str:
    """Return a column's name with its unit."""
    unit = table.attrs["units"].get(name, "")
    return f"{name} in {unit}" if unit else name


def _is_life(table: pd.DataFrame, name: str) -> bool:
    """Return True for a column in hours; lives span decades."""
    return table.attrs["units"].get(name) == "h"


def _drawn(sweep: AnySweep, table: pd.DataFrame) -> pd.DataFrame:
    """Select runs with all answers, thinned evenly if there are many."""
    done = table.dropna(subset=[answer.label for answer in sweep.answers])
    return done.iloc[:: -(-len(done) // MOST_DRAWN) or 1]


def _best(sweep: AnySweep, table: pd.DataFrame, links: Mapping[str, str]) -> Markup:
    best = results.best_and_worst(sweep, table)
    if best.empty:
        return page.paragraph("No run has finished.")
    rows = {
        "answer": best["answer"],
        "": best["which"],
        "run": [page.Cell(str(row.run), True, links.get(row.folder)) for row in best.itertuples()],
        "value": [page.Cell(f"{row.value:.4g} {row.unit}", True) for row in best.itertuples()],
        " ": best["answer"].map(table.attrs["meanings"]),
    }
    return page.table(pd.DataFrame(rows), compact=True)


def _scatter(sweep: AnySweep, table: pd.DataFrame) -> Markup:
    tables = results.scatter_tables(sweep, table)
    if not tables:
        return Markup("")
    ranks = tables["sensitivities"].pivot(index="varied", columns="answer", values="rank correlation")
    order = ranks.abs().max(axis=1).sort_values(ascending=False).index
    answers = [answer.label for answer in sweep.answers if answer.label in ranks]
    # adding 0.0 turns -0.0 to 0.0
    tables["sensitivities"] = (ranks.loc[order, answers].round(2) + 0.0).reset_index()
    parts = [] if tables["quantiles"].empty else [distribution_figure(sweep, table, tables["quantiles"])]
    counts = {"finished": len(results.finished(table)), "drawn": len(table)}
    shown = [(said, tables[name]) for name, said in SCATTER.items() if not tables[name].empty]
    texts = [
        part for said, rows in shown for part in (page.paragraph(said.format(**counts)), page.table(rows))
    ]
    return page.together(*map(page.plot, parts), *texts)


def _figures(sweep: AnySweep, table: pd.DataFrame) -> list[page.Section]:
    labels = [answer.label for answer in sweep.answers]
    effects = results.main_effects(sweep, table)
    means = page.paragraph(
        "Means over all other values that vary; bars reach from the least to the greatest."
    )
    curves = [page.plot(response_curves(sweep, table, label)) for label in labels]
    bars = [page.plot(effect_figure(sweep, table, effects, label)) for label in labels]
    return [
        page.Section("responses", "Response curves", page.together(*curves)),
        page.Section("effects", "Main effects", page.together(means, *bars)),
    ]


def _indices(sweep: AnySweep, table: pd.DataFrame) -> Markup:
    indices, method = results.sobol_indices(sweep, table)
    if indices.empty:
        return page.paragraph(f"None: {method}.")
    said = (
        f"Shares of the variance by each value alone (first) and with all its interactions (total): {method}."
    )
    return page.together(page.paragraph(said), page.table(indices.dropna(axis="columns", how="all")))


def _runs(sweep: AnySweep, table: pd.DataFrame, links: Mapping[str, str]) -> Markup:
    shown = table.head(LONGEST_TABLE)
    labels = [answer.label for answer in sweep.answers]
    columns = [*sweep.columns, *labels, "status", "reason"]
    rows = shown[columns].rename(columns={name: _label(table, name) for name in columns})
    pairs = zip(shown["run"], shown["folder"], strict=True)
    rows.insert(0, "run", [page.Cell(str(number), True, links.get(folder)) for number, folder in pairs])
    left_out = len(table) - len(shown)
    more = [page.paragraph(f"{left_out} more are in results.csv.")] if left_out else []
    return page.together(*more, page.table(rows))


def distribution_figure(sweep: AnySweep, table: pd.DataFrame, quantiles: pd.DataFrame) -> go.Figure:
    """Draw the distribution of each answer over the runs, one panel each, with bounds of its quantiles."""
    done = _drawn(sweep, table)
    by_answer = quantiles.groupby("answer", sort=False)
    figure = make_subplots(cols=len(by_answer), shared_yaxes=True)
    for k, (name, rows) in enumerate(by_answer, 1):
        values = done[name].sort_values()
        place = {"row": 1, "col": k}
        portions = np.arange(1, len(values) + 1) / len(values)
        figure.add_scatter(x=values, y=portions, mode="lines", **place)
        bounds = _bars(rows["value"], rows["least"], rows["most"])
        how = {"mode": "markers", "error_x": bounds, "marker_color": "#444"}
        figure.add_scatter(x=rows["value"], y=rows["portion below"], **how, **place)
        kind = "log" if _is_life(table, name) else None
        figure.update_xaxes(title_text=_label(table, name), type=kind, **FEW_TICKS, **place)
    figure.update_yaxes(title_text="portion of the runs below", col=1)
    return figure.update_layout(height=HEIGHT, margin={"t": 30}, showlegend=False)


def _bars(value: pd.Series, least: pd.Series, most: pd.Series) -> dict[str, object]:
    """Return error bars around values from the least to the most."""
    ends = {"array": most - value, "arrayminus": value - least}
    return {"type": "data", "symmetric": False, "thickness": 1} | ends


def response_curves(sweep: AnySweep, table: pd.DataFrame, answer: str) -> go.Figure:
    """Draw an answer over each varied value: on a grid a curve a level of the next one, else points."""
    done = _drawn(sweep, table)
    panels = []
    for k, name in enumerate(sweep.columns):
        others = (*sweep.columns[k + 1 :], *sweep.columns[:k])
        if not (sweep.design == "grid" and others and done[others[0]].nunique() <= MOST_CURVES):
            how = {"mode": "markers", "showlegend": False}
            panels.append([go.Scatter(x=done[name], y=done[answer], name=answer, **how)])
            continue
        unit = table.attrs["units"].get(others[0], "")
        levels = {
            f"{others[0]} = {cell_text(level)} {unit}".rstrip(): part.groupby(name, sort=True)[answer].mean()
            for level, part in done.groupby(others[0], sort=True)
        }
        lines = {"mode": "lines+markers", "legendgroup": others[0]}
        panels.append(
            [go.Scatter(x=means.index, y=means, name=curve, **lines) for curve, means in levels.items()]
        )
    return _panels(sweep, table, answer, panels)


def effect_figure(sweep: AnySweep, table: pd.DataFrame, effects: pd.DataFrame, answer: str) -> go.Figure:
    """Draw main effects on an answer, one panel for each varied value: means, with extremes as bars."""
    panels = []
    for name in sweep.columns:
        rows = effects[(effects["answer"] == answer) & (effects["varied"] == name)]
        bars = _bars(rows["mean"], rows["least"], rows["greatest"])
        line = {"mode": "lines+markers", "showlegend": False, "error_y": bars}
        panels.append([go.Scatter(x=rows["level"], y=rows["mean"], **line)])
    return _panels(sweep, table, answer, panels)


def _panels(sweep: AnySweep, table: pd.DataFrame, answer: str, panels: list[list[go.Scatter]]) -> go.Figure:
    """Return traces in rows of panels, one for each varied value; lives on logarithmic axes."""
    rows = -(-len(panels) // ACROSS)
    across = min(len(panels), ACROSS)
    figure = make_subplots(rows, across, shared_yaxes="all", vertical_spacing=0.3 / rows)
    for k, (variable, traces) in enumerate(zip(sweep.vary, panels, strict=True)):
        place = {"row": k // ACROSS + 1, "col": k % ACROSS + 1}
        figure.add_traces(traces, rows=place["row"], cols=place["col"])
        axis: dict[str, object] = {"title_text": _label(table, variable.label)}
        if variable.scale == "log":
            axis |= {"type": "log", **FEW_TICKS}
            levels = np.unique(_drawn(sweep, table)[variable.label])
            if len(levels) <= MOST_CURVES:
                axis |= {"tickvals": levels, "ticktext": [cell_text(level, 3) for level in levels]}
        figure.update_xaxes(**axis, **place)
    figure.update_yaxes(title_text=_label(table, answer), col=1)
    figure.update_yaxes(type="log" if _is_life(table, answer) else None)
    return figure.update_layout(height=HEIGHT if rows == 1 else 280 * rows, margin={"t": 30})


def _report_of(run: Path, say: Callable[[str], None]) -> None:
    """Write the report of a run unless there is one as new as the run."""
    path = run / report.REPORT
    outcome = run / worker.OUTCOME
    if path.is_file() and outcome.is_file() and path.stat().st_mtime >= outcome.stat().st_mtime:
        note_written(path)
        return
    try:
        note_file(report.write_report(run, overwrite=True))
    # readers raise all kinds of errors for damaged files
    except Exception as error:
        say(f"no report of {run}: {' '.join(str(error).split())}")


def _link(folder: Path, run: Path) -> str:
    """Return the address of a run's report from the page, or of its folder if it has no report."""
    there = run / report.REPORT if (run / report.REPORT).is_file() else run
    return Path(os.path.relpath(there, folder.resolve())).as_posix()
