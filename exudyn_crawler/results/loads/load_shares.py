"""What makes a stress: the shares of single loads in it."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.stress.stress_columns import StressColumns, columns_by_load
from fem.critical_plane import normal_stress_rows
from fem.damage import SignedCriterion
from fem.stress import VOIGT, von_mises

SHARE = "share of "
"""What the columns of loads begin with."""


def stress_directions(criterion: SignedCriterion, stress: NDArray) -> NDArray:
    """Rows (t, 6) whose products with stresses (t, 6) are a criterion's signal: its derivatives by them.

    A criterion is homogeneous of first order in the stress, so that the rows' products with the stresses of
    single loads add up to it (Euler).
    """
    if criterion == "signed principal":
        tensor = np.empty((len(stress), 3, 3))
        for k, (i, j) in enumerate(VOIGT):
            tensor[:, i, j] = tensor[:, j, i] = stress[:, k]
        values, vectors = np.linalg.eigh(tensor)
        place = np.where(values[:, 2] >= -values[:, 0], 2, 0)
        return normal_stress_rows(vectors[np.arange(len(stress)), :, place])
    mean = stress[:, :3].mean(axis=1, keepdims=True)
    rows = np.concatenate((1.5 * (stress[:, :3] - mean), 3.0 * stress[:, 3:]), axis=1)
    length = np.where(mean[:, 0] < 0.0, -1.0, 1.0) * von_mises(stress)
    return np.divide(rows, length[:, None], out=np.zeros_like(rows), where=length[:, None] != 0.0)


def load_shares(
    history: History, columns: StressColumns, shoe: int, nodes: NDArray, times: NDArray
) -> pd.DataFrame:
    """Share of each load in the von Mises stress of nodes, each at a stored time of its own.

    A load's share is the projection of its stress on the deviator s of the whole,
    ``3/2 s : sigma_load / von Mises^2``: the part of the von Mises stress that goes with a small part of the
    load. Shares add up to 1; a load that relieves has a negative one. The stress of a load is that of its
    static answer with the inertia of the free shoe; "inertia" is that of the integrated modes.

    Parameters
    ----------
    columns : StressColumns
        Of this history.
    shoe : int
        One of its shoes.
    nodes : int array (k,)
        Numbers of nodes.
    times : array (k,)
        s.

    Returns
    -------
    pandas.DataFrame
        A row a node, a column "share of LOAD" a load; zero where there is no stress.
    """
    instants, row = np.unique(times, return_inverse=True)
    at = np.searchsorted(history.time.values, instants)
    part = History(history.case, history.dataset.isel(time=at).load())
    modes = columns.shapes.stress_modes[nodes]
    parts = {
        load: np.einsum("kcm,km->kc", modes, q[row])
        for load, q in columns_by_load(part, columns, shoe).items()
    }
    return pd.DataFrame({SHARE + load: own for load, own in shares(parts).items()})


def shares(parts: Mapping[str, NDArray]) -> dict[str, NDArray]:
    """Shares (k,) as of `load_shares` of the stresses (k, 6) of loads in their sum."""
    stress = np.sum(list(parts.values()), axis=0)
    directions = stress_directions("signed von mises", stress)
    whole = (directions * stress).sum(axis=1)
    zero = np.zeros_like(whole)
    return {
        load: np.divide((directions * own).sum(axis=1), whole, out=zero.copy(), where=whole != 0.0)
        for load, own in parts.items()
    }
