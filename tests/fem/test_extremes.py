"""Extremes of long histories: those of a search at full rank, whatever the reduced one leaves open."""

import numpy as np
import pytest

import fem
from tests.fem.test_rank import degenerate_histories, smooth_history


def assert_same(found: fem.Extremes, exact: fem.Extremes) -> None:
    peak = exact.greatest.max()
    np.testing.assert_allclose(found.greatest, exact.greatest, rtol=1e-12, atol=1e-14 * peak)
    np.testing.assert_allclose(found.highest, exact.highest, rtol=1e-12, atol=1e-14 * peak)
    assert (found.least >= exact.least * (1.0 - 1e-9) - 1e-7 * peak).all()
    assert (found.least <= exact.least + 2.0 * found.bound + 1e-7 * peak).all()


def test_extremes_are_those_of_the_whole_field(reduced: fem.ReducedBody) -> None:
    q = np.random.default_rng(5).normal(size=(300, len(reduced.frequencies)))
    q /= (2 * np.pi * reduced.frequencies) ** 2
    found = fem.recover_extremes(reduced.stress_modes, q)
    field = np.concatenate([reduced.von_mises(part) for part in np.array_split(q, 6)])
    np.testing.assert_allclose(found.greatest, field.max(axis=0), rtol=1e-9)
    np.testing.assert_array_equal(found.greatest_at, field.argmax(axis=0))
    assert (np.abs(found.least - field.min(axis=0)) <= 2.0 * found.bound + 1.0).all()
    np.testing.assert_allclose(found.highest, field.max(axis=1), rtol=1e-9)
    np.testing.assert_array_equal(found.highest_nodes, field.argmax(axis=1))
    table = fem.hot_spots(reduced, np.arange(300.0), q)
    known = fem.hot_spots(reduced, np.arange(300.0), q, peaks=found.peaks)
    np.testing.assert_array_equal(known["node"], table["node"])
    np.testing.assert_allclose(known["value"], table["value"], rtol=1e-9)


def test_a_reduced_rank_finds_what_the_full_one_does(reduced: fem.ReducedBody) -> None:
    q = smooth_history(1000, len(reduced.frequencies)) / (2 * np.pi * reduced.frequencies) ** 2
    exact = fem.recover_extremes(reduced.stress_modes, q, tolerance=None)
    assert not exact.bound.any()
    for tolerance in (1e-3, 1e-2):
        found = fem.recover_extremes(reduced.stress_modes, q, tolerance=tolerance)
        assert 0.0 < found.bound.max() <= 1.05 * tolerance * exact.greatest.max()
        assert_same(found, exact)
        np.testing.assert_array_equal(found.greatest_at, exact.greatest_at)
        np.testing.assert_array_equal(found.highest_nodes, exact.highest_nodes)


def test_near_equals_far_within_the_bound_are_told_apart() -> None:
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
    with pytest.raises(ValueError, match="ranked must be at least one node"):
        fem.recover_extremes(modes, q, ranked=[])


@pytest.mark.parametrize("name", list(degenerate_histories()))
def test_degenerate_histories(small: fem.ReducedBody, name: str) -> None:
    q = degenerate_histories()[name] / small.frequencies**2
    found = fem.recover_extremes(small.stress_modes, iter(np.array_split(q, min(len(q), 7))))
    assert_same(found, fem.recover_extremes(small.stress_modes, q, tolerance=None))
