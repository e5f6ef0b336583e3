"""Pages of a life and of a check of a shoe: coloured shoe in 3D, tables, curves; pictures of a check."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup
from matplotlib.figure import Figure

from exudyn_crawler.results.checks.solve import CheckResults
from exudyn_crawler.results.checks.tables import CYCLES
from exudyn_crawler.results.life.duty import Duty, DutyRun
from exudyn_crawler.results.life.life import (
    BEYOND,
    BROKEN,
    COARSE,
    EXCEEDS,
    LIFE,
    PEAK,
    TENSILE,
    YIELD,
    LifeResults,
    for_reading,
    is_coarse,
    life_hours,
    life_words,
)
from exudyn_crawler.results.stress.hot_spots import flat_triangles
from exudyn_crawler.settings.fields import case_rows
from exudyn_crawler.views import style
from exudyn_crawler.views.pages import packing, page, signed
from exudyn_crawler.views.pages.page import FLAGS
from exudyn_crawler.views.pages.signed import Pairs, SignedReport
from exudyn_crawler.views.scenes import pictures, scene, shoes
from exudyn_crawler.views.tables import cell_text, short_numbers
from fem.body.element_stress import von_mises
from fem.stress import trust

LEAST_LIFE = 1.0  # h, least life with a colour of its own
LEAST_DECADES = 2  # least powers of ten of life in the colour scale
DRAWN, POINTS = 3, 2000
"""Nodes of the table with a curve of their damage, and greatest number of points of a curve."""
BENT = 0.05  # m, greatest drawn elastic displacement of a check
BY_CASE = "Colours show the stress of a case, with a separate scale for each case."
VIEWS = {"from ahead and above": (25.0, 30.0), "from ahead and below": (25.0, -30.0)}  # azimuth, elevation
WINDOW = (-2.0, 2.0, -0.8, 0.8)  # m
UNKNOWN = (
    "Where the drive pulls at a single node the life is unknown; where the mesh is too coarse it is not "
    "shown. A verdict judges the stress ranges: their uncertainty by the mesh, left-out static fields and "
    "the spread."
)
SHARES = (
    "The contribution of a load is its part of the stress ranges, weighted by their damage; that of a load "
    "that relieves is negative. The life by the critical plane leaves out the cycles from run to run."
)
CAUSES = (
    "Machine hours after which each run or check case alone would crack a region: the darker, the sooner. "
    "With stages of wear the damage of all stages until the crack counts."
)
SHOE_CAPTION = "Life that most shoes survive (grey: not known, or mesh too coarse)"
WHY = ("verdict", "main part")
ASKED = "After how many machine hours of this duty does a shoe crack, where, and by which part of the duty?"
MOVES = (
    "By the uncertainty of the stress alone a life lies between the least and the greatest of the table; "
    "other assumed values are not varied here."
)
VALID = (
    "The hours are until a crack that grows, by linear elastic stress, local S-N curves and Miner's rule.",
    "They are those of this duty: another mix of digging, travel and ground has other hours.",
    "They are not compared with cracks of this machine in service.",
)
"""Caption, columns, question, spread and validity of the report to sign."""
CONTACT = (
    'Contact below the treads, in the last stage: "to yield" and "to shakedown" are the factors by which '
    "stresses may grow until the steel flows once, and in every pass. The lives above leave it out."
)


def write_life_page(
    lives: LifeResults,
    path: Path,
    overwrite: bool = False,
    roller_paths: dict[str, pd.DataFrame] | None = None,
) -> Path:
    """Write one self-contained page of a life, to be read offline in a browser; raises as `write_page`.

    `roller_paths` are tables of the treads' contact by run or check case.
    """
    both = for_reading(lives.table).replace(FLAGS), damage_parts(lives)
    shortest, parts = (page.table(table, digits=5) for table in both)
    said = page.paragraph(SHARES)
    titled = page.part("titled", "Parts of the damage at these nodes", parts)
    causes = page.together(page.paragraph(CAUSES), page.plot(causes_figure(lives)))
    growing = page.plot(damage_curves(lives)) if lives.duty.by_stage()[-1].runs else Markup()
    paths = [page.part("titled", name, page.table(table)) for name, table in (roller_paths or {}).items()]
    contact = page.together(page.paragraph(CONTACT), *paths) if paths else Markup()
    sections = [
        page.Section("life", "Life in 3D", page.part("coloured", "life", UNKNOWN)),
        page.Section("causes", "What cracks which region", causes),
        page.Section("shortest", "Shortest lives by region", page.together(said, shortest, titled)),
        page.Section("damage", "Damage as it grows", growing),
        page.Section("roller-path", "Roller path", contact),
        page.Section("duty", "Duty", page.table(pd.DataFrame(case_rows(lives.duty)))),
    ]
    title = f"Life of the shoes: {lives.duty.name}"
    html = _coloured_page(title, life_lines(lives), sections, life_solid(lives))
    return page.write_page(html, path, overwrite)


def signed_life(lives: LifeResults, checksums: Pairs, program: str) -> SignedReport:
    """Return the report to sign of a life; `program` is the program's line."""
    duty = lives.duty
    history = next((run.basis.history for run in lives.runs if run.basis.history is not None), None)
    shoes_of = duty.check if history is None else history.case.gear.words(history.case)
    longest = f"{LIFE} that {100.0 * duty.survivals[-1]:g} % survive"
    table = for_reading(lives.table)[["region", longest, f"{LIFE} at least", f"{LIFE} at most", *WHY]]
    rows = case_rows(duty)
    given = tuple((row.key, short_numbers(row.value)) for row in rows)
    return SignedReport(
        kind="Life of the shoes",
        title=duty.name,
        facts=(("shoes of", shoes_of), signed.revision(checksums), ("program", program)),
        question=ASKED,
        lines=tuple(life_lines(lives)),
        answers=signed.rows_of(table),
        given_words=f"The duty has {len(rows)} values; those that its file does not state are defaults.",
        given=given,
        assumed_words=f"Material: {duty.material.provenance()}. {MOVES}",
        assumed=(),
        validity=VALID,
        checksums=checksums,
        figures={},
    )


