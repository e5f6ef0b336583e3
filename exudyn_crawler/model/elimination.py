"""Solution of sparse linear equations by eliminating groups of unknowns one after the other.

A group and all unknowns that it is coupled to when its turn comes make a dense front, a small matrix of its
own; what eliminating the group leaves of it goes on to the front of the next group that it touches (the
multifrontal method: Duff and Reid, ACM TOMS 9, 1983). Which groups there are, in which order they go and what
couples them is data: more bodies, or a chain that closes, are more groups and not more code.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inlined, inner, kernel
from exudyn_crawler.ground.packed import FloatArray, IntArray, Ints1


class Fronts(NamedTuple):
    """Fronts in the order of their elimination; one array has the values of all of them, then their marks."""

    unknowns: Ints1  # (entries,): unknowns of every front, its own group's first
    first: Ints1  # (fronts + 1,): where a front's unknowns start
    pivots: Ints1  # (fronts,): how many of them it eliminates
    place: Ints1  # (fronts + 1,): where a front's square matrix starts among all values, row by row
    parent: Ints1  # (fronts,): front that takes what is left, -1 where nothing is
    into: Ints1  # (entries,): row in the parent's matrix of every unknown that is left

    @property
    def size(self) -> int:
        """Length of the array of values."""
        return int(self.place[-1] + self.first[-1])

    def rows(self, front: int) -> list[int]:
        """Unknowns of a front in the order of its rows."""
        return self.unknowns[self.first[front] : self.first[front + 1]].tolist()


def fronts_of(groups: Sequence[Sequence[int]], couplings: Sequence[Sequence[int]]) -> Fronts:
    """Fronts of equations whose groups of unknowns are eliminated in the given order.

    Each unknown is in one of the `groups`. `couplings` are sets of unknowns that equations couple with each
    other: all of a set meet in the front of the group among them that goes first.
    """
    order = {unknown: rank for rank, unknown in enumerate(u for group in groups for u in group)}
    group_of = {unknown: k for k, group in enumerate(groups) for unknown in group}
    met: list[set[int]] = [set(group) for group in groups]
    for coupling in couplings:
        met[min(group_of[unknown] for unknown in coupling)].update(coupling)
    unknowns: list[list[int]] = []
    parents: list[int] = []
    for k, group in enumerate(groups):
        left = sorted(met[k].difference(group), key=order.__getitem__)
        parents.append(group_of[left[0]] if left else -1)
        if left:
            met[parents[k]].update(left)
        unknowns.append([*group, *left])
    into: list[int] = []
    for k, rows in enumerate(unknowns):
        row_of = {u: row for row, u in enumerate(unknowns[parents[k]])} if parents[k] >= 0 else {}
        into += [row_of.get(u, -1) if u not in groups[k] else -1 for u in rows]
    sizes = np.array([len(rows) for rows in unknowns])
    return Fronts(
        np.array([u for rows in unknowns for u in rows]),
        np.concatenate(([0], np.cumsum(sizes))),
        np.array([len(group) for group in groups]),
        np.concatenate(([0], np.cumsum(sizes**2))),
        np.array(parents),
        np.array(into),
    )


@inlined
def front(places: Fronts, values: FloatArray, k: int) -> FloatArray:
    """Matrix of front k, a view of the array of values."""
    n = places.first[k + 1] - places.first[k]
    return values[places.place[k] : places.place[k + 1]].reshape((n, n))


@inlined
def marks(places: Fronts, values: FloatArray, k: int) -> FloatArray:
    """Marks of front k, a view: not zero for each row behind its own that has a term, beside it or below.

    After its elimination those of its own rows are the rows that were exchanged with these, 2 added; those
    behind are the unknowns that are left, 1 added, then zero.
    """
    start = places.place[-1]
    return values[start + places.first[k] : start + places.first[k + 1]]


@inner(merged=True)
def _met(met: FloatArray, pivots: int, rows: IntArray) -> int:
    """Write which rows behind a front's own are marked; give how many."""
    count = 0
    for r in range(pivots, met.shape[0]):
        if met[r] != 0.0:
            rows[count] = r
            count += 1
    return count


