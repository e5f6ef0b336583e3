"""Runs and check cases of a duty for the count of damage: repeated parts, and cycles of single nodes."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.sparse import csr_array

from exudyn_crawler.model.flexible_shoes import shoe_model
from exudyn_crawler.results.history.history import History, phases
from exudyn_crawler.results.life.duty import UNLOADED, Duty, DutyCase, DutyRun
from exudyn_crawler.results.loads.kinds import Kind
from exudyn_crawler.results.stress.basis import StressBasis, parts_of, stress_basis
from exudyn_crawler.results.stress.hot_spots import SHARE, stress_directions
from fem import Counting, Shapes, SNCurve
from fem.fatigue import damage
from fem.fatigue.changes import Changes, EndsTracker, PassEnds, changes
from fem.fatigue.rainflow import repeated_cycles

SAME_TIME = 1e-9  # greatest relative difference of times that count as the same
LEAST_TIMES = 3  # least number of stored times that can hold a cycle
BETWEEN = "between runs"  # name of cycles that no run or check case closes alone
CLASSES = 32  # number of classes of a rainflow matrix along each side


@dataclass(frozen=True)
class UsedRun:
    """Repeated part of a run, or a check case as three states: before, loaded, before again."""

    run: DutyRun | DutyCase
    basis: StressBasis
    times_an_hour: float
    phase: pd.Categorical  # (times,), names of the reached phases; for a check case its own name
    time: np.ndarray  # (times,), s

    @property
    def parts(self) -> list[str]:
        """Names of the parts of the damage."""
        of_run = [f"{self.run.name}: {phase}" for phase in self.phase.categories]
        return of_run if isinstance(self.run, DutyRun) else [self.run.name]

    def counting(self, curve: SNCurve, survivals: tuple[float, ...], negligible: float) -> Counting:
        """Return the rules to count its cycles; omitted cycles do at most a `negligible` damage a pass."""
        return Counting(curve, survivals, self.phase.codes, negligible)


def used_runs(duty: Duty, histories: Sequence[History]) -> list[UsedRun]:
    """Return the repeated parts of the histories of a duty's runs, in the duty's order.

    ValueError if a run has no flexible shoes, does not reach its part, or holds no cycle in it. ValueError
    also if shoes, mesh or elastic constants differ among runs, or if the runs together take more than an
    hour.
    """
    parts = [_part(run, history) for run, history in zip(duty.runs, histories, strict=True)]
    _check_shoes(duty.runs, parts)
    times = duty.times_an_hour([float(part.time[-1] - part.time[0]) for part in parts])
    return [
        UsedRun(run, stress_basis(part), often, _phases(whole, part), part.time.values)
        for run, whole, part, often in zip(duty.runs, histories, parts, times, strict=True)
    ]


def used_cases(duty: Duty, shapes: Shapes, runs: Sequence[UsedRun]) -> list[UsedRun]:
    """Return the check cases of a duty at all places of its runs, by `shapes` for `check_cases_of`.

    ValueError if the runs' shoes have another mesh or another coupling of their pins.
    """
    places = [*runs[0].basis.coordinates] if runs else [1]
    columns = check_cases_of(duty)
    if runs and runs[0].basis.shapes.mesh.digest != shapes.mesh.digest:
        raise ValueError(
            f"runs and check cases must have the same mesh, got {len(runs[0].basis.shapes.nodes)} nodes of "
            f"{runs[0].run.name!r} and {len(shapes.nodes)} of {duty.check!r}"
        )
    if runs and (held := pins_of(runs[0].basis.shapes)) != pins_of(shapes):
        raise ValueError(
            f"runs and check cases must have the same pins, got {held!r} of {runs[0].run.name!r} and "
            f"{pins_of(shapes)!r} of {duty.check!r}: both give other stresses at lugs and bores"
        )
    used = []
    for case in duty.cases:
        q = np.zeros((3, len(columns)))
        q[1, columns.index(case.case)] = case.load
        if case.after != UNLOADED:
            q[::2, columns.index(case.after)] = case.load
        loads = {place: {Kind.CHECK_CASES: csr_array(q)} for place in places}
        basis = StressBasis(shapes, loads, np.eye(len(columns)), dict.fromkeys(places, q), 0.0)
        used.append(UsedRun(case, basis, case.an_hour, pd.Categorical([case.case] * 3), np.arange(3.0)))
    return used


def pins_of(shapes: Shapes) -> str:
    """Return the coupling of pins and bores of a shoe."""
    return shapes.interfaces[0].spider


def check_cases_of(duty: Duty) -> list[str]:
    """Return the names of the check cases that a duty needs, each once."""
    names = [name for case in duty.cases for name in (case.case, case.after)]
    return [name for name in dict.fromkeys(names) if name != UNLOADED]


def _part(run: DutyRun, history: History) -> History:
    """Return the part of a run's history that a duty repeats."""
    duration = history.duration
    if run.end is not None and run.end > duration * (1.0 + SAME_TIME):
        raise ValueError(
            f"run {run.name!r} must reach its end = {run.end:g} s, its history has {duration:g} s"
        )
    time = history.time.values
    end = duration if run.end is None else run.end
    rows = np.flatnonzero((time >= run.begin * (1.0 - SAME_TIME)) & (time <= end * (1.0 + SAME_TIME)))
    if len(rows) < LEAST_TIMES:
        raise ValueError(
            f"run {run.name!r} must have at least {LEAST_TIMES} stored times from {run.begin:g} to {end:g} s "
            f"to hold a cycle, got {len(rows)}"
        )
    return History(history.case, history.dataset.isel(time=slice(rows[0], rows[-1] + 1)))


