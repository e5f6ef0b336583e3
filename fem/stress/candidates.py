"""Candidates for the extremes of the von Mises stress over a history: a bounded search in single precision.

Successive times move along few directions. A singular value decomposition finds the directions of each block
of times. Its coordinates are scaled: their length is the root of the sum of squared stresses over all nodes.
A dropped direction changes the stress at a node by no more than its length times that of the node's shapes
(Cauchy and Schwarz). Rounding adds to the bound (N. J. Higham, Accuracy and Stability of Numerical
Algorithms, 2nd ed., section 3.1).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fem.body.element_stress import DEVIATOR
from fem.body.mesh import Floats
from fem.body.shapes import Columns
from fem.compiling import compiler
from fem.stress.low_rank import HALF_ULP, SCAN, node_blocks

Singles = NDArray[np.float32]

CELL = 32
"""Number of successive times, or nodes, that share their bounds; a divisor of `NODES` and `TIMES`."""
NODES, TIMES = 64, 512
"""Numbers of nodes and times of one product; its result stays in the processor's cache."""
LEAST_RANK = 8
"""Least number of directions in a block of times: a product with fewer takes as long and is less exact."""
LEAST_SIZE = 1e-12
"""Squared stress below which a direction is rounding, fraction of the greatest direction's."""


class ScaledShapes(NamedTuple):
    """Shapes of the stress of n nodes in m scaled coordinates; their length is that of all nodes' stress.

    Attributes
    ----------
    singles : array (n, 5, m)
        Combinations `DEVIATOR` of the stress, in single precision.
    lengths : array (n,)
        Length of all shapes of a node together.
    into : array (m, m)
        Matrix from coordinates of a body's columns to scaled ones, in Pa.
    """

    singles: Singles
    lengths: Floats
    into: Floats


def scaled_shapes(stress_modes: Columns) -> ScaledShapes:
    """Compute the scaled shapes of columns (n, 6, m), for searches in several histories."""
    n, _, count = stress_modes.shape
    products = np.zeros((count, count))
    for of in node_blocks(n):
        shapes = (DEVIATOR @ stress_modes[of]).reshape(-1, count)
        products += shapes.T @ shapes
    scale = np.sqrt(np.diag(products))
    scale[scale == 0.0] = 1.0  # columns without stress
    squares, directions = np.linalg.eigh(products / np.outer(scale, scale))
    sizes = np.sqrt(np.maximum(squares, LEAST_SIZE * (squares[-1] or 1.0)))
    turn = directions / scale[:, None] / sizes
    singles = np.empty((n, len(DEVIATOR), count), dtype=np.float32)
    lengths = np.empty(n)
    for of in node_blocks(n):
        shapes = (DEVIATOR @ stress_modes[of]) @ turn
        lengths[of] = np.linalg.norm(shapes.reshape(len(shapes), -1), axis=1)
        singles[of] = shapes
    return ScaledShapes(singles, lengths, sizes[:, None] * directions.T * scale)


class Candidates(NamedTuple):
    """Bounds, in Pa, that tell which cells may hold extremes; cells are `CELL` successive times or nodes.

    Attributes
    ----------
    upper, lower : array (n, cells), (n,)
        Upper bound of a node's greatest stress in each cell of times, and lower bound of its greatest in all.
    least_lower, least_upper : array (n, cells), (n,)
        Lower bound of a node's least stress in each cell of times, and upper bound of its least in all.
    node_upper, node_lower : array (cells, t), (t,)
        Upper bound of the ranked nodes' highest stress in each cell at each time, and lower bound of the
        highest of all cells at each time.
    bound : array (n,)
        Greatest error of a node's stress.
    """

    upper: Singles
    lower: Singles
    least_lower: Singles
    least_upper: Singles
    node_upper: Singles
    node_lower: Singles
    bound: Floats

    @property
    def open_part(self) -> float:
        """Greatest fraction of the cells that may hold extremes, over the three kinds of extremes."""
        greatest = np.mean(self.upper >= self.lower[:, None])
        least = np.mean(self.least_lower <= self.least_upper[:, None])
        highest = np.mean(self.node_upper >= self.node_lower)
        return float(max(greatest, least, highest))


class _TimeBlock(NamedTuple):
    """Block of successive times: few directions (m, r), amplitudes (r, t), and length of the error."""

    directions: Singles
    amplitudes: Singles
    error: float


def _along_few(coordinates: Floats, most: float) -> _TimeBlock:
    """Find directions of coordinates (m, t) with an error of at most `most`, if rounding allows."""
    _, directions = np.linalg.eigh(coordinates @ coordinates.T)
    directions = directions[:, ::-1]
    amplitudes = directions.T @ coordinates
    left_out = np.cumsum((amplitudes**2)[::-1], axis=0)[::-1].max(axis=1)
    left_out = np.sqrt(np.append(left_out, 0.0))
    # roundings of shapes, of their products with directions and amplitudes, and of the scan
    steps = (len(coordinates) + np.arange(len(left_out)) + SCAN) * HALF_ULP
    rounded = np.linalg.norm(np.abs(directions) @ np.abs(amplitudes), axis=0).max()
    errors = left_out + rounded * steps / (1.0 - steps)
    enough = np.append(np.flatnonzero(errors <= most), len(amplitudes))
    rank = min(max(int(enough[0]), LEAST_RANK), len(amplitudes))
    few = np.ascontiguousarray(amplitudes[:rank], dtype=np.float32)
    return _TimeBlock(directions[:, :rank].astype(np.float32), few, float(errors[rank]))


