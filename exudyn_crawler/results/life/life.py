"""Life of the shoes in machine hours, at every node of their surface, over the runs of a duty.

A shoe takes every place in the track in turn, so that its damage is the mean over the places at which the
runs have flexible shoes. Each run is counted as it repeats itself; what goes from one run to another is a
cycle between their extremes, as often as the duty says.
"""

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.history.catalogue import variable
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.life.duty import Duty
from exudyn_crawler.results.life.duty_runs import UsedRun, positions_of, pulled_nodes, used_runs
from exudyn_crawler.results.life.life_table import (
    BETWEEN,
    BEYOND,
    NodeLife,
    life_hours,
    node_lives,
    shortest_by_region,
    shortest_lives,
    worst_nodes,
)
from exudyn_crawler.results.stress.hot_spots import shoe_regions
from exudyn_crawler.results.stress.recovery import flat_triangles
from fem import Shapes
from fem.critical_plane import critical_planes, damage_on_planes, plane_normals, surface_normals
from fem.damage import damage_between, recover_damage
from fem.fatigue import SNCurve
from fem.trust import Resolution, resolution_over, verdict_numbers, verdict_words


@dataclass(frozen=True)
class LifeTrust:
    """What is open of the lives of n nodes.

    Attributes
    ----------
    stress_error : array (n,)
        Of the changes of stress, over these; not a number where no life is known.
    factor : array (n,)
        By which life may be shorter or longer.
    verdict : int array (n,)
        Numbers of `fem.trust.VERDICTS`, of the changes of stress.
    truncation_known : bool
        Whether what left-out modes do to the stress is in it.
    """

    stress_error: NDArray
    factor: NDArray
    verdict: NDArray
    truncation_known: bool

    def words(self, nodes: NDArray) -> list[str]:
        """Verdicts of some nodes in words."""
        return verdict_words(self.verdict[nodes], self.truncation_known)


@dataclass(frozen=True)
class LifeResults:
    """Life of the shoes over a duty.

    Attributes
    ----------
    duty : Duty
    dataset : xarray.Dataset
        Dimensions shoe (place in the track), survival, part ("run: phase", or "between runs"), node, axis,
        face and corner of the surface's triangles. Variables; not a number inside, and where the drive pulls
        at a single node:

        - damage_an_hour (survival, node), 1/h: mean over the places; place_damage (shoe, survival, node)
        - life (survival, node), h: its reciprocal; 1e9 stands for all beyond
        - part_damage (part, node), 1/h: what each part has in the damage at the greatest survival
        - plane_damage (survival, node), 1/h, and plane_normal (node, axis): on the critical plane, at the
          worst nodes; without what goes from run to run
        - stress_error (node), verdict (node), a number of `fem.trust.VERDICTS`, and life_factor (node), by
          which life may be shorter or longer, as of `trust`
        - node_position (node, axis), m, triangle (face, corner) and in_spider (node), as of stresses
    table : pandas.DataFrame
        Of `life_table.shortest_lives`: the shortest life of every region, and its cause; then the chosen
        nodes.
    nodes : mapping of int to NodeLife
        Cycles and causes at the nodes of the table.
    trust : LifeTrust
        What is open of the lives.
    whole : Shapes
        Modes, and static fields, that the stresses are made of.
    """

    duty: Duty
    dataset: xr.Dataset
    table: pd.DataFrame
    nodes: Mapping[int, NodeLife]
    trust: LifeTrust
    whole: Shapes

    def _repr_html_(self) -> str:
        """Shortest lives and the dataset, for notebooks."""
        return self.table.to_html(index=False) + self.dataset._repr_html_()