def life_figure(lives: LifeResults) -> Figure:
    """Draw the shoe from above and below, coloured by the life that most shoes survive."""
    solid = life_solid(lives)
    colouring = solid.colourings[0]
    with mpl.rc_context(style.STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(9.0, 6.0))
        axes = figure.subplots(len(VIEWS), 1)
        for ax, (title, seen) in zip(axes, VIEWS.items(), strict=True):
            pictures.paint(ax, [replace(solid, colourings=(colouring,))], scene.View.seen_from(*seen), WINDOW)
            ax.set_title(title, loc="left")
            ax.set_axis_off()
        scale = style.scale_of(colouring.low, colouring.high, str(colouring.colours))
        figure.colorbar(scale, ax=axes, label=f"log10 of {colouring.title}")
    return figure


def _coloured_page(title: str, lead: list[str], sections: list[page.Section], solid: scene.Solid) -> str:
    """Return the HTML of a page whose first section shows a solid with its colourings."""
    arrays = packing.SceneArrays()
    shown = packing.packed_scene(scene.Scene(("",), (solid,)), arrays)
    data = {"scenes": {sections[0].anchor: {"": shown}}, "arrays": arrays.packed, "first": []}
    return page.page(title, lead, sections, data)


def life_lines(lives: LifeResults) -> list[str]:
    """Return lines on the shortest life, its uncertainty, and the fatigue criterion and material."""
    rows = for_reading(lives.table)
    outside = rows[rows["flag"] != "in spider"]
    worst = (outside if len(outside) else rows).iloc[0]
    material = lives.duty.material
    survival = 100.0 * float(lives.dataset.survival[-1])
    places = lives.dataset.shoe.values.tolist()
    mean = f", the mean over the places {places} that a shoe takes in turn" if lives.duty.runs else ""
    worn = "".join(f", {cell_text(stage.hours)} h {stage.name}" for stage in lives.duty.stages)
    shortest = cell_text(worst[f"{LIFE} that {survival:g} % survive"])
    low, high = (cell_text(worst[f"{LIFE} at {end}"]) for end in ("least", "most"))
    factors = material.factors()
    beyond = list(_beyond_strength(lives))
    given = [f"given the uncertainty of the stress there, {low} to {high} h; stress {worst['verdict']}"]
    strength = material.curve(lives.duty.miner).strength / style.MEGA
    until = f"{shortest} machine hours until a crack"
    if shortest == cell_text(life_words(BROKEN)):
        until = "no machine hours: a crack at the first load"
    elif shortest == COARSE:
        until = "no machine hours: the mesh is too coarse"
        given = list(_resolved(outside, f"{LIFE} that {survival:g} % survive"))
    return [
        f"{until} at the worst node ({worst['region']}; pin couplings "
        f"left out), which {survival:g} % of the shoes survive{mean}"
        f"{worn and f'; stages{worn[1:]}, the last goes on'}",
        *beyond,
        *given,
        *_hours_of(lives.duty),
        f"{lives.duty.criterion}, Miner {lives.duty.miner}; {material.name}: strength at the "
        f"surface {strength:.4g} MPa at R = -1 (of {factors['fatigue_strength'] / style.MEGA:.4g} MPa), mean "
        f"stress sensitivity {factors['mean_sensitivity']:.3g}; {material.provenance()}",
    ]