def _phases(whole: History, part: History) -> pd.Categorical:
    """Return the name of the phase at each time of a part of a history."""
    names = np.full(part.time.size, "", dtype=object)
    for phase in phases(whole.case.loads, whole.duration):
        names[phase.rows(part.time.values)] = phase.name
    names[0] = names[1]  # the instant at which a phase begins is the last of the one before
    return pd.Categorical(names, pd.unique(names))


def _check_shoes(runs: Sequence[DutyRun], parts: Sequence[History]) -> None:
    """Raise ValueError if runs do not have the same flexible shoes."""
    first: dict[str, object] = {}
    for run, case in ((run, part.case) for run, part in zip(runs, parts, strict=True)):
        if (shoes := case.flexible) is None:
            raise ValueError(
                f"run {run.name!r} must have flexible shoes: give their numbers as flexible.shoes of its case"
            )
        body, _ = shoe_model(shoes, case.track)
        traits = {
            name: getattr(shoes, name) for name in ("shoes", "youngs_modulus", "poissons_ratio", "pins")
        }
        traits |= {"mesh": body.mesh.digest[:12]}
        first = first or traits
        if unlike := [name for name, value in traits.items() if value != first[name]]:
            name = unlike[0]
            raise ValueError(
                f"the runs must have the same shoes: {name} of {runs[0].name!r} is {first[name]}, "
                f"of {run.name!r} {traits[name]}"
            )


@dataclass(frozen=True)
class NodeLife:
    """Cycles of a node over a duty.

    `cycles` has a row a cycle: run, shoe (place), and phases, times (s) and stresses (Pa) of both ends.
    Further columns are the rate (1/h) on a shoe that takes all places, and the damage an hour at the greatest
    survival. "contribution of LOAD" is the load's fraction of the range between the ends; fractions add up to
    1, and those of relieving loads are negative. Cycles from run to run have the name `BETWEEN`; the rate of
    the cycles that they replace is reduced by theirs. `by_criterion` is the damage an hour by each of
    `SIGNED_CRITERIA`, `peak` the greatest von Mises stress, Pa.
    """

    cycles: pd.DataFrame
    by_criterion: Mapping[str, float]
    peak: float

    @property
    def load_shares(self) -> dict[str, float]:
        """Fraction of each load in the damage: its fraction of the ranges, weighted by the cycles' damage."""
        harm = self.cycles["damage an hour"]
        if not harm.any():
            return {}
        shares = self.cycles.filter(like=SHARE).fillna(0.0).mul(harm, axis=0).sum() / harm.sum()
        return {name.removeprefix(SHARE): float(share) for name, share in shares.items()}

    def rainflow_matrix(self) -> pd.DataFrame:
        """Return cycles an hour by classes of their begin and end (middles, MPa), without empty classes."""
        ends = self.cycles[["begin in Pa", "end in Pa"]].to_numpy() / 1e6
        low, high = (ends.min(), ends.max()) if len(ends) else (0.0, 0.0)
        edges = np.linspace(low, max(high, low + 1e-6), CLASSES + 1)
        weights = self.cycles["times an hour"].to_numpy()
        counts, _, _ = np.histogram2d(ends[:, 0], ends[:, 1], bins=[edges, edges], weights=weights)
        rows, columns = np.nonzero(counts)
        middles = 0.5 * (edges[1:] + edges[:-1])
        table = pd.DataFrame({"begin in MPa": middles[rows], "end in MPa": middles[columns]})
        return table.assign(**{"cycles an hour": counts[rows, columns]})

    def damage_history(self) -> pd.DataFrame:
        """Return the damage an hour accumulated over each run at each place.

        Half of a cycle's damage counts at each of its ends. Cycles from run to run are left out.
        """
        by = ["run", "shoe", "time in s"]
        columns = [["run", "shoe", f"{end} time in s"] for end in ("begin", "end")]
        cycles = self.cycles[self.cycles["run"] != BETWEEN]
        table = pd.concat([cycles[names].set_axis(by, axis=1) for names in columns])
        table["damage an hour"] = np.tile(0.5 * cycles["damage an hour"], 2)
        summed = table.groupby(by, sort=True, as_index=False).sum()
        summed["damage an hour"] = summed.groupby(["run", "shoe"])["damage an hour"].cumsum()
        return summed


