"""Stress peaks of long modal histories, in blocks: memory does not grow with their length.

The von Mises stress is the Euclidean length of five linear combinations of the stress components,
so that five products a node and time are enough where the tensor would take six.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numba
import numpy as np

from .mesh import Floats, Integers
from .stress import CRITERIA, Criterion, evaluate

NODE_BLOCK, TIME_BLOCK = 512, 256
"""Nodes and times of one product; its result stays in the processor's cache."""

_DEVIATOR = np.array(
    [
        [np.sqrt(0.5), -np.sqrt(0.5), 0, 0, 0, 0],
        [np.sqrt(1 / 6), np.sqrt(1 / 6), -2 * np.sqrt(1 / 6), 0, 0, 0],
        [0, 0, 0, np.sqrt(2), 0, 0],
        [0, 0, 0, 0, np.sqrt(2), 0],
        [0, 0, 0, 0, 0, np.sqrt(2)],
    ]
) * np.sqrt(1.5)


@dataclass(frozen=True)
class Peaks:
    """Greatest value of a criterion at each node over a history.

    Parameters
    ----------
    criterion : its name.
    nodes : (k,) node numbers.
    values : (k,) in Pa; for "least principal" the least value.
    time_indices : (k,) rows of the history where they occur; the first of equals.
    """

    criterion: Criterion
    nodes: Integers
    values: Floats
    time_indices: Integers

    @property
    def order(self) -> Integers:
        """Places in the arrays, from the most severe down."""
        severity = self.values if self.criterion == "least principal" else -self.values
        return np.argsort(severity, kind="stable")


