"""Life of the shoes in machine hours, at every node of their surface, over the runs of a duty.

A shoe takes every place in the track in turn: its damage is the mean over the places of the flexible shoes.
Each run repeats, and each check case is a cycle. Cycles from one run or case to another replace the cycles
that they combine (`fem.fatigue.changes`). Stages of wear add up by Miner's rule. The life is zero above the
tensile strength.
"""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from scipy.spatial import cKDTree

from exudyn_crawler.case import Track
from exudyn_crawler.results.history import History, catalogue
from exudyn_crawler.results.life.duty import Duty
from exudyn_crawler.results.life.duty_runs import (
    BETWEEN,
    NodeLife,
    UsedRun,
    mixed_cycles,
    node_lives,
    used_cases,
    used_runs,
)
from exudyn_crawler.results.stress import hot_spots
from fem import Shapes, SNCurve
from fem.fatigue import critical_plane, defects
from fem.fatigue.changes import PassEnds
from fem.fatigue.damage import SIGNED_CRITERIA, damage_of_changes, recover_damage
from fem.stress import low_rank, trust

BEYOND = 1e9  # greatest distinguished life, h; a damage below its reciprocal is left out
BROKEN = 0.0  # life at a stress above the tensile strength, h
CHOICE_OF_PINS = {"rigid": (0.26, 3.9), "averaging": (0.06, 1.7), "contact": (0.0, 0.0)}
"""Greatest excess of a lug's stress with a pin in contact over that with a coupling, fraction of this.

The first is that of a lug's root, the second that within a diameter from the axis of a bore (`docs/fem.md`).
"""
COARSE = "mesh too coarse"
"""Words in place of hours where the mesh is too coarse for them."""
MEGA = 1e6
MILLI = 1e-3
LIFE = "life in h"  # prefix of the columns of lives
PEAK, EXCEEDS = "peak in MPa", "above"
YIELD, TENSILE = "yield strength", "tensile strength"
"""Columns of the greatest stress and of the strength that it exceeds, and names of the strengths."""


@dataclass(frozen=True)
class LifeResults:
    """Life of the shoes over a duty.

    `dataset` has the catalogue's quantities of life. Its dimensions are shoe (place in the track), survival,
    part, node, axis, and face and corner of the surface's triangles. A part is "run: phase", each as if
    alone, or "between runs", the addition by their mixing. Values are NaN inside, and where the drive pulls
    at a single node. `damage_an_hour` is the mean of `place_damage` over the places. `life` is its
    reciprocal, or 0 where `part_peak` exceeds the tensile strength. `plane_damage` is known at the worst
    nodes, without cycles from run to run. `stress_error`, `verdict` and `life_factor` tell the uncertainty of
    the life.
    """

    duty: Duty
    dataset: xr.Dataset
    table: pd.DataFrame  # result of `shortest_lives`: the worst node of every region; then the chosen nodes
    nodes: Mapping[int, NodeLife]  # cycles and causes at the nodes of the table, in the last stage
    runs: Sequence[UsedRun]  # runs and check cases, in the last stage
    regions: np.ndarray  # (nodes,) of str

    @property
    def whole(self) -> Shapes:
        """Modes and static fields as the basis of the stresses in the last stage."""
        return self.runs[0].basis.shapes

    def causes(self) -> pd.DataFrame:
        """Return the shortest life in h of each region (columns) by each part of the damage alone.

        The shortest come first; 1e9 stands for all longer lives, 0 for a break. With stages a part sums over
        them, by its damage until the crack.
        """
        names = list(self.dataset.part.values)
        for stage in self.duty.stages:
            names = [name.removeprefix(f"{stage.name}, ") for name in names]
        damage = pd.DataFrame(self.dataset.part_damage.values).groupby(names, sort=False).sum()
        lives = damage.T.groupby(self.regions).max().T.map(life_hours)
        peaks = pd.DataFrame(self.dataset.part_peak.values).groupby(names, sort=False).max()
        breaks = self.duty.material.tensile_strength < peaks.T.groupby(self.regions).max().T
        lives = lives.mask(breaks, BROKEN)
        lives = lives.loc[lives.min(axis=1).sort_values(kind="stable").index]
        return lives[lives.min(axis=0).sort_values(kind="stable").index].rename_axis(index="part")

    def _repr_html_(self) -> str:
        """Return the shortest lives and the dataset, as HTML for notebooks."""
        return self.table.to_html(index=False) + self.dataset._repr_html_()


