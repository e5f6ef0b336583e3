"""Extremes of the von Mises stress over a history: of each node over time, and over the nodes at each time.

Each segment of the history is searched at a reduced rank in single precision (`find_candidates`). All
candidates that the bounds leave are recovered again at full rank in double precision. The result is that of
a search at full rank.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fem.body.element_stress import DEVIATOR
from fem.body.mesh import Floats, Integers
from fem.body.shapes import Columns
from fem.compiling import compiler
from fem.memory import give_back_memory
from fem.stress.candidates import CELL, Candidates, ScaledShapes, find_candidates, scaled_shapes
from fem.stress.folds import Fold, StressBlock, fold_stresses
from fem.stress.low_rank import TIME_BLOCK, ModalHistory, checked, node_blocks, segments
from fem.stress.recovery import Peaks

TOLERANCE = 1e-3
"""Tolerance of the search, fraction of the highest stress: less needs more directions, more leaves more
candidates."""
MOST = 0.25
"""Fraction of all cells as candidates above which the search at full rank is faster."""
SEGMENT = 2**13
"""Number of successive times that are searched together; twice as many take 170 MB for the bounds."""

HIGHEST = ("highest", "highest_nodes")
"""Names of the arrays of `Extremes` with one entry for each time."""


@dataclass(frozen=True)
class Extremes:
    """Von Mises stress over a history: extremes of each node over time and the highest node at each time.

    Parameters
    ----------
    greatest, least : array (n,)
        In Pa.
    greatest_at : int array (n,)
        Rows of the greatest values in the history; the first of equals.
    highest : array (t,)
        In Pa, over the ranked nodes.
    highest_nodes : int array (t,)
        Numbers of the highest nodes; the first of equals.
    bound : array (n,)
        Greatest error in Pa of the search at reduced rank at each node, 0 at full rank.
    """

    greatest: Floats
    greatest_at: Integers
    least: Floats
    highest: Floats
    highest_nodes: Integers
    bound: Floats

    @property
    def peaks(self) -> Peaks:
        """Greatest values in the form of `recover_peaks`."""
        return Peaks("von mises", np.arange(len(self.greatest)), self.greatest, self.greatest_at)


def recover_extremes(
    stress_modes: Columns,
    q: ModalHistory,
    *,
    ranked: Integers | None = None,
    tolerance: float | None = TOLERANCE,
    scaled: ScaledShapes | None = None,
) -> Extremes:
    """Find the extremes of the von Mises stress at every node and at every time of a history.

    Parameters
    ----------
    stress_modes, q
        See `folds.fold_stresses`; errors are the same too.
    ranked : int array, optional
        Numbers of the nodes, at least one, that compete for the highest of each time; all if left out.
    tolerance : float, optional
        Greatest error of the search, fraction of the highest stress; None searches at full rank.
    scaled : ScaledShapes, optional
        Scaled shapes of the same `stress_modes`, if already computed.
    """
    chosen = np.ones(len(stress_modes), dtype=bool)
    if ranked is not None:
        chosen[:] = False
        chosen[ranked] = True
    if not chosen.any():
        raise ValueError("ranked must be at least one node, got none")
    parts = []
    for rows in segments(q, SEGMENT):
        if tolerance is None or len(rows) <= TIME_BLOCK:
            parts.append(fold_stresses(stress_modes, rows, VonMisesExtremes(chosen)))
            continue
        if scaled is None:
            scaled = scaled_shapes(stress_modes)
        parts.append(_of_segment(stress_modes, rows, chosen, tolerance, scaled))
    if not parts:
        raise ValueError("the history must have at least one row, got none")
    whole = parts[0]
    start = 0
    for part in parts[1:]:
        start += SEGMENT
        better = part.greatest > whole.greatest
        whole = replace(
            whole,
            greatest=np.where(better, part.greatest, whole.greatest),
            greatest_at=np.where(better, part.greatest_at + start, whole.greatest_at),
            least=np.minimum(whole.least, part.least),
            bound=np.maximum(whole.bound, part.bound),
        )
    highest, nodes = (np.concatenate([getattr(part, name) for part in parts]) for name in HIGHEST)
    return replace(whole, highest=highest, highest_nodes=nodes)


def _of_segment(
    stress_modes: Columns,
    rows: Floats,
    ranked: NDArray[np.bool_],
    tolerance: float,
    scaled: ScaledShapes,
) -> Extremes:
    """Find the extremes over rows (t, m) of a history, by a search if its bounds leave few cells open."""
    candidates = find_candidates(scaled, checked(rows, stress_modes), ranked, tolerance)
    give_back_memory()
    if candidates.open_part < MOST:
        return _recovered(stress_modes, rows, candidates, ranked)
    return fold_stresses(stress_modes, rows, VonMisesExtremes(ranked))


@compiler(nogil=True, fastmath={"contract", "reassoc"})
def _keep_node_extremes(parts, squares, greatest, at, least, start):
    """Write squared lengths of components (k, 5, t) into (k, t); update each node's extremes over time."""
    for k in range(squares.shape[0]):
        a = parts[k, 0]
        b = parts[k, 1]
        c = parts[k, 2]
        d = parts[k, 3]
        e = parts[k, 4]
        low = np.inf
        high = -np.inf
        for t in range(squares.shape[1]):
            square = a[t] * a[t] + b[t] * b[t] + c[t] * c[t] + d[t] * d[t] + e[t] * e[t]
            squares[k, t] = square
            low = min(low, square)
            high = max(high, square)
        least[k] = min(least[k], low)
        if high > greatest[k]:
            greatest[k] = high
            for t in range(squares.shape[1]):
                if squares[k, t] == high:
                    at[k] = start + t
                    break