@numba.njit(cache=True, parallel=True, fastmath={"contract", "reassoc"})
def _keep_greatest_length(parts, values, indices, first, start):
    """Update squared maxima from components (5 k, t) of the nodes from `first` on."""
    for k in numba.prange(parts.shape[0] // 5):
        best, at = values[first + k], indices[first + k]
        a, b, c, d, e = (
            parts[5 * k],
            parts[5 * k + 1],
            parts[5 * k + 2],
            parts[5 * k + 3],
            parts[5 * k + 4],
        )
        greatest = 0.0
        for t in range(parts.shape[1]):
            square = a[t] * a[t] + b[t] * b[t] + c[t] * c[t] + d[t] * d[t] + e[t] * e[t]
            greatest = max(greatest, square)
        if greatest > best:
            for t in range(parts.shape[1]):
                square = a[t] * a[t] + b[t] * b[t] + c[t] * c[t] + d[t] * d[t] + e[t] * e[t]
                if square > best:
                    best, at = square, start + t
            values[first + k], indices[first + k] = best, at


@dataclass(frozen=True)
class Extremes:
    """Von Mises stress over a history: extremes of each node over time and the highest node at each time.

    Parameters
    ----------
    greatest, least : (n,) in Pa.
    greatest_at : (n,) rows of the history where the greatest occur; the first of equals.
    highest : (t,) in Pa, over all nodes.
    highest_nodes : (t,) their numbers; the first of equals.
    """

    greatest: Floats
    greatest_at: Integers
    least: Floats
    highest: Floats
    highest_nodes: Integers

    @property
    def peaks(self) -> Peaks:
        """Greatest values as `recover_peaks` gives them."""
        return Peaks("von mises", np.arange(len(self.greatest)), self.greatest, self.greatest_at)


@numba.njit(cache=True, parallel=True, fastmath={"contract", "reassoc"})
def _squared_length(parts, out):
    """Sum the squares of components (5 k, t) into (k, t)."""
    for k in numba.prange(out.shape[0]):
        a, b, c, d, e = (
            parts[5 * k],
            parts[5 * k + 1],
            parts[5 * k + 2],
            parts[5 * k + 3],
            parts[5 * k + 4],
        )
        for t in range(out.shape[1]):
            out[k, t] = a[t] * a[t] + b[t] * b[t] + c[t] * c[t] + d[t] * d[t] + e[t] * e[t]


def recover_extremes(stress_modes: Floats, q: Floats | Iterable[Floats]) -> Extremes:
    """Extremes of the von Mises stress at every node and at every time of a history.

    Parameters
    ----------
    stress_modes : (n, 6, m) in Pa per unit of a modal coordinate.
    q : (t, m) modal coordinates, or an iterable of such blocks in order of time.

    Raises
    ------
    ValueError
        If the history is empty or not finite, or has another number of modes.
    """
    nodes = len(stress_modes)
    shapes = _von_mises_shapes(stress_modes)
    greatest, least = np.full(nodes, -np.inf), np.full(nodes, np.inf)
    at = np.zeros(nodes, dtype=np.int64)
    highest: list[Floats] = []
    highest_nodes: list[Integers] = []
    squares = np.empty((NODE_BLOCK, TIME_BLOCK))
    start = 0
    for columns in _checked_blocks(q, stress_modes.shape[2]):
        count = columns.shape[1]
        top, top_node = np.full(count, -np.inf), np.zeros(count, dtype=np.int64)
        for first in range(0, nodes, NODE_BLOCK):
            place = slice(first, min(first + NODE_BLOCK, nodes))
            square = squares[: place.stop - first, :count]
            _squared_length(shapes[5 * first : 5 * place.stop] @ columns, square)
            when = square.argmax(axis=1)
            best = np.take_along_axis(square, when[:, None], axis=1)[:, 0]
            better = best > greatest[place]
            at[place] = np.where(better, start + when, at[place])
            greatest[place] = np.maximum(greatest[place], best)
            least[place] = np.minimum(least[place], square.min(axis=1))
            where = square.argmax(axis=0)
            best = np.take_along_axis(square, where[None], axis=0)[0]
            better = best > top
            top_node = np.where(better, first + where, top_node)
            top = np.maximum(top, best)
        highest.append(top)
        highest_nodes.append(top_node)
        start += count
    return Extremes(
        np.sqrt(greatest), at, np.sqrt(least), np.sqrt(np.concatenate(highest)), np.concatenate(highest_nodes)
    )


def _von_mises_shapes(stress_modes: Floats) -> Floats:
    """Five components (5 n, m) whose Euclidean length at a node is its von Mises stress."""
    parts = np.einsum("ck,nkm->ncm", _DEVIATOR, stress_modes, optimize=True)
    return np.ascontiguousarray(parts).reshape(-1, stress_modes.shape[2])


def _checked_blocks(q: Floats | Iterable[Floats], modes: int) -> Iterable[Floats]:
    """Blocks (m, t) of a history; refuses one that does not fit or is not finite, and a history of none."""
    start = 0
    for block in _blocks(q):
        if block.shape[1] != modes:
            raise ValueError(f"the history has {block.shape[1]} modal coordinates, the body {modes}")
        if not np.isfinite(block).all():
            raise ValueError(f"the history is not finite between rows {start} and {start + len(block) - 1}")
        yield np.asfortranarray(block.T)
        start += len(block)
    if start == 0:
        raise ValueError("the history holds no rows")


def _blocks(q: Floats | Iterable[Floats]) -> Iterable[Floats]:
    parts = [q] if isinstance(q, np.ndarray) else q
    for part in parts:
        part = np.atleast_2d(part)
        for start in range(0, len(part), TIME_BLOCK):
            yield part[start : start + TIME_BLOCK]


def recover_peaks(
    stress_modes: Floats,
    q: Floats | Iterable[Floats],
    criterion: Criterion = "von mises",
    nodes: Integers | None = None,
) -> Peaks:
    """Keep the greatest value of a stress criterion over a history, node by node.

    Parameters
    ----------
    stress_modes : (n, 6, m) in Pa per unit of a modal coordinate.
    q : (t, m) modal coordinates, or an iterable of such blocks in order of time.
    criterion : one of `stress.CRITERIA`.
    nodes : numbers of the nodes to look at, all if left out.

    Returns
    -------
    Peaks
        Time indices count from the first row of the first block.

    Raises
    ------
    ValueError
        If the criterion is not known, the history is empty or not finite, or has another number of
        modes.
    """
    if criterion not in CRITERIA:
        raise ValueError(f"criterion = {criterion!r} must be one of {CRITERIA}")
    nodes = np.arange(len(stress_modes)) if nodes is None else np.asarray(nodes, dtype=np.int64)
    modes = stress_modes if len(nodes) == len(stress_modes) else stress_modes[nodes]
    values = np.full(len(nodes), -np.inf)
    indices = np.zeros(len(nodes), dtype=np.int64)
    fast = criterion == "von mises"
    if fast:
        shapes = _von_mises_shapes(modes)
        width = 5
    else:
        shapes = np.ascontiguousarray(modes).reshape(-1, modes.shape[2])
        width = 6
    start = 0
    for columns in _checked_blocks(q, modes.shape[2]):
        for first in range(0, len(nodes), NODE_BLOCK):
            product = shapes[width * first : width * (first + NODE_BLOCK)] @ columns
            if fast:
                _keep_greatest_length(product, values, indices, first, start)
                continue
            stress = product.reshape(-1, 6, columns.shape[1]).transpose(0, 2, 1)
            found = evaluate(criterion, stress)
            found = -found if criterion == "least principal" else found
            at = found.argmax(axis=1)
            best = np.take_along_axis(found, at[:, None], axis=1)[:, 0]
            place = slice(first, first + len(best))
            better = best > values[place]
            values[place] = np.where(better, best, values[place])
            indices[place] = np.where(better, start + at, indices[place])
        start += columns.shape[1]
    if fast:
        values = np.sqrt(values)
    elif criterion == "least principal":
        values = -values
    return Peaks(criterion, nodes, values, indices)


def shares(stress_modes: Floats, q: Floats, node: int) -> Floats:
    """Shares (m,) in Pa of each mode in the von Mises stress of a node at one time.

    The von Mises stress is homogeneous of first order in the stress, so that the derivative along
    each mode's stress, which this is, adds up to the stress itself (Euler).

    Parameters
    ----------
    stress_modes : (n, 6, m) of modes, or of loads.
    q : (m,) their coordinates at that time.
    node : node number.
    """
    parts = (_DEVIATOR @ stress_modes[node]) * q
    total = parts.sum(axis=1)
    length = np.linalg.norm(total)
    return np.zeros(len(q)) if length == 0.0 else total @ parts / length