def life_of(
    duty: Duty,
    histories: Sequence[History],
    say: Callable[[str], None] = lambda _text: None,
    spreads: Sequence[xr.DataArray | None] = (),
    shapes: Shapes | None = None,
) -> LifeResults:
    """Return the life over a duty without stages, from the histories of its runs in the duty's order.

    `say` gets lines on the progress. `spreads` are `relative_spread` (shoe, node) of each run, None if
    unknown. `shapes` has the columns of the duty's `check_cases_of`. ValueError as in `duty_runs.used_runs`
    and `used_cases`, or if a chosen node is not on the surface.
    """
    runs = used_runs(duty, histories) if duty.runs else []
    if shapes is not None:
        runs += used_cases(duty, shapes, runs)
    basis = runs[0].basis
    whole = basis.shapes
    surface = basis.shapes.mesh.surface_nodes
    history = basis.history
    if inside := sorted(set(duty.nodes) - set(surface.tolist())):
        raise ValueError(f"nodes must be on the surface, got {inside[:5]}")
    regions = hot_spots.shoe_regions(whole, Track.ph4100c() if history is None else history.case.track)
    groups = _groups(duty, regions, surface)
    at_places = []
    for shoe in basis.coordinates:
        say(f"shoe {shoe}: counting cycles of {len(surface)} nodes")
        at_places.append(_at_place(duty, runs, groups, shoe))
    damage, parts, amplitude, peaks = (np.array(column) for column in zip(*at_places, strict=True))
    mean = damage.mean(axis=0)
    peak = np.where(np.isnan(mean[-1]), np.nan, peaks.max(axis=0))
    breaks = peak.max(axis=0) > duty.material.tensile_strength
    known = _worst_first(np.where(breaks, np.inf, mean[-1]))
    shown = _shown(known, regions, duty, whole)
    worst = np.union1d(known.index[known > 0.0][: duty.plane_nodes], shown)
    say(f"critical planes of the {len(worst)} worst nodes")
    on_plane, directions = _on_critical_planes(duty, runs, groups, worst)
    say("uncertainty by the mesh")
    values = {
        "place_damage": damage,
        "damage_an_hour": mean,
        "life": np.where(breaks, BROKEN, life_hours(mean)),
        "part_damage": np.where(np.isnan(mean[-1]), np.nan, parts.mean(axis=0)),
        "part_peak": peak,
        "plane_damage": on_plane,
        "plane_normal": directions,
        **_life_trust(runs, next(iter(groups)), damage[:, -1], amplitude, spreads, regions),
    }
    names = [part for run in runs for part in run.parts] + [BETWEEN] * (len(runs) > 1)
    variables = {name: catalogue.variable(name, value) for name, value in values.items()}
    dataset = hot_spots.mesh_dataset(whole).assign(variables)
    dataset = dataset.assign_attrs(duty=duty.model_dump_json()).assign_coords(
        shoe=[*basis.coordinates], survival=list(duty.survivals), part=np.array(names, dtype=object)
    )
    say(f"causes at {len(shown)} nodes")
    nodes = node_lives(duty, runs, _curves(duty, regions, shown))
    life = LifeResults(
        duty, dataset, shortest_lives(duty, dataset, nodes, runs, regions), nodes, runs, regions
    )
    return _with_castings(life, [life], [np.arange(len(whole.nodes))])


def _curves(duty: Duty, regions: np.ndarray, nodes: np.ndarray | list[int]) -> dict[int, SNCurve]:
    """Return the S-N curves of nodes, by their regions."""
    of_regions = {region: duty.material.curve(duty.miner, region) for region in set(regions[nodes])}
    return {node: of_regions[regions[node]] for node in nodes}


