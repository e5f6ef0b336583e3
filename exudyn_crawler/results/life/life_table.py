"""Lives of single nodes: their cycles over a duty, what makes them, and the shortest of every region."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.life.duty import Duty
from exudyn_crawler.results.life.duty_runs import UsedRun, positions_of
from exudyn_crawler.results.stress.hot_spots import SHARE, stress_directions
from fem import Shapes
from fem.damage import SIGNED_CRITERIA, signed_signals
from fem.fatigue import SNCurve

BEYOND = 1e9
"""h, beyond which lives are not distinguished; damage below one over it is left out."""
BETWEEN = "between runs"
"""Part of the damage that no run has alone."""
LIFE = "life in h"
"""What the columns of lives begin with."""
CLASSES = 32
"""Of a rainflow matrix, along either side."""
CYCLES = (
    "run",
    "shoe",
    "begin phase",
    "end phase",
    "begin time in s",
    "end time in s",
    "begin in Pa",
    "end in Pa",
    "times an hour",
    "damage an hour",
)


@dataclass(frozen=True)
class NodeLife:
    """Cycles of a node over a duty.

    Attributes
    ----------
    node : int
    cycles : pandas.DataFrame
        A row a cycle: run, shoe (place), phases, times (s) and stresses (Pa) of both ends, how often an hour
        a shoe has it that takes all places, its damage an hour at the greatest survival; "share of LOAD" for
        each load: its part of the range between the two ends, 1 in all and negative where it relieves.
    by_criterion : mapping of str to float
        Damage an hour at the greatest survival by each of `fem.damage.SIGNED_CRITERIA`, without what goes
        from run to run.
    """

    node: int
    cycles: pd.DataFrame
    by_criterion: Mapping[str, float]

    @property
    def load_shares(self) -> dict[str, float]:
        """Part of each load in the damage: its part of the ranges, weighted by the cycles' damage."""
        names = [name for name in self.cycles.columns if name.startswith(SHARE)]
        damage = self.cycles["damage an hour"]
        whole = float(damage.sum())
        if whole == 0.0:
            return {}
        shares = self.cycles[names].fillna(0.0).mul(damage, axis=0).sum() / whole
        return {name.removeprefix(SHARE): float(share) for name, share in shares.items()}

    def rainflow_matrix(self) -> pd.DataFrame:
        """Cycles an hour by the classes that they begin and end in: begin and end in MPa, cycles an hour.

        A row a class that has any, by its middle; `CLASSES` equal ones from the least to the greatest stress.
        """
        ends = self.cycles[["begin in Pa", "end in Pa"]].to_numpy() / 1e6
        low, high = (ends.min(), ends.max()) if len(ends) else (0.0, 0.0)
        edges = np.linspace(low, max(high, low + 1e-6), CLASSES + 1)
        counts, _, _ = np.histogram2d(
            ends[:, 0], ends[:, 1], bins=[edges, edges], weights=self.cycles["times an hour"].to_numpy()
        )
        rows, columns = np.nonzero(counts)
        middles = 0.5 * (edges[1:] + edges[:-1])
        return pd.DataFrame(
            {
                "begin in MPa": middles[rows],
                "end in MPa": middles[columns],
                "cycles an hour": counts[rows, columns],
            }
        )

    def damage_history(self) -> pd.DataFrame:
        """Damage an hour as it grows over each run at each place: half of a cycle's comes at either end."""
        ends = [
            self.cycles[["run", "shoe", f"{end} time in s", "damage an hour"]].set_axis(
                ["run", "shoe", "time in s", "damage an hour"], axis=1
            )
            for end in ("begin", "end")
        ]
        table = pd.concat(ends).assign(**{"damage an hour": lambda one: 0.5 * one["damage an hour"]})
        summed = table.groupby(["run", "shoe", "time in s"], sort=True, as_index=False).sum()
        summed["damage an hour"] = summed.groupby(["run", "shoe"])["damage an hour"].cumsum()
        return summed


def node_lives(
    duty: Duty, runs: Sequence[UsedRun], curve: SNCurve, nodes: Sequence[int]
) -> dict[int, NodeLife]:
    """Cycles and causes at some nodes, with stresses at full rank.

    Parameters
    ----------
    nodes : sequence of int
        Numbers of nodes.
    """
    positions = positions_of(runs)
    cycles: dict[int, list[pd.DataFrame]] = {node: [] for node in nodes}
    by_criterion = {node: dict.fromkeys(map(str, SIGNED_CRITERIA), 0.0) for node in nodes}
    for one in runs:
        often = one.times_an_hour / len(positions)
        counting = one.counting(curve, duty.survivals[-1:])
        for shoe in positions:
            loads = one.basis.by_load(shoe)
            for node in nodes:
                modes = one.basis.shapes.stress_modes[node]
                by_load = {load: q @ modes.T for load, q in loads.items()}
                stress = one.basis.coordinates[shoe] @ modes.T
                cycles[node].append(_cycles(duty, curve, one, shoe, often, stress, by_load))
                for criterion in SIGNED_CRITERIA:
                    found = counting.damage(signed_signals(criterion, stress.T[None])).sum()
                    by_criterion[node][criterion] += often * float(found)
    return {
        node: NodeLife(node, pd.concat(cycles[node], ignore_index=True), by_criterion[node]) for node in nodes
    }