def life_of(
    duty: Duty,
    histories: Sequence[History],
    say: Callable[[str], None] = lambda _text: None,
    spreads: Sequence[xr.DataArray | None] | None = None,
) -> LifeResults:
    """Life over a duty whose runs have these histories.

    Parameters
    ----------
    histories : sequence of History
        One for each run of the duty, in its order.
    say : callable
        Called with a line that says what is going on.
    spreads : sequence of DataArray (shoe, node) or None, optional
        Spread of each run's peaks over themselves, as of `spread.relative_spread`; None where not known.

    Raises
    ------
    ValueError
        As of `duty_runs.used_runs`; or if a chosen node is not of the surface.
    """
    runs = used_runs(duty, histories)
    inside = sorted(set(duty.nodes) - set(runs[0].basis.shapes.mesh.surface_nodes.tolist()))
    if inside:
        raise ValueError(f"nodes must be of the surface, got {inside[:5]}")
    curve = duty.material.curve(duty.miner)
    whole, positions = runs[0].basis.shapes, positions_of(runs)
    by_place, by_part, amplitudes = [], [], []
    for shoe in positions:
        say(f"shoe {shoe}: counting cycles of {len(whole.mesh.surface_nodes)} nodes")
        found, own_parts, amplitude = _at_place(duty, runs, curve, shoe)
        by_place.append(found)
        by_part.append(own_parts)
        amplitudes.append(amplitude)
    damage, parts = np.array(by_place), np.mean(by_part, axis=0)
    mean = damage.mean(axis=0)
    names = [f"{one.run.name}: {phase}" for one in runs for phase in one.phases]
    names += [BETWEEN] if len(runs) > 1 else []
    regions = shoe_regions(whole, runs[0].history.case.track)
    shown = list(dict.fromkeys([*shortest_by_region(regions, mean[-1]), *duty.nodes]))
    worst = np.union1d(worst_nodes(mean[-1], duty.plane_nodes), shown)
    say(f"critical planes of the {len(worst)} worst nodes")
    on_plane, directions = _on_critical_planes(duty, runs, curve, worst)
    say("what the mesh leaves open")
    known = [None] * len(runs) if spreads is None else spreads
    trust = life_trust(runs, curve, damage[:, -1], np.array(amplitudes), known)
    dataset = _dataset(whole, damage, parts, on_plane, directions, trust).assign_coords(
        shoe=positions, survival=list(duty.survivals), part=np.array(names, dtype=object)
    )
    say(f"causes at {len(shown)} nodes")
    nodes = node_lives(duty, runs, curve, shown)
    verdicts = dict(zip(shown, trust.words(np.array(shown)), strict=True))
    table = shortest_lives(dataset, nodes, whole, regions, verdicts)
    return LifeResults(duty, dataset.assign_attrs(duty=duty.model_dump_json()), table, nodes, trust, whole)


def _at_place(
    duty: Duty, runs: Sequence[UsedRun], curve: SNCurve, shoe: int
) -> tuple[NDArray, NDArray, NDArray]:
    """Of a shoe that stays at its place: damage an hour, by survival and by part, and the amplitude in Pa.

    Arrays (survivals, nodes), (parts, nodes) and (nodes,).
    """
    whole = runs[0].basis.shapes
    surface = whole.mesh.surface_nodes
    damage = np.zeros((len(duty.survivals), len(surface)))
    parts, highest, lowest = [], np.full(len(surface), -np.inf), np.full(len(surface), np.inf)
    for one in runs:
        counting = one.counting(curve, duty.survivals, 1.0 / BEYOND / len(runs))
        found = recover_damage(
            one.basis.shapes.stress_modes, one.basis.coordinates[shoe], duty.criterion, counting, surface
        )
        each = one.times_an_hour * found.damage.transpose(1, 2, 0)
        damage += each.sum(axis=1)
        parts.extend(each[-1])
        highest, lowest = np.maximum(highest, found.highest), np.minimum(lowest, found.lowest)
    if len(runs) > 1:
        often = min(one.times_an_hour for one in runs)
        often = often if duty.changes_an_hour is None else duty.changes_an_hour
        each = often * damage_between(curve, highest, lowest, duty.survivals)
        damage += each
        parts.append(each[-1])
    unknown = pulled_nodes(runs, shoe)[surface]
    count = len(whole.nodes)
    return (
        _spread(np.where(unknown, np.nan, damage), surface, count),
        _spread(np.array(parts), surface, count),
        _spread(0.5 * (highest - lowest), surface, count),
    )


def _spread(values: NDArray, nodes: NDArray, count: int) -> NDArray:
    """Values (..., k) at some nodes as those (..., count) of all, not a number elsewhere."""
    spread = np.full((*values.shape[:-1], count), np.nan)
    spread[..., nodes] = values
    return spread


