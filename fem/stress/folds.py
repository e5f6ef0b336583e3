"""Pass over the stresses of a long modal history, block by block, for any result of them.

One segment of the history is in memory at a time. Within it, each block of nodes is processed in order of
time before the next block. Memory holds the segment's modal coordinates and one block of stresses, whatever
the length of the history and the number of nodes.
"""

from collections.abc import Iterator
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from fem.body.mesh import Floats, Integers
from fem.body.shapes import Columns
from fem.stress.low_rank import ModalHistory, StressHistory, full_rank, node_blocks, reduced_rank

Result = TypeVar("Result", covariant=True)


class StressBlock(NamedTuple):
    """Stresses of k nodes at t successive times.

    Attributes
    ----------
    nodes : slice
        Positions of the nodes among those of the fold.
    times : slice
        Rows of the history.
    segment : slice
        Rows that are in memory together; the last block of these nodes ends at their end.
    stress : array (k, c, t)
        The fold's components in Pa; overwritten by the next block.
    bound : array (k,)
        Greatest error of each node's components at these times, as a length in Pa; 0 at full rank.
    """

    nodes: slice
    times: slice
    segment: slice
    stress: Floats
    bound: Floats


class Fold(Protocol[Result]):
    """Computation of a result from a history of stresses.

    A cycle count and other folds need long histories of single nodes. They gather the blocks of the same
    nodes until `times` stops at the end of the segment.

    Attributes
    ----------
    components : array (c, 6), or None
        Combinations of xx, yy, zz, xy, yz, xz that the fold needs; the six themselves if None.
    """

    components: Floats | None

    def start(self, nodes: Integers, times: int) -> None:
        """Begin with the numbers (n,) of the nodes and the number of times to come."""

    def add(self, block: StressBlock) -> None:
        """Process the next block: times of a segment in order, then the next nodes, then the next segment."""

    def finish(self) -> Result:
        """Return the result."""


def fold_stresses(
    stress_modes: Columns,
    q: ModalHistory,
    fold: Fold[Result],
    nodes: Integers | None = None,
    tolerance: float | None = None,
) -> Result:
    """Apply a fold to the stresses of a history.

    Parameters
    ----------
    stress_modes : columns (n, 6, m)
        Stress of modes, or of modes and static fields side by side, in Pa per unit of a coordinate.
    q : array (t, m), or iterable of arrays
        Coordinates, or parts of them in order of time; one segment of a stored history is in memory.
    fold : Fold
    nodes : int array, optional
        Numbers of the fold's nodes, in any order; all if left out.
    tolerance : float, optional
        Greatest error of stresses at a reduced rank, fraction of the highest stress, see
        `low_rank.reduced_rank`. The fold is then in single precision and several times as fast, and each
        block has its bound. If left out, the fold is at full rank and in double precision.

    Returns
    -------
    Result of the fold's `finish`.

    Raises
    ------
    ValueError
        If the history is empty or not finite, or has another number of modes.
    """
    parts = np.atleast_2d(q) if isinstance(q, np.ndarray) else list(q) if isinstance(q, Iterator) else q
    times = parts.shape[0] if hasattr(parts, "shape") else sum(len(np.atleast_2d(part)) for part in parts)
    if times == 0:
        raise ValueError("the history must have at least one row, got none")
    chosen = np.arange(len(stress_modes)) if nodes is None else np.asarray(nodes, dtype=np.int64)
    fold.start(chosen, times)
    # threads gain nothing in products of this size: they would wait for each other thousands of times
    with threadpool_limits(1, user_api="blas"):
        source = full_rank(stress_modes if nodes is None else stress_modes[chosen], parts, fold.components)
        for block in _stress_blocks(source if tolerance is None else reduced_rank(source, tolerance)):
            fold.add(block)
    return fold.finish()


def _stress_blocks(source: StressHistory) -> Iterator[StressBlock]:
    """Yield the stresses of blocks of nodes over the segments of a history; times run fastest."""
    for start, columns, bound in source.segments():
        ends = np.cumsum([start, *(block.shape[1] for block in columns)]).tolist()
        for of in node_blocks(source.nodes):
            shapes = source.shapes(of)
            k, c, r = shapes.shape
            for number, block in enumerate(columns):
                times = slice(ends[number], ends[number + 1])
                whole = slice(start, ends[-1])
                stress = (shapes.reshape(k * c, r) @ block).reshape(k, c, -1)
                yield StressBlock(of, times, whole, stress, bound[of, number])
