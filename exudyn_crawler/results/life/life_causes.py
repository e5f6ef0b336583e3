"""What wears single nodes out: their cycles over a duty, and run, phase, place and load that make them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from exudyn_crawler.results.life.duty import Duty
from exudyn_crawler.results.life.duty_runs import UsedRun, places_of
from exudyn_crawler.results.stress.basis import coordinates_by_load
from exudyn_crawler.results.stress.hot_spots import SHARE, stress_directions
from fem.damage import SIGNED_CRITERIA, signed_signals
from fem.fatigue import SNCurve

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
    places = places_of(runs)
    cycles: dict[int, list[pd.DataFrame]] = {node: [] for node in nodes}
    by_criterion = {node: dict.fromkeys(map(str, SIGNED_CRITERIA), 0.0) for node in nodes}
    for one in runs:
        often = one.times_an_hour / len(places)
        counting = one.counting(curve, duty.survivals[-1:])
        for shoe in places:
            loads = coordinates_by_load(one.history, one.basis, shoe)
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
