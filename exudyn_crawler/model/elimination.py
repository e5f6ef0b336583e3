"""Solution of sparse linear equations by elimination of groups of unknowns, one after the other.

A group and all unknowns that are coupled to it at its turn make a dense front, a small matrix. The
elimination leaves a Schur complement, which goes on to the front of the next group that it touches (the
multifrontal method: Duff and Reid, ACM TOMS 9, 1983). Groups, their order and their couplings are data: more
bodies, or a closed chain, mean more groups and no more code.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inlined, inner, kernel
from exudyn_crawler.ground.packed import FloatArray, IntArray, Ints1


class Fronts(NamedTuple):
    """Fronts in the order of their elimination.

    Their values are one array: all matrices, then the integers that `terms`, `exchanged`, `remaining` and
    `sizes` read. A front of zeros has no term.
    """

    unknowns: Ints1  # (entries,): unknowns of every front, its own group's first
    first: Ints1  # (fronts + 1,): where a front's unknowns start
    pivots: Ints1  # (fronts,): number of unknowns that it eliminates
    place: Ints1  # (fronts + 1,): where a front's square matrix starts among all values, row by row
    parent: Ints1  # (fronts,): front that takes the remaining part, -1 for none
    into: Ints1  # (entries,): row in the parent's matrix of every unknown that is left

    @property
    def size(self) -> int:
        """Length of the array of values."""
        return int(self.place[-1] + 2 * self.first[-1] + len(self.pivots))

    def rows(self, front: int) -> list[int]:
        """Return the unknowns of a front in the order of its rows."""
        return self.unknowns[self.first[front] : self.first[front + 1]].tolist()


def fronts_of(groups: Sequence[Sequence[int]], couplings: Sequence[Sequence[int]]) -> Fronts:
    """Return the fronts of equations whose groups of unknowns are eliminated in the given order.

    Each unknown is in one of the `groups`. `couplings` are sets of coupled unknowns: all of a set meet in the
    front of the first eliminated group among them.
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
    """Return the matrix of front k, a view of the array of values."""
    n = places.first[k + 1] - places.first[k]
    return values[places.place[k] : places.place[k + 1]].reshape((n, n))


@inlined
def terms(places: Fronts, values: FloatArray, k: int) -> IntArray:
    """Return flags of the rows of front k with a term, a view: nonzero for those behind its own rows."""
    start = places.place[-1]
    return values[start + places.first[k] : start + places.first[k + 1]].view(np.int64)


@inlined
def exchanged(places: Fronts, values: FloatArray, k: int) -> IntArray:
    """Return the rows exchanged with the own rows of front k in its elimination, a view."""
    start = places.place[-1] + places.first[-1] + places.first[k]
    return values[start : start + places.pivots[k]].view(np.int64)


@inlined
def remaining(places: Fronts, values: FloatArray, k: int) -> IntArray:
    """Return the unknowns that remain after the elimination of front k, a view; `sizes` is their number."""
    start = places.place[-1] + places.first[-1]
    return values[start + places.first[k] + places.pivots[k] : start + places.first[k + 1]].view(np.int64)


@inlined
def sizes(places: Fronts, values: FloatArray) -> IntArray:
    """Return the numbers of rows with a term of eliminated fronts, a view; zero before the elimination."""
    start = places.place[-1] + 2 * places.first[-1]
    return values[start : start + places.pivots.shape[0]].view(np.int64)


@inner(merged=True)
def _write_rows(has_term: IntArray, pivots: int, rows: IntArray) -> int:
    """Write the rows with a term behind a front's own rows; return their number."""
    count = 0
    for r in range(pivots, has_term.shape[0]):
        if has_term[r] != 0:
            rows[count] = r
            count += 1
    return count


@inner
def clear(places: Fronts, values: FloatArray) -> None:
    """Clear the terms of all fronts, or the results of `eliminate`."""
    rows = sizes(places, values)
    for k in range(places.pivots.shape[0]):
        pivots = places.pivots[k]
        start = places.place[k]
        eliminated = start + pivots * (2 * rows[k] - pivots)
        values[start : eliminated if rows[k] > 0 else places.place[k + 1]] = 0.0
        rows[k] = 0
        terms(places, values, k)[:] = 0


@inner(merged=True)
def _pivot(matrix: FloatArray, left: int, k: int, exchanges: IntArray) -> None:
    """Exchange the greatest pivot of column k into its row; write the elimination factors above it."""
    p = k
    for r in range(left, k):
        if abs(matrix[r, k]) > abs(matrix[p, k]):
            p = r
    exchanges[k - left] = p
    for c in range(matrix.shape[1] if p != k else 0):
        matrix[p, c], matrix[k, c] = matrix[k, c], matrix[p, c]
    if matrix[k, k] == 0.0:
        raise np.linalg.LinAlgError("Matrix is singular to machine precision.")
    matrix[k, k] = 1.0 / matrix[k, k]
    for r in range(k):
        matrix[r, k] *= matrix[k, k]


