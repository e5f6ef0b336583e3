"""Fatigue damage of every node over a stress history, as a fold over blocks of its stresses.

The history is one pass of a repeated one. A criterion turns the six stress components into one signal. The
signal's cycles are counted (`rainflow`) and summed up by Miner's rule (`sn_curve`). Negligible cycles are
left out first: together they do no more than a chosen damage.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from fem.body.mesh import Floats, Integers
from fem.body.shapes import Columns
from fem.compiling import compiler
from fem.fatigue.changes import Changes, EndsTracker, PassEnds
from fem.fatigue.rainflow import CycleCounter, Cycles, joined_cycles, repeated_cycles
from fem.fatigue.sn_curve import SNCurve, check_survivals
from fem.stress.folds import Fold, StressBlock, fold_stresses
from fem.stress.low_rank import NODE_BLOCK, SEGMENT, ModalHistory

SignedCriterion = Literal["signed von mises", "signed principal"]
SIGNED_CRITERIA: tuple[SignedCriterion, ...] = ("signed von mises", "signed principal")
CHORD = np.sqrt(0.75)
"""Cosine of 30 degrees."""
TOLERANCE = 1e-4
"""Tolerance of `fold_stresses`: greatest error of the counted stresses, fraction of the highest one."""


@dataclass(frozen=True)
class Counting:
    """Rules for counting and summing up the cycles of t successive times.

    Parameters
    ----------
    curve : SNCurve
    survivals : tuple of float
        Survival probabilities of the damages.
    phase : int array (t,)
        Phase number of each time, from 0; each end of a cycle gets half of its damage.
    negligible : float
        Greatest damage of all left-out cycles together, at the greatest of the survivals.

    Raises
    ------
    ValueError
        If the history is too short to hold a cycle, or a value is out of its range.
    """

    curve: SNCurve
    survivals: tuple[float, ...]
    phase: Integers
    negligible: float = 0.0

    def __post_init__(self) -> None:
        check_survivals(self.survivals)
        if len(self.phase) < 3:
            raise ValueError(f"a history must have at least 3 times to hold a cycle, got {len(self.phase)}")
        if not self.negligible >= 0.0:
            raise ValueError(f"negligible must not be negative, got {self.negligible}")

    def check(self, times: int) -> None:
        """Raise `ValueError` for a history with another number of times."""
        if times != len(self.phase):
            raise ValueError(f"phase must have {times} times like the history, got {len(self.phase)}")

    @cached_property
    def cut(self) -> float:
        """Amplitude in Pa; cycles below it are left out, since the greatest possible number is negligible."""
        if self.negligible == 0.0:
            return 0.0
        most = (len(self.phase) + 1) // 2
        return self.curve.harmless(self.negligible / most, max(self.survivals))

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of survivals and phases."""
        return len(self.survivals), int(self.phase.max()) + 1

    def cycles(self, signal: Floats) -> Cycles:
        """Return the cycles of a signal (t,) that are not left out."""
        return repeated_cycles(signal).larger_than(self.cut)


class CountedDamage:
    """Damage (n, s, p) per pass of n histories, by survival and phase; their values come in parts."""

    def __init__(self, counting: Counting, count: int) -> None:
        self._counting, self._cycles = counting, CycleCounter(count, counting.cut)
        self.damage = np.zeros((count, *counting.shape))

    def add(self, of: slice, signals: Floats, start: int) -> None:
        """Add the damage of cycles that the next values (k, t) in Pa close; the first is in row `start`."""
        counting = self._counting
        counter = self._cycles
        batches = [
            (number, counter.add(number, signal, start)) for number, signal in enumerate(signals, of.start)
        ]
        if start + signals.shape[1] == len(counting.phase):
            batches += [(number, counter.close(number)) for number in range(of.start, of.stop)]
        closed = [(number, batch) for number, batch in batches if len(batch.begin)]
        if closed:
            numbers = np.repeat([number for number, _ in closed], [len(batch.begin) for _, batch in closed])
            cycles = joined_cycles([batch for _, batch in closed])
            each = counting.curve.damage(cycles.amplitude, cycles.mean, counting.survivals)
            for end in (cycles.begin_row, cycles.end_row):
                np.add.at(self.damage.transpose(0, 2, 1), (numbers, counting.phase[end]), 0.5 * each.T)


@dataclass(frozen=True)
class Damage:
    """Damage of n nodes by one pass of a history.

    Parameters
    ----------
    nodes : int array (n,)
        Numbers of the nodes.
    damage : array (n, s, p)
        Damage by survival and phase; a crack appears at 1.
    ends : PassEnds
        Ends of the counted signals, Pa.
    bound : array (n,)
        Greatest error of the stress, as a length in Pa.
    """

    nodes: Integers
    damage: Floats
    ends: PassEnds
    bound: Floats


@compiler(nogil=True)
def _signed_mises(parts, signals):
    """Write the von Mises stress with the sign of the hydrostatic stress of (k, 6, t) into (k, t)."""
    for k in range(parts.shape[0]):
        for t in range(parts.shape[2]):
            xx = np.float64(parts[k, 0, t])
            yy = np.float64(parts[k, 1, t])
            zz = np.float64(parts[k, 2, t])
            xy = np.float64(parts[k, 3, t])
            yz = np.float64(parts[k, 4, t])
            xz = np.float64(parts[k, 5, t])
            normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
            mises = np.sqrt(0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz))
            signals[k, t] = -mises if xx + yy + zz < 0.0 else mises


