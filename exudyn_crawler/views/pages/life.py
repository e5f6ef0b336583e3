"""Page of a life: the shoe in 3D with its life at every node, shortest lives, growing damage, material."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from exudyn_crawler.case.parameters.fields import case_rows
from exudyn_crawler.results.life.life import BEYOND, LIFE, LifeResults, in_words, life_hours
from exudyn_crawler.views.pages import page
from exudyn_crawler.views.pages.packing import SceneArrays, packed_scene
from exudyn_crawler.views.scenes.scene import Colouring, Scene, Solid
from exudyn_crawler.views.scenes.shoes import verdict_colouring
from exudyn_crawler.views.style import MEGA, STRESS_MAP
from exudyn_crawler.views.tables import cell_text

LEAST_DECADES = 2  # powers of ten of life that the colours span at least
DRAWN, POINTS = 3, 2000
"""Nodes of the table whose growing damage is drawn, and points of a drawn curve at most."""
UNKNOWN = (
    "Where the drive pulls at a single node the life is not known. A verdict is of the changes of stress: "
    "what mesh, left-out fields and spread leave open of them."
)
SHARES = (
    "The share of a load is its part of the ranges of stress, weighted by their damage; a load that relieves "
    "has a negative one. Lives by single criteria leave out what goes from run to run."
)

CAUSES = (
    "Machine hours after which each thing that happens would crack a region by itself: the darker, the "
    "sooner. With stages of wear it is what a thing does in all of them until the crack."
)

CONTACT = (
    "Contact below the treads, in the last stage: to yield and to shakedown are the factors by which "
    "stresses may grow until the steel flows, and until it flows in every pass. No life above counts it."
)


def write_life_page(
    found: LifeResults,
    path: Path,
    overwrite: bool = False,
    roller_paths: Mapping[str, pd.DataFrame] | None = None,
) -> Path:
    """Write one self-contained page of a life, to be read offline in a browser; raises as `write_page`.

    `roller_paths` are tables of the treads' contact by what happens.
    """
    arrays = SceneArrays()
    scene = packed_scene(Scene(("",), (life_solid(found),)), arrays)
    shortest, parts = (page.table(one, digits=5) for one in (in_words(found.table), damage_parts(found)))
    said, titled = page.paragraph(SHARES), page.part("titled", "Parts of the damage at these nodes", parts)
    causes = page.together(page.paragraph(CAUSES), page.plot(causes_figure(found)))
    runs = found.duty.by_stage()[-1].runs
    paths = [page.part("titled", name, page.table(table)) for name, table in (roller_paths or {}).items()]
    contact = [page.Section("roller-path", "Roller path", page.together(page.paragraph(CONTACT), *paths))]
    sections = [
        page.Section("life", "Life in 3D", page.part("coloured", "life", UNKNOWN)),
        page.Section("causes", "What cracks which region", causes),
        page.Section("shortest", "Shortest lives by region", page.together(said, shortest, titled)),
        *([page.Section("damage", "Damage as it grows", page.plot(damage_curves(found)))] if runs else []),
        *(contact if paths else []),
        page.Section("duty", "Duty", page.table(pd.DataFrame(case_rows(found.duty)))),
    ]
    data = {"scenes": {"life": {"": scene}}, "arrays": arrays.packed, "first": []}
    html = page.page(f"Life of the shoes: {found.duty.name}", life_lines(found), sections, data)
    return page.write_page(html, path, overwrite)


def life_lines(found: LifeResults) -> list[str]:
    """Shortest life and how far to trust it, and what it is counted by."""
    rows = in_words(found.table)
    outside = rows[rows["flag"] != "in spider"]
    worst, material = (outside if len(outside) else rows).iloc[0], found.duty.material
    survival, places = 100.0 * float(found.dataset.survival[-1]), found.dataset.shoe.values.tolist()
    mean = f", the mean over the places {places} that a shoe takes in turn" if found.duty.runs else ""
    worn = "".join(f", {cell_text(one.hours)} h {one.name}" for one in found.duty.stages)
    shortest = cell_text(worst[f"{LIFE} that {survival:g} % survive"])
    low, high = (cell_text(worst[f"{LIFE} at {end}"]) for end in ("least", "most"))
    factors = material.factors()
    strength = material.curve(found.duty.miner).strength
    return [
        f"{survival:g} % of the shoes see no crack at their worst node outside of rigid spiders "
        f"({worst['region']}) before {shortest} machine hours{mean}"
        f"{worn and f'; stages{worn[1:]}, the last goes on'}",
        f"given the uncertainty of the stress there, {low} to {high} h; stress {worst['verdict']}",
        f"{found.duty.criterion}, Miner {found.duty.miner}; {material.name}: strength at the "
        f"surface {strength / MEGA:.4g} MPa at R = -1 (of {factors['fatigue_strength'] / MEGA:.4g} MPa), "
        f"mean stress sensitivity {factors['mean_sensitivity']:.3g}; {material.provenance()}",
    ]


def life_solid(found: LifeResults) -> Solid:
    """Surface of the shoe coloured by its life, over all places and at each, and by how far to trust it."""
    data = found.dataset
    used, corners = np.unique(data.triangle.values, return_inverse=True)
    at_last = data.place_damage.isel(survival=-1)
    lives = {
        f"all places, {100 * one:g} % survive": data.life.sel(survival=one).values
        for one in reversed(data.survival.values)
    }
    lives |= {
        f"stays at place {shoe}": life_hours(at_last.sel(shoe=shoe).values) for shoe in data.shoe.values
    }
    logs, high = {name: np.log10(life[used]) for name, life in lives.items()}, float(np.log10(BEYOND))
    low = min(*(float(np.nanmin(one)) for one in logs.values()), high - LEAST_DECADES)
    colours = (low, high, f"{STRESS_MAP}_r")
    colourings = [
        Colouring("life in h", log[None, None], *colours, name=name, decades=True)
        for name, log in logs.items()
    ]
    is_long = data.life.isel(survival=-1).values[used] >= BEYOND
    said = "long: life beyond 1e9 h", "how far to trust it"
    colourings.append(verdict_colouring(data.verdict.values[used], is_long, *said))
    surface = data.node_position.transpose("node", "axis").values[used], (corners.reshape(-1, 3),)
    return Solid("shoe", *surface, "white", colourings=tuple(colourings), nodes=used)


def causes_figure(found: LifeResults) -> go.Figure:
    """Life by each part of the damage alone, a row each, in every region: colours and hours."""
    lives = found.causes()
    words, decades = lives.map(lambda hours: "" if hours >= BEYOND else cell_text(hours)), np.log10(lives)
    low, high = float(decades.min().min()), float(np.log10(BEYOND))
    ticks = np.arange(np.floor(low), high + 1.0)
    bar = {"title": "h", "tickvals": ticks, "ticktext": [f"1e{one:g}" for one in ticks]}
    colours = {"zmin": min(low, high - LEAST_DECADES), "zmax": high, "colorscale": "YlOrRd_r"}
    cells = {"x": lives.columns, "y": lives.index, "z": decades, "text": words, "colorbar": bar}
    said = {"texttemplate": "%{text}", "hovertemplate": "%{y}<br>%{x}: %{text} h<extra></extra>"}
    figure = go.Figure(go.Heatmap(**cells, **colours, **said))
    figure.update_yaxes(autorange="reversed", automargin=True)
    figure.update_xaxes(side="top")
    height, margin = 120 + 26 * len(lives), {"l": 10, "r": 10, "t": 40, "b": 10}
    return figure.update_layout(height=height, margin=margin)


def damage_curves(found: LifeResults) -> go.Figure:
    """Damage of the worst nodes of the table as it grows over the runs, each at its worst place."""
    figure, runs = go.Figure(), [run.name for run in found.duty.runs]
    for _, row in found.table.head(DRAWN).iterrows():
        node, place = int(row["node"]), row["worst place"]
        history = found.nodes[node].damage_history()
        chosen = history[(history["shoe"] == place) & history["run"].isin(runs)]
        for run, rows in chosen.groupby("run", sort=False):
            shown = rows.iloc[np.unique(np.linspace(0, len(rows) - 1, POINTS).astype(int))]
            time, damage = (shown[name].to_numpy() for name in ("time in s", "damage an hour"))
            name = f"{row['region']}, node {node}, place {place}: {run}"
            figure.add_scatter(x=time, y=damage, name=name, line={"shape": "hv"})
    figure.update_xaxes(title_text="time in the run in s")
    figure.update_yaxes(title_text="damage an hour", exponentformat="e")
    margin = {"l": 70, "r": 10, "t": 10, "b": 10}
    return figure.update_layout(legend={"orientation": "h", "y": -0.25}, margin=margin)


def damage_parts(found: LifeResults) -> pd.DataFrame:
    """Share of every run and phase in the damage at the nodes of the table, in per cent."""
    own = found.dataset.isel(node=found.table["node"].to_numpy())
    shares = 100.0 * own.part_damage / np.maximum(own.damage_an_hour.isel(survival=-1), 1e-300)
    columns = {f"{name} in %": shares.sel(part=name).values for name in own.part.values}
    return found.table[["region", "node"]].assign(**columns)
