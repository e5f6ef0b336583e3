"""Least squares with confidence intervals, from the scatter of points or the jackknife over tests."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
from scipy import optimize, stats

CONFIDENCE = 0.95
"""Confidence of all intervals."""
FEWEST_TESTS = 6
"""Least number of tests for the jackknife; a choice of this project."""


class Points(Protocol):
    """Points, each of a test."""

    @property
    def test(self) -> np.ndarray:
        """Name of the test of each point: array (points,)."""

    def of(self, points: np.ndarray) -> Self:
        """Return some of the points, by a mask."""


Data = TypeVar("Data", bound=Points)
Function = Callable[[np.ndarray, Data], np.ndarray]


@dataclass(frozen=True)
class Parameter:
    """Parameter of a law: its name, and True if its logarithm is fitted, since it is positive."""

    name: str
    by_log: bool = False


@dataclass(frozen=True)
class PartFit:
    """Parameters fitted to tests of one kind."""

    names: tuple[str, ...]
    value: np.ndarray  # (parameters,), SI
    low: np.ndarray  # (parameters,), lower ends of the intervals
    high: np.ndarray  # (parameters,)
    correlation: np.ndarray  # (parameters, parameters), of the logarithms for parameters fitted so
    scatter: float  # Pa, root mean square residual of the points
    points: int
    by_tests: bool  # True if intervals come from the jackknife over tests

    def number(self, name: str) -> float:
        """Return the value of a parameter."""
        return float(self.value[self.names.index(name)])

    def span(self, name: str) -> tuple[float, float]:
        """Return the interval of a parameter."""
        place = self.names.index(name)
        return float(self.low[place]), float(self.high[place])


@dataclass(frozen=True)
class Problem(Generic[Data]):
    """Model for a fit.

    `residuals` (theta, data) returns those of the points, Pa. `outputs` (theta) returns the parameters, or
    their logarithms for those fitted so.
    """

    residuals: Function
    outputs: Callable[[np.ndarray], np.ndarray]
    parameters: Sequence[Parameter]


def fit(problem: Problem[Data], data: Data, start: np.ndarray, rest: Callable[[Data], bool]) -> PartFit:
    """Fit a model, and return its parameters with intervals.

    The intervals are Student's. The covariance is ``s2 inv(J' J)`` of independent points. With at least
    `FEWEST_TESTS` tests it is that of the jackknife, which leaves out each test in turn and so includes the
    scatter of tests. The jackknife needs data without a test that still determine the parameters; `rest`
    tells this.

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
    """Return parameters with intervals from values and covariance, both of logarithms where fitted so."""
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
    """Return the derivatives of a function by central differences: array (outputs, inputs)."""
    columns = []
    for k, value in enumerate(place):
        step = np.zeros_like(place)
        step[k] = 1e-6 * max(1.0, abs(value))
        columns.append((function(place + step) - function(place - step)) / (2.0 * step[k]))
    return np.column_stack(columns)
