"""One pass over blocks of stresses: order, completeness, and histories that are refused."""

import numpy as np
import pytest

import fem
from fem.rank import NODE_BLOCK, TIME_BLOCK


def test_faulty_histories(small: fem.ReducedBody, history: np.ndarray) -> None:
    with pytest.raises(ValueError, match="must have 26 modal coordinates, got 3"):
        fem.recover_peaks(small.stress_modes, history[:, :3])
    with pytest.raises(ValueError, match="at least one row"):
        fem.recover_peaks(small.stress_modes, history[:0])
    spoilt = history.copy()
    spoilt[300, 2] = np.inf
    with pytest.raises(ValueError, match="others in rows 256 to 511"):
        fem.recover_peaks(small.stress_modes, spoilt)


class WholeHistories(fem.Fold[dict[int, np.ndarray]]):
    """History (t, c) of each node, gathered as a count of cycles gathers it: whole before the next ones."""

    def __init__(self, components: np.ndarray | None) -> None:
        self.components = components

    def start(self, nodes: np.ndarray, times: int) -> None:
        """Begin with nothing."""
        self.nodes, self.times = nodes, times
        self.kept: dict[int, np.ndarray] = {}
        self.parts: list[np.ndarray] = []

    def add(self, block: fem.StressBlock) -> None:
        """Gather times; close the nodes with the last of them."""
        assert sum(part.shape[2] for part in self.parts) == block.times.start
        assert block.stress.shape[2] <= TIME_BLOCK
        assert len(block.stress) <= NODE_BLOCK
        self.parts.append(block.stress.copy())
        if block.times.stop == self.times:
            whole = np.concatenate(self.parts, axis=2).transpose(0, 2, 1)
            assert not self.kept.keys() & set(self.nodes[block.nodes].tolist())
            self.kept |= dict(zip(self.nodes[block.nodes].tolist(), whole, strict=True))
            self.parts = []

    def finish(self) -> dict[int, np.ndarray]:
        """Histories by node number."""
        assert not self.parts
        return self.kept


@pytest.mark.parametrize("components", [None, np.eye(6)[[2, 0]] - np.eye(6)[[1, 4]]])
def test_a_fold_sees_the_whole_history_of_every_node_before_the_next(components: np.ndarray | None) -> None:
    rng = np.random.default_rng(6)
    modes = rng.standard_normal((2 * NODE_BLOCK + 5, 6, 4))
    q = rng.standard_normal((TIME_BLOCK + 17, 4))
    nodes = rng.permutation(len(modes))[: NODE_BLOCK + 9]
    found = fem.fold_stresses(modes, iter([q[:3], q[3:]]), WholeHistories(components), nodes)
    assert list(found) == nodes.tolist()
    combine = np.eye(6) if components is None else components
    for node, history in found.items():
        np.testing.assert_allclose(history, q @ (combine @ modes[node]).T, rtol=0, atol=1e-13)
