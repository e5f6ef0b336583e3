"""Stress histories as products of shapes and coordinates, at full rank or at a low rank with a bound.

A long history of modal coordinates moves along fewer directions than there are modes. A singular value
decomposition finds the directions and the last ones are dropped. It weights each mode by its stress. For
modes this is nearly the strain energy, and modes are orthogonal in that energy. The stress at a node changes
by at most the sum of the dropped directions' stresses there, each times its greatest amplitude. The other
directions are in single precision. The bound includes their rounding (N. J. Higham, Accuracy and Stability
of Numerical Algorithms, 2nd ed., section 3.1).
"""

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from fem.body.mesh import Floats
from fem.body.shapes import Columns

NODE_BLOCK, TIME_BLOCK = 256, 256
"""Numbers of nodes and times of one product; its result stays in the processor's cache."""
SEGMENT = 2**14
"""Number of successive times whose coordinates are in memory together."""
HALF_ULP = 2.0**-24
"""Relative rounding error of single precision."""
SCAN = 16
"""Number of roundings beyond those of a product: conversion of both factors, squares, sum, root, bounds."""


ModalHistory = Floats | Iterable[Floats]
"""Coordinates (t, m), or their parts in order of time, to be read more than once."""


Segment = tuple[int, list[Floats], Floats]
"""Successive times: first row, blocks (r, t) of coordinates, and greatest error (n, blocks) in Pa."""


class StressHistory(NamedTuple):
    """Stress of n nodes over a history as shapes times coordinates along r directions.

    `shapes` gives the shapes (k, c, r) of a block of nodes, `segments` the history from its start. Errors
    are Euclidean lengths of the components' errors at each node.
    """

    nodes: int
    shapes: Callable[[slice], Floats]
    segments: Callable[[], Iterator[Segment]]


def segments(q: ModalHistory, length: int | None = None) -> Iterator[Floats]:
    """Yield the rows (t, m) of a history, `length` at a time (default `SEGMENT`), whatever its parts."""
    length = length or SEGMENT
    waiting = np.empty((0, 0))
    for part in [q] if isinstance(q, np.ndarray) else q:
        waiting = np.concatenate((waiting, part)) if len(waiting) else np.atleast_2d(part)
        while len(waiting) >= length:
            yield waiting[:length]
            waiting = waiting[length:]
    if len(waiting):
        yield waiting


def node_blocks(count: int) -> list[slice]:
    """Return slices that cut the nodes into blocks."""
    return [slice(first, min(first + NODE_BLOCK, count)) for first in range(0, count, NODE_BLOCK)]


def full_rank(stress_modes: Columns, q: ModalHistory, components: Floats | None) -> StressHistory:
    """Return the stress history of modes (n, 6, m) in double precision.

    `components` (c, 6) are combinations of the stress components; None means the six themselves. The segments
    raise a `ValueError` if they are not finite or have another number of modes.
    """

    def shapes(nodes: slice) -> Floats:
        if components is None:
            return stress_modes[nodes]
        combined = np.einsum("ck,nkm->ncm", components, stress_modes[nodes], optimize=True)
        return np.ascontiguousarray(combined)

    def blocks() -> Iterator[Segment]:
        start = 0
        for rows in segments(q):
            checked(rows, stress_modes, start)
            columns = [rows[first : first + TIME_BLOCK].T for first in range(0, len(rows), TIME_BLOCK)]
            exact = np.broadcast_to(0.0, (len(stress_modes), len(columns)))
            yield start, [np.asfortranarray(block) for block in columns], exact
            start += len(rows)

    return StressHistory(len(stress_modes), shapes, blocks)


def checked(rows: Floats, stress_modes: Columns, start: int = 0) -> Floats:
    """Return rows (t, m) of a history; raise `ValueError` if they are not finite or m differs from the modes.

    `start` is the number of the first row in the history, for the message.
    """
    modes = stress_modes.shape[2]
    if rows.shape[1] != modes:
        raise ValueError(f"the history must have {modes} modal coordinates, got {rows.shape[1]}")
    if not (finite := np.isfinite(rows).all(axis=1)).all():
        raise ValueError(f"the history must be finite, got other numbers in row {start + finite.argmin()}")
    return rows


def reduced_rank(exact: StressHistory, tolerance: float) -> StressHistory:
    """Return a stress history along fewer directions, in single precision.

    Parameters
    ----------
    exact : StressHistory
        History at full rank; it is read several times.
    tolerance : float
        Greatest bound of the dropped directions at any node, fraction of the highest stress at the time of
        the greatest amplitude.
    """
    groups = node_blocks(exact.nodes)
    weights = np.sqrt(sum(np.einsum("ncm,ncm->m", *2 * (exact.shapes(of),)) for of in groups))
    weights[weights == 0.0] = 1.0  # modes without stress
    squares = sum(block @ block.T for _, blocks, _ in exact.segments() for block in blocks)
    directions = np.linalg.eigh(squares * np.outer(weights, weights))[1][:, ::-1]
    into = directions.T * weights
    turn = directions / weights[:, None]
    greatest = np.zeros(len(weights))
    instant = np.zeros(len(weights))
    length = 0.0
    for amplitudes in (into @ block for _, blocks, _ in exact.segments() for block in blocks):
        greatest = np.maximum(greatest, np.abs(amplitudes).max(axis=1))
        lengths = np.linalg.norm(amplitudes, axis=0)
        if lengths.max() > length:
            instant = amplitudes[:, lengths.argmax()]
            length = lengths.max()
    lengths = np.empty((exact.nodes, len(weights)))
    singles = []
    highest = 0.0
    for of in groups:
        shapes = exact.shapes(of) @ turn
        lengths[of] = np.linalg.norm(shapes, axis=1)
        highest = max(highest, float(np.linalg.norm(shapes @ instant, axis=1).max()))
        singles.append(shapes.astype(np.float32))
    left_out = _tails(lengths * greatest).max(axis=0)
    rank = int(np.flatnonzero(left_out <= tolerance * highest)[0])
    steps = (rank + SCAN) * HALF_ULP
    certainty = np.where(np.arange(len(weights)) < rank, steps / (1.0 - steps), 1.0 + steps)
    single = np.concatenate([part[:, :, :rank] for part in singles])
    singles.clear()

    def along() -> Iterator[Segment]:
        for start, blocks, _ in exact.segments():
            amplitudes = [into @ block for block in blocks]
            most = np.stack([np.abs(amplitude).max(axis=1) for amplitude in amplitudes], axis=1)
            few = [np.asfortranarray(amplitude[:rank].astype(np.float32)) for amplitude in amplitudes]
            yield start, few, lengths @ (certainty[:, None] * most)

    return StressHistory(exact.nodes, lambda of: single[of], along)


def _tails(values: Floats) -> Floats:
    """Return the sums (n, p + 1) of the last p, p - 1, ..., 0 of values (n, p)."""
    sums = np.cumsum(values[:, ::-1], axis=1)[:, ::-1]
    return np.concatenate((sums, np.zeros((len(values), 1))), axis=1)