@inner
def _factor(matrix: FloatArray, pivots: int, exchanges: IntArray) -> None:
    """Factor the last `pivots` rows and columns in place, from the last one up (Gauss).

    The Schur complement of the others takes their place, with reciprocal pivots on the diagonal. Two rows at
    a time are subtracted from those above, which are then read and written half as often.
    """
    k = matrix.shape[0] - 1
    left = k + 1 - pivots
    while k > left:
        lower = matrix[k]
        upper = matrix[k - 1]
        m = k - 1
        _pivot(matrix, left, k, exchanges)
        for r in range(k):
            matrix[r, m] -= matrix[r, k] * lower[m]
        _pivot(matrix, left, m, exchanges)
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
        _pivot(matrix, left, k, exchanges)
        for r in range(k):
            for c in range(k):
                matrix[r, c] -= matrix[r, k] * matrix[k, c]


@inner
def _eliminate(places: Fronts, values: FloatArray, k: int, rows: IntArray, scratch: FloatArray) -> None:
    """Eliminate a front: gather it without rows that have no term, factor it, and store it again.

    From its start it stores, for each of its own unknowns, its row of the factored matrix and its column of
    the remaining part.
    """
    matrix = front(places, values, k)
    parent = places.parent[k]
    pivots = places.pivots[k]
    start = places.place[k]
    left = _write_rows(terms(places, values, k), pivots, rows)
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
    _factor(dense, pivots, exchanged(places, values, k))
    for r in range(left, n):
        row = dense[r]
        to = values[start : start + n + left]
        for c in range(n):
            to[c] = row[c]
        for c in range(left):
            to[n + c] = dense[c, r]
        start += n + left
    sizes(places, values)[k] = n
    unknowns = remaining(places, values, k)
    for r in range(left):
        unknowns[r] = places.unknowns[places.first[k] + rows[r]]
    if parent >= 0:
        higher = front(places, values, parent)
        above = terms(places, values, parent)
        for r in range(left):
            rows[r] = places.into[places.first[k] + rows[r]]
            above[rows[r]] = 1
        for r in range(left):
            row = dense[r]
            to = higher[rows[r]]
            for c in range(left):
                to[rows[c]] += row[c]


@kernel
def eliminate(fronts: Fronts, values: FloatArray) -> None:
    """Eliminate group by group, in place; raise `LinAlgError` if the matrix of a group is singular.

    `values` (size,) are those of the fronts: the terms of their matrices, and `terms` for the rows. They are
    overwritten with the input of `solve`. Rows without any term are left out, because shoes can touch many
    units that they do not touch now.
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
    """Write the unknowns of a front, the remaining ones first, and their values.

    Return the number of the remaining ones.
    """
    unknowns = remaining(fronts, values, k)
    pivots = fronts.pivots[k]
    left = sizes(fronts, values)[k] - pivots
    for r in range(left):
        numbers[r] = unknowns[r]
    for r in range(pivots):
        numbers[left + r] = fronts.unknowns[fronts.first[k] + r]
    for r in range(left + pivots):
        y[r] = x[numbers[r]]
    return left


@inner
def _forward(
    fronts: Fronts, values: FloatArray, k: int, x: FloatArray, numbers: IntArray, y: FloatArray
) -> None:
    """Eliminate the own unknowns of a front from the right-hand sides of the remaining ones."""
    left = _gather(fronts, values, k, x, numbers, y)
    exchanges = exchanged(fronts, values, k)
    start = fronts.place[k]
    n = left + fronts.pivots[k]
    for r in range(n - 1, left - 1, -1):
        p = exchanges[r - left]
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
    """Compute the own unknowns of a front from the remaining ones.

    Three sums grow at once, because each has to wait for its last term.
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
    """Overwrite a right-hand side (unknowns,) with the solution, after `eliminate`."""
    reduce(fronts, values, x, np.int64(0))
    complete(fronts, values, x)


@kernel
def reduce(fronts: Fronts, values: FloatArray, x: FloatArray, first: int) -> None:
    """Overwrite a right-hand side (unknowns,) with that of the last front, and solve for its own unknowns.

    Other terms may be added to the solution of the last front before `complete`. Fronts before `first` are
    left out; their right-hand sides must be zero.
    """
    n = np.max(fronts.first[1:] - fronts.first[:-1])
    y = np.empty(n)
    numbers = np.empty(n, dtype=np.int64)
    last = fronts.pivots.shape[0] - 1
    for k in range(first, last + 1):
        _forward(fronts, values, k, x, numbers, y)
    _back(fronts, values, last, x, numbers, y)


@kernel
def complete(fronts: Fronts, values: FloatArray, x: FloatArray) -> None:
    """Compute the unknowns of all other fronts from those of the last one, after `reduce`."""
    n = np.max(fronts.first[1:] - fronts.first[:-1])
    y = np.empty(n)
    numbers = np.empty(n, dtype=np.int64)
    for k in range(fronts.pivots.shape[0] - 2, -1, -1):
        _back(fronts, values, k, x, numbers, y)
