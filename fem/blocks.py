"""One pass over the stresses of a long modal history, block by block, for whatever is kept of them.

Nodes go outside and times inside: each block of nodes is seen over the whole history, in order of time,
before the next one begins. Memory holds the history of the modal coordinates and one block of stresses,
however long the history is and however many nodes the mesh has.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from fem.mesh import Floats, Integers

NODE_BLOCK, TIME_BLOCK = 512, 256
"""Nodes and times of one product; its result stays in the processor's cache."""

Result = TypeVar("Result", covariant=True)


class StressBlock(NamedTuple):
    """Stresses of k nodes at t successive times.

    Attributes
    ----------
    nodes : slice
        Places of the nodes among those that are looked at.
    times : slice
        Rows of the history.
    stress : array (k, c, t)
        The fold's components in Pa; reused, so that a fold copies what it keeps.
    """

    nodes: slice
    times: slice
    stress: Floats


class Fold(Protocol[Result]):
    """What is kept of a history of stresses.

    A fold that needs whole histories of single nodes, as counts of cycles do, gathers the blocks of the same
    nodes until `times.stop` is the number of times, and is done with these nodes then.

    Attributes
    ----------
    components : array (c, 6), or None
        Combinations of xx, yy, zz, xy, yz, xz that it asks for; the six themselves if None.
    """

    components: Floats | None

    def start(self, nodes: Integers, times: int) -> None:
        """Begin with the numbers (n,) of the nodes to come and the number of times."""

    def add(self, block: StressBlock) -> None:
        """Take the next block: times in order for the same nodes, then the next nodes."""

    def finish(self) -> Result:
        """Give what was kept."""


def fold_stresses(
    stress_modes: Floats,
    q: Floats | Iterable[Floats],
    fold: Fold[Result],
    nodes: Integers | None = None,
) -> Result:
    """Lead a fold over the stresses of a history.

    Parameters
    ----------
    stress_modes : array (n, 6, m)
        In Pa per unit of a modal coordinate.
    q : array (t, m), or iterable of arrays
        Modal coordinates, or blocks of them in order of time.
    fold : Fold
        What is kept.
    nodes : int array, optional
        Numbers of the nodes to look at, in any order; all if left out.

    Returns
    -------
    What the fold's `finish` gives.

    Raises
    ------
    ValueError
        If the history is empty or not finite, or has another number of modes.
    """
    history = list(_checked_blocks(q, stress_modes.shape[2]))
    chosen = np.arange(len(stress_modes)) if nodes is None else np.asarray(nodes, dtype=np.int64)
    fold.start(chosen, sum(columns.shape[1] for columns in history))
    for block in _stress_blocks(stress_modes, history, fold.components, chosen):
        fold.add(block)
    return fold.finish()


def _stress_blocks(
    stress_modes: Floats, history: list[Floats], components: Floats | None, nodes: Integers
) -> Iterator[StressBlock]:
    """Stresses of blocks of nodes over a history of columns (m, t); times run fastest."""
    for first in range(0, len(nodes), NODE_BLOCK):
        places = slice(first, min(first + NODE_BLOCK, len(nodes)))
        shapes = _shapes(stress_modes[nodes[places]], components)
        start = 0
        for columns in history:
            times = slice(start, start + columns.shape[1])
            stress = shapes.reshape(-1, shapes.shape[2]) @ columns
            yield StressBlock(places, times, stress.reshape(*shapes.shape[:2], -1))
            start = times.stop


def _shapes(stress_modes: Floats, components: Floats | None) -> Floats:
    """Components (k, c, m) of the stress modes (k, 6, m) of a block of nodes."""
    if components is None:
        return stress_modes
    return np.ascontiguousarray(np.einsum("ck,nkm->ncm", components, stress_modes, optimize=True))


def _checked_blocks(q: Floats | Iterable[Floats], modes: int) -> Iterator[Floats]:
    """Blocks (m, t) of a history; refuses one that does not fit or is not finite, and a history of none."""
    start = 0
    for block in _row_blocks(q):
        if block.shape[1] != modes:
            raise ValueError(f"the history must have {modes} modal coordinates, got {block.shape[1]}")
        if not np.isfinite(block).all():
            raise ValueError(
                f"the history must be finite, got other numbers in rows {start} to {start + len(block) - 1}"
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
