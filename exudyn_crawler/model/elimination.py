"""Solution of sparse linear equations by eliminating groups of unknowns one after the other.

A group and all unknowns that it is coupled to when its turn comes make a dense front, a small matrix of its
own; what eliminating the group leaves of it goes on to the front of the next group that it touches (the
multifrontal method: Duff and Reid, ACM TOMS 9, 1983). Which groups there are, in which order they go and what
couples them is data: more bodies, or a chain that closes, are more groups and not more code.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.frames import SOURCES
from exudyn_crawler.ground.rotations import FloatArray, IntArray
from fem.compiling import compiler

solving = compiler(Path(__file__).parent, *SOURCES, error_model="numpy")
"""Compiles a function of this room. Sums are taken in their order: where the compiler may choose, processes
that compile apart from each other get other last digits."""

_OPTIONS = {"error_model": "numpy", "no_cpython_wrapper": True}

solving_allocating = compiler(Path(__file__).parent, *SOURCES, **_OPTIONS)
"""The same for compiled callers alone, as `ground.frames.allocating`."""

solving_within = compiler(Path(__file__).parent, *SOURCES, **_OPTIONS, _nrt=False)
"""The same without counts of references, as `ground.frames.within`."""

solving_inside = compiler(Path(__file__).parent, *SOURCES, **_OPTIONS, _nrt=False, forceinline=True)
"""The same, made part of its callers: handing over tables takes longer than what short functions do."""


class Fronts(NamedTuple):
    """Fronts in the order of their elimination; one array has the values of all of them, then their marks."""

    unknowns: IntArray  # (entries,): unknowns of every front, its own group's first
    first: IntArray  # (fronts + 1,): where a front's unknowns start
    own: IntArray  # (fronts,): how many of them it eliminates
    place: IntArray  # (fronts + 1,): where a front's square matrix starts among all values, row by row
    parent: IntArray  # (fronts,): front that takes what is left, -1 where nothing is
    into: IntArray  # (entries,): row in the parent's matrix of every unknown that is left
    small: int = 0  # groups of at most so many unknowns are eliminated by plain loops, larger ones by LAPACK

    @property
    def size(self) -> int:
        """Length of the array of values."""
        return int(self.place[-1] + self.first[-1])

    def rows(self, front: int) -> list[int]:
        """Unknowns of a front in the order of its rows."""
        return self.unknowns[self.first[front] : self.first[front + 1]].tolist()


def fronts_of(groups: Sequence[Sequence[int]], couplings: Sequence[Sequence[int]], small: int = 0) -> Fronts:
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
        small,
    )


@solving
def front(places: Fronts, values: FloatArray, k: int) -> FloatArray:
    """Matrix of front k, a view of the array of values."""
    n = places.first[k + 1] - places.first[k]
    return values[places.place[k] : places.place[k + 1]].reshape((n, n))


@solving
def marks(places: Fronts, values: FloatArray, k: int) -> FloatArray:
    """Marks of front k, a view: not zero for each row behind its own that has a term, beside it or below."""
    start = places.place[-1]
    return values[start + places.first[k] : start + places.first[k + 1]]


@solving_allocating
def clear(places: Fronts, values: FloatArray) -> None:
    """Take the terms out of all fronts: few of their rows and columns have any."""
    rows = np.empty(places.unknowns.shape[0], dtype=np.int64)
    for k in range(places.own.shape[0]):
        at, n, met = places.place[k], places.first[k + 1] - places.first[k], marks(places, values, k)
        own = places.own[k]
        count = own + _met(met, own, rows[own:])
        for r in range(own):
            rows[r] = r
        for r in range(count):
            for c in range(count):
                values[at + rows[r] * n + rows[c]] = 0.0
        met.fill(0.0)


@solving_inside
def _met(met: FloatArray, own: int, rows: IntArray) -> int:
    """Write which rows behind a front's own are marked; give how many."""
    count = 0
    for r in range(own, met.shape[0]):
        if met[r] != 0.0:
            rows[count] = r
            count += 1
    return count


@solving_within
def _invert(values: FloatArray, at: int, n: int, own: int, pivots: IntArray) -> None:
    """Invert the first rows and columns of a front in place (Gauss and Jordan, rows exchanged).

    The front starts at a place of the values and has n columns.
    """
    for k in range(own):
        p, to = k, at + k * n
        for r in range(k + 1, own):
            if abs(values[at + r * n + k]) > abs(values[at + p * n + k]):
                p = r
        pivots[k], pivot = p, values[at + p * n + k]
        if pivot == 0.0:
            raise np.linalg.LinAlgError("Matrix is singular to machine precision.")
        for c in range(own if p != k else 0):
            values[at + p * n + c], values[to + c] = values[to + c], values[at + p * n + c]
        values[to + k] = 1.0
        for c in range(own):
            values[to + c] /= pivot
        for r in range(own):
            row = at + r * n
            factor = values[row + k] if r != k else 0.0
            if factor != 0.0:
                values[row + k] = 0.0
                for c in range(own):
                    values[row + c] -= factor * values[to + c]
    for k in range(own - 1, -1, -1):
        p = pivots[k]
        for r in range(own if p != k else 0):
            row = at + r * n
            values[row + k], values[row + p] = values[row + p], values[row + k]