@inner(allocates=True)
def clear(places: Fronts, values: FloatArray) -> None:
    """Take the terms or what `eliminate` left out of all fronts."""
    rows = np.empty(places.unknowns.shape[0], dtype=np.int64)
    for k in range(places.pivots.shape[0]):
        met = marks(places, values, k)
        pivots = places.pivots[k]
        start = places.place[k]
        size = pivots * (pivots + 2 * _met(met, pivots, rows))
        values[start : start + size if met[0] > 1.0 else places.place[k + 1]] = 0.0
        met[:] = 0.0


@inner(merged=True)
def _pivot(matrix: FloatArray, left: int, k: int, exchanged: FloatArray) -> None:
    """Bring the greatest pivot of column k into its row; above it, leave the factors that take it off."""
    p = k
    for r in range(left, k):
        if abs(matrix[r, k]) > abs(matrix[p, k]):
            p = r
    exchanged[k - left] = 2.0 + p
    for c in range(matrix.shape[1] if p != k else 0):
        matrix[p, c], matrix[k, c] = matrix[k, c], matrix[p, c]
    if matrix[k, k] == 0.0:
        raise np.linalg.LinAlgError("Matrix is singular to machine precision.")
    matrix[k, k] = 1.0 / matrix[k, k]
    for r in range(k):
        matrix[r, k] *= matrix[k, k]


@inner
def _factor(matrix: FloatArray, pivots: int, exchanged: FloatArray) -> None:
    """Factor the last `pivots` rows and columns in place, from the last one up (Gauss).

    What is left of the others stands in their place, reciprocal pivots on the diagonal. Two rows at a time
    are taken off those above, which are read and written half as often.
    """
    k = matrix.shape[0] - 1
    left = k + 1 - pivots
    while k > left:
        lower = matrix[k]
        upper = matrix[k - 1]
        m = k - 1
        _pivot(matrix, left, k, exchanged)
        for r in range(k):
            matrix[r, m] -= matrix[r, k] * lower[m]
        _pivot(matrix, left, m, exchanged)
        for c in range(m):
            upper[c] -= upper[k] * lower[c]
        for r in range(m):
            row = matrix[r]
            by_lower = row[k]
            by_upper = row[m]
            if by_lower != 0.0 or by_upper != 0.0:
                for c in range(m):
                    row[c] -= by_lower * lower[c] + by_upper * upper[c]
        k -= 2
    if k == left:
        _pivot(matrix, left, k, exchanged)
        for r in range(k):
            for c in range(k):
                matrix[r, c] -= matrix[r, k] * matrix[k, c]


@inner
def _eliminate(places: Fronts, values: FloatArray, k: int, rows: IntArray, scratch: FloatArray) -> None:
    """Eliminate a front: gathered without the rows that have no term, factored, and stored again.

    From its start there are, for each of its own unknowns, its row of the factored matrix and its column of
    what is left.
    """
    matrix = front(places, values, k)
    met = marks(places, values, k)
    parent = places.parent[k]
    pivots = places.pivots[k]
    start = places.place[k]
    left = _met(met, pivots, rows)
    n = left + pivots
    dense = scratch[: n * n].reshape((n, n))
    for r in range(n):
        row = matrix[rows[r] if r < left else r - left]
        to = dense[r]
        for c in range(left):
            to[c] = row[rows[c]]
        for c in range(pivots):
            to[left + c] = row[c]
        row[:] = 0.0
    _factor(dense, pivots, met)
    for r in range(left, n):
        row = dense[r]
        to = values[start : start + n + left]
        for c in range(n):
            to[c] = row[c]
        for c in range(left):
            to[n + c] = dense[c, r]
        start += n + left
    for r in range(pivots, met.shape[0]):
        met[r] = 1.0 + places.unknowns[places.first[k] + rows[r - pivots]] if r - pivots < left else 0.0
    if parent >= 0:
        higher = front(places, values, parent)
        above = marks(places, values, parent)
        for r in range(left):
            rows[r] = places.into[places.first[k] + rows[r]]
            above[rows[r]] = 1.0
        for r in range(left):
            row = dense[r]
            to = higher[rows[r]]
            for c in range(left):
                to[rows[c]] += row[c]