def _groups(duty: Duty, regions: np.ndarray, surface: np.ndarray) -> dict[SNCurve, np.ndarray]:
    """Return the nodes of the surface by their S-N curve."""
    nodes = pd.Series(_curves(duty, regions, surface))
    return {curve: group.index.to_numpy() for curve, group in nodes.groupby(nodes, sort=False)}


def _with_castings(
    lives: LifeResults, stages: Sequence[LifeResults], nearest: Sequence[np.ndarray]
) -> LifeResults:
    """Return the lives with residual stress, defect and life with the defect in the table, for castings.

    The cycles are those at the nodes of the table, and at their `nearest` nodes of earlier stages.
    """
    duty = lives.duty
    material = lives.duty.material
    rows = []
    if not any(cast_part.defect_size or cast_part.residual_stress for cast_part in material.castings):
        return lives
    lasting = [*(stage.hours for stage in duty.stages[:-1]), np.inf]
    known = (
        lives.table[name]
        for name in ("region", "node", EXCEEDS, f"{LIFE} that {100.0 * duty.survivals[-1]:g} % survive")
    )
    for region, node, exceeds, sound in zip(*known, strict=True):
        cycles = []
        for stage_life, near, hours in zip(stages, nearest, lasting, strict=True):
            neighbour = int(near[node])
            curve = material.curve(duty.miner, region)
            by_node = (
                lives.nodes
                if stage_life is stages[-1]
                else node_lives(stage_life.duty, stage_life.runs, {neighbour: curve})
            )
            names = ("begin in Pa", "end in Pa", "times an hour")
            begin, end, rate = (by_node[neighbour].cycles[name].to_numpy(dtype=float) for name in names)
            cycles.append(defects.CycleStage(begin, end, rate, hours))
        life = material.defect_life(region, duty.miner, cycles, duty.survivals[-1])
        life = np.minimum(life, sound) if exceeds == TENSILE else life
        casting = material.casting(region)
        row = {"residual stress in MPa": casting.residual_stress / MEGA}
        rows.append(row | {"defect in mm": casting.defect_size / MILLI, f"{LIFE}, defect": min(life, BEYOND)})
    return replace(lives, table=pd.concat((lives.table, pd.DataFrame(rows)), axis=1))


def _worst_first(damage: np.ndarray) -> pd.Series:
    """Return the known damages of (nodes,) by node, in falling order; those of broken nodes are infinite."""
    return pd.Series(damage).dropna().sort_values(ascending=False, kind="stable")


def _shown(known: pd.Series, regions: np.ndarray, duty: Duty, whole: Shapes) -> list[int]:
    """Return the worst node of every region, the worst first, then the duty's chosen nodes.

    `known` has the damages in falling order. The worst node of the bores comes after those of other regions:
    its stress beside a pin coupling is not used.
    """
    shortest = known.groupby(regions[known.index], sort=False).head(1).index.tolist()
    held = set(whole.held_nodes.tolist())
    usable = [node for node in shortest if node not in held]
    return list(dict.fromkeys([*usable, *shortest, *duty.nodes]))


