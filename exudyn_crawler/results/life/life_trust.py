"""How far to trust lives: what is open of the changes of stress that make them, and what that is in life."""

import operator
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.life.duty_runs import UsedRun
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