def node_lives(duty: Duty, runs: Sequence[UsedRun], curves: Mapping[int, SNCurve]) -> dict[int, NodeLife]:
    """Return cycles and causes at nodes with given S-N curves, from stresses at full rank."""
    tables: dict[int, list[pd.DataFrame]] = {node: [] for node in curves}
    by_criterion = {node: dict.fromkeys(map(str, damage.SIGNED_CRITERIA), 0.0) for node in curves}
    peaks = dict.fromkeys(curves, 0.0)
    places = [*runs[0].basis.coordinates]
    for shoe in places:
        rows = {}
        for (node, curve), criterion in itertools.product(curves.items(), damage.SIGNED_CRITERIA):
            signals = [node_signals(criterion, run.basis, shoe, [node])[0] for run in runs]
            cycles = _cycle_rows(duty, runs, signals, len(places))
            ends = cycles["begin in Pa"].to_numpy(), cycles["end in Pa"].to_numpy()
            each = curve.damage(
                0.5 * np.abs(ends[1] - ends[0]), 0.5 * (ends[0] + ends[1]), duty.survivals[-1:]
            )
            harm = cycles["times an hour"].to_numpy() * each[0]
            by_criterion[node][criterion] += float(harm.sum())
            if criterion == "signed von mises":
                peaks[node] = max(peaks[node], *(float(np.abs(signal).max()) for signal in signals))
            if criterion == duty.criterion:
                rows[node] = cycles.assign(**{"damage an hour": harm})
        shares = _load_shares(duty, runs, shoe, rows)
        for node, cycles in rows.items():
            tables[node].append(_named(runs, shoe, cycles).assign(**shares[node]))
    return {
        node: NodeLife(pd.concat(tables[node], ignore_index=True), by_criterion[node], peaks[node])
        for node in curves
    }


def _cycle_rows(
    duty: Duty, runs: Sequence[UsedRun], signals: Sequence[np.ndarray], places: int
) -> pd.DataFrame:
    """Return the cycles of mixed runs with signals (t,): stresses, rate, numbers of runs and rows.

    Cycles from run to run replace cycles of runs and reduce the rate of these.
    """
    of_runs = []
    passes = []
    for k, (run, signal) in enumerate(zip(runs, signals, strict=True)):
        cycles = repeated_cycles(signal)
        ends = cycles.begin, cycles.end, cycles.begin_row, cycles.end_row
        columns = dict(zip(("begin in Pa", "end in Pa", "begin row", "end row"), ends, strict=True))
        rate = run.times_an_hour / places
        of_runs.append(pd.DataFrame(columns).assign(**{"begin of": k, "end of": k, "times an hour": rate}))
        tracker = EndsTracker(1)
        tracker.add(slice(1), signal[None], 0)
        passes.append(tracker)
    mixed = mixed_cycles(duty, runs, PassEnds.stacked([tracker.ends for tracker in passes]), places)
    levels = {"low": mixed.low, "high": mixed.high, "begin in Pa": mixed.begin, "end in Pa": mixed.end}
    events = pd.DataFrame(levels | {"times an hour": mixed.rate})
    net = events.groupby(["low", "high", "begin in Pa", "end in Pa"], as_index=False, sort=False).sum()
    is_own = net["low"] == net["high"]
    for k, rate in net.loc[is_own, ["low", "times an hour"]].itertuples(index=False):
        own = of_runs[int(k)]
        widest = (own["end in Pa"] - own["begin in Pa"]).abs().idxmax()
        own.loc[widest, "times an hour"] += rate
    new = net[~is_own]
    at = PassEnds.stacked([tracker.rows for tracker in passes])
    rows = {"low": np.concatenate((at.lowest, at.valley)), "high": np.concatenate((at.highest, at.peak))}
    for end, level in (("begin", "low"), ("end", "high")):
        number = new[level].to_numpy()
        new = new.assign(**{f"{end} of": number % len(runs), f"{end} row": rows[level][number, 0]})
    cycles = pd.concat((*of_runs, new.drop(columns=["low", "high"])), ignore_index=True)
    # leave out cycles that are wholly replaced, with a rate of zero but for rounding
    return cycles[cycles["times an hour"] > 1e-12 * cycles["times an hour"].max()].reset_index(drop=True)


