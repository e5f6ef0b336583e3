"""Stress peaks of long modal histories, as folds over blocks of their stresses.

The von Mises stress is the Euclidean length of five linear combinations of the stress components. It takes
five products per node and time; the tensor would take six.
"""

from dataclasses import dataclass

import numpy as np

from fem.body.element_stress import CRITERIA, DEVIATOR, Criterion, evaluate
from fem.body.mesh import Floats, Integers
from fem.body.shapes import Columns
from fem.compiling import compiler
from fem.stress.folds import Fold, StressBlock, fold_stresses
from fem.stress.low_rank import ModalHistory


@dataclass(frozen=True)
class Peaks:
    """Greatest value of a criterion at each node over a history.

    Parameters
    ----------
    criterion : str
        Name of the criterion, one of `element_stress.CRITERIA`.
    nodes : int array (k,)
        Node numbers.
    values : array (k,)
        In Pa; for "least principal" the least value.
    time_indices : int array (k,)
        Rows of the values in the history; the first of equals.
    """

    criterion: Criterion
    nodes: Integers
    values: Floats
    time_indices: Integers

    @property
    def order(self) -> Integers:
        """Positions in the arrays, from the most severe down."""
        severity = self.values if self.criterion == "least principal" else -self.values
        return np.argsort(severity, kind="stable")


@compiler(nogil=True, fastmath={"contract", "reassoc"})
def _keep_greatest_length(parts, values, indices, start):
    """Update squared maxima (k,) and their rows from components (k, 5, t); rows count from `start`."""
    for k in range(parts.shape[0]):
        best = values[k]
        row = indices[k]
        a = parts[k, 0]
        b = parts[k, 1]
        c = parts[k, 2]
        d = parts[k, 3]
        e = parts[k, 4]
        greatest = 0.0
        for t in range(parts.shape[2]):
            square = a[t] * a[t] + b[t] * b[t] + c[t] * c[t] + d[t] * d[t] + e[t] * e[t]
            greatest = max(greatest, square)
        if greatest > best:
            for t in range(parts.shape[2]):
                square = a[t] * a[t] + b[t] * b[t] + c[t] * c[t] + d[t] * d[t] + e[t] * e[t]
                if square > best:
                    best = square
                    row = start + t
            values[k] = best
            indices[k] = row


class GreatestVonMises(Fold[Peaks]):
    """Greatest von Mises stress of each node and its row."""

    components = DEVIATOR

    def start(self, nodes: Integers, times: int) -> None:
        """Begin without any stress."""
        self._nodes = nodes
        self._squares = np.full(len(nodes), -np.inf)
        self._rows = np.zeros(len(nodes), dtype=np.int64)

    def add(self, block: StressBlock) -> None:
        """Update the greatest values."""
        _keep_greatest_length(
            block.stress, self._squares[block.nodes], self._rows[block.nodes], block.times.start
        )

    def finish(self) -> Peaks:
        """Return the peaks in Pa."""
        return Peaks("von mises", self._nodes, np.sqrt(self._squares), self._rows)


class GreatestOf(Fold[Peaks]):
    """Greatest value of any criterion at each node and its row.

    Parameters
    ----------
    criterion : str
        One of `element_stress.CRITERIA`, else `ValueError`; for "least principal" the least value counts.
    """

    components = None

    def __init__(self, criterion: Criterion) -> None:
        if criterion not in CRITERIA:
            raise ValueError(f"criterion must be one of {CRITERIA}, got {criterion!r}")
        self._criterion = criterion
        self._sense = -1.0 if criterion == "least principal" else 1.0

    def start(self, nodes: Integers, times: int) -> None:
        """Begin without any stress."""
        self._nodes = nodes
        self._values = np.full(len(nodes), -np.inf)
        self._rows = np.zeros(len(nodes), dtype=np.int64)

    def add(self, block: StressBlock) -> None:
        """Update the most severe values."""
        severity = self._sense * evaluate(self._criterion, block.stress.transpose(0, 2, 1))
        instants = severity.argmax(axis=1)
        best = np.take_along_axis(severity, instants[:, None], axis=1)[:, 0]
        values = self._values[block.nodes]
        rows = self._rows[block.nodes]
        better = best > values
        values[better] = best[better]
        rows[better] = block.times.start + instants[better]

    def finish(self) -> Peaks:
        """Return the peaks in Pa."""
        return Peaks(self._criterion, self._nodes, self._sense * self._values, self._rows)


def recover_peaks(
    stress_modes: Columns,
    q: ModalHistory,
    criterion: Criterion = "von mises",
    nodes: Integers | None = None,
) -> Peaks:
    """Find the greatest value of a stress criterion over a history, node by node.

    See `folds.fold_stresses` for the other parameters and errors.

    Parameters
    ----------
    criterion : str
        One of `element_stress.CRITERIA`.

    Returns
    -------
    Peaks
        Peaks; time indices count from the first row of the first block.

    Raises
    ------
    ValueError
        If the criterion is unknown.
    """
    if criterion == "von mises":
        return fold_stresses(stress_modes, q, GreatestVonMises(), nodes)
    return fold_stresses(stress_modes, q, GreatestOf(criterion), nodes)


def shares(stress_modes: Columns, q: Floats, node: int) -> Floats:
    """Return each mode's share (m,) in Pa of the von Mises stress of a node at one time.

    A share is the derivative of the von Mises stress along a mode's stress. The shares add up to the stress,
    since it is homogeneous of first order (Euler).

    Parameters
    ----------
    stress_modes : columns (n, 6, m)
        Stress of modes, or of loads, in Pa per unit of a coordinate.
    q : array (m,)
        Coordinates of the columns at that time.
    node : int
        Node number.
    """
    parts = (DEVIATOR @ stress_modes[node]) * q
    total = parts.sum(axis=1)
    length = np.linalg.norm(total)
    return np.zeros(len(q)) if length == 0.0 else total @ parts / length
