"""Stresses of histories, block by block: bounds, peaks, extremes and hot spots against brute force."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import fem
from fem.body.element_stress import CRITERIA, DEVIATOR, evaluate
from fem.body.mesh import Floats, Integers
from fem.stress import candidates
from fem.stress.folds import Fold, StressBlock
from fem.stress.low_rank import NODE_BLOCK, TIME_BLOCK
from tests.fem.refusals import refused

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


def reduced_rank(modes, q, components=None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sizes (n, t) of what a reduced rank is off by, of its bound and of the exact stress."""
    exact, none = fem.fold_stresses(modes, q, WholeStress(components))
    found, bound = fem.fold_stresses(modes, q, WholeStress(components), tolerance=TOLERANCE)
    assert not none.any()
    return np.linalg.norm(found - exact, axis=1), bound, np.linalg.norm(exact, axis=1)


@pytest.mark.parametrize("components", [None, DEVIATOR])
@pytest.mark.parametrize("name", list(degenerate_histories()))
def test_bound_holds_at_every_node_and_time(small, name, components):
    q = degenerate_histories()[name] / small.frequencies**2
    off, bound, exact = reduced_rank(small.stress_modes, q, components)
    assert (off <= bound).all()
    assert off.max() > 1e-3 * bound.max() or not q.any()  # no idle bound
    assert bound.max() <= 1.05 * TOLERANCE * exact.max()


def test_the_bound_sees_a_direction_that_matters_at_one_node_alone():
    """Most of the stress moves along one direction; a second one is felt by a single node, a short time."""
    modes = np.zeros((300, 6, 2))
    modes[:, 0, 0] = 1e6
    modes[200, 3, 1] = 1e3
    q = np.ones((2 * TIME_BLOCK, 2))
    q[:, 1] = 0.0
    q[TIME_BLOCK + 5, 1] = 0.1
    off, bound, _ = reduced_rank(modes, q)
    assert off.max() == pytest.approx(100.0, rel=0.1)
    assert bound[200, TIME_BLOCK + 5] > 99.0
    rounding = bound[0, 0]
    assert bound[200, 0] < 10.0 * rounding
    assert bound[199].max() < 10.0 * rounding


def test_modes_without_stress(small):
    modes = small.stress_modes.copy()
    modes[:, :, 3] = 0.0
    q = smooth_history(300, 26) / small.frequencies**2
    off, bound, _ = reduced_rank(modes, q)
    assert (off <= bound).all()
    assert not any(sizes.any() for sizes in reduced_rank(0.0 * modes, q))


@pytest.mark.parametrize("recover", [fem.recover_peaks, fem.recover_extremes])
def test_faulty_histories(small, history, recover):
    refused("must have 26 modal coordinates, got 3", recover, small.stress_modes, history[:, :3])
    for nothing in (history[:0], []):
        refused("at least one row", recover, small.stress_modes, nothing)
    for value in (np.inf, np.nan):
        spoilt = history.copy()
        spoilt[300, 2] = value
        refused("must be finite, got other numbers in row 300", recover, small.stress_modes, spoilt)


@pytest.mark.parametrize("components", [None, np.eye(6)[[2, 0]] - np.eye(6)[[1, 4]]])
def test_a_fold_sees_the_whole_history_of_every_node_before_the_next(components):
    rng = np.random.default_rng(6)
    modes = rng.standard_normal((2 * NODE_BLOCK + 5, 6, 4))
    q = rng.standard_normal((TIME_BLOCK + 17, 4))
    nodes = rng.permutation(len(modes))[: NODE_BLOCK + 9]
    found, _ = fem.fold_stresses(modes, iter([q[:3], q[3:]]), WholeStress(components), nodes)
    combine = np.eye(6) if components is None else components
    np.testing.assert_allclose(found, combine @ modes[nodes] @ q.T, rtol=0, atol=1e-13)


@pytest.mark.parametrize("criterion", CRITERIA)
def test_peaks_against_brute_force(small, history, criterion):
    values = evaluate(criterion, small.stress(history))
    at = (-values if criterion == "least principal" else values).argmax(axis=0)
    for q in (history, iter([history[:100], history[100:101], history[101:]])):
        peaks = fem.recover_peaks(small.stress_modes, q, criterion)
        np.testing.assert_array_equal(peaks.time_indices, at)
        np.testing.assert_allclose(peaks.values, values[at, np.arange(len(at))], rtol=1e-9)