@compiler(nogil=True)
def _keep_highest(squares, ranked, top, places, first):
    """Update the highest square of each time and its node; the rows of `squares` count from `first`."""
    for k in range(squares.shape[0]):
        for t in range(squares.shape[1] if ranked[k] else 0):
            if squares[k, t] > top[t]:
                top[t] = squares[k, t]
                places[t] = first + k


class VonMisesExtremes(Fold[Extremes]):
    """Extremes of the von Mises stress of each node over time, and over the nodes at each time.

    Parameters
    ----------
    ranked : bool array (n,)
        Nodes that compete for the highest of each time.
    """

    components = DEVIATOR

    def __init__(self, ranked: NDArray[np.bool_]) -> None:
        self._ranked = ranked

    def start(self, nodes: Integers, times: int) -> None:
        """Begin without any stress."""
        self._nodes = nodes
        self._greatest, self._least = np.full(len(nodes), -np.inf), np.full(len(nodes), np.inf)
        self._rows = np.zeros(len(nodes), dtype=np.int64)
        self._highest = np.full(times, -np.inf)
        self._places = np.zeros(times, dtype=np.int64)

    def add(self, block: StressBlock) -> None:
        """Update the extremes."""
        of = block.nodes
        times = block.times
        squares = np.empty((block.stress.shape[0], block.stress.shape[2]))
        _keep_node_extremes(
            block.stress, squares, self._greatest[of], self._rows[of], self._least[of], times.start
        )
        _keep_highest(squares, self._ranked[of], self._highest[times], self._places[times], of.start)

    def finish(self) -> Extremes:
        """Return the extremes in Pa."""
        return Extremes(
            np.sqrt(self._greatest),
            self._rows,
            np.sqrt(self._least),
            np.sqrt(self._highest),
            self._nodes[self._places],
            np.zeros(len(self._nodes)),
        )


@compiler(nogil=True, fastmath={"contract", "reassoc"})
def _square(shapes, q):
    """Return the square of the von Mises stress of shapes (6, m) with coordinates (m,)."""
    xx = 0.0
    yy = 0.0
    zz = 0.0
    xy = 0.0
    yz = 0.0
    xz = 0.0
    for k in range(len(q)):
        xx += shapes[0, k] * q[k]
        yy += shapes[1, k] * q[k]
        zz += shapes[2, k] * q[k]
        xy += shapes[3, k] * q[k]
        yz += shapes[4, k] * q[k]
        xz += shapes[5, k] * q[k]
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return 0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz)


@compiler(nogil=True)
def _search_times(stress_modes, q, nodes, cells, sense, best, at):
    """Find the greatest sense times square of nodes in cells of times, and its row (first of equals)."""
    for node, cell in zip(nodes, cells):  # noqa: B905 - compiled
        for row in range(CELL * cell, min(CELL * (cell + 1), len(q))):
            square = sense * _square(stress_modes[node], q[row])
            if square > best[node]:
                best[node] = square
                at[node] = row


@compiler(nogil=True)
def _search_nodes(stress_modes, q, cells, rows, ranked, best, at, first):
    """Find the highest square of rows in cells of nodes, counted from `first`, and its first node."""
    for cell, row in zip(cells, rows):  # noqa: B905 - compiled
        for node in range(CELL * cell, min(CELL * (cell + 1), len(stress_modes))):
            if ranked[node]:
                square = _square(stress_modes[node], q[row])
                if square > best[row]:
                    best[row] = square
                    at[row] = first + node


def _recovered(
    stress_modes: Columns, q: Floats, candidates: Candidates, ranked: NDArray[np.bool_]
) -> Extremes:
    """Recover the extremes at full rank from all candidate nodes and times."""
    n = len(stress_modes)
    t = len(q)
    greatest = np.full(n, -np.inf)
    least = np.full(n, -np.inf)
    highest = np.full(t, -np.inf)
    instants = np.zeros(n, dtype=np.int64)
    places = np.zeros(t, dtype=np.int64)
    rows = np.ascontiguousarray(q)
    for of in node_blocks(n):
        shapes = np.ascontiguousarray(stress_modes[of])
        inside = np.arange(len(shapes))
        places_of_least = np.zeros_like(inside)
        open_greatest = candidates.upper[of] >= candidates.lower[of, None]
        _search_times(shapes, rows, *np.nonzero(open_greatest), 1.0, greatest[of], instants[of])
        lowest = candidates.least_lower[of].argmin(axis=1)
        _search_times(shapes, rows, inside, lowest, -1.0, least[of], places_of_least)
        open_least = candidates.least_lower[of] <= np.sqrt(-least[of])[:, None]
        open_least[inside, lowest] = False
        _search_times(shapes, rows, *np.nonzero(open_least), -1.0, least[of], places_of_least)
        groups = slice(of.start // CELL, -(-of.stop // CELL))
        open_nodes = candidates.node_upper[groups] >= candidates.node_lower
        _search_nodes(shapes, rows, *np.nonzero(open_nodes), ranked[of], highest, places, of.start)
    return Extremes(np.sqrt(greatest), instants, np.sqrt(-least), np.sqrt(highest), places, candidates.bound)
