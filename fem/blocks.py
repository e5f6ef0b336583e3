"""One pass over the stresses of a long modal history, block by block, for any result of them.

Nodes go outside and times inside: each block of nodes is seen over the whole history, in order of time,
before the next one begins. Memory holds the history of the modal coordinates and one block of stresses,
however long the history is and however many nodes the mesh has.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from fem.mesh import Floats, Integers
from fem.rank import TIME_BLOCK, StressHistory, full_rank, node_blocks, reduced_rank
from fem.shapes import Columns

Result = TypeVar("Result", covariant=True)


class StressBlock(NamedTuple):
    """Stresses of k nodes at t successive times.

    Attributes
    ----------
    nodes : slice
        Positions of the nodes among those that are looked at.
    times : slice
        Rows of the history.
    stress : array (k, c, t)
        The fold's components in Pa; overwritten by the next block.
    bound : array (k,)
        Greatest error of each node's components at these times, as a length in Pa; 0 at full rank.
    """

    nodes: slice
    times: slice
    stress: Floats
    bound: Floats


class Fold(Protocol[Result]):
    """A result that is gathered from a history of stresses.

    A fold that needs whole histories of single nodes, as counts of cycles do, gathers the blocks of the same
    nodes until `times.stop` is the number of times, and is done with these nodes then.

    Attributes
    ----------
    components : array (c, 6), or None
        Combinations of xx, yy, zz, xy, yz, xz that it needs; the six themselves if None.
    """

    components: Floats | None

    def start(self, nodes: Integers, times: int) -> None:
        """Begin with the numbers (n,) of the nodes to come and the number of times."""

    def add(self, block: StressBlock) -> None:
        """Take the next block: times in order for the same nodes, then the next nodes."""

    def finish(self) -> Result:
        """Return the result."""


def fold_stresses(
    stress_modes: Columns,
    q: Floats | Iterable[Floats],
    fold: Fold[Result],
    nodes: Integers | None = None,
    tolerance: float | None = None,
) -> Result:
    """Apply a fold to the stresses of a history.

    Parameters
    ----------
    stress_modes : columns (n, 6, m)
        In Pa per unit of a coordinate: of modes, or of modes and static fields side by side.
    q : array (t, m), or iterable of arrays
        Coordinates, or blocks of them in order of time.
    fold : Fold
    nodes : int array, optional
        Numbers of the nodes to look at, in any order; all if left out.
    tolerance : float, optional
        Fold stresses of a reduced rank, in single precision and several times as fast. The error is at most
        this part of the highest stress, as of `rank.reduced_rank`, and each block has its bound. If left out,
        at full rank and in double precision.

    Returns
    -------
    Result of the fold's `finish`.

    Raises
    ------
    ValueError
        If the history is empty or not finite, or has another number of modes.
    """
    history = list(_checked_blocks(q, stress_modes.shape[2]))
    chosen = np.arange(len(stress_modes)) if nodes is None else np.asarray(nodes, dtype=np.int64)
    fold.start(chosen, sum(columns.shape[1] for columns in history))
    # products of this size gain nothing by threads, which would wait for each other thousands of times
    with threadpool_limits(1, user_api="blas"):
        source = full_rank(stress_modes if nodes is None else stress_modes[chosen], history, fold.components)
        for block in _stress_blocks(source if tolerance is None else reduced_rank(source, tolerance)):
            fold.add(block)
    return fold.finish()


def _stress_blocks(source: StressHistory) -> Iterator[StressBlock]:
    """Stresses of blocks of nodes over a history; times run fastest."""
    for places in node_blocks(len(source.bound)):
        shapes = source.shapes(places)
        k, c, r = shapes.shape
        start = 0
        for number, columns in enumerate(source.history):
            times = slice(start, start + columns.shape[1])
            stress = shapes.reshape(k * c, r) @ columns
            yield StressBlock(places, times, stress.reshape(k, c, -1), source.bound[places, number])
            start = times.stop


def _checked_blocks(q: Floats | Iterable[Floats], modes: int) -> Iterator[Floats]:
    """Blocks (m, t) of a history; `ValueError` if one does not fit or is not finite, or if there is none."""
    start = 0
    for block in _row_blocks(q):
        if block.shape[1] != modes:
            raise ValueError(f"the history must have {modes} modal coordinates, got {block.shape[1]}")
        if not np.isfinite(block).all():
            raise ValueError(
                f"the history must be finite, got others in rows {start} to {start + len(block) - 1}"
            )
        yield np.asfortranarray(block.T)
        start += len(block)
    if start == 0:
        raise ValueError("the history must have at least one row, got none")


def _row_blocks(q: Floats | Iterable[Floats]) -> Iterator[Floats]:
    parts = [q] if isinstance(q, np.ndarray) else q
    for part in parts:
        part = np.atleast_2d(part)
        for start in range(0, len(part), TIME_BLOCK):
            yield part[start : start + TIME_BLOCK]