def test_a_peak_splits_into_the_shares_of_its_modes(small, history):
    whole = small.von_mises(history[5], np.array([17]))[0, 0]
    parts = fem.shares(small.stress_modes, history[5], 17)
    assert parts.shape == (26,)
    assert parts.sum() == pytest.approx(whole, rel=1e-9)
    # a mode's share is how the whole grows with it
    more = small.von_mises(history[5] * (1.0 + 1e-6 * np.eye(26)), np.array([17]))[:, 0]
    np.testing.assert_allclose((more - whole) / 1e-6, parts, atol=1e-4 * np.abs(parts).max())


def assert_same(found: fem.Extremes, exact: fem.Extremes) -> None:
    peak = exact.greatest.max()
    np.testing.assert_allclose(found.greatest, exact.greatest, rtol=1e-12, atol=1e-14 * peak)
    np.testing.assert_allclose(found.highest, exact.highest, rtol=1e-12, atol=1e-14 * peak)
    # a root of what rounding leaves of a square
    np.testing.assert_allclose(found.least, exact.least, rtol=1e-9, atol=1e-7 * peak)


def test_extremes_are_those_of_the_whole_field(reduced):
    q = np.random.default_rng(5).normal(size=(300, len(reduced.frequencies)))
    q /= (2 * np.pi * reduced.frequencies) ** 2
    found = fem.recover_extremes(reduced.stress_modes, q)
    field = np.concatenate([reduced.von_mises(part) for part in np.array_split(q, 6)])
    np.testing.assert_allclose(found.greatest, field.max(axis=0), rtol=1e-9)
    np.testing.assert_array_equal(found.greatest_at, field.argmax(axis=0))
    np.testing.assert_allclose(found.least, field.min(axis=0), rtol=1e-9, atol=1.0)
    np.testing.assert_allclose(found.highest, field.max(axis=1), rtol=1e-9)
    np.testing.assert_array_equal(found.highest_nodes, field.argmax(axis=1))
    table = fem.hot_spots(reduced, np.arange(300.0), q)
    known = fem.hot_spots(reduced, np.arange(300.0), q, peaks=found.peaks)
    np.testing.assert_array_equal(known["node"], table["node"])
    np.testing.assert_allclose(known["value"], table["value"], rtol=1e-9)


def test_a_reduced_rank_finds_what_the_full_one_does(reduced):
    q = smooth_history(1000, len(reduced.frequencies)) / (2 * np.pi * reduced.frequencies) ** 2
    exact = fem.recover_extremes(reduced.stress_modes, q, tolerance=None)
    assert not exact.bound.any()
    for tolerance in (1e-3, 1e-2):
        found = fem.recover_extremes(reduced.stress_modes, q, tolerance=tolerance)
        assert 0.0 < found.bound.max() <= 1.05 * tolerance * exact.greatest.max()
        assert_same(found, exact)
        np.testing.assert_array_equal(found.greatest_at, exact.greatest_at)
        np.testing.assert_array_equal(found.highest_nodes, exact.highest_nodes)


@pytest.mark.parametrize("name", list(degenerate_histories()))
def test_bounds_of_the_search_enclose_the_stress(small, name):
    q = degenerate_histories()[name] / small.frequencies**2
    ranked = np.arange(len(small.nodes)) % 3 > 0
    found = candidates.find_candidates(candidates.scaled_shapes(small.stress_modes), q, ranked, TOLERANCE)
    exact = small.von_mises(q)
    starts = range(0, len(q), candidates.CELL)
    groups = range(0, len(small.nodes), candidates.CELL)
    slack = 1e-7 * exact.max()
    for bounds, values in (
        ((found.lower, found.upper.max(axis=1)), exact.max(axis=0)),
        ((found.least_lower.min(axis=1), found.least_upper), exact.min(axis=0)),
        ((found.node_lower, found.node_upper.max(axis=0)), exact[:, ranked].max(axis=1)),
    ):
        assert (bounds[0] - slack <= values).all()
        assert (values <= bounds[1] + slack).all()
    assert (found.upper + slack >= np.maximum.reduceat(exact, starts).T).all()
    assert (found.least_lower - slack <= np.minimum.reduceat(exact, starts).T).all()
    of_ranked = np.where(ranked, exact, -np.inf).T
    assert (np.maximum.reduceat(of_ranked, groups) <= found.node_upper + slack).all()
    assert found.bound.max() <= 1.05 * TOLERANCE * exact.max()
    # no wider than they say
    assert (found.upper.max(axis=1) - found.lower <= 2.0 * found.bound + slack).all()