@compiler(nogil=True, fastmath={"contract", "reassoc", "nnan", "nsz"})
def _keep_squares(parts, ranked, greatest, least, highest):
    """Write extremes of squared lengths of components (k, 5, t): nodes in cells of times, cells at times."""
    squares = np.empty(parts.shape[2], dtype=np.float32)
    for k in range(parts.shape[0]):
        a = parts[k, 0]
        b = parts[k, 1]
        c = parts[k, 2]
        d = parts[k, 3]
        e = parts[k, 4]
        for t in range(len(squares)):
            squares[t] = a[t] * a[t] + b[t] * b[t] + c[t] * c[t] + d[t] * d[t] + e[t] * e[t]
        if ranked[k]:
            top = highest[k // CELL]
            for t in range(len(squares)):
                top[t] = max(top[t], squares[t])
        for first in range(0, len(squares), CELL):
            low = squares[first]
            high = squares[first]
            for t in range(first + 1, min(first + CELL, len(squares))):
                low = min(low, squares[t])
                high = max(high, squares[t])
            greatest[k, first // CELL] = high
            least[k, first // CELL] = low


def find_candidates(
    shapes: ScaledShapes, rows: Floats, ranked: NDArray[np.bool_], tolerance: float
) -> Candidates:
    """Find the candidates for the extremes of a history.

    Parameters
    ----------
    shapes : ScaledShapes
    rows : array (t, m)
        Coordinates of the body's columns, finite.
    ranked : bool array (n,)
        Nodes that compete for the highest of each time.
    tolerance : float
        Error of the search, fraction of the highest stress.
    """
    # threads gain nothing in products of this size: they would wait for each other thousands of times
    with threadpool_limits(1, user_api="blas"):
        return _bounds(shapes, rows, ranked, tolerance)


def _bounds(shapes: ScaledShapes, rows: Floats, ranked: NDArray[np.bool_], tolerance: float) -> Candidates:
    """Return the bounds of all cells, see `find_candidates`.

    Each block of times keeps a few directions of the coordinates (`_along_few`), so that stresses are known
    but for an error: a node's length times that of the block. A cell's greatest length of stress, more or
    less this error, bounds its greatest stress; the same holds for the least stress and for groups of nodes.
    """
    n, components, _ = shapes.singles.shape
    times = len(rows)
    coordinates = shapes.into @ rows.T
    instant = coordinates[:, np.linalg.norm(coordinates, axis=0).argmax()]
    # stress that the tolerance is a fraction of: the highest at the time of the largest coordinates
    highest = float(np.linalg.norm(shapes.singles @ instant.astype(np.float32), axis=1).max())
    widest = max(float(shapes.lengths.max()), np.finfo(float).tiny)
    starts = range(0, times, TIMES)
    blocks = [
        _along_few(coordinates[:, start : start + TIMES], tolerance * highest / widest) for start in starts
    ]
    # directions of all blocks side by side, multiplied in one product and split at `ends`
    turns = np.concatenate([block.directions for block in blocks], axis=1)
    ends = np.cumsum([block.directions.shape[1] for block in blocks])
    error_at = np.repeat([block.error for block in blocks], [block.amplitudes.shape[1] for block in blocks])
    cells = -(-times // CELL)
    groups = -(-n // CELL)
    upper = np.empty((n, cells), dtype=np.float32)
    least = np.empty((n, cells), dtype=np.float32)
    least_upper = np.empty(n, dtype=np.float32)
    node_upper = np.zeros((groups, times), dtype=np.float32)
    lower = np.empty(n, dtype=np.float32)
    node_lower = np.zeros(times, dtype=np.float32)
    products = np.empty(NODES * components * TIMES, dtype=np.float32)
    for first in range(0, n, NODES):
        of = slice(first, min(first + NODES, n))
        count = of.stop - of.start
        few = np.split(shapes.singles[of].reshape(count * components, -1) @ turns, ends[:-1], axis=1)
        in_groups = slice(first // CELL, -(-of.stop // CELL))
        for start, block, shape in zip(starts, blocks, few, strict=True):
            stop = min(start + TIMES, times)
            stress = products[: count * components * (stop - start)].reshape(count * components, -1)
            np.matmul(shape, block.amplitudes, out=stress)
            of_cells = slice(start // CELL, -(-stop // CELL))
            _keep_squares(
                stress.reshape(count, components, -1),
                ranked[of],
                upper[of, of_cells],
                least[of, of_cells],
                node_upper[in_groups, start:stop],
            )
        # of these nodes the arrays have squared lengths up to here, and bounds from here on
        off = np.outer(shapes.lengths[of], error_at[::CELL])
        length = np.sqrt(upper[of])
        lower[of] = (length - off).max(axis=1)
        upper[of] = length + off
        length = np.sqrt(least[of])
        least_upper[of] = (length + off).min(axis=1)
        least[of] = length - off
        of_group = np.maximum.reduceat(np.where(ranked[of], shapes.lengths[of], 0.0), range(0, count, CELL))
        off = np.outer(of_group, error_at)
        length = np.sqrt(node_upper[in_groups])
        np.maximum(node_lower, (length - off).max(axis=0), out=node_lower)
        node_upper[in_groups] = length + off
    # groups without a ranked node have no candidate
    node_upper[~np.logical_or.reduceat(ranked, range(0, n, CELL))] = -np.inf
    bound = shapes.lengths * error_at.max()
    return Candidates(upper, lower, least, least_upper, node_upper, node_lower, bound)