def life_of_stages(duty: Duty, stages: Sequence[LifeResults]) -> LifeResults:
    """Return the life over stages of wear from the life of each alone: the damage of a node adds up to 1.

    The result is on the mesh of the last stage; a node stands for the nearest one of the same region in
    earlier stages. `damage_an_hour` and its parts are means until the crack; names of parts begin with their
    stage. Planes, the uncertainty of the stress, and cycles at nodes are those of the last stage. ValueError
    if stages have flexible shoes at different places in the track.
    """
    last = stages[-1]
    if any(stage.dataset.shoe.values.tolist() != last.dataset.shoe.values.tolist() for stage in stages):
        raise ValueError("all stages must have flexible shoes at the same positions in the track")
    nearest = [nearest_nodes(stage, last) for stage in stages]
    each = [stage.dataset.isel(node=k) for stage, k in zip(stages, nearest, strict=True)]
    damage = np.stack([data.damage_an_hour.values for data in each])
    strength = duty.material.tensile_strength
    breaks = np.stack([data.part_peak.max("part").values > strength for data in each])[:, None]
    spent = hours_in_stages(np.where(breaks, np.inf, damage), [stage.hours for stage in duty.stages])
    hours = spent.sum(axis=0)
    # for nodes that break at once the first stage counts
    first = np.eye(len(damage))[0][:, None, None]
    shares = np.where(hours > 0.0, spent / np.maximum(hours, np.finfo(float).tiny), first)
    mean = (shares * damage).sum(axis=0)
    broken = (breaks & (np.cumsum(spent, axis=0) >= hours)).any(axis=0)
    parts = [share[-1] * data.part_damage.values for share, data in zip(shares, each, strict=True)]
    of_stages = zip(duty.stages, each, strict=True)
    names = [f"{stage.name}, {part}" for stage, data in of_stages for part in data.part.values]
    values = {
        "place_damage": sum(
            share * data.place_damage.values for share, data in zip(shares, each, strict=True)
        ),
        "damage_an_hour": mean,
        "life": np.where(broken, np.where(np.isnan(mean), np.nan, hours), life_hours(mean)),
        "part_damage": np.concatenate(parts),
        "part_peak": np.concatenate([data.part_peak.values for data in each]),
    }
    worst = np.divide(1.0, hours[-1], out=np.full(mean[-1].shape, np.inf), where=hours[-1] > 0.0)
    worst = np.where(broken[-1], worst, mean[-1])
    known = _worst_first(np.where(np.isnan(mean[-1]), np.nan, worst))
    shown = _shown(known, last.regions, duty, last.whole)
    nodes = dict(last.nodes)
    if more := [node for node in shown if node not in nodes]:
        nodes |= node_lives(last.duty, last.runs, _curves(duty, last.regions, more))
        groups = _groups(duty, last.regions, last.whole.mesh.surface_nodes)
        planes = _on_critical_planes(last.duty, last.runs, groups, np.array(more))
        for name, array in zip(("plane_damage", "plane_normal"), planes, strict=True):
            values[name] = np.where(np.isnan(array), last.dataset[name].values, array)
    nodes = {node: nodes[node] for node in shown}  # the worst first
    dataset = last.dataset.drop_dims("part").assign_coords(part=np.array(names, dtype=object))
    dataset = dataset.assign({name: catalogue.variable(name, value) for name, value in values.items()})
    dataset = dataset.assign_attrs(duty=duty.model_dump_json())
    table = shortest_lives(duty, dataset, nodes, last.runs, last.regions)
    life = replace(last, duty=duty, dataset=dataset, table=table, nodes=nodes)
    return _with_castings(life, stages, nearest)


def hours_in_stages(damage: np.ndarray, hours: Sequence[float]) -> np.ndarray:
    """Return the hours (stages, ...) in each stage until damages an hour (stages, ...) add up to 1.

    The last stage goes on, to `BEYOND` at most. A stage of infinite damage has zero hours.
    """
    rest = np.ones(damage.shape[1:])
    spent = np.zeros(damage.shape)
    for k, rate in enumerate(damage):
        until = rest / np.maximum(rate, 1.0 / BEYOND)
        spent[k] = until if k == len(damage) - 1 else np.minimum(until, hours[k])
        used = np.multiply(spent[k], rate, out=np.ones(rate.shape), where=np.isfinite(rate))
        rest = np.maximum(rest - used, 0.0)
    return spent


def nearest_nodes(stage: LifeResults, last: LifeResults) -> np.ndarray:
    """Return for each node of the last stage the nearest surface node of a stage, same region: (nodes,)."""
    nodes = np.arange(len(last.whole.nodes))
    if stage.whole.mesh.digest == last.whole.mesh.digest:
        return nodes
    surface = stage.whole.mesh.surface_nodes
    for region in np.unique(last.regions):
        here = np.flatnonzero(last.regions == region)
        candidates = surface[stage.regions[surface] == region]
        candidates = candidates if len(candidates) else surface
        nodes[here] = candidates[cKDTree(stage.whole.nodes[candidates]).query(last.whole.nodes[here])[1]]
    return nodes