@compiler(nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nnan", "nsz"})
def _signed_principal(parts, signals):
    """Write the principal stress of the greatest magnitude of components (k, 6, t) into (k, t).

    The eigenvalues have a trigonometric form (O. K. Smith, Comm. ACM 4(4), 1961). If x is the cosine of an
    angle, the cosine c of its third solves ``4 c^3 - 3 c = x``. For x in [0, 1] three steps of Newton's
    method from the chord give c up to rounding. There are no branches, so that several times are computed at
    once.
    """
    for k in range(parts.shape[0]):
        for t in range(parts.shape[2]):
            xx = np.float64(parts[k, 0, t])
            yy = np.float64(parts[k, 1, t])
            zz = np.float64(parts[k, 2, t])
            xy = np.float64(parts[k, 3, t])
            yz = np.float64(parts[k, 4, t])
            xz = np.float64(parts[k, 5, t])
            mean = (xx + yy + zz) / 3.0
            xx = xx - mean
            yy = yy - mean
            zz = zz - mean
            shear = xy * xy + yz * yz + xz * xz
            radius = np.sqrt((xx * xx + yy * yy + zz * zz + 2.0 * shear) / 6.0)
            volume = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
            third = min(1.0, 0.5 * abs(volume) / max(radius * radius * radius, 1e-300))
            c = CHORD + (1.0 - CHORD) * third
            c -= (4.0 * c * c * c - 3.0 * c - third) / (12.0 * c * c - 3.0)
            c -= (4.0 * c * c * c - 3.0 * c - third) / (12.0 * c * c - 3.0)
            c -= (4.0 * c * c * c - 3.0 * c - third) / (12.0 * c * c - 3.0)
            far = 2.0 * radius * c
            near = radius * (c + np.sqrt(3.0 * max(0.0, 1.0 - c * c)))
            high = mean + (far if volume >= 0.0 else near)
            low = mean - (near if volume >= 0.0 else far)
            signals[k, t] = high if high >= -low else low


_SIGNALS = {"signed von mises": _signed_mises, "signed principal": _signed_principal}


def signed_signals(criterion: SignedCriterion, stress: Floats) -> Floats:
    """Return the signals (k, t) in Pa of a criterion, from stresses (k, 6, t).

    "signed von mises" has the sign of the hydrostatic stress; "signed principal" is the principal stress of
    the greatest magnitude.
    """
    signals = np.empty((stress.shape[0], stress.shape[2]))
    _SIGNALS[criterion](stress, signals)
    return signals


class DamageOf(Fold[Damage]):
    """Damage of each node by the cycles of a criterion's signal.

    Parameters
    ----------
    criterion : str
        One of `SIGNED_CRITERIA`.
    counting : Counting
    """

    components = None

    def __init__(self, criterion: SignedCriterion, counting: Counting) -> None:
        self._criterion = criterion
        self._counting = counting

    def start(self, nodes: Integers, times: int) -> None:
        """Begin without damage."""
        n = len(nodes)
        self._counting.check(times)
        self._nodes, self._signals = nodes, np.empty((min(n, NODE_BLOCK), min(times, SEGMENT)))
        self._counted, self._bound = CountedDamage(self._counting, n), np.zeros(n)
        self._tracker = EndsTracker(n)

    def add(self, block: StressBlock) -> None:
        """Gather the signals of a block of nodes; count their cycles at the end of a segment."""
        of = block.nodes
        times = block.times
        whole = block.segment
        signals = self._signals[: of.stop - of.start, : whole.stop - whole.start]
        signals[:, times.start - whole.start : times.stop - whole.start] = signed_signals(
            self._criterion, block.stress
        )
        self._bound[of] = np.maximum(self._bound[of], block.bound)
        if times.stop == whole.stop:
            self._counted.add(of, signals, whole.start)
            self._tracker.add(of, signals, whole.start)

    def finish(self) -> Damage:
        """Return damage and extremes of all nodes."""
        return Damage(self._nodes, self._counted.damage, self._tracker.ends, self._bound)


def recover_damage(
    stress_modes: Columns,
    q: ModalHistory,
    criterion: SignedCriterion,
    counting: Counting,
    nodes: Integers | None = None,
    tolerance: float | None = TOLERANCE,
) -> Damage:
    """Find the damage of nodes by one pass of a repeated history.

    Parameters
    ----------
    stress_modes, q, nodes
        See `folds.fold_stresses`; errors are the same too; q (t, m).
    criterion : str
        One of `SIGNED_CRITERIA`.
    counting : Counting
        Rules for as many times.
    tolerance : float, optional
        Tolerance of the counted stresses; None counts at full rank and in double precision.

    Raises
    ------
    ValueError
        If the criterion is unknown or the phases have another number of times.
    """
    if criterion not in SIGNED_CRITERIA:
        raise ValueError(f"criterion must be one of {SIGNED_CRITERIA}, got {criterion!r}")
    return fold_stresses(stress_modes, q, DamageOf(criterion, counting), nodes, tolerance)


def damage_of_changes(found: Changes, curve: SNCurve, survivals: Sequence[float], places: int) -> Floats:
    """Return the net damage (s, places) of cycles that appear and vanish as histories are mixed."""
    damage = np.zeros((len(survivals), places))
    amplitude = 0.5 * (found.end - found.begin)
    each = found.rate * curve.damage(amplitude, 0.5 * (found.begin + found.end), survivals)
    for of_survival, harm in zip(damage, each, strict=True):
        of_survival += np.bincount(found.place, harm, places)
    return damage