def _cycles(
    duty: Duty,
    curve: SNCurve,
    one: UsedRun,
    shoe: int,
    often: float,
    stress: NDArray,
    by_load: Mapping[str, NDArray],
) -> pd.DataFrame:
    """Cycles of a node's stress (t, 6) over a run, that of single loads beside it."""
    counting = one.counting(curve, duty.survivals[-1:])
    signal = signed_signals(duty.criterion, stress.T[None])[0]
    found = counting.cycles(signal)
    damage = curve.damage(found.amplitude, found.mean, duty.survivals[-1:])[0]
    phase, time = np.array(one.phases, dtype=object)[one.phase], one.history.time.values
    begin, end = found.begin_row, found.end_row
    columns = (
        one.run.name,
        shoe,
        phase[begin],
        phase[end],
        time[begin],
        time[end],
        found.begin,
        found.end,
        often,
        often * damage,
    )
    table = pd.DataFrame(dict(zip(CYCLES, columns, strict=True)), index=range(len(begin)))
    rows = stress_directions(duty.criterion, stress)
    for load, parts in by_load.items():
        of_load = np.einsum("tk,tk->t", rows, parts)
        table[SHARE + load] = (of_load[end] - of_load[begin]) / (found.end - found.begin)
    return table


def life_hours(damage: NDArray | float) -> NDArray:
    """Hours that damages an hour leave; `BEYOND` stands for all beyond."""
    return np.where(damage * BEYOND <= 1.0, BEYOND, 1.0 / np.maximum(damage, 1.0 / BEYOND))


def worst_nodes(damage: NDArray, count: int) -> NDArray:
    """Numbers of the nodes with the greatest damage (n,) at most `count`; what is not a number has none."""
    known = np.flatnonzero(damage > 0.0)
    return known[np.argsort(-damage[known], kind="stable")[:count]]


def shortest_by_region(regions: NDArray, damage: NDArray) -> list[int]:
    """Node of the greatest damage (n,) of each region, the worst first.

    Parameters
    ----------
    regions : array (n,) of str
        Of `regions.shoe_regions`; those without any known damage are left out.
    """
    found = []
    for name in dict.fromkeys(regions):
        own = np.flatnonzero((regions == name) & ~np.isnan(damage))
        if len(own):
            found.append(int(own[damage[own].argmax()]))
    return sorted(found, key=lambda node: -damage[node])


def shortest_lives(
    dataset: xr.Dataset,
    nodes: Mapping[int, NodeLife],
    whole: Shapes,
    regions: NDArray,
    verdicts: Mapping[int, str],
) -> pd.DataFrame:
    """Table of lives and what makes them, of some nodes such as the worst of every region.

    Parameters
    ----------
    regions : array (n,) of str
        Of `regions.shoe_regions`.
    verdicts : mapping of int to str
        How far to trust the stress of each node.

    Returns
    -------
    pandas.DataFrame
        A row a node: region, node and its place in the shoe (m); life (h, 1e9 for
        all beyond) at each survival; the range in which the last of them lies, by what is open of the stress,
        and the verdict; the place in the track that wears it most and the life of a shoe that
        stays there; run and phase with the greatest part of the damage, and that part; the load with the
        greatest part, and the parts of all; life by each criterion at the greatest survival, those signed
        without what goes from run to run; and whether a joint's rigid spider is near.
    """
    rows = []
    for node, life in nodes.items():
        own = dataset.sel(node=node)
        places = own.place_damage.isel(survival=-1)
        parts = own.part_damage
        whole_damage = float(own.damage_an_hour[-1])
        loads = life.load_shares
        row: dict[str, object] = {"region": regions[node], "node": node}
        row |= {f"{axis} in the shoe in m": float(own.node_position.sel(axis=axis)) for axis in "xyz"}
        row |= {_life_at(one): float(own.life.sel(survival=one)) for one in own.survival.values}
        factor = float(own.life_factor)
        row |= {
            f"{LIFE} at least": float(life_hours(whole_damage * factor)),
            f"{LIFE} at most": float(life_hours(whole_damage / factor)),
            "verdict": verdicts[node],
            "worst place": int(places.shoe[int(np.nanargmax(places.values))]),
            f"{LIFE} there": float(life_hours(float(places.max()))),
            "main part": str(parts.part.values[int(parts.values.argmax())]) if whole_damage > 0.0 else "",
            "its share": float(parts.max()) / whole_damage if whole_damage > 0.0 else 0.0,
            "main load": max(loads, key=lambda name: loads[name]) if loads else "",
        }
        row |= {SHARE + name: share for name, share in loads.items()}
        row |= {f"{LIFE}, {name}": float(life_hours(one)) for name, one in life.by_criterion.items()}
        row[f"{LIFE}, critical plane"] = float(life_hours(float(own.plane_damage[-1])))
        row["flag"] = _flag(whole, node)
        rows.append(row)
    return pd.DataFrame(rows)


def _life_at(survival: float) -> str:
    return f"{LIFE} that {100.0 * survival:g} % survive"


def _flag(whole: Shapes, node: int) -> str:
    """Whether a joint's rigid spider makes the stress of a node, in words of the hot spots."""
    if node in whole.spider_nodes:
        return "in spider"
    return "beside spider" if node in whole.nodes_beside_spiders else ""


def in_words(table: pd.DataFrame) -> pd.DataFrame:
    """Same table with lives as they are read: four digits, "beyond 1e9"."""
    lives = [name for name in table.columns if name.startswith(LIFE)]
    return table.assign(**{name: table[name].map(life_words) for name in lives})


def life_words(hours: float) -> str:
    """Life in h for reading."""
    if np.isnan(hours):
        return "not known"
    return "beyond 1e9" if hours >= BEYOND else f"{hours:.4g}"
