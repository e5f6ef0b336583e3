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

solving_within = compiler(Path(__file__).parent, *SOURCES, error_model="numpy", no_cpython_wrapper=True)
"""The same for compiled callers alone, as `ground.frames.within`."""

solving_inside = compiler(
    Path(__file__).parent, *SOURCES, error_model="numpy", no_cpython_wrapper=True, forceinline=True
)
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


@solving_within
def clear(places: Fronts, values: FloatArray) -> None:
    """Take the terms out of all fronts: few of their rows have any."""
    for k in range(places.own.shape[0]):
        matrix, met = front(places, values, k), marks(places, values, k)
        for r in range(matrix.shape[0]):
            if r < places.own[k] or met[r] != 0.0:
                for c in range(matrix.shape[0]):
                    matrix[r, c] = 0.0
                met[r] = 0.0


@solving_within
def _met(met: FloatArray, own: int, rows: IntArray) -> int:
    """Write which rows behind a front's own are marked; give how many."""
    count = 0
    for r in range(own, met.shape[0]):
        if met[r] != 0.0:
            rows[count] = r
            count += 1
    return count


@solving_within
def _invert(matrix: FloatArray, own: int, pivots: IntArray) -> None:
    """Invert the first rows and columns of a matrix in place (Gauss and Jordan, rows exchanged)."""
    for k in range(own):
        p = k
        for r in range(k + 1, own):
            if abs(matrix[r, k]) > abs(matrix[p, k]):
                p = r
        pivots[k], pivot = p, matrix[p, k]
        if pivot == 0.0:
            raise np.linalg.LinAlgError("Matrix is singular to machine precision.")
        for c in range(own if p != k else 0):
            matrix[p, c], matrix[k, c] = matrix[k, c], matrix[p, c]
        matrix[k, k] = 1.0
        for c in range(own):
            matrix[k, c] /= pivot
        for r in range(own):
            factor = matrix[r, k] if r != k else 0.0
            if factor != 0.0:
                matrix[r, k] = 0.0
                for c in range(own):
                    matrix[r, c] -= factor * matrix[k, c]
    for k in range(own - 1, -1, -1):
        for r in range(own if pivots[k] != k else 0):
            matrix[r, k], matrix[r, pivots[k]] = matrix[r, pivots[k]], matrix[r, k]


@solving_within
def _add_product(left: FloatArray, right: FloatArray, out: FloatArray) -> None:
    """Add a product of small matrices, row by row."""
    for i in range(out.shape[0]):
        row = out[i]
        for k in range(right.shape[0]):
            f, by = left[i, k], right[k]
            for j in range(row.shape[0]):
                row[j] += f * by[j]


@solving
def eliminate(fronts: tuple, values: FloatArray) -> None:
    """Eliminate group by group, in place; a `LinAlgError` if the matrix of a group is singular.

    `fronts` are `Fronts` as a plain tuple, `values` (size,) the matrices of the fronts, each with the terms
    that were put there, and their marks; they are overwritten with what `solve` takes. Shoes may touch much
    that they do not touch now: rows without any term are left out.
    """
    places = Fronts(*fronts)
    rows, pivots = np.empty((2, places.unknowns.shape[0]), dtype=np.int64)
    for k in range(places.own.shape[0]):
        matrix, own = front(places, values, k), places.own[k]
        count, small = _met(marks(places, values, k), own, rows), own <= places.small
        below, beside = np.empty((count, own)), np.empty((own, count))
        for i in range(own):
            for j in range(count):
                below[j, i], beside[i, j] = matrix[rows[j], i], matrix[i, rows[j]]
        if small:
            _invert(matrix, own, pivots)
            right = np.zeros((own, count))
            _add_product(matrix, beside, right)
        else:
            inverse = np.linalg.inv(np.ascontiguousarray(matrix[:own, :own]))
            right = np.dot(inverse, beside)
            for i in range(own):
                for j in range(own):
                    matrix[i, j] = inverse[i, j]
        for i in range(own):
            for j in range(count):
                matrix[i, rows[j]] = right[i, j]
        if places.parent[k] < 0:
            continue
        if small:
            taken = np.zeros((count, count))
            _add_product(below, right, taken)
        else:
            taken = np.dot(below, right)
        above, first = front(places, values, places.parent[k]), places.first[k]
        met = marks(places, values, places.parent[k])
        for i in range(count):
            row, to = matrix[rows[i]], above[places.into[first + rows[i]]]
            met[places.into[first + rows[i]]] = 1.0
            for j in range(count):
                to[places.into[first + rows[j]]] += row[rows[j]] - taken[i, j]


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
