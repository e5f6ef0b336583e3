"""Elimination group by group against a dense solution."""

import numpy as np
import pytest

from exudyn_crawler.model.elimination import eliminate, front, fronts_of, solve, terms


def chain(links):
    """Bodies of six on a common ground of seven, and links of five between neighbours: groups, couplings.

    Eight links close the chain.
    """
    bodies = [list(range(6 * s, 6 * s + 6)) for s in range(8)]
    ground = list(range(48, 55))
    joints = [list(range(55 + 5 * k, 60 + 5 * k)) for k in range(links)]
    couplings = [[*body, *ground] for body in bodies]
    couplings += [[*joint, *bodies[(k + end) % 8]] for k, joint in enumerate(joints) for end in (0, 1)]
    return [*bodies, *joints, ground], couplings


def equations(groups, couplings, seed=3, idle=()):
    """Dense matrix of random terms, none in couplings of these numbers, the fronts and their values."""
    rng = np.random.default_rng(seed)
    size = sum(map(len, groups))
    fronts, dense = fronts_of(groups, couplings), np.zeros((size, size))
    values = np.zeros(fronts.size)
    for k, coupling in enumerate(couplings):
        if k in idle:
            continue
        block = rng.normal(size=(len(coupling), len(coupling)))
        dense[np.ix_(coupling, coupling)] += block
        first = next(k for k, group in enumerate(groups) if set(group) & set(coupling))
        rows = [fronts.rows(first).index(unknown) for unknown in coupling]
        front(fronts, values, first)[np.ix_(rows, rows)] += block
        terms(fronts, values, first)[rows] = 1
    return dense, fronts, values


def assert_solved(dense, fronts, values):
    """The solution is that of the dense equations."""
    right = np.random.default_rng(5).normal(size=len(dense))
    x = right.copy()
    eliminate(fronts, values)
    solve(fronts, values, x)
    np.testing.assert_allclose(x, np.linalg.solve(dense, right), rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("links", [7, 8], ids=["open", "closed"])
def test_solution_is_that_of_the_dense_equations(links):
    assert_solved(*equations(*chain(links)))


def test_what_is_coupled_without_a_term_is_left_out():
    dense, fronts, values = equations(*chain(8), idle=(0, 3, 4))
    # a body without ground has terms of its own by its links alone, here by its mass
    for shoe in (0, 3, 4):
        own = slice(6 * shoe, 6 * shoe + 6)
        dense[own, own] += 4.0 * np.eye(6)
        front(fronts, values, shoe)[:6, :6] += 4.0 * np.eye(6)
    assert_solved(dense, fronts, values)


def test_a_front_of_a_chain_meets_its_neighbour_the_ground_and_where_it_closes_the_last_link():
    _, fronts, _ = equations(*chain(7))
    assert [len(fronts.rows(k)) for k in range(8, 14)] == [5 + 5 + 7] * 6
    assert fronts.pivots[-1] == 7
    assert fronts.parent[-1] == -1
    # what is left of a link meets the last one too, until it is its turn
    _, fronts, _ = equations(*chain(8))
    assert [len(fronts.rows(k)) for k in range(8, 14)] == [5 + 5 + 5 + 7] * 6


def test_singular_equations_are_told():
    _, fronts, values = equations(*chain(7))
    values[:] = 0.0
    with pytest.raises(np.linalg.LinAlgError):
        eliminate(fronts, values)
