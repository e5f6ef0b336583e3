"""Page of a life: the shoe in 3D with its life at every node, shortest lives, growing damage, material."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import NDArray

from exudyn_crawler.case.parameters.fields import case_rows
from exudyn_crawler.results.life.life import BEYOND, LIFE, LifeResults, in_words, life_hours, life_words
from exudyn_crawler.views.pages.packing import SceneArrays, packed_scene
from exudyn_crawler.views.pages.page import (
    Section,
    page,
    paragraph,
    part,
    plot,
    table,
    together,
    write_page,
)
from exudyn_crawler.views.scenes.scene import Colouring, Scene, Solid
from exudyn_crawler.views.scenes.shoes import verdict_colouring
from exudyn_crawler.views.style import MEGA, STRESS_MAP

LEAST_DECADES = 2
"""Powers of ten of life that the colours span at least."""
DRAWN = 3
"""Nodes of the table whose growing damage is drawn."""
POINTS = 2000
"""Of a drawn curve at most."""
SHARES = (
    "The share of a load is its part of the ranges of stress, weighted by their damage; a load that relieves "
    "has a negative one. Lives by single criteria leave out what goes from run to run."
)


def write_life_page(found: LifeResults, path: Path, overwrite: bool = False) -> Path:
    """Write one self-contained page of a life, to be read offline in a browser.

    Raises
    ------
    FileExistsError
        If it exists and `overwrite` is false.
    """
    return write_page(life_page(found), path, overwrite)


def life_page(found: LifeResults) -> str:
    """HTML of the page."""
    arrays = SceneArrays()
    scene = packed_scene(Scene(("",), (life_solid(found),)), arrays)
    parts = part("titled", "Parts of the damage at these nodes", table(damage_parts(found), digits=5))
    return page(
        f"Life of the shoes: {found.duty.name}",
        _lead(found),
        [
            Section("life", "Life in 3D", part("life")),
            Section(
                "shortest",
                "Shortest lives by region",
                together(paragraph(SHARES), table(in_words(found.table), digits=5), parts),
            ),
            Section("damage", "Damage as it grows", plot(damage_curves(found))),
            Section("duty", "Duty", table(pd.DataFrame(case_rows(found.duty)))),
        ],
        {"scenes": {"life": {"": scene}}, "arrays": arrays.packed, "first": []},
    )


def _lead(found: LifeResults) -> list[str]:
    """Shortest life and how far to trust it, and what it is counted by."""
    shortest = float(np.nanmin(found.dataset.life[-1]))
    survival, places = 100.0 * float(found.dataset.survival[-1]), found.dataset.shoe.values.tolist()
    worst, material = found.table.iloc[0], found.duty.material
    low, high = (life_words(worst[f"{LIFE} at {end}"]) for end in ("least", "most"))
    factors = material.factors()
    strength = material.curve(found.duty.miner).strength
    return [
        f"{survival:g} % of the shoes see no crack at their worst node before {life_words(shortest)} "
        f"machine hours, the mean over the places {places} that a shoe takes in turn",
        f"given the uncertainty of the stress there, {low} to {high} h; stress {worst['verdict']}",
        f"{found.duty.criterion}, Miner {found.duty.miner}; {material.name}: strength at the "
        f"surface {strength / MEGA:.4g} MPa at R = -1 (of {factors['fatigue_strength'] / MEGA:.4g} MPa), "
        f"mean stress sensitivity {factors['mean_sensitivity']:.3g}; {material.provenance()}",
    ]


def life_solid(found: LifeResults) -> Solid:
    """Surface of the shoe coloured by its life, over all places and at each, and by how far to trust it."""
    data = found.dataset
    used, corners = np.unique(data.triangle.values, return_inverse=True)
    position = data.node_position.transpose("node", "axis").values[used]
    life = data.life.isel(survival=-1).values[used]
    trust = verdict_colouring(
        found.dataset.verdict.values[used], life >= BEYOND, "long: life beyond 1e9 h", "how far to trust it"
    )
    return Solid(
        "shoe",
        position,
        (corners.reshape(-1, 3),),
        "white",
        colourings=(*_life_colourings(found, used), trust),
        nodes=used,
    )


def _life_colourings(found: LifeResults, used: NDArray) -> Iterator[Colouring]:
    """Nodes of the surface by the logarithm of their life, over all places and at each."""
    data = found.dataset
    survivals = {
        f"all places, {100 * one:g} % survive": data.life.sel(survival=one).values
        for one in data.survival.values
    }
    at_last = data.place_damage.isel(survival=-1)
    lives = dict(reversed(survivals.items())) | {
        f"stays at place {shoe}": life_hours(at_last.sel(shoe=shoe).values) for shoe in data.shoe.values
    }
    logs = {name: np.log10(life[used]) for name, life in lives.items()}
    high = float(np.log10(BEYOND))
    low = min(*(float(np.nanmin(one)) for one in logs.values()), high - LEAST_DECADES)
    for name, log in logs.items():
        yield Colouring("life in h", log[None, None], low, high, f"{STRESS_MAP}_r", name=name, decades=True)


def damage_curves(found: LifeResults) -> go.Figure:
    """Damage of the worst nodes of the table as it grows over the runs, each at its worst place."""
    figure = go.Figure()
    for _, row in found.table.head(DRAWN).iterrows():
        node = int(row["node"])
        history = found.nodes[node].damage_history()
        own = history[history["shoe"] == row["worst place"]]
        for run, rows in own.groupby("run", sort=False):
            shown = rows.iloc[np.unique(np.linspace(0, len(rows) - 1, POINTS).astype(int))]
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
