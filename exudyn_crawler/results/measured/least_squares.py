"""Least squares with intervals: from the scatter of points, or from what leaving out a test changes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
from scipy import optimize, stats

CONFIDENCE = 0.95
"""Of all intervals."""
FEWEST_TESTS = 6
"""Tests from which on intervals come from leaving out tests. Chosen here."""


class Points(Protocol):
    """Points that belong to tests."""

    @property
    def test(self) -> np.ndarray:
        """Names of their tests: array (points,)."""

    def of(self, points: np.ndarray) -> Self:
        """Some of them, by a mask."""


Data = TypeVar("Data", bound=Points)
Function = Callable[[np.ndarray, Data], np.ndarray]


@dataclass(frozen=True)
class Parameter:
    """Parameter of a law: its name, and True where it is fitted by its logarithm, since it is positive."""

    name: str
    by_log: bool = False


@dataclass(frozen=True)
class PartFit:
    """Parameters that tests of one kind give."""

    names: tuple[str, ...]
    value: np.ndarray  # (parameters,), SI
    low: np.ndarray  # (parameters,), lower ends of the intervals
    high: np.ndarray  # (parameters,)
    correlation: np.ndarray  # (parameters, parameters), of logarithms where they are fitted so
    scatter: float  # Pa, root mean square of what points differ from the fit by
    points: int
    by_tests: bool  # True where intervals come from leaving out tests

    def number(self, name: str) -> float:
        """Value of a parameter."""
        return float(self.value[self.names.index(name)])

    def span(self, name: str) -> tuple[float, float]:
        """Interval of a parameter."""
        place = self.names.index(name)
        return float(self.low[place]), float(self.high[place])


@dataclass(frozen=True)
class Problem(Generic[Data]):
    """Model to be fitted.

    `residuals` (theta, data) are those of the points, in Pa; `outputs` (theta) the parameters, logarithms of
    those that are fitted so.
    """

    residuals: Function
    outputs: Callable[[np.ndarray], np.ndarray]
    parameters: Sequence[Parameter]


def fit(problem: Problem[Data], data: Data, start: np.ndarray, rest: Callable[[Data], bool]) -> PartFit:
    """Fit a model, and give its parameters with intervals.

    The intervals are Student's: with the covariance ``s2 inv(J' J)`` of independent points, or, of at least
    `FEWEST_TESTS` tests, with that of the jackknife, which leaves out each test in turn and so counts how
    tests scatter; the latter only where the `rest` of the data would determine the parameters, too.

    Raises
    ------
    ValueError
        If there are no more points than parameters.
    """
    count = len(problem.parameters)
    if len(data.test) <= count:
        raise ValueError(f"points must be more than {count} to fit {count} parameters, got {len(data.test)}")
    solution = optimize.least_squares(problem.residuals, start, args=(data,), x_scale="jac")
    theta = solution.x
    middle = problem.outputs(theta)
    tests = np.unique(data.test)
    others = [data.of(data.test != name) for name in tests] if len(tests) >= FEWEST_TESTS else []
    by_tests = bool(others) and all(rest(other) for other in others)
    if by_tests:
        refits = [
            optimize.least_squares(problem.residuals, theta, args=(other,), x_scale="jac").x
            for other in others
        ]
        apart = np.array([problem.outputs(refit) for refit in refits])
        apart -= apart.mean(axis=0)
        freedom = len(tests) - 1
        covariance = freedom / len(tests) * apart.T @ apart
    else:
        freedom = len(data.test) - count
        variance = 2.0 * solution.cost / freedom
        gradient = _gradient(problem.outputs, theta)
        covariance = variance * gradient @ np.linalg.pinv(solution.jac.T @ solution.jac) @ gradient.T
    scatter = float(np.sqrt(2.0 * solution.cost / len(data.test)))
    return part(problem.parameters, middle, covariance, freedom, scatter, len(data.test), by_tests)


def part(
    parameters: Sequence[Parameter],
    middle: np.ndarray,
    covariance: np.ndarray,
    freedom: int,
    scatter: float,
    points: int,
    by_tests: bool = False,
) -> PartFit:
    """Parameters with intervals, from their values and covariance, both of logarithms where fitted so."""
    spread = np.sqrt(np.diag(covariance))
    half = stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * spread
    by_log = np.array([parameter.by_log for parameter in parameters])
    value, low, high = (
        np.where(by_log, np.exp(np.where(by_log, x, 0.0)), x) for x in (middle, middle - half, middle + half)
    )
    safe = np.where(spread > 0.0, spread, 1.0)
    correlation = covariance / np.outer(safe, safe)
    names = tuple(parameter.name for parameter in parameters)
    return PartFit(names, value, low, high, correlation, scatter, points, by_tests)


def _gradient(function: Callable[[np.ndarray], np.ndarray], place: np.ndarray) -> np.ndarray:
    """Derivatives of a function by central differences: array (outputs, inputs)."""
    columns = []
    for k, value in enumerate(place):
        step = np.zeros_like(place)
        step[k] = 1e-6 * max(1.0, abs(value))
        columns.append((function(place + step) - function(place - step)) / (2.0 * step[k]))
    return np.column_stack(columns)
