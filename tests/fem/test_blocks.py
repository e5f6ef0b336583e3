"""One pass over blocks of stresses: order, completeness, and histories that are refused."""

from collections.abc import Callable

import numpy as np
import pytest

import fem
from fem.rank import NODE_BLOCK, TIME_BLOCK
from tests.fem.test_rank import WholeStress


@pytest.mark.parametrize("recover", [fem.recover_peaks, fem.recover_extremes])
def test_faulty_histories(small: fem.ReducedBody, history: np.ndarray, recover: Callable) -> None:
    with pytest.raises(ValueError, match="must have 26 modal coordinates, got 3"):
        recover(small.stress_modes, history[:, :3])
    for nothing in (history[:0], []):
        with pytest.raises(ValueError, match="at least one row"):
            recover(small.stress_modes, nothing)
    for value in (np.inf, np.nan):
        spoilt = history.copy()
        spoilt[300, 2] = value
        with pytest.raises(ValueError, match="must be finite, got others in rows 256 to 511"):
            recover(small.stress_modes, spoilt)


@pytest.mark.parametrize("components", [None, np.eye(6)[[2, 0]] - np.eye(6)[[1, 4]]])
def test_a_fold_sees_the_whole_history_of_every_node_before_the_next(components: np.ndarray | None) -> None:
    rng = np.random.default_rng(6)
    modes = rng.standard_normal((2 * NODE_BLOCK + 5, 6, 4))
    q = rng.standard_normal((TIME_BLOCK + 17, 4))
    nodes = rng.permutation(len(modes))[: NODE_BLOCK + 9]
    found, _ = fem.fold_stresses(modes, iter([q[:3], q[3:]]), WholeStress(components), nodes)
    combine = np.eye(6) if components is None else components
    np.testing.assert_allclose(found, combine @ modes[nodes] @ q.T, rtol=0, atol=1e-13)
