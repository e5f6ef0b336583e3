"""How far to trust lives: what is open of the changes of stress that make them, and what that is in life."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.results.duty_runs import UsedRun
from fem.fatigue import SNCurve
from fem.trust import resolution_over, verdict_numbers, verdict_words


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
    over all of them; what left-out static fields and spread may do counts against the greatest amplitude and
    at the place that wears a node most.

    Parameters
    ----------
    damage, amplitude : array (places, nodes)
        Damage an hour at each place and half the range of the stress in Pa; not a number inside.
    spreads : sequence of DataArray (shoe, node) or None
        Spread of each run's peaks over themselves, as of `spread.relative_spread`; None where not known.
    """
    whole = runs[0].columns.shapes
    found = None
    for one in runs:
        changes = np.concatenate([q - q.mean(axis=0) for q in one.columns.coordinates.values()])
        own = resolution_over(one.columns.shapes, changes)
        found = own if found is None else found + own
    assert found is not None
    known = ~np.isnan(damage).any(axis=0)
    greatest = np.max(np.where(known, amplitude, 0.0), axis=0)
    bounds = [one.columns.bound for one in runs]
    most = max((bound for bound in bounds if bound is not None), default=0.0)
    part = found.error + np.divide(most, greatest, out=np.zeros_like(greatest), where=greatest > 0.0)
    worst = np.argmax(np.where(known, damage, 0.0), axis=0)
    for spread in spreads:
        if spread is not None:
            part += spread.values[worst, np.arange(len(part))]
    part = np.where(known, part, np.nan)
    held = np.isin(np.arange(len(part)), whole.spider_nodes) & known
    verdict = verdict_numbers(part, found.error, found.relative_jump, held)
    return LifeTrust(part, (1.0 + part) ** curve.steepest, verdict, None not in bounds)