def _at_place(
    duty: Duty, runs: Sequence[UsedRun], groups: Mapping[SNCurve, np.ndarray], shoe: int
) -> list[np.ndarray]:
    """Return damage an hour of a shoe by survival and by part, amplitudes, and peaks of stress by part.

    The arrays are (survivals, nodes), (parts, nodes), (nodes,) and (parts, nodes); stresses are in Pa.
    """
    whole = runs[0].basis.shapes
    surface = np.concatenate([*groups.values()])
    of_groups = zip(*(_of_group(duty, runs, *group, shoe) for group in groups.items()), strict=True)
    quantities = [_spread(np.concatenate(pieces, axis=-1), surface, len(whole.nodes)) for pieces in of_groups]
    for run in runs:
        if run.basis.history is not None:
            quantities[0][:, hot_spots.near_pull(run.basis.history, whole, shoe)] = np.nan
    return quantities


def _of_group(
    duty: Duty, runs: Sequence[UsedRun], curve: SNCurve, surface: np.ndarray, shoe: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the values of `_at_place` for nodes of the surface with the same S-N curve."""
    parts, ends, peaks = [], [], []  # (survivals, phases, nodes); ends of passes; (phases, nodes)
    negligible = negligible_damage(runs)
    for run in runs:
        counting = run.counting(curve, duty.survivals, negligible)
        modes = run.basis.shapes.stress_modes
        q = run.basis.coordinates[shoe]
        recovery = recover_damage(modes, q, duty.criterion, counting, surface)
        parts.append(run.times_an_hour * recovery.damage.transpose(1, 2, 0))
        ends.append(recovery.ends)
        peak = np.maximum(np.abs(recovery.ends.lowest), np.abs(recovery.ends.highest))
        peaks.append(np.tile(peak, (len(run.parts), 1)))
    passes = PassEnds.stacked(ends)
    if len(runs) > 1:
        mixed = mixed_cycles(duty, runs, passes)
        parts.append(damage_of_changes(mixed, curve, duty.survivals, len(surface))[:, None])
        peaks.append(np.zeros((1, len(surface))))
    damage = sum((each.sum(axis=1) for each in parts), start=np.zeros((len(duty.survivals), len(surface))))
    # replaced cycles may be so small that they were not counted
    damage = np.maximum(damage, 0.0)
    amplitude = 0.5 * (passes.highest.max(axis=0) - passes.lowest.min(axis=0))
    return damage, np.concatenate([each[-1] for each in parts]), amplitude, np.concatenate(peaks)


def negligible_damage(runs: Sequence[UsedRun]) -> float:
    """Return the greatest omitted damage a pass; all passes of an hour together omit one over `BEYOND`."""
    return 1.0 / BEYOND / sum(run.times_an_hour for run in runs)


def _spread(values: np.ndarray, nodes: np.ndarray, count: int) -> np.ndarray:
    """Return values (..., k) at some nodes as values (..., count) at all, NaN elsewhere."""
    spread = np.full((*values.shape[:-1], count), np.nan)
    spread[..., nodes] = values
    return spread


def _on_critical_planes(
    duty: Duty, runs: Sequence[UsedRun], groups: Mapping[SNCurve, np.ndarray], nodes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return damage an hour (survivals, nodes) on critical planes of some nodes, and normals (nodes, 3)."""
    negligible = negligible_damage(runs)
    mesh = runs[0].basis.shapes.mesh
    normals = critical_plane.surface_normals(mesh)

    def damage_on(nodes: np.ndarray, angles: np.ndarray) -> np.ndarray:
        damage = np.zeros((*angles.shape, len(duty.survivals)))
        for run, (curve, there) in itertools.product(runs, groups.items()):
            rows = np.flatnonzero(np.isin(nodes, there))
            counting = run.counting(curve, duty.survivals, negligible)
            modes = run.basis.shapes.stress_modes
            coordinates = run.basis.coordinates
            for q in coordinates.values() if len(rows) else ():
                of_own = modes, q, normals, angles[rows], counting, nodes[rows]
                each = critical_plane.damage_on_planes(*of_own)
                damage[rows] += run.times_an_hour / len(coordinates) * each
        return damage

    planes = critical_plane.critical_planes(damage_on, nodes)
    directions = critical_plane.plane_normals(normals[nodes], planes.angles[:, None])[:, 0]
    count = len(mesh.nodes)
    return _spread(planes.damage.T, nodes, count), _spread(directions.T, nodes, count).T


def relative_spread(dataset: xr.Dataset) -> xr.DataArray:
    """Return the relative spread of each node's greatest stress by starts and laws together: (shoe, node)."""
    size = np.maximum(dataset.peak_von_mises, np.finfo(float).tiny)
    return ((dataset.peak_spread + dataset.peak_choice) / size).transpose("shoe", "node")


def _life_trust(
    runs: Sequence[UsedRun],
    curve: SNCurve,
    damage: np.ndarray,
    amplitude: np.ndarray,
    spreads: Sequence[xr.DataArray | None],
    regions: np.ndarray,
) -> dict[str, np.ndarray]:
    """Return the uncertainty of lives from damage (1/h) and amplitude (Pa), (places, nodes), as quantities.

    The mesh error is the mean square over all runs and places, of the stress less its mean over each of them.
    The error by omitted static fields is relative to the greatest amplitude. The widest spread of the runs
    counts, at the place with a node's greatest damage. The factor of lives also has the error by the coupling
    of the pins.
    """
    resolved = [trust.resolution_over(run.basis.shapes, _changes(run.basis.coordinates)) for run in runs]
    resolution = sum(resolved[1:], start=resolved[0])
    error = trust.with_bores(resolution.error, runs[0].basis.shapes)
    known = ~np.isnan(damage).any(axis=0)
    greatest = np.max(np.where(known, amplitude, 0.0), axis=0)
    most = max(run.basis.bound or 0.0 for run in runs)
    part = error + np.divide(most, greatest, out=np.zeros_like(greatest), where=greatest > 0.0)
    worst = np.argmax(np.where(known, damage, 0.0), axis=0)
    known_spreads = [spread.values[worst, np.arange(len(part))] for spread in spreads if spread is not None]
    part = np.where(known, part + np.max([np.zeros_like(part), *known_spreads], axis=0), np.nan)
    held = np.isin(np.arange(len(part)), runs[0].basis.shapes.held_nodes) & known
    return {
        "stress_error": part,
        "verdict": trust.verdict_numbers(part, error, resolution.relative_jump, held),
        "life_factor": (1.0 + part + _choice_of_pins(runs[0].basis.shapes, regions)) ** curve.steepest,
    }


def _choice_of_pins(whole: Shapes, regions: np.ndarray) -> np.ndarray:
    """Return the relative error (n,) of a shoe's stress by the coupling of its pins: zero off its lugs."""
    at_root, near_bore = CHOICE_OF_PINS[whole.interfaces[0].spider]
    nearest = np.full(len(regions), np.inf)
    for interface in whole.interfaces:
        x, _, z = (whole.nodes - interface.center).T
        away = np.hypot(x, z)
        nearest = np.minimum(nearest, away / away[interface.nodes].mean())
    error = np.where(nearest < 2.0, near_bore, at_root)
    return np.where(np.isin(regions, ["lugs", hot_spots.BORES]), error, 0.0)


def _changes(coordinates: Mapping[int, Any]) -> Iterator[np.ndarray]:
    """Yield the coordinates of a run's shoes less their means, in segments."""
    for q in coordinates.values():
        mean = sum(rows.sum(axis=0) for rows in low_rank.segments(q)) / len(q)
        yield from (rows - mean for rows in low_rank.segments(q))


def life_hours(damage: np.ndarray | float) -> np.ndarray:
    """Return the lives in h at damages an hour; `BEYOND` stands for all longer ones."""
    return np.where(damage * BEYOND <= 1.0, BEYOND, 1.0 / np.maximum(damage, 1.0 / BEYOND))


def shortest_lives(
    duty: Duty,
    dataset: xr.Dataset,
    nodes: Mapping[int, NodeLife],
    runs: Sequence[UsedRun],
    regions: np.ndarray,
) -> pd.DataFrame:
    """Return a table of lives and their causes at some nodes, such as the worst of every region.

    A row has these values of a node:

    - region, number, and place in the shoe (m)
    - life (h; 1e9 for all longer ones, 0 for a break) at each survival, its range at the last survival by the
      uncertainty of the stress, and the verdict
    - greatest von Mises stress of all runs, and the strength that it exceeds
    - place in the track with the greatest damage, and life of a shoe that stays there
    - run and phase, and load, with the greatest fraction of the damage, and the fractions of all loads
    - life by each criterion; that by the critical plane is without cycles from run to run
    - flag of a node in, or beside, a joint's rigid spider
    """
    whole = runs[0].basis.shapes
    data = dataset.sel(node=list(nodes))
    damage = data.damage_an_hour.values[-1]
    factor = data.life_factor.values
    places = data.place_damage.isel(survival=-1)
    parts = data.part_damage
    shares = [node_life.load_shares for node_life in nodes.values()]
    columns = {"region": regions[data.node], "node": data.node.values}
    columns |= hot_spots.in_the_shoe(data.node_position)
    for survival, lives in zip(data.survival.values, data.life.values, strict=True):
        columns[f"{LIFE} that {100.0 * survival:g} % survive"] = lives
    peak = np.maximum(data.part_peak.max("part").values, [node_life.peak for node_life in nodes.values()])
    material = duty.material
    exceeds = np.select(
        [peak > material.tensile_strength, peak > material.yield_strength], [TENSILE, YIELD], ""
    )
    columns |= {
        f"{LIFE} at least": life_hours(damage * factor),
        f"{LIFE} at most": life_hours(damage / factor),
        PEAK: peak / MEGA,
        EXCEEDS: exceeds,
        "verdict": trust.verdict_words(data.verdict, all(run.basis.bound is not None for run in runs)),
        "worst place": places.shoe.values[np.nanargmax(places, axis=0)],
        f"{LIFE} there": life_hours(places.max("shoe").values),
        "main part": np.where(damage > 0.0, parts.part.values[parts.values.argmax(axis=0)], ""),
        "its share": np.divide(parts.max("part"), damage, out=np.zeros(len(nodes)), where=damage > 0.0),
        "main load": [max(loads, key=lambda name: loads[name], default="") for loads in shares],
    }
    columns |= pd.DataFrame(shares).add_prefix(hot_spots.SHARE).to_dict("series")
    for name in SIGNED_CRITERIA:
        columns[f"{LIFE}, {name}"] = life_hours(
            np.array([node_life.by_criterion[name] for node_life in nodes.values()])
        )
    columns[f"{LIFE}, critical plane"] = life_hours(data.plane_damage.values[-1])
    broken = data.part_peak.max("part").values > material.tensile_strength
    shortest = data.life.values[-1]
    columns |= {
        name: np.where(broken, np.minimum(hours, shortest), hours)
        for name, hours in columns.items()
        if name.startswith(LIFE)
    }
    beside = np.where(np.isin(data.node, whole.nodes_beside_spiders), "beside spider", "")
    columns["flag"] = np.where(np.isin(data.node, whole.held_nodes), trust.IN_SPIDER, beside)
    return pd.DataFrame(columns)


def in_words(table: pd.DataFrame) -> pd.DataFrame:
    """Return the table with lives for reading: four digits, or words such as "beyond 1e9"."""
    lives = [name for name in table.columns if name.startswith(LIFE)]
    return table.assign(**{name: table[name].map(life_words) for name in lives})


def for_reading(table: pd.DataFrame) -> pd.DataFrame:
    """Return the table `in_words`, without hours where the verdict calls the mesh too coarse."""
    shown = in_words(table)
    coarse = is_coarse(table)
    lives = [name for name in table.columns if name.startswith(LIFE)]
    return shown.assign(
        **{name: shown[name].mask(coarse & (table[name] != BROKEN), COARSE) for name in lives}
    )


def is_coarse(table: pd.DataFrame) -> pd.Series:
    """Return True for rows of a table whose verdict calls the mesh too coarse."""
    return table["verdict"].str.startswith(trust.VERDICTS[trust.LIMITED])


def life_words(hours: float) -> float | str:
    """Return the life in h with four digits, or words for an unknown life, a break, or one beyond 1e9 h."""
    if np.isnan(hours):
        return "not known"
    if hours == BROKEN:
        return "breaks"
    return "beyond 1e9" if hours >= BEYOND else float(f"{hours:.4g}")