def _resolved(rows: pd.DataFrame, life: str) -> Iterator[str]:
    """Yield a line on the shortest life that the mesh resolves; none if there is none."""
    fine = rows[~is_coarse(rows)]
    if len(fine):
        row = fine.iloc[0]
        shown = f"{cell_text(row[life])} h in {row['region']}; stress {row['verdict']}"
        yield f"shortest life that the mesh resolves: {shown}"


def _hours_of(duty: Duty) -> Iterator[str]:
    """Yield a line on the share of the machine hours for which each run stands; none without runs."""
    parts = [f"{run.name} {_often(run)}" for run in duty.runs]
    if parts:
        yield f"of the machine hours: {', '.join(parts)}; the rest does no damage"


def _often(run: DutyRun) -> str:
    """Return the words for the frequency of a run."""
    return f"{run.an_hour:g} times an hour" if run.share is None else f"{100.0 * run.share:.3g} %"


def _beyond_strength(lives: LifeResults) -> Iterator[str]:
    """Yield a line for each strength that stress exceeds; bores are left out."""
    material = lives.duty.material
    table = lives.table[lives.table["flag"] != "in spider"].sort_values(PEAK, ascending=False, kind="stable")
    for name, strength, unknown in (
        (TENSILE, material.tensile_strength, "it breaks at the first such load, and there are no hours"),
        (
            YIELD,
            material.yield_strength,
            "the life is by linear stress. It does not know how far the steel flows, what residual stress "
            "that leaves, cracks after few cycles of flow, and that the shoe bends for good",
        ),
    ):
        rows = table[table[EXCEEDS] == name]
        if len(rows):
            row = rows.iloc[0]
            regions = ", ".join(dict.fromkeys(rows["region"]))
            at = f"up to {cell_text(row[PEAK])} MPa at node {row['node']}"
            limit = f"{material.name}'s {name} is {cell_text(strength / style.MEGA)} MPa"
            yield f"above {name}: {regions}, {at}; {limit}: {unknown}"


def life_solid(lives: LifeResults) -> scene.Solid:
    """Return the surface of the shoe coloured by life, over all places and at each, and by verdict."""
    data = lives.dataset
    used, corners = np.unique(data.triangle.values, return_inverse=True)
    at_last = data.place_damage.isel(survival=-1)
    fields = {
        f"all places, {100 * survival:g} % survive": data.life.sel(survival=survival).values
        for survival in reversed(data.survival.values)
    }
    fields |= {
        f"stays at place {shoe}": np.where(
            data.life.values[-1] == BROKEN, BROKEN, life_hours(at_last.sel(shoe=shoe).values)
        )
        for shoe in data.shoe.values
    }
    logs = {name: np.log10(np.maximum(life[used], LEAST_LIFE)) for name, life in fields.items()}
    high = float(np.log10(BEYOND))
    low = min(*(float(np.nanmin(log)) for log in logs.values()), high - LEAST_DECADES)
    coarse = data.verdict.values[used] == trust.LIMITED
    logs = {name: np.where(coarse, np.nan, log) for name, log in logs.items()}
    colours = (low, high, f"{style.STRESS_MAP}_r")
    colourings = [
        scene.Colouring("life in h", log[None, None], *colours, name=name, decades=True)
        for name, log in logs.items()
    ]
    is_long = data.life.isel(survival=-1).values[used] >= BEYOND
    said = "long: life beyond 1e9 h", "how far to trust it"
    colourings.append(shoes.verdict_colouring(data.verdict.values[used], is_long, *said))
    surface = data.node_position.transpose("node", "axis").values[used], (corners.reshape(-1, 3),)
    return scene.Solid("shoe", *surface, "white", colourings=tuple(colourings), nodes=used)


