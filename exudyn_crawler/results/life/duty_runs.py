"""Runs of a duty as damage is counted over them: the parts that are repeated, checked against each other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.model.flexible_shoes import shoe_model
from exudyn_crawler.results.history.history import History, phases
from exudyn_crawler.results.life.duty import Duty, DutyRun
from exudyn_crawler.results.stress.basis import StressBasis, stress_basis
from exudyn_crawler.results.stress.recovery import near_pull
from fem.damage import Counting
from fem.fatigue import SNCurve

SAME_TIME = 1e-9
"""Relative, by which times may differ and be the same."""
LEAST_TIMES = 3
"""Stored times that can hold a cycle."""


@dataclass(frozen=True)
class UsedRun:
    """Part of a run that is repeated.

    Attributes
    ----------
    run : DutyRun
    history : History
        Of the part.
    basis : StressBasis
        What its stresses are the products of.
    times_an_hour : float
    phases : tuple of str
        Names of the phases that it reaches.
    phase : int array (times,)
        Place of each time's phase among them.
    """

    run: DutyRun
    history: History
    basis: StressBasis
    times_an_hour: float
    phases: tuple[str, ...]
    phase: NDArray

    def counting(self, curve: SNCurve, survivals: tuple[float, ...], negligible: float = 0.0) -> Counting:
        """How its cycles are counted; what is left out does a negligible damage an hour at most."""
        return Counting(curve, survivals, self.phase, negligible / self.times_an_hour)


def used_runs(duty: Duty, histories: Sequence[History]) -> list[UsedRun]:
    """Parts of the histories of a duty's runs, in its order.

    Raises
    ------
    ValueError
        If a run has no flexible shoes, does not reach its part or holds no cycle in it; if shoes, mesh or
        elastic constants are not the same in all of them; or if together they take more than an hour.
    """
    parts = [_part(run, history) for run, history in zip(duty.runs, histories, strict=True)]
    durations = [float(part.time[-1] - part.time[0]) for part in parts]
    times = duty.times_an_hour(durations)
    _check_shoes(duty.runs, parts)
    used = []
    for run, whole, part, often in zip(duty.runs, histories, parts, times, strict=True):
        names, phase = _phases(whole, part)
        used.append(UsedRun(run, part, stress_basis(part), often, names, phase))
    return used


def positions_of(runs: Sequence[UsedRun]) -> list[int]:
    """Places in the track that have a flexible shoe."""
    return list(runs[0].history.case.flexible_shoes().shoes)


def pulled_nodes(runs: Sequence[UsedRun], shoe: int) -> NDArray:
    """Whether a node of a shoe belongs to an element about the node that a drive pulls: array (nodes,)."""
    return np.any([near_pull(one.history, one.basis.shapes, shoe) for one in runs], axis=0)


def _part(run: DutyRun, history: History) -> History:
    """Part of a run's history that a duty repeats."""
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


def _phases(whole: History, part: History) -> tuple[tuple[str, ...], NDArray]:
    """Names of the phases that a part of a history reaches, and the place of each time's among them."""
    reached = phases(whole.case.loads, whole.duration)
    number = np.zeros(part.time.size, dtype=np.int64)
    for k, phase in enumerate(reached):
        number[phase.rows(part.time.values)] = k
    number[0] = number[1]  # the instant at which a phase begins is the last of the one before
    there, places = np.unique(number, return_inverse=True)
    return tuple(reached[k].name for k in there), places


def _check_shoes(runs: Sequence[DutyRun], parts: Sequence[History]) -> None:
    """Refuse runs that are not of the same shoes."""
    first = parts[0]
    for run, part in zip(runs, parts, strict=True):
        if part.case.flexible is None:
            raise ValueError(f"run {run.name!r} must have flexible shoes, it has rigid ones alone")
        own, other = (_shoes(one.case) for one in (part, first))
        for name, value in own.items():
            if value != other[name]:
                raise ValueError(
                    f"the runs must have the same shoes: {name} of {runs[0].name!r} is {other[name]}, "
                    f"of {run.name!r} {value}"
                )


def _shoes(case: Case) -> dict[str, object]:
    """What of a case's flexible shoes is the same in all runs of a duty."""
    flexible = case.flexible_shoes()
    body, _ = shoe_model(flexible, case.track)
    return {
        "shoes": flexible.shoes,
        "mesh": body.mesh.digest[:12],
        "youngs_modulus": flexible.youngs_modulus,
        "poissons_ratio": flexible.poissons_ratio,
    }