@solving_within
def _eliminate_small(
    values: FloatArray,
    front: tuple[int, int, int],
    rows: IntArray,
    above: tuple[int, int],
    into: IntArray,
    scratch: tuple[IntArray, FloatArray, FloatArray, FloatArray],
) -> None:
    """Eliminate the own unknowns of a small front by plain loops.

    `front` and `above` are where it and its parent start among the values and how many columns they have,
    the former with the number of its own; `rows` (count,) are the rows that are left, and `into` theirs in
    the parent. Places of numbers are reckoned here: views of rows would take longer than what is done.
    """
    (at, n, own), (top, width), (pivots, beside, right, taken) = front, above, scratch
    count = rows.shape[0]
    for i in range(own):
        for j in range(count):
            beside[i, j], right[i, j] = values[at + i * n + rows[j]], 0.0
    _invert(values, at, n, own, pivots)
    for i in range(own):
        for k in range(own):
            factor = values[at + i * n + k]
            for j in range(count):
                right[i, j] += factor * beside[k, j]
        for j in range(count):
            values[at + i * n + rows[j]] = right[i, j]
    for i in range(count if top >= 0 else 0):
        row, to = at + rows[i] * n, top + into[i] * width
        taken.fill(0.0)
        for k in range(own):
            factor = values[row + k]
            for j in range(count):
                taken[j] += factor * right[k, j]
        for j in range(count):
            values[to + into[j]] += values[row + rows[j]] - taken[j]


@solving
def eliminate(fronts: tuple, values: FloatArray) -> None:
    """Eliminate group by group, in place; a `LinAlgError` if the matrix of a group is singular.

    `fronts` are `Fronts` as a plain tuple, `values` (size,) the matrices of the fronts, each with the terms
    that were put there, and their marks; they are overwritten with what `solve` takes. Shoes may touch much
    that they do not touch now: rows without any term are left out.
    """
    places = Fronts(*fronts)
    most = places.unknowns.shape[0]
    rows, into, pivots = np.empty((3, most), dtype=np.int64)
    wide = np.max(places.first[1:] - places.first[:-1])
    beside, right, taken = np.empty((places.small, wide)), np.empty((places.small, wide)), np.empty(wide)
    for k in range(places.own.shape[0]):
        own, parent, first = places.own[k], places.parent[k], places.first[k]
        count = _met(marks(places, values, k), own, rows)
        for i in range(count if parent >= 0 else 0):
            into[i] = places.into[first + rows[i]]
            marks(places, values, parent)[into[i]] = 1.0
        if own <= places.small:
            above, width = -1, 0
            if parent >= 0:
                above, width = places.place[parent], places.first[parent + 1] - places.first[parent]
            this = places.place[k], places.first[k + 1] - first, own
            scratch = pivots, beside, right, taken
            _eliminate_small(values, this, rows[:count], (above, width), into, scratch)
            continue
        matrix = front(places, values, k)
        below, across = np.empty((count, own)), np.empty((own, count))
        for i in range(own):
            for j in range(count):
                below[j, i], across[i, j] = matrix[rows[j], i], matrix[i, rows[j]]
        inverse = np.linalg.inv(np.ascontiguousarray(matrix[:own, :own]))
        solved = np.dot(inverse, across)
        for i in range(own):
            for j in range(own):
                matrix[i, j] = inverse[i, j]
            for j in range(count):
                matrix[i, rows[j]] = solved[i, j]
        if parent < 0:
            continue
        away = np.dot(below, solved)
        higher = front(places, values, parent)
        for i in range(count):
            row, to = matrix[rows[i]], higher[into[i]]
            for j in range(count):
                to[into[j]] += row[rows[j]] - away[i, j]


@solving
def solve(fronts: tuple, values: FloatArray, x: FloatArray) -> None:
    """Turn a right-hand side (unknowns,) into the solution, in place, after `eliminate`."""
    places = Fronts(*fronts)
    y, rows = np.empty(places.unknowns.shape[0]), np.empty(places.unknowns.shape[0], dtype=np.int64)
    for k in range(places.own.shape[0]):
        matrix, own = front(places, values, k), places.own[k]
        at = places.unknowns[places.first[k] : places.first[k + 1]]
        for i in range(own):
            s = 0.0
            for j in range(own):
                s += matrix[i, j] * x[at[j]]
            y[i] = s
        for i in range(own):
            x[at[i]] = y[i]
        for m in range(_met(marks(places, values, k), own, rows)):
            s = 0.0
            for j in range(own):
                s += matrix[rows[m], j] * y[j]
            x[at[rows[m]]] -= s
    for k in range(places.own.shape[0] - 1, -1, -1):
        matrix, own = front(places, values, k), places.own[k]
        at = places.unknowns[places.first[k] : places.first[k + 1]]
        count = _met(marks(places, values, k), own, rows)
        for i in range(own):
            s = 0.0
            for m in range(count):
                s += matrix[i, rows[m]] * x[at[rows[m]]]
            x[at[i]] -= s