def causes_figure(lives: LifeResults) -> go.Figure:
    """Draw the life under each part of the damage alone by region: one row a part, colours and hours."""
    causes = lives.causes()
    words = causes.map(lambda hours: "" if hours >= BEYOND else cell_text(life_words(hours)))
    coarse = set(lives.table["region"][is_coarse(lives.table)])
    words[[region for region in words.columns if region in coarse]] = COARSE
    decades = np.log10(causes.clip(lower=LEAST_LIFE))
    low = float(decades.min().min())
    high = float(np.log10(BEYOND))
    ticks = np.arange(np.floor(low), high + 1.0)
    bar = {"title": "h", "tickvals": ticks, "ticktext": [f"1e{tick:g}" for tick in ticks]}
    colours = {"zmin": min(low, high - LEAST_DECADES), "zmax": high, "colorscale": "YlOrRd_r"}
    cells = {"x": causes.columns, "y": causes.index, "z": decades, "text": words, "colorbar": bar}
    said = {"texttemplate": "%{text}", "hovertemplate": "%{y}<br>%{x}: %{text}<extra></extra>"}
    figure = go.Figure(go.Heatmap(**cells, **colours, **said))
    figure.update_yaxes(autorange="reversed", automargin=True)
    figure.update_xaxes(side="top")
    height = 120 + 26 * len(causes)
    margin = {"l": 10, "r": 10, "t": 40, "b": 10}
    return figure.update_layout(height=height, margin=margin)


def damage_curves(lives: LifeResults) -> go.Figure:
    """Draw the growing damage of the worst nodes of the table over the runs, each at its worst place."""
    figure = go.Figure()
    runs = [run.name for run in lives.duty.runs]
    for _, row in lives.table.head(DRAWN).iterrows():
        node = int(row["node"])
        place = row["worst place"]
        history = lives.nodes[node].damage_history()
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


def damage_parts(lives: LifeResults) -> pd.DataFrame:
    """Return the share of every run and phase in the damage at the nodes of the table, in per cent."""
    data = lives.dataset.isel(node=lives.table["node"].to_numpy())
    shares = 100.0 * data.part_damage / np.maximum(data.damage_an_hour.isel(survival=-1), 1e-300)
    columns = {f"{name} in %": shares.sel(part=name).values for name in data.part.values}
    return lives.table[["region", "node"]].assign(**columns)


def check_lines(checked: CheckResults) -> list[str]:
    """Return lines on what yields in a checked shoe, and what cracks first without yield.

    Both leave out bores whose stress is not to be used. Above yield, a shoe bends for good: linear stress
    does not hold, and cycles to a crack are formal.
    """
    worst = checked.worst_cycles
    worst = worst[~worst["region"].isin(checked.shoe.unused_regions)]
    peaks = checked.table.set_index(["case", "region"])
    is_above = (worst["above yield"] == "yes").to_numpy()
    lines = []
    if is_above.any():
        row = worst[is_above].iloc[0]
        stress = max(
            float(peaks["von Mises in MPa"].get((row[end], row["region"]), 0.0)) for end in ("from", "to")
        )
        strength = checked.check.material.yield_strength / style.MEGA
        lines.append(
            f"yields: {row['region']}, up to {cell_text(stress)} MPa of linear stress in {row['to']!r}, "
            f"{stress / strength:.2g} times the {cell_text(strength)} MPa at which "
            f"{checked.check.material.name} yields; {int(is_above.sum())} of {len(worst)} cycles do, "
            "whose numbers to a crack are formal"
        )
    if not is_above.all():
        row = worst[~is_above].iloc[0]
        verdict = peaks["verdict"].get((row["to"], row["region"]), "")
        lines.append(
            f"first to crack{' below yield' if lines else ''}: {row['region']}, after "
            f"{cell_text(row[CYCLES])} cycles from {row['from']!r} to {row['to']!r}"
            f"{verdict and f'; stress there {verdict}'}"
        )
    return lines


