"""Page of a life: the shoe in 3D with its life at every node, shortest lives, growing damage, material."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray
from plotly.offline import get_plotlyjs

from exudyn_crawler.case.files.text import case_rows
from exudyn_crawler.files import whole_file
from exudyn_crawler.results.life.life import LifeResults
from exudyn_crawler.results.life.life_table import BEYOND, LIFE, in_words, life_hours, life_words
from exudyn_crawler.views.report.plots import page_colours
from exudyn_crawler.views.report.tables import html_table
from exudyn_crawler.views.report.templating import rendered_page
from fem.trust import VERDICTS

LEAST_DECADES = 2
"""Powers of ten of life that the colours span at least."""
DRAWN = 3
"""Nodes of the table whose growing damage is drawn."""
POINTS = 2000
"""Of a drawn curve at most."""


def write_life_page(found: LifeResults, path: Path, overwrite: bool = False) -> Path:
    """Write one self-contained page of a life, to be read offline in a browser.

    Raises
    ------
    FileExistsError
        If it exists and `overwrite` is false.
    """
    page = life_page(found)
    with whole_file(path, overwrite) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return path


def life_page(found: LifeResults) -> str:
    """HTML of the page."""
    shortest = float(np.nanmin(found.dataset.life[-1]))
    survival, places = 100.0 * float(found.dataset.survival[-1]), found.dataset.shoe.values.tolist()
    worst = found.table.iloc[0]
    low, high = (life_words(worst[f"{LIFE} at {end}"]) for end in ("least", "most"))
    factors = found.duty.material.factors()
    strength = found.duty.material.curve(found.duty.miner).strength
    return rendered_page(
        "life.html",
        title=f"Life of the shoes: {found.duty.name}",
        lead=[
            f"{survival:g} % of the shoes see no crack at their worst node before {life_words(shortest)} "
            f"machine hours, the mean over the places {places} that a shoe takes in turn",
            f"by what is open of the stress there, {low} to {high} h; stress {worst['verdict']}",
            f"{found.duty.criterion}, Miner {found.duty.miner}; {found.duty.material.name}: strength at the "
            f"surface {strength / 1e6:.4g} MPa at R = -1 (of {factors['fatigue_strength'] / 1e6:.4g} MPa), "
            f"mean stress sensitivity {factors['mean_sensitivity']:.3g}; {found.duty.material.source}",
        ],
        surface=_shown(life_surface(found), "life"),
        curves=_shown(damage_curves(found), "damage"),
        table=html_table("Shortest lives by region", in_words(found.table)),
        parts=html_table("Parts of the damage at these nodes", damage_parts(found)),
        duty=html_table("Duty", pd.DataFrame(case_rows(found.duty))),
        plotly=Markup(get_plotlyjs()),
    )


def life_surface(found: LifeResults) -> go.Figure:
    """Surface of the shoe coloured by its life, over all places and at each, and by how far to trust it."""
    data = found.dataset
    used, corners = np.unique(data.triangle.values, return_inverse=True)
    position = data.node_position.transpose("node", "axis").values[used].astype(np.float32)
    corners = corners.reshape(-1, 3).astype(np.int32)
    views = _life_views(found, used) | {"how far to trust it": _trust_view(found, used)}
    first = next(iter(views.values()))
    figure = go.Figure(
        go.Mesh3d(
            **dict(zip("xyz", position.T, strict=True)),
            **dict(zip("ijk", corners.T, strict=True)),
            **first,
            colorscale=page_colours()["colours"],
            flatshading=True,
            hoverinfo="text",
        )
    )
    buttons = [
        {"label": name, "method": "restyle", "args": [{key: [value] for key, value in view.items()}]}
        for name, view in views.items()
    ]
    figure.update_layout(
        updatemenus=[{"buttons": buttons, "x": 0.5, "xanchor": "center", "y": 1, "yanchor": "top"}],
        scene={"aspectmode": "data"} | {f"{axis}axis": {"title": {"text": f"{axis} in m"}} for axis in "xyz"},
        margin={"l": 0, "r": 0, "t": 0, "b": 0},
        height=600,
    )
    return figure


def _life_views(found: LifeResults, used: NDArray) -> dict[str, dict[str, Any]]:
    """Views of the nodes of the surface by the logarithm of their life."""
    data = found.dataset
    survivals = {
        f"all places, {100 * one:g} % survive": data.life.sel(survival=one).values
        for one in data.survival.values
    }
    at_last = data.place_damage.isel(survival=-1)
    lives = dict(reversed(survivals.items())) | {
        f"stays at place {shoe}": life_hours(at_last.sel(shoe=shoe).values) for shoe in data.shoe.values
    }
    logs = {name: np.log10(life[used]).astype(np.float32) for name, life in lives.items()}
    low, high = min(float(np.nanmin(one)) for one in logs.values()), float(np.log10(BEYOND))
    ticks = {one: f"1e{one}" for one in range(int(np.floor(low)), int(high) + 1)}
    verdicts = found.trust.words(used)
    return {
        name: {
            "intensity": log,
            "cmin": min(low, high - LEAST_DECADES),
            "cmax": high,
            "reversescale": True,
            "text": _hover(lives[name][used], used, verdicts),
            "colorbar": _colorbar("life in h", ticks),
        }
        for name, log in logs.items()
    }


def _trust_view(found: LifeResults, used: NDArray) -> dict[str, Any]:
    """View of the nodes of the surface by their verdicts."""
    numbers, factor = found.trust.verdict[used], found.trust.factor[used]
    return {
        "intensity": np.where(numbers < 0, np.nan, numbers).astype(np.float32),
        "cmin": 0,
        "cmax": len(VERDICTS) - 1,
        "reversescale": False,
        "text": [
            f"node {node}: {words}" + ("" if np.isnan(one) else f", life within a factor of {one:.3g}")
            for node, words, one in zip(used, found.trust.words(used), factor, strict=True)
        ],
        "colorbar": _colorbar("stress", dict(enumerate(VERDICTS))),
    }


def _colorbar(title: str, ticks: Mapping[int, str]) -> dict[str, Any]:
    """Scale at the left with words at its ticks."""
    placed = {"tickvals": list(ticks), "ticktext": list(ticks.values()), "x": 0, "xanchor": "left"}
    return {"title": {"text": title}} | placed


def _hover(life: NDArray, nodes: NDArray, verdicts: Sequence[str]) -> list[str]:
    """Words of every node of the surface."""
    return [
        f"node {node}: "
        + ("not known: the drive pulls here" if np.isnan(one) else f"{life_words(one)} h, {verdict}")
        for one, node, verdict in zip(life, nodes, verdicts, strict=True)
    ]


def damage_curves(found: LifeResults) -> go.Figure:
    """Damage of the worst nodes of the table as it grows over the runs, each at its worst place."""
    figure = go.Figure()
    for _, row in found.table.head(DRAWN).iterrows():
        node = int(row["node"])
        history = found.nodes[node].damage_history()
        own = history[history["shoe"] == row["worst place"]]
        for run, part in own.groupby("run", sort=False):
            shown = part.iloc[np.unique(np.linspace(0, len(part) - 1, POINTS).astype(int))]
            figure.add_scatter(
                x=shown["time in s"].to_numpy(),
                y=shown["damage an hour"].to_numpy(),
                name=f"{row['region']}, node {node}, place {row['worst place']}: {run}",
                line={"shape": "hv"},
            )
    figure.update_layout(
        xaxis={"title": {"text": "time in the run in s"}},
        yaxis={"title": {"text": "damage an hour"}, "exponentformat": "e"},
        legend={"orientation": "h", "y": -0.25},
        margin={"l": 70, "r": 10, "t": 10, "b": 10},
    )
    return figure


def damage_parts(found: LifeResults) -> pd.DataFrame:
    """Share of every run and phase in the damage at the nodes of the table, in per cent."""
    rows = []
    for _, row in found.table.iterrows():
        own = found.dataset.sel(node=int(row["node"]))
        whole = max(float(own.damage_an_hour[-1]), 1e-300)
        shares = {
            f"{part} in %": 100.0 * float(own.part_damage.sel(part=part)) / whole for part in own.part.values
        }
        rows.append({"region": row["region"], "node": row["node"]} | shares)
    return pd.DataFrame(rows)


def _shown(figure: go.Figure, name: str) -> Markup:
    """Figure as HTML without the library, which stands on the page once."""
    return Markup(figure.to_html(full_html=False, include_plotlyjs=False, div_id=f"plot-{name}"))
