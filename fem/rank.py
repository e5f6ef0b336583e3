"""Histories of stress as products of shapes and coordinates: at full rank, or at a reduced one with a bound.

A long history of modal coordinates moves along fewer directions than there are modes. A singular value
decomposition finds them. It weights every mode by its stress, which for modes is nearly their strain energy,
in which they are orthogonal; the last directions are dropped. The error is bounded: the stress at a node
changes by no more than the sum over the dropped directions of their stress there times their greatest
amplitude. The other directions are in single precision, whose rounding the bound includes (N. J. Higham,
Accuracy and Stability of Numerical Algorithms, 2nd ed., section 3.1).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fem.mesh import Floats
from fem.shapes import Columns

NODE_BLOCK, TIME_BLOCK = 256, 256
"""Nodes and times of one product; its result stays in the processor's cache."""
HALF_ULP = 2.0**-24
"""Relative rounding error of single precision."""
SCAN = 16
"""Roundings beyond those of a product: conversion of both factors, squares, their sum, root, bounds."""


class StressHistory(NamedTuple):
    """Stress of n nodes over a history as shapes times coordinates, of r directions.

    Attributes
    ----------
    shapes : callable
        Shapes (k, c, r) of a block of nodes, given as a slice.
    history : list of array (r, t)
        Coordinates, blocks in order of time.
    bound : array (n, blocks)
        Greatest error of the components at each node in each block of times, as a length in Pa.
    """

    shapes: Callable[[slice], Floats]
    history: list[Floats]
    bound: Floats


def node_blocks(count: int) -> list[slice]:
    """Slices that cut nodes into blocks."""
    return [slice(first, min(first + NODE_BLOCK, count)) for first in range(0, count, NODE_BLOCK)]


def full_rank(stress_modes: Columns, history: list[Floats], components: Floats | None) -> StressHistory:
    """Stress of modes (n, 6, m) over a history of blocks (m, t), in double precision.

    Parameters
    ----------
    components : array (c, 6), or None
        Combinations of the stress components; the six themselves if None.
    """

    def shapes(nodes: slice) -> Floats:
        if components is None:
            return stress_modes[nodes]
        combined = np.einsum("ck,nkm->ncm", components, stress_modes[nodes], optimize=True)
        return np.ascontiguousarray(combined)

    return StressHistory(shapes, history, np.broadcast_to(0.0, (len(stress_modes), len(history))))


def reduced_rank(exact: StressHistory, tolerance: float) -> StressHistory:
    """Same history along fewer directions, in single precision.

    Parameters
    ----------
    exact : StressHistory
        At full rank.
    tolerance : float
        Greatest bound that dropping directions may cause anywhere, over the highest stress at the time of the
        greatest amplitude.
    """
    blocks = node_blocks(len(exact.bound))
    q = np.concatenate(exact.history, axis=1)
    weights = np.sqrt(sum(np.einsum("ncm,ncm->m", *2 * (exact.shapes(nodes),)) for nodes in blocks))
    weights[weights == 0.0] = 1.0  # modes without stress
    weighted = weights[:, None] * q
    directions = np.linalg.svd(weighted, full_matrices=False)[0]
    amplitudes = directions.T @ weighted
    turn = directions / weights[:, None]
    shapes = [exact.shapes(nodes) @ turn for nodes in blocks]
    lengths = np.concatenate([np.linalg.norm(part, axis=1) for part in shapes])
    instant = amplitudes[:, np.linalg.norm(amplitudes, axis=0).argmax()]
    highest = max(np.linalg.norm(part @ instant, axis=1).max() for part in shapes)
    left_out = _tails(lengths * np.abs(amplitudes).max(axis=1)).max(axis=0)
    rank = int(np.flatnonzero(left_out <= tolerance * highest)[0])
    steps = (rank + SCAN) * HALF_ULP
    certainty = np.where(np.arange(len(amplitudes)) < rank, steps / (1.0 - steps), 1.0 + steps)
    starts = np.cumsum([0, *(block.shape[1] for block in exact.history[:-1])])
    greatest = np.maximum.reduceat(np.abs(amplitudes), starts, axis=1)
    single = np.concatenate([part[:, :, :rank].astype(np.float32) for part in shapes])
    columns = np.split(amplitudes[:rank].astype(np.float32), starts[1:], axis=1)
    return StressHistory(
        lambda nodes: single[nodes],
        [np.asfortranarray(block) for block in columns],
        lengths @ (certainty[:, None] * greatest),
    )


def _tails(values: Floats) -> Floats:
    """Sums (n, p + 1) of the last p, p - 1, ..., 0 of values (n, p)."""
    sums = np.cumsum(values[:, ::-1], axis=1)[:, ::-1]
    return np.concatenate((sums, np.zeros((len(values), 1))), axis=1)