def mixed_cycles(duty: Duty, runs: Sequence[UsedRun], ends: PassEnds, places: int = 1) -> Changes:
    """Return the cycles that the mixing of runs adds and removes, by the ends (runs, n) of their passes."""
    rates = np.array([run.times_an_hour for run in runs])
    return changes(ends, rates / places, duty.most_changes / places)


def node_signals(
    criterion: damage.SignedCriterion, basis: StressBasis, shoe: int, nodes: np.ndarray | list[int]
) -> np.ndarray:
    """Return the signals (nodes, t) of a criterion at nodes of a shoe, Pa."""
    modes = basis.shapes.stress_modes[nodes]
    q = basis.coordinates[shoe]
    signals = []
    for rows in parts_of(len(q)):
        stress = modes.reshape(-1, modes.shape[2]) @ q[rows].T
        signals.append(damage.signed_signals(criterion, stress.reshape(len(nodes), 6, -1)))
    return np.concatenate(signals, axis=1)


def _named(runs: Sequence[UsedRun], shoe: int, cycles: pd.DataFrame) -> pd.DataFrame:
    """Return cycles of a shoe with names, phases and times instead of numbers and rows."""
    is_own = (cycles["begin of"] == cycles["end of"]).to_numpy()
    names = np.array([run.run.name for run in runs], dtype=object)
    columns = {"run": np.where(is_own, names[cycles["begin of"]], BETWEEN), "shoe": shoe}
    for end in ("begin", "end"):
        places = list(zip(cycles[f"{end} of"], cycles[f"{end} row"], is_own, strict=True))
        columns[f"{end} phase"] = [
            runs[k].phase[row] if own else runs[k].parts[runs[k].phase.codes[row]] for k, row, own in places
        ]
        columns[f"{end} time in s"] = [runs[k].time[row] for k, row, _ in places]
    values = ["begin in Pa", "end in Pa", "times an hour", "damage an hour"]
    return pd.concat((pd.DataFrame(columns, index=cycles.index), cycles[values]), axis=1)


def _load_shares(
    duty: Duty, runs: Sequence[UsedRun], shoe: int, cycles: Mapping[int, pd.DataFrame]
) -> dict[int, dict[str, np.ndarray]]:
    """Return each load's fraction of the range of cycles (n,) at nodes of a shoe, by column of a table."""
    shares: dict[int, dict[str, np.ndarray]] = {node: {} for node in cycles}
    for k, run in enumerate(runs):
        for end, sense in (("begin", -1.0), ("end", 1.0)):
            here = {node: np.flatnonzero(rows[f"{end} of"] == k) for node, rows in cycles.items()}
            instants = {node: rows[f"{end} row"].to_numpy()[here[node]] for node, rows in cycles.items()}
            for node, of_loads in _load_parts(duty, run.basis, shoe, instants).items():
                rows = cycles[node]
                size = (rows["end in Pa"] - rows["begin in Pa"]).to_numpy()[here[node]]
                for load, part in of_loads.items():
                    share = shares[node].setdefault(SHARE + load, np.zeros(len(rows)))
                    share[here[node]] += sense * part / size
    return shares


def _load_parts(
    duty: Duty, basis: StressBasis, shoe: int, instants: Mapping[int, np.ndarray]
) -> dict[int, dict[str, np.ndarray]]:
    """Return each load's part of the duty's signal at nodes of a shoe at instants (n,), Pa."""
    q = basis.coordinates[shoe]
    by_node: dict[int, dict[str, np.ndarray]] = {node: {} for node in instants}
    for rows in parts_of(len(q)):
        loads = basis.by_load(shoe, rows)
        coordinates = q[rows]
        for node, chosen in instants.items():
            modes = basis.shapes.stress_modes[node]
            here = np.flatnonzero((chosen >= rows.start) & (chosen < rows.stop))
            at = chosen[here] - rows.start
            along = stress_directions(duty.criterion, coordinates[at] @ modes.T)
            for load, part in loads.items():
                of_load = by_node[node].setdefault(load, np.zeros(len(chosen)))
                of_load[here] += np.einsum("tk,tk->t", along, part[at] @ modes.T)
    return by_node