def test_near_equals_far_within_the_bound_are_told_apart():
    """Two instants, and two nodes, whose stresses differ by 1e-9: the greater ones win, not the first."""
    rng = np.random.default_rng(2)
    modes = np.zeros((400, 6, 8))
    modes[:, 0, 0] = 1e6 * (1.0 - 0.5 * rng.random(400))
    modes[:, 3, 1:] = 1e3 * rng.standard_normal((400, 7))
    modes[[70, 333]] = 0.0
    modes[[70, 333], 0, 0] = 2e6, 2e6 * (1.0 + 1e-9)
    q = 1e-3 * rng.standard_normal((900, 8))
    q[:, 0] = np.sin(np.linspace(0.0, 3.0, 900)) * 0.9
    q[[123, 777], 0] = 1.0, 1.0 + 1e-9
    found = fem.recover_extremes(modes, q, tolerance=1e-2)
    assert found.bound[333] > 1.0  # Pa, of 2e-3 Pa that tell the two apart
    assert found.greatest_at[333] == 777
    assert found.highest_nodes[777] == found.highest_nodes[123] == 333
    assert_same(found, fem.recover_extremes(modes, q, tolerance=None))
    others = np.setdiff1d(np.arange(400), [333])
    ranked = fem.recover_extremes(modes, q, ranked=others)
    assert ranked.highest_nodes[777] == 70
    assert_same(ranked, fem.recover_extremes(modes, q, ranked=others, tolerance=None))
    refused("ranked must be at least one node", fem.recover_extremes, modes, q, ranked=[])


@pytest.mark.parametrize("name", list(degenerate_histories()))
def test_degenerate_histories(small, name):
    q = degenerate_histories()[name] / small.frequencies**2
    found = fem.recover_extremes(small.stress_modes, iter(np.array_split(q, min(len(q), 7))))
    assert_same(found, fem.recover_extremes(small.stress_modes, q, tolerance=None))


def test_hot_spots_rank_flag_and_separate(small, history):
    times = 0.001 * np.arange(len(history))
    table = fem.hot_spots(small, times, history, 10)
    assert list(table["rank"]) == list(range(1, 11))
    assert table["value"].is_monotonic_decreasing
    top = table.iloc[0]
    row = round(top["time"] / 0.001)
    assert small.von_mises(history[row])[0, top["node"]] == pytest.approx(top["value"])
    assert small.von_mises(history).max() == pytest.approx(top["value"])
    assert (np.isin(table["node"], small.spider_nodes) == (table["flag"] == "in spider")).all()

    apart = fem.hot_spots(small, times, history, 4, separation=fem.Apart(0.2))
    assert (pdist(apart[["x", "y", "z"]]) > 0.2).all()

    window = (times >= 0.1) & (times <= 0.2)
    free = fem.hot_spots(small, times[window], history[window], 5, nodes=small.nodes_away_from_spiders)
    assert (free["flag"] == "").all()
    assert free["time"].between(0.1, 0.2).all()


def test_regions_have_one_peak_each(small):
    # pure bending is greatest at opposite faces, with a calm core in between
    assert len(fem.hot_spots(small, [0.0], np.eye(26)[0], 10, separation=fem.OneARegion(0.7))) == 2


def test_bad_requests(small, history):
    times, modes, spots = np.arange(len(history)), small.stress_modes, fem.hot_spots
    refused(r"criterion must be one of .* got 'tresca'", fem.recover_peaks, modes, history, "tresca")
    refused("got 0 times and", spots, small, times[:0], history[:0])
    refused("got 700 times and 0 nodes", spots, small, times, history, nodes=np.array([], dtype=int))
    refused("count must be at least 1, got 0", spots, small, times, history, 0)
    refused("times must be as many as the rows of q, got 699 and 700", spots, small, times[1:], history)
    peaks = fem.recover_peaks(modes, history, "greatest shear")
    refused("peaks must be those of 'von mises' at all", spots, small, times, history, peaks=peaks)
    refused("radius must be positive, got 0", fem.Apart, 0.0)
    refused(r"fraction must lie inside \(0, 1\), got 1", fem.OneARegion, 1.0)