@kernel
def eliminate(fronts: Fronts, values: FloatArray) -> None:
    """Eliminate group by group, in place; a `LinAlgError` if the matrix of a group is singular.

    `values` (size,) are the matrices of the fronts, each with the terms that were put there, and their marks;
    they are overwritten with what `solve` takes. Shoes may touch much that they do not touch now: rows
    without any term are left out.
    """
    n = np.max(fronts.first[1:] - fronts.first[:-1])
    rows = np.empty(n, dtype=np.int64)
    scratch = np.empty(n * n)
    for k in range(fronts.pivots.shape[0]):
        _eliminate(fronts, values, k, rows, scratch)


@inner
def _gather(
    fronts: Fronts, values: FloatArray, k: int, x: FloatArray, numbers: IntArray, y: FloatArray
) -> int:
    """Write the unknowns of a front, those that are left first, and their values; give how many are left."""
    met = marks(fronts, values, k)
    pivots = fronts.pivots[k]
    left = 0
    while pivots + left < met.shape[0] and met[pivots + left] > 0.0:
        numbers[left] = int(met[pivots + left]) - 1
        left += 1
    for r in range(pivots):
        numbers[left + r] = fronts.unknowns[fronts.first[k] + r]
    for r in range(left + pivots):
        y[r] = x[numbers[r]]
    return left


@inner
def _forward(
    fronts: Fronts, values: FloatArray, k: int, x: FloatArray, numbers: IntArray, y: FloatArray
) -> None:
    """Take the own unknowns of a front out of the right-hand sides of those that are left."""
    left = _gather(fronts, values, k, x, numbers, y)
    met = marks(fronts, values, k)
    start = fronts.place[k]
    n = left + fronts.pivots[k]
    for r in range(n - 1, left - 1, -1):
        p = int(met[r - left]) - 2
        y[r], y[p] = y[p], y[r]
    for r in range(n - 1, left - 1, -1):
        first = start + (r - left) * (n + left)
        row = values[first : first + n]
        column = values[first + n : first + n + left]
        s = y[r]
        for c in range(r + 1, n):
            s -= row[c] * y[c]
        y[r] = s
        for c in range(left):
            y[c] -= s * column[c]
    for r in range(n):
        x[numbers[r]] = y[r]


@inner
def _back(
    fronts: Fronts, values: FloatArray, k: int, x: FloatArray, numbers: IntArray, y: FloatArray
) -> None:
    """Find the own unknowns of a front from those that are left.

    Three sums grow at once: each has to wait for its last term.
    """
    left = _gather(fronts, values, k, x, numbers, y)
    pivots = fronts.pivots[k]
    start = fronts.place[k]
    width = pivots + 2 * left
    end = left + pivots
    rows = values[start : start + pivots * width].reshape((pivots, width))
    for first in range(left, end, 3):
        second = min(first + 1, end - 1)
        third = min(first + 2, end - 1)
        upper = rows[first - left]
        middle = rows[second - left]
        lower = rows[third - left]
        s = y[first]
        t = y[second]
        u = y[third]
        for c in range(first):
            s -= upper[c] * y[c]
            t -= middle[c] * y[c]
            u -= lower[c] * y[c]
        y[first] = s = upper[first] * s
        if second > first:
            y[second] = t = middle[second] * (t - middle[first] * s)
        if third > second:
            y[third] = lower[third] * (u - lower[first] * s - lower[second] * t)
    for r in range(left, end):
        x[numbers[r]] = y[r]


@kernel
def solve(fronts: Fronts, values: FloatArray, x: FloatArray) -> None:
    """Turn a right-hand side (unknowns,) into the solution, in place, after `eliminate`."""
    n = np.max(fronts.first[1:] - fronts.first[:-1])
    y = np.empty(n)
    numbers = np.empty(n, dtype=np.int64)
    for k in range(fronts.pivots.shape[0]):
        _forward(fronts, values, k, x, numbers, y)
    for k in range(fronts.pivots.shape[0] - 1, -1, -1):
        _back(fronts, values, k, x, numbers, y)