def check_solid(
    checked: CheckResults, colourings: list[scene.Colouring], bend: np.ndarray | float = 0.0
) -> scene.Solid:
    """Return the surface of a checked shoe, moved by `bend` (nodes, 3), m, with colourings of its nodes."""
    mesh = checked.shoe.mesh
    faces = np.searchsorted(mesh.surface_nodes, flat_triangles(mesh.boundary))
    points = mesh.nodes[mesh.surface_nodes] + bend
    shades = tuple(colourings)
    return scene.Solid("shoe", points, (faces,), "white", colourings=shades, nodes=mesh.surface_nodes)


def write_check_page(checked: CheckResults, path: Path, overwrite: bool = False) -> Path:
    """Write a page of a check: cases in 3D, cycles to a crack, and its tables."""
    colourings = []
    for case, stress in zip(checked.cases, checked.stress, strict=True):
        mises = von_mises(stress) / style.MEGA
        limits = 0.0, style.round_up(float(mises.max())), style.STRESS_MAP
        colourings.append(scene.Colouring("von Mises in MPa", mises[None, None], *limits, name=case.name))
    sections = [
        page.Section("check", "Cases in 3D", page.part("coloured", "check", BY_CASE)),
        page.Section("cycles", "Cycles to a crack", page.table(checked.worst_cycles)),
        page.Section("moments", "Section moments and blows", page.table(checked.moments)),
        page.Section("hertz", "Below a tread", page.table(checked.hertz)),
        page.Section("peaks", "Peaks by region", page.table(checked.table)),
    ]
    lead = [
        *check_lines(checked),
        f"{len(checked.cases)} static cases, mesh {checked.check.mesh}, {checked.check.material.name}",
        f"an hour: cycles that crack 2.5 % of the shoes in {cell_text(checked.check.hours)} h; worst regions",
    ]
    html = _coloured_page(f"Check of {checked.check.name}", lead, sections, check_solid(checked, colourings))
    return page.write_page(html, path, overwrite)


def case_figure(checked: CheckResults, number: int) -> Figure:
    """Draw one case from above and below: von Mises stress on the bent shoe, and its peaks by region."""
    case = checked.cases[number]
    stress = von_mises(checked.stress[number])
    bend = checked.displacement[number]
    larger = style.drawn_scale(bend, BENT)
    high = style.round_up(float(stress.max()) / style.MEGA)
    colouring = scene.Colouring("von Mises stress in MPa", stress / style.MEGA, 0.0, high, style.STRESS_MAP)
    solid = check_solid(checked, [colouring], larger * bend)
    with mpl.rc_context(style.STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(9.0, 7.4))
        axes = figure.subplots(len(VIEWS), 1)
        for ax, (title, (azimuth, elevation)) in zip(axes, VIEWS.items(), strict=True):
            pictures.paint(ax, [solid], scene.View.seen_from(azimuth, elevation), WINDOW)
            ax.set_title(title, loc="left")
            ax.set_axis_off()
        rows = checked.table[checked.table["case"] == case.name]
        peaks = dict(zip(rows["region"], rows["von Mises in MPa"], strict=True))
        unused = {region: peaks.pop(region) for region in checked.shoe.unused_regions if region in peaks}
        words = ", ".join(f"{region} {peak:.0f}" for region, peak in peaks.items()) + " MPa"
        words += "".join(f" ({region} {peak:.0f}, not to be used)" for region, peak in unused.items())
        figure.suptitle(f"{case.name}\n{words}; displacement x {larger:g}", parse_math=False)
        figure.colorbar(style.scale_of(0.0, high, style.STRESS_MAP), ax=axes, label=colouring.title)
    return figure
