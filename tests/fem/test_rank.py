"""Reduced rank: the bound at every node, and degenerate histories."""

import numpy as np
import pytest

import fem
from fem.blocks import Fold, StressBlock
from fem.mesh import Floats, Integers
from fem.rank import NODE_BLOCK, TIME_BLOCK
from fem.stress import DEVIATOR

TOLERANCE = 1e-3


class WholeStress(Fold[tuple[Floats, Floats]]):
    """Components (n, c, t) of all nodes and times, and their bounds (n, t).

    Blocks come as a count of cycles needs them: the whole history of some nodes before the next ones.
    """

    def __init__(self, components: Floats | None) -> None:
        self.components = components

    def start(self, nodes: Integers, times: int) -> None:
        """Begin with no number known."""
        count = 6 if self.components is None else len(self.components)
        self.stress = np.full((len(nodes), count, times), np.nan)
        self.bound = np.full((len(nodes), times), np.nan)
        self.known = np.zeros(len(nodes), dtype=int)

    def add(self, block: StressBlock) -> None:
        """Fill in a block of the next times, while other nodes have all of theirs or none."""
        assert (self.known[block.nodes] == block.times.start).all()
        assert set(np.delete(self.known, block.nodes)) <= {0, self.stress.shape[2]}
        assert block.stress.shape[2] <= TIME_BLOCK
        assert len(block.stress) <= NODE_BLOCK
        self.known[block.nodes] = block.times.stop
        self.stress[block.nodes, :, block.times] = block.stress
        self.bound[block.nodes, block.times] = block.bound[:, None]

    def finish(self) -> tuple[Floats, Floats]:
        """Give both."""
        assert (self.known == self.stress.shape[2]).all()
        return self.stress, self.bound


def smooth_history(times: int, modes: int) -> np.ndarray:
    """Random slow motion along few directions with a little of everything else."""
    rng = np.random.default_rng(3)
    t = np.linspace(0.0, 1.0, times)[:, None]
    slow = np.sin(2 * np.pi * (t * np.arange(1, 6) + rng.random(5))) @ rng.standard_normal((5, modes))
    return slow + 1e-5 * rng.standard_normal((times, modes))


def degenerate_histories() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(8)
    one = rng.standard_normal((1, 26))
    return {
        "random": rng.standard_normal((600, 26)),
        "smooth": smooth_history(600, 26),
        "rank one": rng.standard_normal((600, 1)) * one,
        "constant": np.repeat(one, 600, axis=0),
        "zero": np.zeros((600, 26)),
        "fewer times than modes": rng.standard_normal((9, 26)),
        "one time": one,
    }


@pytest.mark.parametrize("components", [None, DEVIATOR])
@pytest.mark.parametrize("name", list(degenerate_histories()))
def test_bound_holds_at_every_node_and_time(
    small: fem.ReducedBody, name: str, components: np.ndarray | None
) -> None:
    q = degenerate_histories()[name] / small.frequencies**2
    modes = small.stress_modes
    exact, none = fem.fold_stresses(modes, q, WholeStress(components))
    found, bound = fem.fold_stresses(modes, q, WholeStress(components), tolerance=TOLERANCE)
    assert not none.any()
    off = np.linalg.norm(found - exact, axis=1)
    assert (off <= bound).all()
    assert off.max() > 1e-3 * bound.max() or not q.any()  # no idle bound
    highest = np.linalg.norm(exact, axis=1).max()
    assert bound.max() <= 1.05 * TOLERANCE * highest


def test_the_bound_sees_a_direction_that_matters_at_one_node_alone() -> None:
    """Most of the stress moves along one direction; a second one is felt by a single node, a short time."""
    modes = np.zeros((300, 6, 2))
    modes[:, 0, 0] = 1e6
    modes[200, 3, 1] = 1e3
    q = np.ones((2 * TIME_BLOCK, 2))
    q[:, 1] = 0.0
    q[TIME_BLOCK + 5, 1] = 0.1
    found, bound = fem.fold_stresses(modes, q, WholeStress(None), tolerance=TOLERANCE)
    exact, _ = fem.fold_stresses(modes, q, WholeStress(None))
    assert np.linalg.norm(found - exact, axis=1).max() == pytest.approx(100.0, rel=0.1)
    rounding = bound[0, 0]
    assert bound[200, TIME_BLOCK + 5] > 99.0
    assert bound[200, 0] < 10.0 * rounding
    assert bound[199].max() < 10.0 * rounding


def test_modes_without_stress(small: fem.ReducedBody) -> None:
    modes = small.stress_modes.copy()
    modes[:, :, 3] = 0.0
    q = smooth_history(300, 26) / small.frequencies**2
    exact, _ = fem.fold_stresses(modes, q, WholeStress(None))
    found, bound = fem.fold_stresses(modes, q, WholeStress(None), tolerance=TOLERANCE)
    assert (np.linalg.norm(found - exact, axis=1) <= bound).all()
    still, bound = fem.fold_stresses(0.0 * modes, q, WholeStress(None), tolerance=TOLERANCE)
    assert not still.any()
    assert not bound.any()
