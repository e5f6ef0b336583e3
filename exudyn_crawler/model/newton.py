"""Newton's method for one step of a track."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.packed import FloatArray, IntArray
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model import elimination, kinds
from exudyn_crawler.model.equations import matrix, residual
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.tables import Search, read_system

CONTRACTION = 0.5
"""Largest ratio of successive residuals at which an old matrix is kept."""
OLDEST = 8
"""Largest number of iterations with one matrix."""
TANGENTS = 2
"""Number of matrices of a step with the tangent of the friction curve; later ones use the secant."""
CLOSER = 0.25
"""Residual that the matrix of the last step must reach, fraction of the limit.

A new matrix leaves a hundredth of the limit; the residuals of an old one add up over steps.
"""
DIVERGED = 1e30
"""Residual above which the search is given up, N."""

FACTORED, DERIVED, STALE = 0, 1, 2
"""States of the matrix at the start of an iteration: factored; rows with derivatives for a new matrix;
neither, so that the iteration first evaluates the residual with derivatives."""


class Limits(NamedTuple):
    """Start and end of the search of a step."""

    residual: float  # N, root mean square, at which it has converged
    iterations: int  # at most
    factored: bool  # True if it begins with the factored matrix of the last step


class Outcome(NamedTuple):
    """Result of the search of a step."""

    converged: bool
    iterations: int
    matrices: int  # that were made and factored
    residual: float  # N, root mean square, the last one


@inner(allocates=True)
def _norm(residual: FloatArray) -> float:
    """Return the root mean square of the residual."""
    return np.sqrt(np.sum(residual * residual) / residual.shape[0])


@kernel
def subtract(
    system: IntArray, change: FloatArray, weights: Weights, state: FloatArray, multipliers: FloatArray
) -> None:
    """Subtract a change of coordinates and multipliers; rates and accelerations follow by the weights."""
    tables = read_system(system).tables
    n = state.shape[1]
    for k in range(n):
        state[0, k] -= change[k]
        state[1, k] -= weights.velocity * change[k]
        state[2, k] -= weights.acceleration * change[k]
    for k in range(multipliers.shape[0]):
        multipliers[k] -= change[n + k]
    kinds.turn_multipliers(tables.joints, tables.bodies, tables.markers, change, multipliers)


@kernel
def is_stale(search: Search, matrices: int, age: int, norm: float, last: float, limit: float) -> bool:
    """Return True if a matrix should be replaced after an iteration that reduced a residual `last` to `norm`.

    `matrices` is the number of matrices of this step so far, `age` the number of iterations with the present
    one. A matrix is replaced if it converges slowly or is too old. As long as matrices with tangents remain,
    it is also replaced if `search` predicts that it misses the limit.
    """
    if (age > 2 and norm > CONTRACTION * last) or age > OLDEST:
        return True
    if matrices >= TANGENTS:
        return False
    remaining = max(search.least, search.slower * norm / last)
    if remaining * norm > limit:
        return True
    has_rate = age > 1 or matrices == 0
    return search.ahead > 0 and has_rate and norm * (norm / last) ** search.ahead > limit


@kernel
def step(
    system: IntArray,
    state: FloatArray,
    multipliers: FloatArray,
    inputs: Inputs,
    weights: Weights,
    limits: Limits,
    scratch: tuple[FloatArray, FloatArray],
) -> Outcome:
    """Solve the equations of a step from its prediction, in place.

    `system` is a block of `tables.System`. `state` (3, coordinates) holds predicted coordinates, rates and
    accelerations; rates and accelerations follow a change of the coordinates by the factors
    ``weights.velocity`` and ``weights.acceleration``. `multipliers` are those of the last step. `scratch`
    holds the last residual and the values of the fronts with the factored matrix.

    Contacts of pins with play may open and close from iteration to iteration. With ``search.guards`` a change
    by an old matrix that raises the residual is taken back, one by a new matrix is halved once.
    """
    out, values = scratch
    fronts = read_system(system).tables.fronts
    search = read_system(system).tables.search
    # a literal among them would compile the equations once more
    none = Weights(0.0, 0.0, 0.0, weights.secant, weights.level)
    change = np.empty_like(out)
    state_before = np.empty_like(state)
    multipliers_before = np.empty_like(multipliers)
    iterations = matrices = age = 0
    stage = FACTORED if limits.factored else DERIVED
    residual(system, state, multipliers, inputs, none if limits.factored else weights, out)
    last = _norm(out)
    while iterations < limits.iterations:
        if stage == STALE:
            secant = matrices >= TANGENTS
            by = Weights(weights.position, weights.velocity, weights.acceleration, secant, weights.level)
            residual(system, state, multipliers, inputs, by, out)
        if stage != FACTORED:
            matrix(system, weights, values)
            elimination.eliminate(fronts, values)
            matrices += 1
            age = 0
        change[:] = out
        elimination.solve(fronts, values, change)
        if search.guards:
            state_before[:] = state
            multipliers_before[:] = multipliers
        subtract(system, change, weights, state, multipliers)
        iterations += 1
        age += 1
        residual(system, state, multipliers, inputs, none, out)
        norm = _norm(out)
        if search.guards and not norm <= last:
            state[:] = state_before
            multipliers[:] = multipliers_before
            if age > 1 or matrices == 0:
                stage = STALE
                continue
            change *= 0.5
            subtract(system, change, weights, state, multipliers)
            iterations += 1
            residual(system, state, multipliers, inputs, none, out)
            norm = _norm(out)
        limit = limits.residual if matrices > 0 else CLOSER * limits.residual
        if norm <= limit:
            return Outcome(True, iterations, matrices, norm)
        if not norm < DIVERGED:
            break
        stage = STALE if is_stale(search, matrices, age, norm, last, limit) else FACTORED
        last = norm
    return Outcome(False, iterations, matrices, last)