def _on_critical_planes(
    duty: Duty, runs: Sequence[UsedRun], curve: SNCurve, nodes: NDArray
) -> tuple[NDArray, NDArray]:
    """Damage an hour (survivals, nodes) on the critical planes of some nodes, and normals (nodes, 3)."""
    mesh, positions = runs[0].basis.shapes.mesh, positions_of(runs)
    normals = surface_normals(mesh)

    def damage_on(nodes: NDArray, angles: NDArray) -> NDArray:
        found = np.zeros((*angles.shape, len(duty.survivals)))
        for one in runs:
            counting = one.counting(curve, duty.survivals, 1.0 / BEYOND / len(runs))
            for shoe in positions:
                modes, q = one.basis.shapes.stress_modes, one.basis.coordinates[shoe]
                each = damage_on_planes(modes, q, normals, angles, counting, nodes)
                found += one.times_an_hour / len(positions) * each
        return found

    planes = critical_planes(damage_on, nodes)
    directions = plane_normals(normals[nodes], planes.angles[:, None])[:, 0]
    count = len(mesh.nodes)
    return _spread(planes.damage.T, nodes, count), _spread(directions.T, nodes, count).T


def _dataset(
    whole: Shapes,
    damage: NDArray,
    parts: NDArray,
    on_plane: NDArray,
    directions: NDArray,
    trust: LifeTrust,
) -> xr.Dataset:
    """Dataset of the damage (places, survivals, nodes), of its parts, on critical planes, and of trust."""
    mean = damage.mean(axis=0)
    values = {
        "place_damage": damage,
        "damage_an_hour": mean,
        "life": life_hours(mean),
        "part_damage": np.where(np.isnan(mean[-1]), np.nan, parts),
        "plane_damage": on_plane,
        "plane_normal": directions,
        "stress_error": trust.stress_error,
        "verdict": trust.verdict,
        "life_factor": trust.factor,
        "node_position": whole.nodes,
        "triangle": flat_triangles(whole.mesh.boundary),
        "in_spider": np.isin(np.arange(len(whole.nodes)), whole.spider_nodes),
    }
    dataset = xr.Dataset({name: variable(name, value) for name, value in values.items()})
    return dataset.assign_coords(node=np.arange(len(whole.nodes)), axis=["x", "y", "z"])


def life_trust(
    runs: Sequence[UsedRun],
    curve: SNCurve,
    damage: NDArray,
    amplitude: NDArray,
    spreads: Sequence[xr.DataArray | None],
) -> LifeTrust:
    """What is open of the lives that the stresses of runs make.

    What the mesh leaves open is that of the stress less its mean over each run and place, in the mean square
    over all of them; what left-out static fields may do counts against the greatest amplitude. Of spreads the
    widest of the runs' counts, at the place that wears a node most.

    Parameters
    ----------
    damage, amplitude : array (places, nodes)
        Damage an hour at each place and half the range of the stress in Pa; not a number inside.
    spreads : sequence of DataArray (shoe, node) or None
        Spread of each run's peaks over themselves, as of `spread.relative_spread`; None where not known.
    """
    whole = runs[0].basis.shapes
    found = reduce(operator.add, map(_resolved_changes, runs))
    known = ~np.isnan(damage).any(axis=0)
    greatest = np.max(np.where(known, amplitude, 0.0), axis=0)
    bounds = [one.basis.bound for one in runs]
    most = max((bound for bound in bounds if bound is not None), default=0.0)
    part = found.error + np.divide(most, greatest, out=np.zeros_like(greatest), where=greatest > 0.0)
    worst = np.argmax(np.where(known, damage, 0.0), axis=0)
    known_spreads = [one.values[worst, np.arange(len(part))] for one in spreads if one is not None]
    part = np.where(known, part + np.max([np.zeros_like(part), *known_spreads], axis=0), np.nan)
    held = np.isin(np.arange(len(part)), whole.spider_nodes) & known
    verdict = verdict_numbers(part, found.error, found.relative_jump, held)
    return LifeTrust(part, (1.0 + part) ** curve.steepest, verdict, None not in bounds)


def _resolved_changes(one: UsedRun) -> Resolution:
    """How far the mesh resolves the stress of a run less its mean at each place."""
    coordinates = one.basis.coordinates.values()
    return resolution_over(one.basis.shapes, np.concatenate([q - q.mean(axis=0) for q in coordinates]))
